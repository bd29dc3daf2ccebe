/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `dam_break` as the user sees it: a column of bodies behind a gate that goes. */
#include <math.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct dam_break_params, member)

static const struct field fields[] = {
    SPEC_GRAVITY_ROW(AT(gravity_m_s2)),
    {.name = "count",
     .type = FIELD_INT,
     AT(count),
     .min = 1,
     .max = 1000000,
     .preset = 300,
     .unit = "bodies",
     .doc = "how many are poured, one shape",
     .source = "seed 001 III"},
    {.name = "length_m",
     .type = FIELD_REAL,
     AT(length_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.64,
     .unit = "m",
     .doc = "of the box",
     .source = "seed 001 III"},
    {.name = "width_m",
     .type = FIELD_REAL,
     AT(width_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.2,
     .unit = "m",
     .doc = "of the box",
     .source = "seed 001 III"},
    {.name = "column_m",
     .type = FIELD_REAL,
     AT(column_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.12,
     .unit = "m",
     .doc = "length L_0 of the column: where the gate stands",
     .source = "seed 001 III"},
    {.name = "settle_s",
     .type = FIELD_REAL,
     AT(settle_s),
     .min = 0,
     .max = 1e6,
     .preset = 1.5,
     .unit = "s",
     .doc = "when the gate goes; until then the column settles",
     .source = "protocols 2.3"},
    {.name = "gate_m_s2",
     .type = FIELD_REAL,
     AT(gate_m_s2),
     .min = 0,
     .max = 1e9,
     .preset = 0,
     .unit = "m/s2",
     .doc = "acceleration with which the gate is lifted; 0: it vanishes; the experiment's is 43",
     .source = "seed 001 III"},
    {.name = "gate_m_s",
     .type = FIELD_REAL,
     AT(gate_m_s),
     .min = 1e-6,
     .max = 1e6,
     .preset = 3,
     .unit = "m/s",
     .doc = "speed that the gate does not exceed",
     .source = "seed 001 III"},
    {.name = "body", .type = FIELD_GROUP, AT(body), .unit = "", .doc = "", .source = "", .table = &body_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct dam_break_params)};
_Static_assert(sizeof(struct dam_break_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct dam_break_params *params_of(const struct job_spec *job)
{
    return (const struct dam_break_params *)(const void *)job->params;
}

static void dam_break_defaults(struct job_spec *job)
{
    rigid_defaults(job);
    job->time.end_s = 4;
    job->stop.when = 1 << 0; // rest, after the gate has gone
}

static struct job_cost dam_break_cost(const struct job_spec *job)
{
    return rigid_cost(job, (double)params_of(job)->count);
}

/* How far the gate is off the floor when the run ends, m; it speeds up until it has its speed. */
static double gate_lift(const struct dam_break_params *p, double time_s)
{
    if (p->gate_m_s2 == 0)
        return INFINITY; // it vanishes
    double speeding = fmin(time_s, p->gate_m_s / p->gate_m_s2);
    return speeding * (0.5 * p->gate_m_s2 * speeding) + (time_s - speeding) * p->gate_m_s;
}

/* A gate that stands too near the end of its box, or that opens no gap, lets nothing go. */
static enum scree_status check_gate(const struct job_spec *job, struct scree_error *err)
{
    const struct dam_break_params *p = params_of(job);
    char a[TEXT_REAL_MAX], b[TEXT_REAL_MAX];
    const double across = 2 * body_reach(&p->body), gap = body_gap(&p->body);
    const double lift = gate_lift(p, job->time.end_s - p->settle_s);
    if (p->length_m - p->column_m < across)
        return scree_fail(err, SCREE_INVALID, "params.column_m",
                          "params.column_m: a column of %s m in a box of %s m leaves no room to run out to a body that is %.3g m "
                          "across: at most %.3g m",
                          text_real(p->column_m, a), text_real(p->length_m, b), across, p->length_m - across);
    if (lift < gap)
        return scree_fail(
            err, SCREE_INVALID, "params.gate_m_s2",
            "params.gate_m_s2: %s m/s2 lift the gate by %.3g m until the run ends, under which no body that is %.3g m "
            "thin gets out",
            text_real(p->gate_m_s2, a), lift, gap);
    return SCREE_OK;
}

static enum scree_status dam_break_check(const struct job_spec *job, struct scree_error *err)
{
    const struct dam_break_params *p = params_of(job);
    char a[TEXT_REAL_MAX], b[TEXT_REAL_MAX];
    if (p->column_m >= p->length_m)
        return scree_fail(err, SCREE_INVALID, "params.column_m",
                          "params.column_m: a column of %s m does not fit a box of %s m: its gate would stand outside",
                          text_real(p->column_m, a), text_real(p->length_m, b));
    if (p->settle_s >= job->time.end_s)
        return scree_fail(err, SCREE_INVALID, "params.settle_s", "params.settle_s: the gate goes at %s s, and the run ends at %s s",
                          text_real(p->settle_s, a), text_real(job->time.end_s, b));
    enum scree_status status = rigid_check(job, &p->body, p->column_m, p->width_m, "params.column_m", err);
    return status ? status : check_gate(job, err);
}

const struct scenario_fields scenario_dam_break_fields = {
    .name = "dam_break",
    .doc = "a column of rigid bodies, entangled or not, collapses when its gate goes",
    .source = "seed 001, III",
    .kind = SCENARIO_DEM,
    .material = "plastic-crosses",
    .params = &table,
    .defaults = dam_break_defaults,
    .check = dam_break_check,
    .cost = dam_break_cost,
};
