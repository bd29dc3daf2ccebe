/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `tilt` as the user sees it: the avalanche angle of the continuum. */
#include <math.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct tilt_params, member)

#define LENGTH(key, value, what)                                                                                                   \
    {                                                                                                                              \
        .name = #key, .type = FIELD_REAL, AT(key), .min = 1e-4, .max = 1e3, .preset = value, .unit = "m", .doc = what,             \
        .source = "seed 002 section 2.4"                                                                                           \
    }
#define ANGLE(key, least, value, what)                                                                                             \
    {                                                                                                                              \
        .name = #key, .type = FIELD_REAL, AT(key), .min = least, .max = 80, .preset = value, .unit = "deg", .doc = what,           \
        .source = "seed 002 section 2.4"                                                                                           \
    }
#define CELLS(key, value, what)                                                                                                    \
    {                                                                                                                              \
        .name = #key, .type = FIELD_INT, AT(key), .min = 1, .max = 10000, .preset = value, .unit = "cells", .doc = what,           \
        .source = "seed 002 section 2.4"                                                                                           \
    }

static const struct field fields[] = {
    ANGLE(from_deg, -80, 18, "inclination at the start"),
    ANGLE(to_deg, -80, 30, "inclination at which tilting ends"),
    ANGLE(step_deg, 0.001, 0.5, "added at once each time"),
    {.name = "hold_s",
     .type = FIELD_REAL,
     AT(hold_s),
     .min = 1e-6,
     .max = 1e6,
     .preset = 0.5,
     .unit = "s",
     .doc = "time at each inclination, in which the bed comes to rest",
     .source = ""},
    {.name = "gravity_m_s2",
     .type = FIELD_REAL,
     AT(gravity_m_s2),
     .min = 1e-3,
     .max = 1e3,
     .preset = 9.81,
     .unit = "m/s2",
     .doc = "acceleration of gravity",
     .source = ""},
    LENGTH(length_m, 1, "of the box"),
    LENGTH(height_m, 0.3, "of the box"),
    LENGTH(width_m, 0.1, "of the box"),
    LENGTH(bed_m, 0.1, "depth of the bed"),
    {.name = "plane",
     .type = FIELD_BOOL,
     AT(plane),
     .preset = 1,
     .unit = "",
     .doc = "two dimensions: forces and masses are per metre of width",
     .source = "seed 002 section 2.4"},
    CELLS(cells_x, 100, "along the box; 250 in the paper's plane, 100 in space"),
    CELLS(cells_y, 10, "across"),
    CELLS(cells_z, 60, "up; 150 in the paper's plane, 30 in space"),
    {.name = "continuum", .type = FIELD_GROUP, AT(continuum), .unit = "", .doc = "", .source = "", .table = &continuum_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct tilt_params)};
_Static_assert(sizeof(struct tilt_params) <= SPEC_PARAMS_MAX, "params fit the job");

static void tilt_defaults(struct job_spec *job)
{
    struct tilt_params *p = (struct tilt_params *)(void *)job->params;
    p->continuum.points = 3;
    job->time.step_s = 1e-3;
    job->time.end_s = 12.5;
    job->record.basal_force.every_s = 1e-3;
    job->record.bulk.every_s = 0.05;
    job->record.surface.on = true;
    job->record.surface.every_s = 0.5;
    job->record.snapshots.every_s = 0.5;
    job->stop.when = 0;
}

static struct job_cost tilt_cost(const struct job_spec *job)
{
    const struct tilt_params *p = (const struct tilt_params *)(const void *)job->params;
    double cells = (double)p->cells_x * (p->plane ? 1 : (double)p->cells_y) * (double)p->cells_z;
    double each = pow((double)p->continuum.points, p->plane ? 2 : 3);
    struct job_cost cost = {.moving = fmax(1, cells * fmin(1, p->bed_m / p->height_m) * each),
                            .steps = fmax(1, round(job->time.end_s / job->time.step_s))};
    cost.bytes = continuum_bytes(cost.moving, cells);
    return cost;
}

static enum scree_status tilt_check(const struct job_spec *job, struct scree_error *err)
{
    const struct tilt_params *p = (const struct tilt_params *)(const void *)job->params;
    char a[TEXT_REAL_MAX], b[TEXT_REAL_MAX];
    double cell = fmin(p->length_m / (double)p->cells_x, p->height_m / (double)p->cells_z);
    if (p->bed_m > p->height_m)
        return scree_fail(err, SCREE_INVALID, "params.bed_m", "params.bed_m: a bed of %s m does not fit a box of %s m",
                          text_real(p->bed_m, a), text_real(p->height_m, b));
    if (p->height_m / (double)p->cells_z > p->bed_m)
        return scree_fail(err, SCREE_INVALID, "params.cells_z", "params.cells_z: a cell of %s m is higher than the bed of %s m",
                          text_real(p->height_m / (double)p->cells_z, a), text_real(p->bed_m, b));
    if (p->to_deg < p->from_deg)
        return scree_fail(err, SCREE_INVALID, "params.to_deg", "params.to_deg: %s deg is below from_deg, %s deg",
                          text_real(p->to_deg, a), text_real(p->from_deg, b));
    return continuum_check(job, &p->continuum, sqrt(2 * p->gravity_m_s2 * p->bed_m), cell, err);
}

const struct scenario_fields scenario_tilt_fields = {
    .name = "tilt",
    .doc = "a bed of granular material, as a continuum, in a closed box that is tilted step by step: its avalanche angle",
    .source = "seed 002, section 2.4",
    .kind = SCENARIO_MPM,
    .material = "glass-beads-2mm",
    .params = &table,
    .defaults = tilt_defaults,
    .check = tilt_check,
    .cost = tilt_cost,
};
