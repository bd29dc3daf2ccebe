/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `gas` as the user sees it. */
#include <math.h>

#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct gas_params, member)

static const char *const boxes[] = {"periodic", "walled", NULL};

static const struct field fields[] = {
    {.name = "n",
     .type = FIELD_INT,
     AT(n),
     .min = 2,
     .max = 200,
     .preset = 10,
     .unit = "grains",
     .doc = "along each edge of the box, which holds n^3",
     .source = ""},
    {.name = "solid_fraction",
     .type = FIELD_REAL,
     AT(solid_fraction),
     .min = 1e-6,
     .max = 0.45,
     .preset = 0.1,
     .unit = "",
     .doc = "volume of the grains over that of the box",
     .source = ""},
    {.name = "temperature_m2_s2",
     .type = FIELD_REAL,
     AT(temperature_m2_s2),
     .min = 0,
     .max = 100,
     .preset = 0.01,
     .unit = "m2/s2",
     .doc = "a third of the mean square velocity at the start, exactly; their sum of momenta is 0",
     .source = "seed 000 S6.1"},
    {.name = "box",
     .type = FIELD_ENUM,
     AT(box),
     .preset = GAS_PERIODIC,
     .unit = "",
     .doc = "periodic along x, y and z, or between a floor and a ceiling, whose floor's force is that on the base",
     .source = "",
     .choices = boxes},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct gas_params)};
_Static_assert(sizeof(struct gas_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct gas_params *params_of(const struct job_spec *job)
{
    return (const struct gas_params *)(const void *)job->params;
}

double gas_edge(const struct job_spec *job)
{
    const struct gas_params *p = params_of(job);
    double r = job->material.radius_m, s = job->material.radius_spread;
    double volume = 4.0 / 3.0 * M_PI * r * r * r * (1 + s * s); // mean over radii uniform on r (1 -+ s)
    return (double)p->n * cbrt(volume / p->solid_fraction);
}

static void gas_defaults(struct job_spec *job)
{
    job->time.end_s = 0.1;
    job->stop.when = 0;
    job->record.basal_force.on = job->record.bulk.on = false;
    job->record.energy.on = true;
}

static struct job_cost gas_cost(const struct job_spec *job)
{
    double n = (double)params_of(job)->n;
    struct job_cost cost = {.moving = n * n * n, .steps = fmax(1, round(job->time.end_s / job->time.step_s))};
    cost.bytes = cost.moving * SPEC_BYTES_PER_GRAIN;
    return cost;
}

static enum scree_status gas_check(const struct job_spec *job, struct scree_error *err)
{
    const struct gas_params *p = params_of(job);
    double cell = gas_edge(job) / (double)p->n, largest = job->material.radius_m * (1 + job->material.radius_spread);
    if (job->record.profiles.on || job->record.connectivity.on)
        return scree_fail(err, SCREE_INVALID, job->record.profiles.on ? "record.profiles" : "record.connectivity",
                          "record.%s: is for flows over a base, and scenario gas has none",
                          job->record.profiles.on ? "profiles" : "connectivity");
    if (job->record.contact.on)
        return scree_fail(err, SCREE_INVALID, "record.contact",
                          "record.contact: is for scenario collision, where there is one contact");
    if (cell <= 2 * largest)
        return scree_fail(
            err, SCREE_INVALID, "params.solid_fraction",
            "params.solid_fraction: %.3g leaves %.3g m to each grain, and the largest are %.3g m wide: take less, or a "
            "smaller material.radius_spread",
            p->solid_fraction, cell, 2 * largest);
    struct job_spec as = *job; // contacts last shortest between the smallest grains
    as.material.radius_m *= 1 - job->material.radius_spread;
    /* Two grains of the distribution's tail that meet head on. */
    enum scree_status status = check_step(&as, fmax(0.1, 10 * sqrt(p->temperature_m2_s2)), err);
    if (!status)
        status = check_flow_only_in_chute(job, err);
    return status ? status : check_intervals(job, err);
}

const struct scenario_fields scenario_gas_fields = {
    .name = "gas",
    .doc = "grains that fly about in a box without gravity, elastic or cooling: what measurements are checked on",
    .source = "seed 000, S6.1",
    .kind = SCENARIO_DEM,
    .material = "glass-beads-2mm",
    .params = &table,
    .defaults = gas_defaults,
    .check = gas_check,
    .cost = gas_cost,
};
