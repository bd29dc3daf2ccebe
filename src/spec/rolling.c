/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `rolling` as the user sees it. */
#include <math.h>
#include <stdio.h>

#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct rolling_params, member)

static const struct field fields[] = {
    {.name = "slope_deg",
     .type = FIELD_REAL,
     AT(slope_deg),
     .min = 0,
     .max = 60,
     .preset = 0,
     .unit = "deg",
     .doc = "tilt of the plane: 0 lets the sphere rock, above atan(mu_r) it rolls on",
     .source = "seed 000 S4.2"},
    {.name = "gravity_m_s2",
     .type = FIELD_REAL,
     AT(gravity_m_s2),
     .min = 1e-3,
     .max = 1000,
     .preset = 9.81,
     .unit = "m/s2",
     .doc = "acceleration of gravity",
     .source = ""},
    {.name = "speed_m_s",
     .type = FIELD_REAL,
     AT(speed_m_s),
     .min = -10,
     .max = 10,
     .preset = 2e-4,
     .unit = "m/s",
     .doc = "of the sphere down the slope at the start, which it rolls at without slip",
     .source = "ours: small enough to rock without slipping in its rolling resistance"},
    {.name = "length_m",
     .type = FIELD_REAL,
     AT(length_m),
     .min = 1e-6,
     .max = 1e3,
     .preset = 0.2,
     .unit = "m",
     .doc = "of the plane: a sphere that comes so far has reached its bottom",
     .source = "seed 000 S4.2"},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct rolling_params)};
_Static_assert(sizeof(struct rolling_params) <= SPEC_PARAMS_MAX, "params fit the job");

static void rolling_defaults(struct job_spec *job)
{
    job->time.end_s = 0.4;
    job->record.basal_force.on = job->record.bulk.on = false;
    job->record.rolling.on = true;
    job->stop.when = 0;
}

static struct job_cost rolling_cost(const struct job_spec *job)
{
    return (struct job_cost){.moving = 1, .steps = fmax(1, round(job->time.end_s / job->time.step_s)), .bytes = 1e6};
}

static enum scree_status rolling_check(const struct job_spec *job, struct scree_error *err)
{
    static const char *const flows[] = {"bulk", "profiles", "connectivity", "contact"};
    for (size_t k = 0; k < sizeof flows / sizeof *flows; k++)
        if (record_find(job, flows[k]).on) {
            char path[64];
            snprintf(path, sizeof path, "record.%s", flows[k]);
            return scree_fail(err, SCREE_INVALID, path, "%s: is not for scenario rolling, where one sphere lies on a plane", path);
        }
    double samples = job->record.rolling.on ? job->time.end_s / job->record.rolling.every_s : 0;
    if (samples > ROLLING_SAMPLES_MAX)
        return scree_fail(err, SCREE_INVALID, "record.rolling.every_s",
                          "record.rolling.every_s: %.9g s makes %.3g samples by time.end_s = %.9g s; at most %d are fitted",
                          job->record.rolling.every_s, samples, job->time.end_s, ROLLING_SAMPLES_MAX);
    enum scree_status status = check_step(job, 0.1, err);
    if (!status)
        status = check_flow_only_in_chute(job, err);
    return status ? status : check_intervals(job, err);
}

const struct scenario_fields scenario_rolling_fields = {
    .name = "rolling",
    .doc = "one sphere on a plane: it rocks about where it lies, or rolls down a slope, or comes to a stop",
    .source = "seed 000, S4.2",
    .kind = SCENARIO_DEM,
    .material = "glass-beads-2mm",
    .params = &table,
    .defaults = rolling_defaults,
    .check = rolling_check,
    .cost = rolling_cost,
};
