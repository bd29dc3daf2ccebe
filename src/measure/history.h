/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Running sums of many numbers, kept at a bounded number of instants: means over a
 * window that is known only afterwards (window.h says why), for vectors. */
#ifndef SCREE_MEASURE_HISTORY_H
#define SCREE_MEASURE_HISTORY_H

#include "measure/measure.h"

enum { HISTORY_INSTANTS = 128 };

/* Plain data of a measurement's state; the numbers are in two of its buffers. */
struct history {
    uint64_t width;        // of the vector
    uint64_t every, added; // instants: additions each stands for; additions so far
};
enum { HISTORY_NOW, HISTORY_KEPT, HISTORY_BUFFERS }; // of the measurement's buffers, from the first given

/* Sums start at 0. `buffers` are HISTORY_BUFFERS of the measurement's. */
enum scree_status history_start(struct history *history, struct measure_buffer *buffers, size_t width, struct scree_error *err);

/* The sums, for adding to. */
double *history_sums(struct measure_buffer *buffers);

/* Keeps the sums as those at time_s. */
enum scree_status history_keep(struct history *history, struct measure_buffer *buffers, double time_s, struct scree_error *err);

/* Sums from the last instant at or before from_s to now, into `out`; returns that instant's time (0: the start). Where
 * nothing has been added since, those from an instant earlier. */
double history_since(const struct history *history, const struct measure_buffer *buffers, double from_s, double *out);

/* Whether a restored one is one that additions can make; width as started. */
bool history_sound(const struct history *history, const struct measure_buffer *buffers, size_t width);

#endif
