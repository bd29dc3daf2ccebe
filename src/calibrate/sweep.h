/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The trials of a sweep: values of a range, and which trial takes which.
 *
 * A grid of axes is run through like an odometer, the last axis fastest and the
 * replicas of one point fastest of all, so that the first trials of a sweep
 * already show its spread. */
#ifndef SCREE_CALIBRATE_SWEEP_H
#define SCREE_CALIBRATE_SWEEP_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum { SWEEP_AXES_MAX = 16, SWEEP_TRIALS_MAX = 4096 };

/* {"from", "to", "step"} or {"from", "to", "count"}, with "log" evenly in the logarithm. */
struct sweep_range {
    double from, to;
    double step;  // 0: `count` says how many
    double count; // 0: `step` says how far apart; from a file, hence a double
    bool log;
};

/* How many values the range has. SCREE_INVALID says at `path` what is wrong: both or none of step and count,
 * a step that leads away from `to`, a logarithm of what is not above 0, more than SWEEP_TRIALS_MAX values. */
enum scree_status sweep_range_count(const struct sweep_range *range, const char *path, size_t *count, struct scree_error *err);

/* Value number k of `count`. Rounded to twelve digits, so that 22 + 3 * 0.1 is 22.3; the last value of a
 * range by count is `to` itself. */
double sweep_range_at(const struct sweep_range *range, size_t count, size_t k);

/* A sweep's shape: `counts` values on each axis, `replicas` of every point. */
struct sweep {
    size_t counts[SWEEP_AXES_MAX];
    size_t axes, replicas;
};

/* How many trials it has; SCREE_INVALID above SWEEP_TRIALS_MAX, with the number that was asked for. */
enum scree_status sweep_trials(const struct sweep *sweep, size_t *trials, struct scree_error *err);

/* Which value of each axis, and which replica, trial number `trial` takes. */
void sweep_trial(const struct sweep *sweep, size_t trial, size_t values[SWEEP_AXES_MAX], size_t *replica);

#endif
