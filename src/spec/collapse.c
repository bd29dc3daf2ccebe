/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `collapse` as the user sees it, with the published runs. Lengths are
 * those that the published script used (protocols 3.1), not the rounded ones of
 * the paper's tables; for granules the script's columns are 0.1 m longer. */
#include <math.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct collapse_params, member)

enum { RUN_BEADS = 0, RUN_GRANULES = 5, RUN_COUNT = 9 };
static const char *const runs[] = {"B00", "B05", "B10", "B15", "B20", "G00", "G05", "G10", "G15", NULL};
static const struct {
    double slope_deg, height_m, length_m, end_s; // end: a little after the published rest, from the start of the wait
} published[RUN_COUNT] = {
    {0, 0.1194, 0.224, 1.4},   {5, 0.1108, 0.224, 1.6},   {10, 0.1108, 0.224, 2.0},
    {15, 0.1108, 0.2244, 2.2}, {20, 0.1182, 0.2244, 3.2}, {0, 0.1138, 0.2868, 1.2},
    {5, 0.1243, 0.2979, 1.2},  {10, 0.1150, 0.3789, 1.4}, {15, 0.1171, 0.3677, 1.6},
};

#define LENGTH(key, most, value, what, where)                                                                                      \
    {                                                                                                                              \
        .name = #key, .type = FIELD_REAL, AT(key), .min = 1e-4, .max = most, .preset = value, .unit = "m", .doc = what,            \
        .source = where                                                                                                            \
    }

static const struct field fields[] = {
    {.name = "run",
     .type = FIELD_ENUM,
     AT(run),
     .preset = 0,
     .unit = "",
     .doc = "published run whose values the other keys start from: beads B00-B20, granules G00-G15",
     .source = "seed 002 Tables 2, 3",
     .choices = runs},
    {.name = "slope_deg",
     .type = FIELD_REAL,
     AT(slope_deg),
     .min = -60,
     .max = 60,
     .preset = 0,
     .unit = "deg",
     .doc = "of the bed, downwards along x",
     .source = "seed 002 Table 2",
     .steerable = true},
    SPEC_GRAVITY_ROW(AT(gravity_m_s2)),
    LENGTH(height_m, 100, 0.1194, "of the column over the bed", "protocols 3.1"),
    LENGTH(length_m, 100, 0.224, "of the column from the back wall to the gate", "protocols 3.1"),
    LENGTH(width_m, 100, 0.06, "of the channel", "seed 002 section 3.2"),
    {.name = "bed_m",
     .type = FIELD_REAL,
     AT(bed_m),
     .min = 0,
     .max = 100,
     .preset = 0.014925,
     .unit = "m",
     .doc = "depth of the erodible bed under column and channel; the published code's is an eighth of the column's height, the "
            "paper's 0.02 m",
     .source = "protocols 3.1"},
    LENGTH(box_length_m, 1000, 0.62, "of the whole channel; rounded up to whole cells", "protocols 3.1"),
    LENGTH(box_height_m, 100, 0.14925, "of the box over its floor; rounded up to whole cells", "protocols 3.1"),
    {.name = "plane",
     .type = FIELD_BOOL,
     AT(plane),
     .preset = 0,
     .unit = "",
     .doc = "two dimensions: no side walls, forces and masses are per metre of width",
     .source = "seed 002 section 5.1"},
    LENGTH(cell_m, 10, 0.01, "edge of a cell along and across the channel; fitted so that the column is whole cells",
           "seed 002 section 4.1"),
    LENGTH(cell_height_m, 10, 0.005, "height of a cell; fitted so that bed and column together are whole cells",
           "seed 002 section 4.1"),
    {.name = "cells_across",
     .type = FIELD_INT,
     AT(cells_across),
     .min = 0,
     .max = 10000,
     .preset = 0,
     .unit = "cells",
     .doc = "across the channel; 0: of about cell_m. Profiles hardly differ across it, so that few do for most purposes",
     .source = "seed 002 section 4.2"},
    {.name = "mu_wall",
     .type = FIELD_REAL,
     AT(mu_wall),
     .min = 0,
     .max = 10,
     .preset = 0.23,
     .unit = "",
     .doc = "friction coefficient of side and back walls",
     .source = "seed 002 Table 1"},
    {.name = "mu_gate",
     .type = FIELD_REAL,
     AT(mu_gate),
     .min = 0,
     .max = 10,
     .preset = 0.23,
     .unit = "",
     .doc = "friction coefficient of the gate; 0.18 in the paper's B.2",
     .source = "protocols 3.1"},
    {.name = "gate_speed_m_s",
     .type = FIELD_REAL,
     AT(gate_speed_m_s),
     .min = 0,
     .max = 1e3,
     .preset = 0.7,
     .unit = "m/s",
     .doc = "v of the gate's U(t) = v (1 - exp(-(t - wait)/tau))",
     .source = "protocols 3.1"},
    {.name = "gate_tau_s",
     .type = FIELD_REAL,
     AT(gate_tau_s),
     .min = 0,
     .max = 1e3,
     .preset = 0.13,
     .unit = "s",
     .doc = "tau of the gate; 0: at once",
     .source = "protocols 3.1"},
    {.name = "gate_wait_s",
     .type = FIELD_REAL,
     AT(gate_wait_s),
     .min = 0,
     .max = 1e3,
     .preset = 0.2,
     .unit = "s",
     .doc = "time before the gate lifts, in which the column settles; times of the deposit count from its end",
     .source = "protocols 3.1"},
    {.name = "continuum", .type = FIELD_GROUP, AT(continuum), .unit = "", .doc = "", .source = "", .table = &continuum_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct collapse_params)};
