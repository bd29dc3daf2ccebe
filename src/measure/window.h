/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Means over the window that a summary speaks of: from t_0 where the flow was
 * found steady, else the last half of the run. That window is known only
 * afterwards, so running integrals are kept at a bounded number of instants. */
#ifndef SCREE_MEASURE_WINDOW_H
#define SCREE_MEASURE_WINDOW_H

#include "scree.h"

enum { WINDOW_VALUES = 8, WINDOW_INSTANTS = 4096 };

struct window {
    double sum[WINDOW_VALUES]; // of weight * value since the start
    double weight;
    size_t count;   // instants kept
    uint64_t every; // additions an instant stands for
    uint64_t added;
    struct {
        double time_s, weight, sum[WINDOW_VALUES];
    } instants[WINDOW_INSTANTS];
};

void window_start(struct window *window);

/* Adds `values` that stand for `weight` (samples, steps) and end at time_s. */
void window_add(struct window *window, double time_s, double weight, const double values[WINDOW_VALUES]);

/* Means from the last instant at or before from_s to the end; the time at which it begins is returned. */
double window_means(const struct window *window, double from_s, double means[WINDOW_VALUES]);

/* Bytes in use: instants that were not kept need not be stored. */
size_t window_bytes(const struct window *window);
/* Whether a window read from outside is one that additions can make. */
bool window_sound(const struct window *window);

#endif
