/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of continuum set-ups, and what they share. */
#include "scenario/continuum.h"

#include <string.h>

extern const struct continuum_scenario continuum_collapse, continuum_tilt, continuum_layer;

static const struct continuum_scenario *const all[] = {&continuum_collapse, &continuum_tilt, &continuum_layer};

const struct continuum_scenario *continuum_scenario_find(const char *name)
{
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (strcmp(all[k]->name, name) == 0)
            return all[k];
    return NULL;
}

void continuum_fill(const struct job_spec *job, const struct continuum_spec *c, struct mpm_setup *setup)
{
    static const struct mpm_law *const laws[] = {
        [LAW_CONSTANT] = &mpm_law_constant,
        [LAW_MU_I] = &mpm_law_mu_i,
        [LAW_HYSTERETIC] = &mpm_law_hysteretic_ramp,
        [LAW_HYSTERETIC_STEP] = &mpm_law_hysteretic_step,
    };
    enum { CHECK = 20 };
    setup->step_s = job->time.step_s;
    setup->seed = (uint64_t)job->seed;
    setup->density = c->density_kg_m3;
    setup->points_per_cell = (int)c->points;
    setup->jitter = c->jitter;
    setup->law = laws[c->law];
    setup->coefs = (struct mpm_law_coefs){
        .mu = c->mu, .mu_2 = c->mu_2, .inertial0 = c->inertial0, .delta_mu = c->delta_mu, .inertial_star = c->inertial_star};
    setup->grain_diameter = c->grain_m;
    setup->inertial_density = c->density_kg_m3 / c->inertial_fraction;
    setup->recover_s = c->recover_s;
    setup->solver = (struct mpm_solver){.tolerance = c->tolerance, .sweeps = (int)c->sweeps, .check = CHECK, .accelerate = true};
}
