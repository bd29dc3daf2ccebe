/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared by the files that describe one scenario each; private to this folder. */
#ifndef SCREE_SPEC_SCENARIOS_H
#define SCREE_SPEC_SCENARIOS_H

#include "spec/spec.h"

extern const struct scenario_fields scenario_incline_fields, scenario_collision_fields, scenario_chute_fields;

/* Refuses a time step too long for the material at impacts of `speed`, m/s. */
enum scree_status check_step(const struct job_spec *job, double speed, struct scree_error *err);

/* Refuses record.flow. */
enum scree_status check_flow_only_in_chute(const struct job_spec *job, struct scree_error *err);

/* Refuses record intervals shorter than a step. */
enum scree_status check_intervals(const struct job_spec *job, struct scree_error *err);

#endif
