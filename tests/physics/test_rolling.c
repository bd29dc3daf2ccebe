/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One sphere on a plane through the production path: rocking (targets S0-17), and rolling down a slope (S0-18). */
#include "summary.h"

#include <math.h>

static struct summary roll(const struct job_spec *job)
{
    return run(job, &(struct scree_sink){.put = sink_nowhere});
}

static struct rolling_params *setup(struct job_spec *job)
{
    job_defaults(job, scenario_find("rolling"));
    return (struct rolling_params *)(void *)job->params;
}

/* Softened a thousandfold; the overlap is still a ten thousandth of the radius, and no stiffness is in what is tested. */
static struct rolling_params *soft(struct job_spec *job)
{
    struct rolling_params *p = setup(job);
    job->material.young_Pa /= 1000;
    job->time.step_s = 4e-6;
    return p;
}

static void near_to(double value, double expect, double relative)
{
    if (!(fabs(value - expect) <= relative * fabs(expect)))
        fail_msg("%.9g is not %.9g within %g", value, expect, relative);
}

/* S0-17, the row of a plane without slip: w0 = 101.97, decay 10.399, w = 101.44, which the minus sign gives. */
static void a_bead_rocks_as_eq_27_says(void **state)
{
    (void)state;
    struct job_spec job;
    setup(&job);
    struct summary o = roll(&job);
    print_message("omega %.4f rad/s (101.44), decay %.4f 1/s (10.399), kappa %.6f, beta_r %.7f\n", number(&o, "rocking_rate"),
                  number(&o, "rocking_decay"), number(&o, "kappa"), number(&o, "beta_r"));
    near_to(number(&o, "natural_rate"), 101.97, 2e-3);
    near_to(number(&o, "rocking_rate"), 101.44, 2e-3);
    near_to(number(&o, "rocking_decay"), 10.399, 1e-2);
    near_to(number(&o, "kappa"), 0.742, 1e-3);
    near_to(number(&o, "beta_r"), 2e-3, 1e-3);
    near_to(number(&o, "kappa_as_printed"), 0.742 * 4 / 7, 1e-3);
    assert_true(number(&o, "rocking_misfit") < 1e-6);
    assert_int_equal(o.verdict, VERDICT_REST);
}

/* It does so for other values, too, and softened. */
static void rocking_follows_kappa_and_beta_r(void **state)
{
    (void)state;
    struct job_spec job;
    soft(&job);
    job.material.kappa = 1.3;
    job.material.beta_r_s = 5e-4;
    struct summary o = roll(&job);
    near_to(number(&o, "kappa"), 1.3, 2e-3);
    near_to(number(&o, "beta_r"), 5e-4, 1e-2);
}

/* S0-18: it rolls on to the bottom iff tan(slope) > mu_r, less 7/10 v^2 / g L cos(slope) for its start (eq. 30, put right). */
static void a_bead_rolls_on_above_the_angle_of_rolling_friction(void **state)
{
    (void)state;
    const double start = 0.7 * 0.01 * 0.01 / (9.81 * 0.2), at[2] = {-0.004, 0.004};
    for (int k = 0; k < 2; k++) {
        struct job_spec job;
        struct rolling_params *p = soft(&job);
        p->speed_m_s = 0.01;
        p->slope_deg = atan(0.017455 - start) * 180 / M_PI + at[k];
        assert_true(fabs(p->slope_deg - 1.000) < 0.01);
        job.material.mu_r = 0.017455;
        job.stop.when = STOP_REST | STOP_ACCELERATING;
        job.time.end_s = 60;
        struct summary o = roll(&job);
        print_message("%.4f deg: %s, %.4f m after %.3f s\n", p->slope_deg, scree_verdict_word(o.verdict), number(&o, "distance"),
                      o.time_s);
        assert_int_equal(o.verdict, k ? VERDICT_ACCELERATING : VERDICT_REST);
        assert_true(o.time_s < 59);
    }
}

/* Eq. 29 without its slip: the sphere gains 5/7 g (sin - mu_r cos), for it moves as well as turns. */
static void a_bead_gains_speed_at_five_sevenths(void **state)
{
    (void)state;
    struct job_spec job;
    struct rolling_params *p = soft(&job);
    p->speed_m_s = 0.01;
    p->slope_deg = 3;
    job.time.end_s = 0.2;
    struct summary o = roll(&job);
    double slope = 3 * M_PI / 180, expect = 5.0 / 7 * 9.81 * (sin(slope) - job.material.mu_r * cos(slope));
    near_to((number(&o, "velocity") - 0.01) / 0.2, expect, 5e-3);
}

static void what_cannot_be_is_refused(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error error;
    setup(&job);
    job.time.end_s = 1000;
    job.record.rolling.every_s = 1e-4;
    assert_int_equal(job_check(&job, 0, &error), SCREE_INVALID);
    assert_error(&error, SCREE_INVALID, "record.rolling.every_s",
                 "record.rolling.every_s: 0.0001 s makes 1e+07 samples by time.end_s = 1000 s; at most 1048576 are fitted");
    job_defaults(&job, scenario_find("gas"));
    job.record.rolling.on = true;
    assert_int_equal(job_check(&job, 0, &error), SCREE_INVALID);
    assert_error(&error, SCREE_INVALID, "record.rolling", "record.rolling: is for scenario rolling, of one sphere on a plane");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bead_rocks_as_eq_27_says),
        cmocka_unit_test(rocking_follows_kappa_and_beta_r),
        cmocka_unit_test(a_bead_rolls_on_above_the_angle_of_rolling_friction),
        cmocka_unit_test(a_bead_gains_speed_at_five_sevenths),
        cmocka_unit_test(what_cannot_be_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
