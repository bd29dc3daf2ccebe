/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pairs of boxes out of a column, and how long their distances take. */
#ifndef SCREE_BENCH_PAIRS_H
#define SCREE_BENCH_PAIRS_H

#ifdef __cplusplus
extern "C" {
#else
#include "convex/convex.h"

enum scree_status pairs_compare(struct convex *world, const struct composite *shape, struct scree_error *err);
#endif

double pairs_seconds(void); // of processor time

struct placed_box {
    double half[3];    // m
    double axis[3][3]; // in space
    double centre[3];  // m
};
struct box_pair {
    struct placed_box a, b;
};

/* Another library's test of `count` pairs, `rounds` times over: nanoseconds a pair, and how many it calls overlapping. */
struct other {
    const char *name;
    double (*time)(const struct box_pair *pair, unsigned long count, int rounds, unsigned long *overlapping);
};
extern const struct other others[];
extern const int other_count;

#ifdef __cplusplus
}
#endif
#endif
