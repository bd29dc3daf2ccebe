/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Collapse and tilt as a user asks for them: published lengths, refusals, and the grid that is made of them. */
#include "unit.h"

#include <math.h>

#include "scenario/continuum.h"
#include "spec/scenarios.h"

static struct collapse_params *collapse(struct job_spec *job)
{
    job_defaults(job, &scenario_collapse_fields);
    return (struct collapse_params *)(void *)job->params;
}

static void adopt(struct job_spec *job, int run)
{
    collapse(job)->run = run;
    job->scenario->adopt(job);
}

/* Protocols 3.1, row by row: heights, lengths, friction, density, gate. */
static void runs_have_the_published_lengths(void **state)
{
    (void)state;
    static const double height[9] = {.1194, .1108, .1108, .1108, .1182, .1138, .1243, .1150, .1171};
    static const double length[9] = {.224, .224, .224, .2244, .2244, .2868, .2979, .3789, .3677};
    static const double slope[9] = {0, 5, 10, 15, 20, 0, 5, 10, 15};
    for (int run = 0; run < 9; run++) {
        struct job_spec job;
        adopt(&job, run);
        const struct collapse_params *p = (const struct collapse_params *)(const void *)job.params;
        bool beads = run < 5;
        assert_true(p->height_m == height[run] && p->length_m == length[run] && p->slope_deg == slope[run]);
        assert_true(fabs(p->bed_m - height[run] / 8) < 1e-15 && fabs(p->box_height_m - height[run] / 0.8) < 1e-15);
        assert_true(p->continuum.mu == (beads ? 0.44 : 0.75) && p->mu_wall == (beads ? 0.23 : 0.30));
        assert_true(p->continuum.density_kg_m3 == (beads ? 1473 : 1517));
        assert_true(p->gate_speed_m_s == (beads ? 0.7 : 0.8) && p->gate_tau_s == (beads ? 0.13 : 0.06) && p->gate_wait_s == 0.2);
        assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    }
}

/* Gate, walls and top of the bed lie on layers of nodes; both bed heights are possible. */
static void grid_fits_the_set_up(void **state)
{
    (void)state;
    for (int paper = 0; paper < 2; paper++) {
        struct job_spec job;
        struct continuum_plan plan;
        struct collapse_params *p = collapse(&job);
        if (paper) {
            p->bed_m = 0.02;
            p->box_height_m = 0.16;
        }
        assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
        continuum_scenario_find("collapse")->plan(&job, &plan);
        const struct mpm_setup *s = &plan.setup;
        double x = p->length_m * s->cells[0] / s->length[0], z = p->bed_m * s->cells[2] / s->length[2];
        assert_true(fabs(x - round(x)) < 1e-9 && fabs(z - round(z)) < 1e-9);
        assert_true(fabs(s->length[0] / s->cells[0] - 0.01) < 3e-4 && fabs(s->length[2] / s->cells[2] - 0.005) < 3e-4);
        assert_true(s->length[0] >= p->box_length_m - 1e-12 && s->length[1] == 0.06 && s->cells[1] == 6);
        assert_true(plan.gate.low[0] == p->length_m && plan.gate.low[2] == p->bed_m);
        assert_int_equal(s->region_count, 2);
    }
}

static void refuse(const struct job_spec *job, const char *path, const char *message)
{
    struct scree_error err;
    job_check(job, 0, &err);
    assert_error(&err, SCREE_INVALID, path, message);
}

