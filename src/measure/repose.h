/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The slope of a heap that has formed under a hopper (seed 001, B.2; protocols 2.4). */
#ifndef SCREE_MEASURE_REPOSE_H
#define SCREE_MEASURE_REPOSE_H

#include "base/status.h"
#include "view.h"

struct repose {
    double (*row)[2]; // of rings about the axis: radius of the middle, height of the surface, mean over azimuth, m; owned
    size_t rings;
    double height; // of the highest ring, m
    double angle;  // of the line through the rings between 20 and 80 % of that, degrees; NaN with fewer than three
    double left;   // share of the bodies above the ledge
};

/* Of bodies under `ledge`, m, about the middle of a square floor of side `floor`, m, in rings `width` m wide. */
enum scree_status repose_measure(const struct view *view, double floor, double ledge, double width, struct repose *out,
                                 struct scree_error *err);
void repose_free(struct repose *repose);

#endif
