/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `layer` as the user sees it: what `incline` is to grains, for the continuum. */
#include <math.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct layer_params, member)

static const struct field fields[] = {
    {.name = "slope_deg",
     .type = FIELD_REAL,
     AT(slope_deg),
     .min = 0,
     .max = 60,
     .preset = 23.5,
     .unit = "deg",
     .doc = "angle of gravity to the normal of the base",
     .source = "seed 002 section 2.2",
     .steerable = true},
    SPEC_GRAVITY_ROW(AT(gravity_m_s2)),
    {.name = "depth_m",
     .type = FIELD_REAL,
     AT(depth_m),
     .min = 1e-6,
     .max = 100,
     .preset = 0.02,
     .unit = "m",
     .doc = "of the material, at its densest",
     .source = ""},
    {.name = "cells",
     .type = FIELD_INT,
     AT(cells),
     .min = 2,
     .max = 10000,
     .preset = 20,
     .unit = "cells",
     .doc = "through the depth; the box has a quarter more above",
     .source = ""},
    {.name = "continuum", .type = FIELD_GROUP, AT(continuum), .unit = "", .doc = "", .source = "", .table = &continuum_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct layer_params)};
_Static_assert(sizeof(struct layer_params) <= SPEC_PARAMS_MAX, "params fit the job");

/* mu(I) with the values of seed 002, section 4.3: a constant coefficient has no steady flow. */
static void layer_defaults(struct job_spec *job)
{
    struct layer_params *p = (struct layer_params *)(void *)job->params;
    p->continuum.law = LAW_MU_I;
    p->continuum.mu = 0.38;
    p->continuum.points = 4;
    p->continuum.jitter = 0;
    job->time.step_s = 5e-4;
    job->time.end_s = 5;
    job->record.basal_force.every_s = 5e-4;
    job->record.bulk.every_s = 0.01;
    job->record.surface.on = true;
    job->record.surface.every_s = 0.1;
    job->record.snapshots.every_s = 0.1;
    job->stop.when = 0;
}

static struct job_cost layer_cost(const struct job_spec *job)
{
    const struct layer_params *p = (const struct layer_params *)(const void *)job->params;
    struct job_cost cost = {.moving = (double)(p->cells * p->continuum.points),
                            .steps = fmax(1, round(job->time.end_s / job->time.step_s))};
    cost.bytes = continuum_bytes(cost.moving, 1.25 * (double)p->cells);
    return cost;
}

/* The grid moves nothing along the slope from cell to cell, so only the way across layers bounds the step. */
static enum scree_status layer_check(const struct job_spec *job, struct scree_error *err)
{
    const struct layer_params *p = (const struct layer_params *)(const void *)job->params;
    double cell = p->depth_m / (double)p->cells;
    return continuum_check(job, &p->continuum, sqrt(2 * p->gravity_m_s2 * p->depth_m), cell, err);
}

const struct scenario_fields scenario_layer_fields = {
    .name = "layer",
    .doc = "an endless layer of granular material on a rough slope, as a continuum: beside `incline`, the same of grains",
    .source = "seed 002, section 2.2",
    .kind = SCENARIO_MPM,
    .material = "glass-beads-2mm",
    .params = &table,
    .defaults = layer_defaults,
    .check = layer_check,
    .cost = layer_cost,
};
