/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculation `contact_parameters` as the user sees it: the defaults are the spheres of Table II. */
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct contact_parameters_params, member)
#define ROW(member, low, high, value, in, what, from)                                                                              \
    {                                                                                                                              \
        .name = #member, .type = FIELD_REAL, AT(member), .min = low, .max = high, .preset = value, .unit = in, .doc = what,        \
        .source = from                                                                                                             \
    }

static const char *const partners[] = {"like", "wall", NULL};

static const struct field fields[] = {
    {.name = "partner",
     .type = FIELD_ENUM,
     AT(partner),
     .preset = CONTACT_LIKE,
     .unit = "",
     .doc = "what the body meets: its like, or a wall, as Table I's stiffness of crosses is of",
     .source = "seed 001 II.C",
     .choices = partners},
    ROW(mass_kg, 1e-15, 1e12, 1.0471975511965977e-5, "kg", "of the body", "seed 001 Table II: 2500 kg/m3"),
    ROW(radius_m, 1e-9, 1e6, 1e-3, "m", "of the body, or of the sphere of its volume", "seed 001 Table II"),
    ROW(inertia_kg_m2, 0, 1e12, 0, "kg m2", "about an axis it rolls on; 0: a sphere's", ""),
    ROW(overlap_m, 1e-15, 1e3, 5e-6, "m", "largest overlap, at an impact of speed_m_s", "seed 001 eq. 16, Table II: 0.005 R"),
    ROW(speed_m_s, 1e-9, 1e6, 2.62, "m/s", "of the fastest impact", "seed 001 eq. 13; what Table II's k_n implies"),
    ROW(stiffness, 0, 1e15, 0, "N/m", "k_n, where it is given; 0: that of overlap_m and speed_m_s", ""),
    ROW(restitution, 1e-12, 1, 0.45, "", "e_n", "seed 001 Table II"),
    ROW(restitution_t, 1e-12, 1, 0.3, "", "e_t", "not stated; what Table II's k_t implies"),
    ROW(rolling_friction, 0, 100, 0.45, "", "mu_r of eqs A5-A9", "what Table II's k_r implies"),
    ROW(steps_per_contact, 1.01, 1e9, 20, "", "time steps that a contact should take", "seed 001 II.C"),
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields,
                                         sizeof(struct contact_parameters_params)};
_Static_assert(sizeof(struct contact_parameters_params) <= SPEC_PARAMS_MAX, "params fit the job");

const struct scenario_fields scenario_contact_parameters_fields = {
    .name = "contact_parameters",
    .doc = "a calculation: stiffnesses, dampings and time step from overlap, restitution and speed",
    .source = "seed 001, eqs 9-19",
    .kind = SCENARIO_CALCULATION,
    .material = "plastic-crosses",
    .params = &table,
    .defaults = calculation_defaults,
    .check = calculation_check,
    .cost = calculation_cost,
};
