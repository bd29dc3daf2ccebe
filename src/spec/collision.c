/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `collision` as the user sees it. */
#include <math.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct collision_params, member)

static const char *const partners[] = {"sphere", "fixed_sphere", "plane", "wall", "mirror", NULL};

static const struct field fields[] = {
    {.name = "partner",
     .type = FIELD_ENUM,
     AT(partner),
     .preset = PARTNER_SPHERE,
     .unit = "",
     .doc = "what grain 1 meets: a like sphere, one that is fixed, a plane of its own matter, a side wall of material.wall, or its "
            "image in a plane of symmetry",
     .source = "seed 000 S4.1, S4.4",
     .choices = partners},
    {.name = "speed_m_s",
     .type = FIELD_REAL,
     AT(speed_m_s),
     .min = 1e-6,
     .max = 100,
     .preset = 0.14,
     .unit = "m/s",
     .doc = "closing speed along the normal",
     .source = "seed 000 S4.3"},
    {.name = "gap_m",
     .type = FIELD_REAL,
     AT(gap_m),
     .min = 0,
     .max = 1,
     .preset = 0,
     .unit = "m",
     .doc = "between the surfaces at the start; below 0 they would overlap",
     .source = ""},
    {.name = "radius1_m",
     .type = FIELD_REAL,
     AT(radius1_m),
     .min = 0,
     .max = 10,
     .preset = 0,
     .unit = "m",
     .doc = "of grain 1; 0 takes the material's",
     .source = ""},
    {.name = "radius2_m",
     .type = FIELD_REAL,
     AT(radius2_m),
     .min = 0,
     .max = 10,
     .preset = 0,
     .unit = "m",
     .doc = "of the sphere it meets; 0 takes the material's",
     .source = ""},
    {.name = "tangential_m_s",
     .type = FIELD_VEC3,
     AT(tangential_m_s),
     .min = -100,
     .max = 100,
     .preset = 0,
     .unit = "m/s",
     .doc = "velocity of grain 1 in the plane of contact; its z must be 0",
     .source = ""},
    {.name = "spin1_rad_s",
     .type = FIELD_VEC3,
     AT(spin1_rad_s),
     .min = -1e6,
     .max = 1e6,
     .preset = 0,
     .unit = "rad/s",
     .doc = "of grain 1; the normal is z",
     .source = ""},
    {.name = "spin2_rad_s",
     .type = FIELD_VEC3,
     AT(spin2_rad_s),
     .min = -1e6,
     .max = 1e6,
     .preset = 0,
     .unit = "rad/s",
     .doc = "of the free sphere it meets",
     .source = ""},
    {.name = "gravity_m_s2",
     .type = FIELD_VEC3,
     AT(gravity_m_s2),
     .min = -1e3,
     .max = 1e3,
     .preset = 0,
     .unit = "m/s2",
     .doc = "acceleration of gravity",
     .source = ""},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct collision_params)};
_Static_assert(sizeof(struct collision_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct collision_params *params_of(const struct job_spec *job)
{
    return (const struct collision_params *)(const void *)job->params;
}

int collision_kind(const struct job_spec *job)
{
    int partner = params_of(job)->partner;
    return partner == PARTNER_WALL ? BEAD_WALL : partner == PARTNER_MIRROR ? BEAD_MIRROR : BEAD_BEAD;
}

static void collision_defaults(struct job_spec *job)
{
    job->time = (struct time_spec){.step_s = 5e-8, .end_s = 1e-3};
    job->stop.when = 0;
    job->record.basal_force.on = job->record.bulk.on = false;
    job->record.contact.on = true;
}

static struct job_cost collision_cost(const struct job_spec *job)
{
    return (struct job_cost){.moving = params_of(job)->partner == PARTNER_SPHERE ? 2 : 1,
                             .fixed = params_of(job)->partner == PARTNER_FIXED_SPHERE ? 1 : 0,
                             .steps = fmax(1, round(job->time.end_s / job->time.step_s)),
                             .bytes = 1e6};
}

static enum scree_status collision_check(const struct job_spec *job, struct scree_error *err)
{
    const struct collision_params *p = params_of(job);
    char text[TEXT_REAL_MAX];
    if (job->record.profiles.on || job->record.connectivity.on)
        return scree_fail(err, SCREE_INVALID, job->record.profiles.on ? "record.profiles" : "record.connectivity",
                          "record.%s: is for flows over a base, and scenario collision has none",
                          job->record.profiles.on ? "profiles" : "connectivity");
    if (p->tangential_m_s[2] != 0)
        return scree_fail(err, SCREE_INVALID, "params.tangential_m_s[2]",
                          "params.tangential_m_s[2]: %s m/s is not 0: z is the normal, and the velocity along it is speed_m_s",
                          text_real(p->tangential_m_s[2], text));
    struct job_spec as = *job; // the contact's own time scale: of the smaller grain
    double r1 = p->radius1_m > 0 ? p->radius1_m : job->material.radius_m;
    double r2 = p->radius2_m > 0 ? p->radius2_m : job->material.radius_m;
    double speed = collision_kind(job) == BEAD_BEAD ? p->speed_m_s : 2 * p->speed_m_s; // as two beads' that meet in the middle
    if (collision_kind(job) == BEAD_WALL)
        as.material = material_as_wall(&job->material);
    as.material.radius_m = p->partner >= PARTNER_PLANE || r1 < r2 ? r1 : r2;
    enum scree_status status = check_step(&as, speed, err);
    if (!status)
        status = check_flow_only_in_chute(job, err);
    return status ? status : check_intervals(job, err);
}

const struct scenario_fields scenario_collision_fields = {
    .name = "collision",
    .doc = "one contact: a grain meets a sphere or a plane, with any velocity and spin",
    .source = "seed 000, S4.1, S4.5",
    .kind = SCENARIO_DEM,
    .material = "glass-beads-2mm",
    .params = &table,
    .defaults = collision_defaults,
    .check = collision_check,
    .cost = collision_cost,
};
