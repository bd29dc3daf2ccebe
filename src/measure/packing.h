/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The network of contacts of bodies at rest (seed 001, IV.C and Appendix E). */
#ifndef SCREE_MEASURE_PACKING_H
#define SCREE_MEASURE_PACKING_H

#include "view.h"

enum { FORCE_BINS = 64, FABRIC_BINS = 18, PACKING_REGIONS = 3 };
#define FORCE_BIN 0.5 // of F / <F>; the last bin also holds what is beyond

/* A part of a column: all of it, the half close to the gate, the upper half of that. */
struct packing_region {
    double bodies, contacts;    // points of contact between bodies that lie in it
    double ground, sides, gate; // and with the floor, the two walls along the flow, the wall that faces it
};

/* Plain data. */
struct packing {
    struct packing_region region[PACKING_REGIONS];
    double force_mean, force_most; // of points of contact between bodies: mean magnitude, N; the largest over it
    double force_pdf[FORCE_BINS];  // of F / <F>
    double fabric[FABRIC_BINS];    // of the angle theta in [0, 180) degrees of branches with x, seen along y: share a bin
    double anisotropy;             // mean of cos 2 theta: 1 all level, 0 none preferred, -1 all upright
    double janssen;                // share of the weight that walls other than the floor carry
};

/* Of a column of `length` and `height`, m, whose gate stands at x = length. */
void packing_measure(const struct view *view, double length, double height, struct packing *out);

#endif
