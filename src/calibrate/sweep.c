/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See sweep.h. */
#include "calibrate/sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/text.h"

static double twelve_digits(double value)
{
    char text[48];
    snprintf(text, sizeof text, "%.12g", value);
    return strtod(text, NULL);
}

static enum scree_status check_step(const struct sweep_range *r, const char *path, struct scree_error *err)
{
    char from[TEXT_REAL_MAX], to[TEXT_REAL_MAX], step[TEXT_REAL_MAX];
    text_real(r->from, from);
    text_real(r->to, to);
    text_real(r->step, step);
    if (!r->log) {
        if ((r->to - r->from) * r->step < 0)
            return scree_fail(err, SCREE_INVALID, path, "%s: a step of %s does not lead from %s to %s", path, step, from, to);
        return SCREE_OK;
    }
    /* On a logarithmic range the step is a factor. */
    if (!(r->step > 0) || r->step == 1 || (r->to - r->from) * (r->step - 1) < 0)
        return scree_fail(err, SCREE_INVALID, path, "%s: a factor of %s does not lead from %s to %s", path, step, from, to);
    return SCREE_OK;
}

enum scree_status sweep_range_count(const struct sweep_range *r, const char *path, size_t *count, struct scree_error *err)
{
    if ((r->step != 0) == (r->count != 0))
        return scree_fail(err, SCREE_INVALID, path, "%s: one of \"step\" and \"count\" is expected, and not 0", path);
    if (r->log && !(r->from > 0 && r->to > 0))
        return scree_fail(err, SCREE_INVALID, path, "%s: a logarithmic range needs ends above 0", path);
    double values = r->count;
    if (r->step != 0) {
        enum scree_status status = check_step(r, path, err);
        if (status)
            return status;
        /* A hair more than the quotient, or 22..24 in steps of 0.1 would lose its 24 to rounding. */
        double steps = r->log ? log(r->to / r->from) / log(r->step) : (r->to - r->from) / r->step;
        values = floor(steps + 1e-9) + 1;
    }
    if (!(values >= 1 && values == floor(values)))
        return scree_fail(err, SCREE_INVALID, path, "%s: \"count\" must be a whole number from 1 on", path);
    if (r->step == 0 && values == 1 && r->from != r->to)
        return scree_fail(err, SCREE_INVALID, path, "%s: one value cannot stand at both ends of a range", path);
    if (values > SWEEP_TRIALS_MAX)
        return scree_fail(err, SCREE_INVALID, path, "%s: %.6g values are more than the %d trials that a sweep may have", path,
                          values, SWEEP_TRIALS_MAX);
    *count = (size_t)values;
    return SCREE_OK;
}

double sweep_range_at(const struct sweep_range *r, size_t count, size_t k)
{
    if (k == 0)
        return r->from;
    if (r->step != 0)
        return twelve_digits(r->log ? r->from * pow(r->step, (double)k) : r->from + (double)k * r->step);
    if (k + 1 >= count)
        return r->to;
    double part = (double)k / (double)(count - 1);
    return twelve_digits(r->log ? r->from * pow(r->to / r->from, part) : r->from + part * (r->to - r->from));
}

enum scree_status sweep_trials(const struct sweep *sweep, size_t *trials, struct scree_error *err)
{
    double product = (double)sweep->replicas; // in floating point: sixteen axes overflow any integer
    for (size_t k = 0; k < sweep->axes; k++)
        product *= (double)sweep->counts[k];
    if (product > SWEEP_TRIALS_MAX) {
        scree_fail(err, SCREE_INVALID, "grid", "grid: %.6g trials are more than the %d that a sweep may have", product,
                   SWEEP_TRIALS_MAX);
        scree_hint(err, "split it into several studies, or take coarser ranges or fewer replicas");
        return SCREE_INVALID;
    }
    *trials = (size_t)product;
    return SCREE_OK;
}

void sweep_trial(const struct sweep *sweep, size_t trial, size_t values[SWEEP_AXES_MAX], size_t *replica)
{
    *replica = trial % sweep->replicas;
    trial /= sweep->replicas;
    for (size_t k = sweep->axes; k-- > 0;) {
        values[k] = trial % sweep->counts[k];
        trial /= sweep->counts[k];
    }
}
