/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculation `damping` as the user sees it. */
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct damping_params, member)

static const char *const lengths[] = {"two_free_spheres", "published", "printed", NULL};

static const struct field fields[] = {
    {.name = "restitution",
     .type = FIELD_REAL,
     AT(restitution),
     .min = 0.05,
     .max = 1,
     .preset = 0.97,
     .unit = "",
     .doc = "that was measured",
     .source = "seed 000 S4.1"},
    {.name = "speed_m_s",
     .type = FIELD_REAL,
     AT(speed_m_s),
     .min = 1e-6,
     .max = 100,
     .preset = 1.2,
     .unit = "m/s",
     .doc = "at which it was",
     .source = "seed 000 S4.1"},
    {.name = "length",
     .type = FIELD_ENUM,
     AT(length),
     .preset = DAMPING_FREE,
     .unit = "",
     .doc = "scale of the overlap: of two free spheres, which is right; without its pi, as the published 45.1 ns has it; or as "
            "printed, half as long",
     .source = "seed 000 S4.1",
     .choices = lengths},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct damping_params)};
_Static_assert(sizeof(struct damping_params) <= SPEC_PARAMS_MAX, "params fit the job");

const struct scenario_fields scenario_damping_fields = {
    .name = "damping",
    .doc = "a calculation: the damping beta that explains a restitution",
    .source = "seed 000, S4.1",
    .kind = SCENARIO_CALCULATION,
    .material = "foerster-3mm",
    .params = &table,
    .defaults = calculation_defaults,
    .check = calculation_check,
    .cost = calculation_cost,
};
