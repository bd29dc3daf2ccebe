/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `incline`: steady flow down a rough slope, periodic in x and y (seed 000 S5, S8). */
#include "scenario/slope.h"

static enum scree_status incline_build(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                                       struct scree_error *err)
{
    const struct slope_sides none = {.count = 0};
    return slope_build(job, &none, means, out, err);
}

static void incline_profile(const struct job_spec *job, size_t *layers, double *area_m2, double region[2])
{
    (void)area_m2;
    (void)region;
    *layers = (size_t)slope_params(job)->nz;
}

const struct scenario scenario_incline = {
    .name = "incline", .build = incline_build, .gravity = slope_gravity, .base = slope_top, .profile = incline_profile};
