/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `hopper` as the user sees it: a flat-bottomed hopper that empties onto a floor. */
#include <math.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct hopper_params, member)

static const struct field fields[] = {
    SPEC_GRAVITY_ROW(AT(gravity_m_s2)),
    {.name = "count",
     .type = FIELD_INT,
     AT(count),
     .min = 1,
     .max = 1000000,
     .preset = 10000,
     .unit = "bodies",
     .doc = "how many are poured into the hopper, one shape",
     .source = "protocols 2.4"},
    {.name = "floor_m",
     .type = FIELD_REAL,
     AT(floor_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.3,
     .unit = "m",
     .doc = "side of the square of the floor that pictures show; the floor itself has no end",
     .source = ""},
    {.name = "side_m",
     .type = FIELD_REAL,
     AT(side_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.05,
     .unit = "m",
     .doc = "of the hopper, which is square and stands over the floor's middle",
     .source = "protocols 2.4"},
    {.name = "hole_m",
     .type = FIELD_REAL,
     AT(hole_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.016,
     .unit = "m",
     .doc = "side of the square hole in the middle of its bottom, which is flat",
     .source = "protocols 2.4: 8 d"},
    {.name = "height_m",
     .type = FIELD_REAL,
     AT(height_m),
     .min = 1e-4,
     .max = 100,
     .preset = 0.1,
     .unit = "m",
     .doc = "of the hopper's bottom over the floor",
     .source = "protocols 2.4"},
    {.name = "settle_s",
     .type = FIELD_REAL,
     AT(settle_s),
     .min = 0,
     .max = 1e6,
     .preset = 0.3,
     .unit = "s",
     .doc = "when the hole opens",
     .source = ""},
    {.name = "body", .type = FIELD_GROUP, AT(body), .unit = "", .doc = "", .source = "", .table = &body_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct hopper_params)};
_Static_assert(sizeof(struct hopper_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct hopper_params *params_of(const struct job_spec *job)
{
    return (const struct hopper_params *)(const void *)job->params;
}

static void hopper_defaults(struct job_spec *job)
{
    struct hopper_params *p = (struct hopper_params *)(void *)job->params;
    rigid_defaults(job);
    p->body.shape = BODY_SPHERE;
    p->body.radius_m = 1e-3;
    job->time.step_s = 5e-7;
    job->time.end_s = 4;
    job->stop.when = 1 << 0; // rest, after the hole has opened
}

static struct job_cost hopper_cost(const struct job_spec *job)
{
    return rigid_cost(job, (double)params_of(job)->count);
}

static enum scree_status hopper_check(const struct job_spec *job, struct scree_error *err)
{
    const struct hopper_params *p = params_of(job);
    char a[TEXT_REAL_MAX], b[TEXT_REAL_MAX];
    double across = 2 * body_reach(&p->body);
    if (p->side_m > p->floor_m)
        return scree_fail(err, SCREE_INVALID, "params.side_m", "params.side_m: a hopper of %s m is wider than its floor of %s m",
                          text_real(p->side_m, a), text_real(p->floor_m, b));
    if (p->hole_m >= p->side_m)
        return scree_fail(err, SCREE_INVALID, "params.hole_m", "params.hole_m: a hole of %s m leaves no bottom to a hopper of %s m",
                          text_real(p->hole_m, a), text_real(p->side_m, b));
    if (p->hole_m < body_gap(&p->body))
        return scree_fail(err, SCREE_INVALID, "params.hole_m",
                          "params.hole_m: a body that is %s m thick does not get through a hole of %s m",
                          text_real(body_gap(&p->body), a), text_real(p->hole_m, b));
    if (p->height_m < across)
        return scree_fail(err, SCREE_INVALID, "params.height_m",
                          "params.height_m: a body that is %s m across does not get out of a hopper %s m over the floor",
                          text_real(across, a), text_real(p->height_m, b));
    if (p->settle_s >= job->time.end_s)
        return scree_fail(err, SCREE_INVALID, "params.settle_s",
                          "params.settle_s: the hole opens at %s s, and the run ends at %s s", text_real(p->settle_s, a),
                          text_real(job->time.end_s, b));
    return rigid_check(job, &p->body, p->side_m, p->side_m, "params.side_m", err);
}

const struct scenario_fields scenario_hopper_fields = {
    .name = "hopper",
    .doc = "a flat-bottomed hopper empties through a hole onto a floor; the slope of the heap is measured",
    .source = "seed 001, B.2",
    .kind = SCENARIO_DEM,
    .material = "hopper-beads",
    .params = &table,
    .defaults = hopper_defaults,
    .check = hopper_check,
    .cost = hopper_cost,
};