static void bad_collapses_are_refused(void **state)
{
    (void)state;
    struct job_spec job;
    struct collapse_params *p = collapse(&job);
    p->cell_height_m = 0.05;
    refuse(&job, "params.cell_height_m", "params.cell_height_m: a cell of 0.05 m is higher than the bed of 0.014925 m");
    p->bed_m = 0;
    p->cell_height_m = 0.2;
    refuse(&job, "params.cell_height_m", "params.cell_height_m: a cell of 0.2 m is higher than the column of 0.1194 m");
    p->cell_m = 0.3;
    refuse(&job, "params.cell_m", "params.cell_m: a cell of 0.3 m is longer than the column of 0.224 m");
    p = collapse(&job);
    p->box_length_m = 0.24;
    refuse(&job, "params.box_length_m", "params.box_length_m: the gate at 0.224 m, two cells thick, is outside a box of 0.24 m");
    p = collapse(&job);
    p->box_height_m = 0.12;
    refuse(&job, "params.box_height_m", "params.box_height_m: bed and column of 0.134325 m do not fit a box of 0.12 m");
    p = collapse(&job);
    p->continuum.mu = -0.1;
    refuse(&job, "params.continuum.mu", "params.continuum.mu: -0.1 is outside 0..1");
    p = collapse(&job);
    p->continuum.mu = 1.2;
    refuse(&job, "params.continuum.mu", "params.continuum.mu: 1.2 is outside 0..1");
    p = collapse(&job);
    p->continuum.law = LAW_HYSTERETIC;
    p->continuum.delta_mu = 0.6;
    refuse(&job, "params.continuum.delta_mu",
           "params.continuum.delta_mu: 0.6 makes mu + delta_mu = 1.04 at rest, above 1, where the law's cone holds tension");
    p = collapse(&job);
    p->continuum.points = 0;
    refuse(&job, "params.continuum.points", "params.continuum.points: 0 is outside 1..16");
    p->continuum.points = 216; // along an edge, so that what a cell holds is always a cube
    refuse(&job, "params.continuum.points", "params.continuum.points: 216 is outside 1..16");
    p = collapse(&job);
    p->continuum.law = LAW_MU_I;
    p->continuum.mu_2 = 0.3;
    refuse(&job, "params.continuum.mu_2", "params.continuum.mu_2: 0.3 is below mu, 0.44: mu(I) must not fall with I");
    collapse(&job);
    job.time.step_s = 0.01;
    refuse(&job, "time.step_s",
           "time.step_s: in 0.01 s a point falling at 1.53 m/s crosses more than a cell of 0.005 m: at most 0.00327 s");
}

static void bad_tilts_are_refused(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, &scenario_tilt_fields);
    struct tilt_params *p = (struct tilt_params *)(void *)job.params;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    p->bed_m = 0.5;
    refuse(&job, "params.bed_m", "params.bed_m: a bed of 0.5 m does not fit a box of 0.3 m");
    p->bed_m = 0.1;
    p->cells_z = 2;
    refuse(&job, "params.cells_z", "params.cells_z: a cell of 0.15 m is higher than the bed of 0.1 m");
    p->cells_z = 60;
    p->to_deg = 10;
    refuse(&job, "params.to_deg", "params.to_deg: 10 deg is below from_deg, 18 deg");
}

/* A layer is one column of cells; what bounds its step is the fall through its depth. */
static void layers_are_planned_and_refused(void **state)
{
    (void)state;
    struct job_spec job;
    struct continuum_plan plan;
    job_defaults(&job, &scenario_layer_fields);
    struct layer_params *p = (struct layer_params *)(void *)job.params;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    continuum_scenario_find("layer")->plan(&job, &plan);
    assert_true(plan.setup.endless && plan.setup.cells[2] == 25 && fabs(plan.setup.length[2] - 0.025) < 1e-15);
    assert_true(plan.setup.body_count == 0 && plan.regions[0].high[2] == 0.02);
    assert_true(fabs(plan.setup.gravity[0] / -plan.setup.gravity[2] - tan(23.5 * M_PI / 180)) < 1e-12);
    p->cells = 1;
    refuse(&job, "params.cells", "params.cells: 1 is outside 2..10000 cells");
    p->cells = 20;
    job.time.step_s = 0.002;
    refuse(&job, "time.step_s",
           "time.step_s: in 0.002 s a point falling at 0.626 m/s crosses more than a cell of 0.001 m: at most 0.0016 s");
    job_defaults(&job, &scenario_incline_fields);
    job.record.surface.on = true;
    refuse(&job, "record.surface", "record.surface: is for continua, and scenario incline is none");
}

/* The engine refuses by itself what would make no sense to it. */
static void bad_set_ups_are_refused(void **state)
{
    (void)state;
    struct job_spec job;
    struct continuum_plan plan;
    struct scree_error err;
    struct mpm *mpm;
    collapse(&job);
    continuum_scenario_find("collapse")->plan(&job, &plan);
    plan.setup.threads = 1;
    plan.gate.high[0] = plan.gate.low[0] + 0.001;
    mpm_create(&plan.setup, &mpm, &err);
    assert_error(&err, SCREE_INVALID, "bodies", "bodies: a body must be at least two cells thick");
    continuum_scenario_find("collapse")->plan(&job, &plan);
    plan.regions[1].high[2] = 1;
    mpm_create(&plan.setup, &mpm, &err);
    assert_error(&err, SCREE_INVALID, "regions", "regions: material must lie inside the box");
    plan.setup.cells[0] = 100000000;
    mpm_create(&plan.setup, &mpm, &err);
    assert_string_equal(err.path, "cells");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(runs_have_the_published_lengths), cmocka_unit_test(grid_fits_the_set_up),
        cmocka_unit_test(bad_collapses_are_refused),       cmocka_unit_test(bad_tilts_are_refused),
        cmocka_unit_test(layers_are_planned_and_refused),  cmocka_unit_test(bad_set_ups_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
