/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The shape of a heap of bodies in a box, by the image rules of seed 001, III.C:
 * what a camera above, and one in front, would see, in square pixels. */
#ifndef SCREE_MEASURE_PILE_H
#define SCREE_MEASURE_PILE_H

#include "base/status.h"
#include "view.h"

struct pile {
    /* Where the first column of pixels beyond `from` is of which less than 10 % is covered, seen from above; 20 % and 1 % are
     * its bounds, m. */
    double runout, runout_least, runout_most;
    double height, height_low, height_high; // of the highest body over each line of pixels across, mean and quartiles, m
    double centre[3];                       // of mass, m
    double speed_mean;                      // of the bodies, m/s
    double contacts;                        // coordination number: points of contact between bodies, twice, a body
    double overlap;                         // largest, m
};

/* Of a box from the origin to length, width; bodies outside it are not seen. `from`: a place within the heap, m. */
enum scree_status pile_measure(const struct view *view, double length, double width, double from, double pixel, struct pile *out,
                               struct scree_error *err);

/* Index of the first of `count` shares from `from` on below a threshold, `count` if there is none. */
size_t pile_first_below(const double *share, size_t count, size_t from, double threshold);

#endif
