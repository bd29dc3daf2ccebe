/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A bed in a closed box that is tilted step by step (seed 002, section 2.4): the
 * box stays and gravity turns. Sides slip, the floor sticks. */
#include <math.h>

#include "scenario/continuum.h"

static const struct tilt_params *params_of(const struct job_spec *job)
{
    return (const struct tilt_params *)(const void *)job->params;
}

static void tilt_gravity(const struct job_spec *job, double gravity[3])
{
    const struct tilt_params *p = params_of(job);
    double angle = p->from_deg * M_PI / 180;
    gravity[0] = p->gravity_m_s2 * sin(angle);
    gravity[1] = 0;
    gravity[2] = -p->gravity_m_s2 * cos(angle);
}

static void tilt_plan(const struct job_spec *job, struct continuum_plan *plan)
{
    const struct tilt_params *p = params_of(job);
    struct mpm_setup *s = &plan->setup;
    *plan = (struct continuum_plan){.bed = p->bed_m, .gate_x = p->length_m};
    continuum_fill(job, &p->continuum, s);
    s->plane = p->plane;
    const double length[3] = {p->length_m, p->width_m, p->height_m};
    const int64_t cells[3] = {p->cells_x, p->cells_y, p->cells_z};
    for (int a = 0; a < 3; a++) {
        s->length[a] = length[a];
        s->cells[a] = (int)cells[a];
    }
    tilt_gravity(job, s->gravity);
    s->tilt = (struct mpm_tilt){.from = p->from_deg * M_PI / 180,
                                .to = p->to_deg * M_PI / 180,
                                .step = p->step_deg * M_PI / 180,
                                .hold_s = p->hold_s,
                                .weight = p->gravity_m_s2};
    s->walls[MPM_Z_LOW].kind = MPM_STICK;
    plan->regions[0] = (struct mpm_region){{0, 0, 0}, {p->length_m, p->width_m, p->bed_m}};
    s->regions = plan->regions;
    s->region_count = 1;
}

const struct continuum_scenario continuum_tilt = {"tilt", tilt_plan, tilt_gravity};
