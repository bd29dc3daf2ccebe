/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What scenarios of rigid bodies refuse, and what they cost. */
#include "unit.h"

#include <math.h>
#include <stdio.h>

#include "base/text.h"
#include "spec/scenarios.h"

static void refused(const struct job_spec *job, const char *path, const char *message)
{
    struct scree_error err = {0};
    assert_int_equal(job_check(job, 0, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, path, message);
}

static struct dam_break_params *dam(struct job_spec *job)
{
    job_defaults(job, &scenario_dam_break_fields);
    return (struct dam_break_params *)(void *)job->params;
}

static void defaults_are_those_of_the_paper(void **state)
{
    (void)state;
    struct job_spec job;
    const struct dam_break_params *p = dam(&job);
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    assert_true(fabs(body_volume(&p->body) - 312e-9) < 1e-18); // S1-09
    /* S1-02: 5.14e-5 s between two crosses. */
    double duration = rigid_contact_time(&job.rigid, 0.5 * job.rigid.density_kg_m3 * body_volume(&p->body));
    assert_true(fabs(duration - 5.14e-5) < 5e-8);
}

static void gate_outside_the_box(void **state)
{
    (void)state;
    struct job_spec job;
    dam(&job)->column_m = 0.7;
    refused(&job, "params.column_m",
            "params.column_m: a column of 0.7 m does not fit a box of 0.64 m: its gate would stand outside");
}

static void gate_that_never_goes(void **state)
{
    (void)state;
    struct job_spec job;
    dam(&job)->settle_s = 5;
    refused(&job, "params.settle_s", "params.settle_s: the gate goes at 5 s, and the run ends at 4 s");
}

/* A box that ends where the gate stands: at most a body less is left for the column. */
static void gate_without_room_behind_it(void **state)
{
    (void)state;
    struct job_spec job;
    struct dam_break_params *p = dam(&job);
    p->column_m = 0.62;
    refused(
        &job, "params.column_m",
        "params.column_m: a column of 0.62 m in a box of 0.64 m leaves no room to run out to a body that is 0.0272 m across: at "
        "most 0.613 m");
    p->column_m = 0.61;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
}

/* 0.5 g t^2 / 2 within the 2.5 s that are left, and no faster than its speed. */
static void gate_that_opens_no_gap(void **state)
{
    (void)state;
    struct job_spec job;
    struct dam_break_params *p = dam(&job);
    p->gate_m_s2 = 5e-4;
    refused(&job, "params.gate_m_s2",
            "params.gate_m_s2: 0.0005 m/s2 lift the gate by 0.00156 m until the run ends, under which no body that is 0.002 m thin "
            "gets out");
    p->gate_m_s2 = 7e-4; // 2.2 mm
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    p->gate_m_s = 7e-4; // 0.35 mm while it speeds up, 1.05 mm after that
    refused(&job, "params.gate_m_s2",
            "params.gate_m_s2: 0.0007 m/s2 lift the gate by 0.0014 m until the run ends, under which no body that is 0.002 m thin "
            "gets out");
    p->gate_m_s2 = 0; // it vanishes
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    p->body.shape = BODY_SPHERE;
    p->body.radius_m = 2e-3;
    job.time.step_s = 1e-6;
    p->gate_m_s2 = 1e-3; // 3.1 mm, and they are 4 mm
    p->gate_m_s = 1;
    refused(&job, "params.gate_m_s2",
            "params.gate_m_s2: 0.001 m/s2 lift the gate by 0.00313 m until the run ends, under which no body that is 0.004 m thin "
            "gets out");
}

/* Between gate and back wall, and between the sides. */
static void body_wider_than_its_column(void **state)
{
    (void)state;
    struct job_spec job;
    struct dam_break_params *p = dam(&job);
    char message[200], across[TEXT_REAL_MAX];
    text_real(2 * body_reach(&p->body), across);
    p->column_m = 0.027;
    snprintf(message, sizeof message, "params.column_m: 0.027 m do not hold a body that is %s m across, whatever way it is turned",
             across);
    refused(&job, "params.column_m", message);
    p->column_m = 0.05;
    p->width_m = 0.0271;
    snprintf(message, sizeof message, "params.width_m: 0.0271 m do not hold a body that is %s m across, whatever way it is turned",
             across);
    refused(&job, "params.width_m", message);
    p->width_m = 0.0273;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
}

static void crust_without_a_core(void **state)
{
    (void)state;
    struct job_spec job;
    dam(&job);
    job.rigid.crust_m = 1e-3;
    refused(&job, "material.crust_m",
            "material.crust_m: 0.001 m leave no core to a body that is 0.002 m thin: at most a quarter of it");
}

static void step_too_long_for_a_contact(void **state)
{
    (void)state;
    struct job_spec job;
    dam(&job);
    job.time.step_s = 1e-5;
    struct scree_error err = {0};
    assert_int_equal(job_check(&job, 0, &err), SCREE_INVALID);
    assert_string_equal(err.path, "time.step_s");
    job.rigid.stiffness /= 4; // twice as long
    assert_int_equal(job_check(&job, 0, &err), SCREE_OK);
}

static void records_of_spheres(void **state)
{
    (void)state;
    struct job_spec job;
    dam(&job);
    job.record.profiles.on = true;
    refused(&job, "record.profiles", "record.profiles: is for worlds of spheres, and scenario dam_break has rigid bodies");
}

static void several_threads(void **state)
{
    (void)state;
    struct job_spec job;
    dam(&job);
    job.threads = 2;
    refused(&job, "threads", "threads: 2: worlds of rigid bodies step in one thread, several jobs at once");
}

static void hopper_that_does_not_let_go(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, &scenario_hopper_fields);
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    struct hopper_params *p = (struct hopper_params *)(void *)job.params, good = *p;
    p->hole_m = 0.05;
    refused(&job, "params.hole_m", "params.hole_m: a hole of 0.05 m leaves no bottom to a hopper of 0.05 m");
    p->hole_m = 0.0019;
    refused(&job, "params.hole_m", "params.hole_m: a body that is 0.002 m thick does not get through a hole of 0.0019 m");
    *p = good;
    p->side_m = 0.4;
    refused(&job, "params.side_m", "params.side_m: a hopper of 0.4 m is wider than its floor of 0.3 m");
    *p = good;
    p->height_m = 0.001;
    refused(&job, "params.height_m",
            "params.height_m: a body that is 0.002 m across does not get out of a hopper 0.001 m over the floor");
    *p = good;
    p->settle_s = 4;
    refused(&job, "params.settle_s", "params.settle_s: the hole opens at 4 s, and the run ends at 4 s");
}

static void heap_of_what_has_no_bodies(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, &scenario_incline_fields);
    job.record.heap.on = true;
    refused(&job, "record.heap", "record.heap: is for worlds of rigid bodies, and scenario incline has none");
    job.record.heap.on = false;
    job.record.views.on = true;
    refused(&job, "record.views", "record.views: is for worlds of rigid bodies, and scenario incline has none");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_those_of_the_paper),
        cmocka_unit_test(gate_outside_the_box),
        cmocka_unit_test(gate_that_never_goes),
        cmocka_unit_test(gate_without_room_behind_it),
        cmocka_unit_test(gate_that_opens_no_gap),
        cmocka_unit_test(body_wider_than_its_column),
        cmocka_unit_test(crust_without_a_core),
        cmocka_unit_test(step_too_long_for_a_contact),
        cmocka_unit_test(records_of_spheres),
        cmocka_unit_test(several_threads),
        cmocka_unit_test(hopper_that_does_not_let_go),
        cmocka_unit_test(heap_of_what_has_no_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