_Static_assert(sizeof(struct collapse_params) <= SPEC_PARAMS_MAX, "params fit the job");

static struct collapse_params *params_of(struct job_spec *job)
{
    return (struct collapse_params *)(void *)job->params;
}

static void collapse_adopt(struct job_spec *job)
{
    struct collapse_params *p = params_of(job);
    p->slope_deg = published[p->run].slope_deg;
    p->height_m = published[p->run].height_m;
    p->length_m = published[p->run].length_m;
    job->time.end_s = published[p->run].end_s;
    p->box_height_m = p->height_m / 0.8;
    p->bed_m = 0.1 * p->box_height_m;
    p->box_length_m = p->length_m + (p->slope_deg >= 20 ? 1.2 : p->slope_deg >= 15 ? 0.8 : 0.4);
    if (p->run >= RUN_GRANULES) {
        p->continuum.density_kg_m3 = 1517;
        p->continuum.grain_m = 2.7e-3;
        p->continuum.mu = 0.75;
        p->mu_wall = p->mu_gate = 0.30;
        p->gate_speed_m_s = 0.8;
        p->gate_tau_s = 0.06;
    }
}

static void collapse_defaults(struct job_spec *job)
{
    job->time.step_s = 1.0 / 1200;
    job->record.basal_force.every_s = 1.0 / 1200;
    job->record.bulk.every_s = 1.0 / 60;
    job->record.surface.on = true;
    job->record.surface.every_s = 1.0 / 15;
    job->record.snapshots.every_s = 1.0 / 15;
    job->stop.when = STOP_REST;
    collapse_adopt(job);
}

static struct job_cost collapse_cost(const struct job_spec *job)
{
    const struct collapse_params *p = (const struct collapse_params *)(const void *)job->params;
    double width = p->plane ? p->cell_m : p->width_m;
    double across = p->cells_across > 0 && !p->plane ? width / (double)p->cells_across : p->cell_m;
    double cell = p->cell_m * across * p->cell_height_m;
    double volume = width * (p->bed_m * p->box_length_m + p->height_m * p->length_m);
    double each = p->plane ? (double)(p->continuum.points * p->continuum.points) : pow((double)p->continuum.points, 3);
    struct job_cost cost = {.moving = fmax(1, volume / cell * each), .steps = fmax(1, round(job->time.end_s / job->time.step_s))};
    cost.bytes = continuum_bytes(cost.moving, width * p->box_length_m * p->box_height_m / cell);
    return cost;
}

static enum scree_status collapse_check(const struct job_spec *job, struct scree_error *err)
{
    const struct collapse_params *p = (const struct collapse_params *)(const void *)job->params;
    char a[TEXT_REAL_MAX], b[TEXT_REAL_MAX];
    if (p->bed_m > 0 && p->cell_height_m > p->bed_m)
        return scree_fail(err, SCREE_INVALID, "params.cell_height_m",
                          "params.cell_height_m: a cell of %s m is higher than the bed of %s m", text_real(p->cell_height_m, a),
                          text_real(p->bed_m, b));
    if (p->cell_m > p->length_m)
        return scree_fail(err, SCREE_INVALID, "params.cell_m", "params.cell_m: a cell of %s m is longer than the column of %s m",
                          text_real(p->cell_m, a), text_real(p->length_m, b));
    if (p->cell_height_m > p->height_m)
        return scree_fail(err, SCREE_INVALID, "params.cell_height_m",
                          "params.cell_height_m: a cell of %s m is higher than the column of %s m", text_real(p->cell_height_m, a),
                          text_real(p->height_m, b));
    if (p->length_m + 3 * p->cell_m > p->box_length_m)
        return scree_fail(err, SCREE_INVALID, "params.box_length_m",
                          "params.box_length_m: the gate at %s m, two cells thick, is outside a box of %s m",
                          text_real(p->length_m, a), text_real(p->box_length_m, b));
    if (p->bed_m + p->height_m > p->box_height_m)
        return scree_fail(err, SCREE_INVALID, "params.box_height_m",
                          "params.box_height_m: bed and column of %s m do not fit a box of %s m",
                          text_real(p->bed_m + p->height_m, a), text_real(p->box_height_m, b));
    double speed = sqrt(2 * p->gravity_m_s2 * p->height_m);
    return continuum_check(job, &p->continuum, speed, fmin(p->cell_m, p->cell_height_m), err);
}

const struct scenario_fields scenario_collapse_fields = {
    .name = "collapse",
    .doc = "a column of granular material, as a continuum, collapses over an erodible bed when its gate lifts",
    .source = "seed 002, section 4, Tables 2-3",
    .kind = SCENARIO_MPM,
    .material = "glass-beads-2mm",
    .params = &table,
    .defaults = collapse_defaults,
    .adopt_key = "run",
    .adopt = collapse_adopt,
    .check = collapse_check,
    .cost = collapse_cost,
};
