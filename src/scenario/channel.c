/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `channel`: the same flow between an acrylic wall at y = 0 and the
 * channel's midline at y = ny d, a plane of symmetry (seed 000 S4.4). Both stand
 * while the base is made. What is measured is the half of the width away from the
 * wall (S5), so that the wall's drag is in the flow but not in the numbers. */
#include <math.h>

#include "scenario/slope.h"

static enum scree_status channel_build(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                                       struct scree_error *err)
{
    double length[2];
    slope_lengths(job, length);
    const struct slope_sides sides = {.wall = {{.normal = {0, 1, 0}, .partner = BEAD_WALL},
                                               {.point = {0, length[1], 0}, .normal = {0, -1, 0}, .partner = BEAD_MIRROR}},
                                      .count = 2,
                                      .measured_y = {0.5 * length[1], INFINITY}};
    return slope_build(job, &sides, means, out, err);
}

static void channel_profile(const struct job_spec *job, size_t *layers, double *area_m2, double region[2])
{
    double length[2];
    slope_lengths(job, length);
    *layers = (size_t)slope_params(job)->nz;
    *area_m2 = length[0] * 0.5 * length[1];
    region[0] = 0.5 * length[1];
}

const struct scenario scenario_channel = {
    .name = "channel", .build = channel_build, .gravity = slope_gravity, .base = slope_top, .profile = channel_profile};
