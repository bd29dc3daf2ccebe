/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `incline` as the user sees it. */
#include <math.h>

#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct incline_params, member)

static const struct field fields[] = {
    {.name = "slope_deg",
     .type = FIELD_REAL,
     AT(slope_deg),
     .min = 0,
     .max = 60,
     .preset = 23.5,
     .unit = "deg",
     .doc = "angle of gravity to the normal of the base",
     .source = "seed 000 movie S1",
     .steerable = true},
    {.name = "gravity_m_s2",
     .type = FIELD_REAL,
     AT(gravity_m_s2),
     .min = 1e-3,
     .max = 1e3,
     .preset = 9.81,
     .unit = "m/s2",
     .doc = "acceleration of gravity",
     .source = "",
     .steerable = true},
    {.name = "nx",
     .type = FIELD_INT,
     AT(nx),
     .min = 2,
     .max = 4000,
     .preset = 10,
     .unit = "grain diameters",
     .doc = "downslope length of the periodic domain: at least two grains, or a grain would touch itself",
     .source = "seed 000 S8"},
    {.name = "ny",
     .type = FIELD_INT,
     AT(ny),
     .min = 2,
     .max = 4000,
     .preset = 10,
     .unit = "grain diameters",
     .doc = "cross-slope length of the periodic domain: at least two grains, or a grain would touch itself",
     .source = "seed 000 S8"},
    {.name = "nz",
     .type = FIELD_INT,
     AT(nz),
     .min = 1,
     .max = 1000,
     .preset = 10,
     .unit = "grains",
     .doc = "grains over each point of the base: nx * ny * nz flow",
     .source = "seed 000 S1"},
    {.name = "base_seed",
     .type = FIELD_INT,
     AT(base_seed),
     .min = 0,
     .max = 9007199254740992.0,
     .preset = 1,
     .unit = "",
     .doc = "realisation of the fixed base",
     .source = "seed 000 S8"},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct incline_params)};
_Static_assert(sizeof(struct incline_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct incline_params *params_of(const struct job_spec *job)
{
    return (const struct incline_params *)(const void *)job->params;
}

static struct job_cost incline_cost(const struct job_spec *job)
{
    const struct incline_params *p = params_of(job);
    double area = (double)(p->nx * p->ny);
    struct job_cost cost = {
        .moving = area * (double)p->nz, .fixed = 1.5 * area, .steps = fmax(1, round(job->time.end_s / job->time.step_s))};
    cost.bytes = (cost.moving + cost.fixed) * SPEC_BYTES_PER_GRAIN;
    return cost;
}

static enum scree_status incline_check(const struct job_spec *job, struct scree_error *err)
{
    const struct incline_params *p = params_of(job);
    double grains = incline_cost(job).moving;
    if (grains > SPEC_GRAINS_MAX)
        return scree_fail(err, SCREE_INVALID, "params",
                          "params: nx * ny * nz = %.4g grains are more than the %.4g that a world holds", grains,
                          (double)SPEC_GRAINS_MAX);
    if (job->record.contact.on)
        return scree_fail(err, SCREE_INVALID, "record.contact",
                          "record.contact: is for scenario collision, where there is one contact");
    /* Impacts of the filling's fall: a few grains' height, and never below 1 m/s. */
    double speed = fmax(1.0, sqrt(2 * p->gravity_m_s2 * 20 * job->material.radius_m));
    struct job_spec as = *job; // contacts last shortest between the smallest grains
    as.material.radius_m *= 1 - job->material.radius_spread;
    enum scree_status status = check_step(&as, speed, err);
    if (!status)
        status = check_flow_only_in_chute(job, err);
    return status ? status : check_intervals(job, err);
}

const struct scenario_fields scenario_incline_fields = {
    .name = "incline",
    .doc = "steady flow of grains down a rough incline, periodic downslope and cross-slope",
    .source = "seed 000, Table S1",
    .kind = SCENARIO_DEM,
    .material = "glass-beads-2mm",
    .params = &table,
    .check = incline_check,
    .cost = incline_cost,
};
