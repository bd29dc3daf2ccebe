/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of scenarios, and the checks that several share. */
#include "spec/scenarios.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"

const struct scenario_fields *const scenario_list[] = {
    &scenario_incline_fields,   &scenario_channel_fields,       &scenario_collision_fields,
    &scenario_chute_fields,     &scenario_collapse_fields,      &scenario_tilt_fields,
    &scenario_layer_fields,     &scenario_gas_fields,           &scenario_settle_fields,
    &scenario_dam_break_fields, &scenario_hopper_fields,        &scenario_rolling_fields,
    &scenario_damping_fields,   &scenario_plastic_yield_fields, &scenario_contact_parameters_fields};
const size_t scenario_count = sizeof scenario_list / sizeof *scenario_list;

const struct scenario_fields *scenario_find(const char *name)
{
    for (size_t k = 0; k < scenario_count; k++)
        if (strcmp(scenario_list[k]->name, name) == 0)
            return scenario_list[k];
    return NULL;
}

enum scree_status check_step(const struct job_spec *job, double speed, struct scree_error *err)
{
    double stable = material_stable_step(&job->material, speed);
    char step[TEXT_REAL_MAX];
    if (job->time.step_s <= stable)
        return SCREE_OK;
    double contact = material_contact_time(&job->material, speed);
    if (stable < 0.1 * contact) // stiffness alone asks for about six steps a contact
        scree_fail(err, SCREE_INVALID, "time.step_s",
                   "time.step_s: %s s is above the largest stable step %.3g s for this material, whose damping beta_s = %.3g s is "
                   "stronger than its springs",
                   text_real(job->time.step_s, step), stable, job->material.beta_s);
    else
        scree_fail(
            err, SCREE_INVALID, "time.step_s",
            "time.step_s: %s s is above the largest stable step %.3g s for this material: a contact at %.3g m/s lasts %.3g s "
            "and its stiffest motion needs %.0f steps of it",
            text_real(job->time.step_s, step), stable, speed, contact, ceil(contact / stable));
    scree_hint(err, "shorten time.step_s, or soften material.young_Pa: the step grows as its power -2/5");
    return SCREE_INVALID;
}

/* An interval must hold at least one step; it is rounded to whole steps. */
static enum scree_status check_interval(double every_s, double step_s, const char *path, struct scree_error *err)
{
    char every[TEXT_REAL_MAX], step[TEXT_REAL_MAX];
    if (every_s >= 0.5 * step_s)
        return SCREE_OK;
    return scree_fail(err, SCREE_INVALID, path, "%s: %s s is below the time step of %s s", path, text_real(every_s, every),
                      text_real(step_s, step));
}

enum scree_status check_flow_only_in_chute(const struct job_spec *job, struct scree_error *err)
{
    if (!job->record.flow.on)
        return SCREE_OK;
    return scree_fail(err, SCREE_INVALID, "record.flow", "record.flow: is for scenario chute, where a flow has a front and an end");
}

enum scree_status check_intervals(const struct job_spec *job, struct scree_error *err)
{
    const struct field *record = field_find(&job_table, "record");
    for (size_t k = 0; k < record->table->count; k++) {
        const char *name = record->table->fields[k].name;
        const struct record_choice choice = record_find(job, name);
        char path[96];
        snprintf(path, sizeof path, "record.%s.every_s", name);
        enum scree_status status =
            choice.on && choice.every_s > 0 ? check_interval(choice.every_s, job->time.step_s, path, err) : SCREE_OK;
        if (status)
            return status;
    }
    return SCREE_OK;
}
