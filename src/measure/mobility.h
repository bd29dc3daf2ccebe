/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A flow of bodies that is let go, runs out and comes to rest: how far its centre
 * of mass got, how agitated it was, what it lost (seed 003, 3.3 and 3.4). */
#ifndef SCREE_MEASURE_MOBILITY_H
#define SCREE_MEASURE_MOBILITY_H

#include "geom/chute.h"
#include "scree.h"
#include "view.h"

/* What a measurement must know beside the view. */
struct mobility_site {
    struct chute chute;
    const double (*release)[4]; // by body id: x, y, z at release, m, and mass, kg
    size_t count;
    double grain_m; // size, delta
};

struct mobility {
    size_t bodies, in_flow; // all, and of the flow proper: the largest set of bodies that touch one another
    double mass, volume;    // of the flow proper, kg, m3
    double mobility;        // mu_A, eq. 14: drop over horizontal way of its centre of mass, from that of all at release (Fig. 8)
    double trimmed;         // the same from the centre of its own bodies at release (Fig. 9)
    double upper;           // of the part whose front is 3 cm less far
    double lower;           // of all bodies
    double beta;            // eq. 16 in the paper's unit: lengths in mm over the width in cm squared
    double front, rear;     // of the flow proper along the chute from x = 0, m
    double cube_height,
        cube_front; // mean rank of the largest bodies above the floor and along the chute, 0..1; 0.5: no segregation
    double overlap; // largest of any contact, in grain sizes
};

/* Of the state seen. `in_flow` (may be NULL) gets a 1 for each body, in the view's
 * order, that belongs to the flow proper. */
enum scree_status mobility_measure(const struct view *view, const struct mobility_site *site, struct mobility *out,
                                   uint8_t *in_flow, struct scree_error *err);

/* The central 5 cm of the flow: bodies within 2.5 cm, along the chute, of the median of the mass; overlaps of all
 * contacts; where on the chute bodies lie still (slower than FLOW_STILL). */
enum { FLOW_PLACE = 1, FLOW_VARIANCE = 3, FLOW_OVERLAP = 10, FLOW_COLUMNS = 13 };
#define FLOW_STILL        0.01  // m/s
#define FLOW_CENTRAL_HALF 0.025 // m
enum scree_status flow_measure(const struct view *view, const struct mobility_site *site, double row[FLOW_COLUMNS],
                               struct scree_error *err);

/* Every body at the end: a row of a frame. */
enum { FRAGMENT_COLUMNS = 16 };
void fragment_row(const struct view_body *body, int in_flow, double row[FRAGMENT_COLUMNS]);

#endif
