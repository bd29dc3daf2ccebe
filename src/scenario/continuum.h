/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Set-ups of the continuum: how a job's params become an mpm_setup. */
#ifndef SCREE_SCENARIO_CONTINUUM_H
#define SCREE_SCENARIO_CONTINUUM_H

#include "mpm/mpm.h"
#include "spec/spec.h"

/* A set-up with what it points to; fill and use it where it lies. */
struct continuum_plan {
    struct mpm_setup setup;
    struct mpm_region regions[2];
    struct mpm_body gate;
    /* What a deposit is measured from. */
    double bed, gate_x, height; // m: depth of the bed, where the column ends, its height over the bed
    double start_s;             // when the gate begins to lift
};

struct continuum_scenario {
    const char *name; // as in scenario_list
    void (*plan)(const struct job_spec *job, struct continuum_plan *plan);
    /* Gravity of the job's params as they now stand, for steering. */
    void (*gravity)(const struct job_spec *job, double gravity[3]);
};
const struct continuum_scenario *continuum_scenario_find(const char *name);

/* The part of a set-up that every scenario of continuum has: rheology, points, solver, seed, step. */
void continuum_fill(const struct job_spec *job, const struct continuum_spec *continuum, struct mpm_setup *setup);

#endif
