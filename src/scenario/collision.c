/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `collision`: one contact, for looking at the law itself. Grain 1
 * comes down along z onto a free sphere, a fixed sphere or a plane at z = 0. */
#include <math.h>
#include <string.h>

#include "scenario/scenario.h"

static const struct collision_params *params_of(const struct job_spec *job)
{
    return (const struct collision_params *)(const void *)job->params;
}

static void collision_gravity(const struct job_spec *job, double gravity[3])
{
    memcpy(gravity, params_of(job)->gravity_m_s2, 3 * sizeof *gravity);
}

static void collision_base(const struct job_spec *job, double *z, double *area_m2)
{
    (void)job;
    *z = 0;
    *area_m2 = 0;
}

static enum scree_status collision_build(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                                         struct scree_error *err)
{
    const struct collision_params *p = params_of(job);
    double r1 = p->radius1_m > 0 ? p->radius1_m : job->material.radius_m;
    double r2 = p->radius2_m > 0 ? p->radius2_m : job->material.radius_m;
    bool plane = p->partner >= PARTNER_PLANE, fixed = p->partner == PARTNER_FIXED_SPHERE;
    struct dem_grain grains[2] = {
        {.position = {0, 0, r1 + p->gap_m},
         .velocity = {p->tangential_m_s[0], p->tangential_m_s[1], -p->speed_m_s},
         .radius = r1,
         .density = job->material.density_kg_m3},
        {.position = {0, 0, -r2}, .radius = r2, .density = job->material.density_kg_m3, .fixed = fixed},
    };
    memcpy(grains[0].spin, p->spin1_rad_s, sizeof grains[0].spin);
    memcpy(grains[1].spin, p->spin2_rad_s, sizeof grains[1].spin);
    const struct dem_wall floor = {.normal = {0, 0, 1}, .base = true, .partner = collision_kind(job)};
    struct dem_setup setup = {.step_s = job->time.step_s,
                              .grains = grains,
                              .grain_count = plane ? 1 : 2,
                              .walls = &floor,
                              .wall_count = plane ? 1 : 0,
                              .material = job->material,
                              .floor_z = -INFINITY,
                              .threads = means->threads,
                              .isa = means->isa,
                              .ledger = job->record.energy.on};
    collision_gravity(job, setup.gravity);
    return dem_create(&setup, out, err);
}

const struct scenario scenario_collision = {
    .name = "collision", .build = collision_build, .gravity = collision_gravity, .base = collision_base};
