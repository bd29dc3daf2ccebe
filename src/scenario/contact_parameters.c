/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculation `contact_parameters`: what the law spring-dashpot-memory takes, from what is wanted of a contact (seed 001
 * eqs 9-19). convex/contact_parameters.h does it, and names the paper's slips. */
#include "convex/contact_parameters.h"

#include <math.h>

#include "scenario/calculation.h"

static enum scree_status run(const struct job_spec *job, struct calculation_result *out, struct scree_error *err)
{
    const struct contact_parameters_params *p = (const struct contact_parameters_params *)(const void *)job->params;
    double inertia = p->inertia_kg_m2 > 0 ? p->inertia_kg_m2 : 0.4 * p->mass_kg * p->radius_m * p->radius_m;
    struct contact_wanted wanted = {.a = {p->mass_kg, p->radius_m, inertia},
                                    .b = {INFINITY, INFINITY, INFINITY},
                                    .overlap = p->overlap_m,
                                    .speed = p->speed_m_s,
                                    .restitution = p->restitution,
                                    .restitution_t = p->restitution_t,
                                    .rolling_friction = p->rolling_friction,
                                    .steps = p->steps_per_contact};
    if (p->partner == CONTACT_LIKE)
        wanted.b = wanted.a;
    struct contact_parameters c;
    enum scree_status status = p->stiffness > 0 ? contact_parameters_of_stiffness(&wanted, p->stiffness, &c, err)
                                                : contact_parameters_find(&wanted, &c, err);
    if (status)
        return status;
    const struct scree_number numbers[] = {
        {"stiffness", "N/m", "k_n of eq. 16", c.stiffness},
        {"damping", "N s/m", "eta_n of eq. 17", c.damping},
        {"stiffness_t", "N/m", "k_t of eq. 18", c.stiffness_t},
        {"damping_t", "N s/m", "eta_t of eq. 19", c.damping_t},
        {"rate", "1/s", "gamma_n = eta_n / 2 m_ij", c.rate},
        {"rate_t", "1/s", "gamma_t = eta_t / 2 m_ij", c.rate_t},
        {"stiffness_r", "N m", "k_r of eq. A9, with the reduced radius", c.stiffness_r},
        {"damping_r", "N m s", "eta_r of eq. A9", c.damping_r},
        {"reduced_mass", "kg", "m_ij: half a body's, or all of it against a wall", c.mass},
        {"frequency", "1/s", "omega_0", c.frequency},
        {"contact_time", "s", "T_c of eq. 12, without the clamp of eq. 5", c.duration},
        {"step", "s", "time step that gives params.steps_per_contact", c.step},
        {"largest_overlap", "m", "at params.speed_m_s", contact_parameters_overlap(&wanted, c.stiffness, p->speed_m_s)},
    };
    calculation_put(out, numbers, sizeof numbers / sizeof *numbers);
    return SCREE_OK;
}

const struct calculation calculation_contact_parameters = {"contact_parameters", run};
