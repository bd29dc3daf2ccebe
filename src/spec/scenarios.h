/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared by the files that describe one scenario each; private to this folder. */
#ifndef SCREE_SPEC_SCENARIOS_H
#define SCREE_SPEC_SCENARIOS_H

#include "spec/spec.h"

extern const struct scenario_fields scenario_incline_fields, scenario_collision_fields, scenario_chute_fields,
    scenario_collapse_fields, scenario_tilt_fields, scenario_layer_fields, scenario_gas_fields, scenario_settle_fields,
    scenario_dam_break_fields, scenario_rolling_fields, scenario_damping_fields, scenario_plastic_yield_fields,
    scenario_contact_parameters_fields, scenario_channel_fields, scenario_hopper_fields;

/* The row of a gravity that always pulls down and can be steered; `at` is where its struct keeps it. */
#define SPEC_GRAVITY_ROW(at)                                                                                                       \
    {                                                                                                                              \
        .name = "gravity_m_s2", .type = FIELD_REAL, at, .min = 1e-3, .max = 1e3, .preset = 9.81, .unit = "m/s2",                   \
        .doc = "acceleration of gravity", .source = "", .steerable = true                                                          \
    }

/* Refuses a time step too long for the material at impacts of `speed`, m/s. */
enum scree_status check_step(const struct job_spec *job, double speed, struct scree_error *err);

/* Refuses what no world of continuum can do: steps in which a point at `speed`, m/s, crosses a cell of `cell` m. */
enum scree_status continuum_check(const struct job_spec *job, const struct continuum_spec *continuum, double speed, double cell,
                                  struct scree_error *err);

/* Bytes of a world of that many points and cells. */
double continuum_bytes(double points, double cells);

/* What scenarios of rigid bodies share: defaults, cost, and checks of a body that is poured into `length` (the field at
 * `path`) times `width`, m. */
void rigid_defaults(struct job_spec *job);
struct job_cost rigid_cost(const struct job_spec *job, double bodies);
enum scree_status rigid_check(const struct job_spec *job, const struct body_spec *body, double length, double width,
                              const char *path, struct scree_error *err);

/* What calculations share: no world, hence no records, and a single step. */
void calculation_defaults(struct job_spec *job);
struct job_cost calculation_cost(const struct job_spec *job);
enum scree_status calculation_check(const struct job_spec *job, struct scree_error *err);

/* Refuses record.flow. */
enum scree_status check_flow_only_in_chute(const struct job_spec *job, struct scree_error *err);

/* Refuses record intervals shorter than a step. */
enum scree_status check_intervals(const struct job_spec *job, struct scree_error *err);

#endif
