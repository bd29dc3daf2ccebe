/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenarios `incline` and `channel` as the user sees them. */
#include <math.h>

#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct incline_params, member)

#define REAL(member, low, high, value, units, text, from)                                                                          \
    {                                                                                                                              \
        .name = #member, .type = FIELD_REAL, AT(member), .min = low, .max = high, .preset = value, .unit = units, .doc = text,     \
        .source = from, .steerable = true                                                                                          \
    }
#define COUNT(member, low, high, value, units, text, from)                                                                         \
    {                                                                                                                              \
        .name = #member, .type = FIELD_INT, AT(member), .min = low, .max = high, .preset = value, .unit = units, .doc = text,      \
        .source = from                                                                                                             \
    }
/* Rows that both have. */
#define SLOPE    REAL(slope_deg, 0, 60, 23.5, "deg", "angle of gravity to the normal of the base", "seed 000 movie S1")
#define GRAVITY  REAL(gravity_m_s2, 1e-3, 1e3, 9.81, "m/s2", "acceleration of gravity", "")
#define PERIODIC "of the periodic domain: at least two grains, or a grain would touch itself"
#define NX       COUNT(nx, 2, 4000, 10, "grain diameters", "downslope length " PERIODIC, "seed 000 S8")
#define NZ       COUNT(nz, 1, 1000, 10, "grains", "grains over each point of the base: nx * ny * nz flow", "seed 000 S1")
#define SEED     COUNT(base_seed, 0, 9007199254740992.0, 1, "", "realisation of the fixed base", "seed 000 S8")

static const struct field incline_fields[] = {
    SLOPE, GRAVITY, NX, COUNT(ny, 2, 4000, 10, "grain diameters", "cross-slope length " PERIODIC, "seed 000 S8"), NZ, SEED};
static const struct field channel_fields[] = {
    SLOPE,
    GRAVITY,
    NX,
    COUNT(ny, 2, 4000, 50, "grain diameters", "from the wall to the midline; the half at the midline is measured", "seed 000 S4.4"),
    NZ,
    SEED};
static const struct field_table incline_table = {"params", "", incline_fields, sizeof incline_fields / sizeof *incline_fields,
                                                 sizeof(struct incline_params)};
static const struct field_table channel_table = {"params", "", channel_fields, sizeof channel_fields / sizeof *channel_fields,
                                                 sizeof(struct incline_params)};
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

/* Steps must follow impacts of the filling's fall: a few grains' height, and never below 1 m/s; `times` as fast. */
static enum scree_status check_landing(const struct job_spec *job, double times, struct scree_error *err)
{
    double speed = fmax(1.0, sqrt(2 * params_of(job)->gravity_m_s2 * 20 * job->material.radius_m));
    struct job_spec as = *job; // contacts last shortest between the smallest grains
    as.material.radius_m *= 1 - job->material.radius_spread;
    return check_step(&as, times * speed, err);
}

static enum scree_status incline_check(const struct job_spec *job, struct scree_error *err)
{
    double grains = incline_cost(job).moving;
    if (grains > SPEC_GRAINS_MAX)
        return scree_fail(err, SCREE_INVALID, "params",
                          "params: nx * ny * nz = %.4g grains are more than the %.4g that a world holds", grains,
                          (double)SPEC_GRAINS_MAX);
    if (job->record.contact.on)
        return scree_fail(err, SCREE_INVALID, "record.contact",
                          "record.contact: is for scenario collision, where there is one contact");
    enum scree_status status = check_landing(job, 1, err);
    if (!status)
        status = check_flow_only_in_chute(job, err);
    return status ? status : check_intervals(job, err);
}

/* Half of the width is measured: fewer grains abreast are no flow to take means of. */
enum { CHANNEL_MEASURED = 2 };

static enum scree_status channel_check(const struct job_spec *job, struct scree_error *err)
{
    const struct incline_params *p = params_of(job);
    if (p->ny < 2 * CHANNEL_MEASURED)
        return scree_fail(err, SCREE_INVALID, "params.ny",
                          "params.ny: %lld grain diameters leave %.3g in the half that is measured, and it takes at least %d: at "
                          "least %d from the wall to the midline",
                          (long long)p->ny, 0.5 * (double)p->ny, CHANNEL_MEASURED, 2 * CHANNEL_MEASURED);
    struct job_spec at_wall = *job; // as stiff and as damped as a contact with the side wall, met at half the speed
    at_wall.material = material_as_wall(&job->material);
    enum scree_status status = check_landing(&at_wall, 2, err);
    return status ? status : incline_check(job, err);
}

const struct scenario_fields scenario_incline_fields = {
    .name = "incline",
    .doc = "steady flow of grains down a rough incline, periodic downslope and cross-slope",
    .source = "seed 000, Table S1",
    .kind = SCENARIO_DEM,
    .material = "glass-beads-2mm",
    .params = &incline_table,
    .check = incline_check,
    .cost = incline_cost,
};

const struct scenario_fields scenario_channel_fields = {
    .name = "channel",
    .doc = "steady flow of grains down a rough channel, periodic downslope, from an acrylic wall to the midline",
    .source = "seed 000, S4.4",
    .kind = SCENARIO_DEM,
    .material = "glass-beads-2mm",
    .params = &channel_table,
    .check = channel_check,
    .cost = incline_cost,
};
