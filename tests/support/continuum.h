/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A plain set-up for tests of the continuum: a closed box, material given by the test. */
#ifndef TEST_SUPPORT_CONTINUUM_H
#define TEST_SUPPORT_CONTINUUM_H

#include "unit.h"

#include <math.h>

#include "mpm/mpm.h"

/* Cells of 1 cm, 2 points along an axis on a lattice, slippery walls, gravity down. */
static inline struct mpm_setup continuum_box(int x, int y, int z, const struct mpm_region *region)
{
    return (struct mpm_setup){.step_s = 1e-3,
                              .gravity = {0, 0, -9.81},
                              .length = {0.01 * x, 0.01 * y, 0.01 * z},
                              .cells = {x, y, z},
                              .plane = y == 0,
                              .density = 1500,
                              .regions = region,
                              .region_count = 1,
                              .points_per_cell = 2,
                              .seed = 1,
                              .law = &mpm_law_constant,
                              .coefs = {.mu = 0.5},
                              .grain_diameter = 5e-4,
                              .inertial_density = 2500,
                              .solver = {.tolerance = 1e-16, .sweeps = 4000, .check = 10, .accelerate = true},
                              .threads = 1};
}

static inline struct mpm *continuum_start(const struct mpm_setup *setup)
{
    struct scree_error err;
    struct mpm *mpm = NULL;
    if (mpm_create(setup, &mpm, &err) != SCREE_OK)
        fail_msg("%s", err.message);
    return mpm;
}

static inline void continuum_run(struct mpm *mpm, uint64_t steps)
{
    struct scree_error err;
    if (mpm_advance(mpm, steps, &err) != SCREE_OK)
        fail_msg("%s", err.message);
}

static inline struct continuum_view continuum_view(struct mpm *mpm)
{
    struct continuum_view view;
    assert_int_equal(mpm_view(mpm, &view, NULL), SCREE_OK);
    return view;
}

/* Mean velocity, weighted by volume. */
static inline void continuum_mean(const struct continuum_view *view, double mean[3])
{
    double volume = 0;
    for (int a = 0; a < 3; a++)
        mean[a] = 0;
    for (size_t n = 0; n < view->nodes; n++) {
        for (int a = 0; a < 3; a++)
            mean[a] += view->node_velocity[n][3] * view->node_velocity[n][a];
        volume += view->node_velocity[n][3];
    }
    for (int a = 0; a < 3; a++)
        mean[a] /= volume;
}

#endif
