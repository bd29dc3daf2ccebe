/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A column behind a gate on an erodible bed (seed 002, section 4; protocols 3.1).
 *
 * x runs down the channel from the back wall, z up from the floor. The grid is
 * fitted to the set-up: gate and back wall, side walls and the top of the bed lie
 * on layers of nodes. The published code has rigid bodies of one cell for back
 * and side walls and a box that is wider by those; here the walls are faces of the
 * box, with the same friction. Floor and far end stick, the top slips. */
#include <math.h>

#include "scenario/continuum.h"

static const struct collapse_params *params_of(const struct job_spec *job)
{
    return (const struct collapse_params *)(const void *)job->params;
}

static void collapse_gravity(const struct job_spec *job, double gravity[3])
{
    const struct collapse_params *p = params_of(job);
    double slope = p->slope_deg * M_PI / 180;
    gravity[0] = p->gravity_m_s2 * sin(slope);
    gravity[1] = 0;
    gravity[2] = -p->gravity_m_s2 * cos(slope);
}

/* Whole cells of about `wanted` that fill `length`; at least one. */
static int whole(double length, double wanted)
{
    return (int)fmax(1, round(length / wanted));
}

static void fit_grid(const struct collapse_params *p, struct mpm_setup *s)
{
    double along = p->length_m / whole(p->length_m, p->cell_m);
    double fitted = p->bed_m > 0 ? p->bed_m : p->height_m, up = fitted / whole(fitted, p->cell_height_m);
    s->cells[0] = (int)ceil(p->box_length_m / along - 1e-9);
    s->cells[1] = p->cells_across > 0 ? (int)p->cells_across : whole(p->width_m, p->cell_m);
    s->cells[2] = (int)ceil(p->box_height_m / up - 1e-9);
    s->length[0] = s->cells[0] * along;
    s->length[1] = p->width_m;
    s->length[2] = s->cells[2] * up;
}

static void collapse_plan(const struct job_spec *job, struct continuum_plan *plan)
{
    const struct collapse_params *p = params_of(job);
    struct mpm_setup *s = &plan->setup;
    *plan = (struct continuum_plan){.bed = p->bed_m, .gate_x = p->length_m, .height = p->height_m, .start_s = p->gate_wait_s};
    continuum_fill(job, &p->continuum, s);
    s->plane = p->plane;
    fit_grid(p, s);
    collapse_gravity(job, s->gravity);
    const struct mpm_wall side = {p->mu_wall > 0 ? MPM_FRICTION : MPM_SLIP, .mu = p->mu_wall};
    s->walls[MPM_X_LOW] = s->walls[MPM_Y_LOW] = s->walls[MPM_Y_HIGH] = side;
    s->walls[MPM_X_HIGH].kind = s->walls[MPM_Z_LOW].kind = MPM_STICK;
    double width = s->length[1], top = p->bed_m + p->height_m, cell = s->length[0] / s->cells[0];
    if (p->bed_m > 0)
        plan->regions[s->region_count++] = (struct mpm_region){{0, 0, 0}, {s->length[0], width, p->bed_m}};
    plan->regions[s->region_count++] = (struct mpm_region){{0, 0, p->bed_m}, {p->length_m, width, top}};
    plan->gate = (struct mpm_body){.low = {p->length_m, -width, p->bed_m},
                                   .high = {p->length_m + 2 * cell, 2 * width, 2 * s->length[2]},
                                   .velocity = {0, 0, p->gate_speed_m_s},
                                   .start_s = p->gate_wait_s,
                                   .tau_s = p->gate_tau_s,
                                   .mu = p->mu_gate};
    s->regions = plan->regions;
    s->bodies = &plan->gate;
    s->body_count = 1;
}

const struct continuum_scenario continuum_collapse = {"collapse", collapse_plan, collapse_gravity};
