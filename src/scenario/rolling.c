/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `rolling`: one sphere on a plane, as in the two experiments of seed 000 S4.2 that calibrate rolling resistance.
 *
 * The sphere starts at the overlap whose force carries it (eq. 5 without motion). A sphere that bounced on its contact, however
 * little, would lose a rolling spring's torque each time its normal force falls (eq. 23) and gain none when it rises. */
#include <math.h>
#include <string.h>

#include "scenario/scenario.h"

static const struct rolling_params *params_of(const struct job_spec *job)
{
    return (const struct rolling_params *)(const void *)job->params;
}

static void rolling_gravity(const struct job_spec *job, double gravity[3])
{
    const struct rolling_params *p = params_of(job);
    double slope = p->slope_deg * M_PI / 180;
    gravity[0] = p->gravity_m_s2 * sin(slope);
    gravity[1] = 0;
    gravity[2] = -p->gravity_m_s2 * cos(slope);
}

static void rolling_base(const struct job_spec *job, double *z, double *area_m2)
{
    (void)job;
    *z = 0;
    *area_m2 = 0;
}

/* Overlap at which 2 E sqrt(r) / 3 (1 - nu^2) overlap^(3/2) is the weight across the plane. */
static double resting_overlap(const struct material_spec *m, double weight)
{
    double stiffness = 2 * m->young_Pa * sqrt(m->radius_m) / (3 * (1 - m->poisson * m->poisson));
    return pow(weight / stiffness, 2.0 / 3.0);
}

static enum scree_status rolling_build(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                                       struct scree_error *err)
{
    const struct rolling_params *p = params_of(job);
    const struct material_spec *m = &job->material;
    const struct dem_wall plane = {.normal = {0, 0, 1}, .base = true};
    struct dem_setup setup = {.step_s = job->time.step_s,
                              .grain_count = 1,
                              .walls = &plane,
                              .wall_count = 1,
                              .material = *m,
                              .floor_z = -INFINITY,
                              .threads = means->threads,
                              .isa = means->isa,
                              .ledger = job->record.energy.on};
    rolling_gravity(job, setup.gravity);
    /* Contacts exert no force at t = 0 yet: the half kick with which this one would carry the weight. */
    double carry = -0.5 * setup.gravity[2] * setup.step_s;
    double overlap = resting_overlap(m, -setup.gravity[2] * material_grain_mass(m));
    struct dem_grain sphere = {.position = {0, 0, m->radius_m - overlap},
                               .velocity = {p->speed_m_s, 0, carry},
                               .spin = {0, p->speed_m_s / m->radius_m, 0},
                               .radius = m->radius_m,
                               .density = m->density_kg_m3};
    setup.grains = &sphere;
    return dem_create(&setup, out, err);
}

const struct scenario scenario_rolling = {
    .name = "rolling", .build = rolling_build, .gravity = rolling_gravity, .base = rolling_base};
