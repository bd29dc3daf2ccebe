/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bodies that are poured into an open box and come to rest. */
#include "scenario/rigid.h"

static const struct settle_params *params_of(const struct job_spec *job)
{
    return (const struct settle_params *)(const void *)job->params;
}

static double settle_gravity(const struct job_spec *job)
{
    return params_of(job)->gravity_m_s2;
}

static const struct body_spec *settle_body(const struct job_spec *job)
{
    return &params_of(job)->body;
}

static enum scree_status settle_plan(const struct job_spec *job, struct rigid_plan *plan, struct scree_error *err)
{
    const struct settle_params *p = params_of(job);
    enum scree_status status = rigid_fill(job, &p->body, p->gravity_m_s2, plan, err);
    if (status)
        return status;
    rigid_box(plan, p->length_m, p->width_m);
    plan->layer = true;
    return rigid_pour(job, (size_t)p->count, p->length_m, p->width_m, plan, err);
}

const struct rigid_scenario rigid_settle = {"settle", settle_plan, settle_gravity, settle_body};
