/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A column of bodies that settles behind a gate, which then goes (seed 001, III).
 * The gate is the box's sixth wall. */
#include "scenario/rigid.h"

static const struct dam_break_params *params_of(const struct job_spec *job)
{
    return (const struct dam_break_params *)(const void *)job->params;
}

static double dam_break_gravity(const struct job_spec *job)
{
    return params_of(job)->gravity_m_s2;
}

static const struct body_spec *dam_break_body(const struct job_spec *job)
{
    return &params_of(job)->body;
}

static enum scree_status dam_break_plan(const struct job_spec *job, struct rigid_plan *plan, struct scree_error *err)
{
    const struct dam_break_params *p = params_of(job);
    enum scree_status status = rigid_fill(job, &p->body, p->gravity_m_s2, plan, err);
    if (status)
        return status;
    rigid_box(plan, p->length_m, p->width_m);
    plan->setup.gate = (struct convex_gate){.present = true,
                                            .wall = (uint32_t)plan->setup.wall_count,
                                            .start_s = p->settle_s,
                                            .acceleration = p->gate_m_s2,
                                            .speed = p->gate_m_s};
    plan->walls[plan->setup.wall_count++] = (struct convex_wall){{p->column_m, 0, 0}, {-1, 0, 0}, 0};
    return rigid_pour(job, (size_t)p->count, p->column_m, p->width_m, plan, err);
}

const struct rigid_scenario rigid_dam_break = {"dam_break", dam_break_plan, dam_break_gravity, dam_break_body};
