/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An endless layer on a rough slope: one column of cells, the same everywhere along
 * and across, that starts at rest. Forces are of a square metre of base. */
#include <math.h>

#include "scenario/continuum.h"

static const struct layer_params *params_of(const struct job_spec *job)
{
    return (const struct layer_params *)(const void *)job->params;
}

static void layer_gravity(const struct job_spec *job, double gravity[3])
{
    const struct layer_params *p = params_of(job);
    double slope = p->slope_deg * M_PI / 180;
    gravity[0] = p->gravity_m_s2 * sin(slope);
    gravity[1] = 0;
    gravity[2] = -p->gravity_m_s2 * cos(slope);
}

static void layer_plan(const struct job_spec *job, struct continuum_plan *plan)
{
    const struct layer_params *p = params_of(job);
    struct mpm_setup *s = &plan->setup;
    *plan = (struct continuum_plan){.bed = 0};
    continuum_fill(job, &p->continuum, s);
    s->endless = s->plane = true;
    s->cells[2] = (int)p->cells + ((int)p->cells + 3) / 4;
    s->length[2] = p->depth_m * s->cells[2] / (double)p->cells;
    s->length[0] = s->length[1] = 1;
    s->cells[0] = s->cells[1] = 1;
    layer_gravity(job, s->gravity);
    s->walls[MPM_Z_LOW].kind = MPM_STICK;
    plan->regions[0] = (struct mpm_region){{0, 0, 0}, {1, 1, p->depth_m}};
    s->regions = plan->regions;
    s->region_count = 1;
}

const struct continuum_scenario continuum_layer = {"layer", layer_plan, layer_gravity};
