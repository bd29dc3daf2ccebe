/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `settle` as the user sees it: bodies poured into a box, until they rest. */
#include <math.h>

#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct settle_params, member)

static const struct field fields[] = {
    SPEC_GRAVITY_ROW(AT(gravity_m_s2)),
    {.name = "count",
     .type = FIELD_INT,
     AT(count),
     .min = 1,
     .max = 1000000,
     .preset = 200,
     .unit = "bodies",
     .doc = "how many are poured, one shape",
     .source = ""},
    {.name = "length_m",
     .type = FIELD_REAL,
     AT(length_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.1,
     .unit = "m",
     .doc = "of the box",
     .source = ""},
    {.name = "width_m",
     .type = FIELD_REAL,
     AT(width_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.1,
     .unit = "m",
     .doc = "of the box",
     .source = ""},
    {.name = "body", .type = FIELD_GROUP, AT(body), .unit = "", .doc = "", .source = "", .table = &body_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct settle_params)};
_Static_assert(sizeof(struct settle_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct settle_params *params_of(const struct job_spec *job)
{
    return (const struct settle_params *)(const void *)job->params;
}

static void settle_defaults(struct job_spec *job)
{
    rigid_defaults(job);
    job->time.end_s = 3;
    job->stop.when = 1 << 0; // rest
}

static struct job_cost settle_cost(const struct job_spec *job)
{
    return rigid_cost(job, (double)params_of(job)->count);
}

static enum scree_status settle_check(const struct job_spec *job, struct scree_error *err)
{
    const struct settle_params *p = params_of(job);
    return rigid_check(job, &p->body, p->length_m, p->width_m, "params.length_m", err);
}

const struct scenario_fields scenario_settle_fields = {
    .name = "settle",
    .doc = "rigid bodies (crosses, boxes, tetrapods, spheres) poured into an open box, until they rest",
    .source = "seed 001, III.A and B.1",
    .kind = SCENARIO_DEM,
    .material = "plastic-crosses",
    .params = &table,
    .defaults = settle_defaults,
    .check = settle_check,
    .cost = settle_cost,
};
