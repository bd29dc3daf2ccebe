/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A square hopper over the middle of a floor without an end (seed 001, B.2; the
 * paper does not say its geometry, protocols 2.4 does). Its bottom is a wall in
 * which a hole opens; its sides end there. */
#include <string.h>

#include "scenario/rigid.h"

static const struct hopper_params *params_of(const struct job_spec *job)
{
    return (const struct hopper_params *)(const void *)job->params;
}

static double hopper_gravity(const struct job_spec *job)
{
    return params_of(job)->gravity_m_s2;
}

static const struct body_spec *hopper_body(const struct job_spec *job)
{
    return &params_of(job)->body;
}

static enum scree_status hopper_plan(const struct job_spec *job, struct rigid_plan *plan, struct scree_error *err)
{
    const struct hopper_params *p = params_of(job);
    const double middle = 0.5 * p->floor_m, from = middle - 0.5 * p->side_m, to = middle + 0.5 * p->side_m, z = p->height_m;
    const double rim[2] = {middle - 0.5 * p->hole_m, middle + 0.5 * p->hole_m};
    enum { BOTTOM = 1 };
    const struct convex_wall walls[] = {{{0, 0, 0}, {0, 0, 1}, 0},    [BOTTOM] = {{0, 0, z}, {0, 0, 1}, 0},
                                        {{from, 0, 0}, {1, 0, 0}, z}, {{to, 0, 0}, {-1, 0, 0}, z},
                                        {{0, from, 0}, {0, 1, 0}, z}, {{0, to, 0}, {0, -1, 0}, z}};
    enum scree_status status = rigid_fill(job, &p->body, p->gravity_m_s2, plan, err);
    if (status)
        return status;
    _Static_assert(sizeof walls <= sizeof plan->walls, "there is room for all walls");
    memcpy(plan->walls, walls, sizeof walls);
    plan->setup.wall_count = sizeof walls / sizeof *walls;
    plan->setup.gate =
        (struct convex_gate){.present = true, .wall = BOTTOM, .start_s = p->settle_s, .hole = {{rim[0], rim[1]}, {rim[0], rim[1]}}};
    plan->length = plan->width = p->floor_m;
    plan->ledge = z;
    if ((status = rigid_pour(job, (size_t)p->count, p->side_m, p->side_m, plan, err)))
        return status;
    for (size_t k = 0; k < plan->setup.body_count; k++) {
        plan->bodies[k].position[0] += from;
        plan->bodies[k].position[1] += from;
        plan->bodies[k].position[2] += z;
    }
    return SCREE_OK;
}

const struct rigid_scenario rigid_hopper = {"hopper", hopper_plan, hopper_gravity, hopper_body};
