/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculation `plastic_yield` as the user sees it. */
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct plastic_yield_params, member)

static const struct field fields[] = {
    {.name = "restitution",
     .type = FIELD_REAL,
     AT(restitution),
     .min = 0.05,
     .max = 1,
     .preset = 0.97,
     .unit = "",
     .doc = "that was measured",
     .source = "seed 000 S2"},
    {.name = "speed_m_s",
     .type = FIELD_REAL,
     AT(speed_m_s),
     .min = 1e-6,
     .max = 100,
     .preset = 1.2,
     .unit = "m/s",
     .doc = "at which it was",
     .source = "seed 000 S2"},
    {.name = "at_m_s",
     .type = FIELD_REAL,
     AT(at_m_s),
     .min = 1e-6,
     .max = 1000,
     .preset = 0.14,
     .unit = "m/s",
     .doc = "impact speed at which the restitution is asked for",
     .source = "seed 000 Fig. S1b"},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct plastic_yield_params)};
_Static_assert(sizeof(struct plastic_yield_params) <= SPEC_PARAMS_MAX, "params fit the job");

const struct scenario_fields scenario_plastic_yield_fields = {
    .name = "plastic_yield",
    .doc = "a calculation: the yield threshold that explains a restitution, whatever the material",
    .source = "seed 000, S2",
    .kind = SCENARIO_CALCULATION,
    .material = "foerster-3mm",
    .params = &table,
    .defaults = calculation_defaults,
    .check = calculation_check,
    .cost = calculation_cost,
};
