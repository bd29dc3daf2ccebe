/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The classifier of protocols 1.5 on made-up series, and the window of summaries. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "base/rng.h"
#include "measure/verdict.h"
#include "measure/window.h"

/* Feeds samples every millisecond until a verdict that is not undecided, or `end`; returns its time. */
static double decide(struct verdict *v, double layers, double end, double (*kinetic)(double), double elastic)
{
    verdict_start(v, 2e-3, 9.81, layers, VERDICT_CALM);
    for (int k = 1; k <= (int)round(end * 1000); k++) {
        double t = k * 1e-3, e = kinetic(t);
        verdict_add(v, t, e, elastic, sqrt(2 * e / 0.01), 0.01);
        if (v->current != VERDICT_UNDECIDED)
            return t;
    }
    return end;
}

static double constant(double t)
{
    (void)t;
    return 1e-4;
}
static double noisy(double t) // 20 % of noise at 3 Hz and faster, the same mean
{
    return 1e-4 * (1 + 0.2 * sin(19.3 * t) + 0.1 * sin(97 * t));
}
static double approaching(double t) // levels off with a time of 1.5 s
{
    return 1e-4 * (1 - exp(-t / 1.5));
}
static double drifting(double t)
{
    return 1e-4 * (1 + 0.03 * t);
}
static double growing(double t)
{
    return 1e-5 * t * t;
}
static double stopping(double t)
{
    return t < 1.5 ? 1e-4 * pow(1 - t / 1.5, 2) + 1e-30 : 1e-20;
}
static double nothing(double t)
{
    return t < 0.05 ? 0 : 1e-4;
}

static void a_steady_series_is_steady_after_four_windows(void **state)
{
    (void)state;
    struct verdict v;
    assert_true(fabs(decide(&v, 10, 20, constant, 1e-6) - 4) < 2e-3);
    assert_int_equal(v.current, VERDICT_STEADY);
    assert_true(fabs(v.t0_s - 4) < 2e-3);
    double t = decide(&v, 10, 20, noisy, 1e-6);
    assert_int_equal(v.current, VERDICT_STEADY);
    assert_true(t >= 4 && t < 8);
}

static void a_thin_flow_must_stay_steady_for_two_seconds_more(void **state)
{
    (void)state;
    struct verdict v;
    assert_true(fabs(decide(&v, 4, 20, constant, 1e-6) - 6) < 2e-3);
    assert_true(fabs(v.t0_s - 4) < 2e-3);
}

/* From nothing the energy first more than doubles over four windows, which is
 * accelerating; later it is steady. A verdict may change while a job goes on. */
static void an_approach_is_accelerating_first_and_steady_once_level(void **state)
{
    (void)state;
    struct verdict v;
    verdict_start(&v, 2e-3, 9.81, 10, VERDICT_CALM);
    enum scree_verdict at_four = VERDICT_UNDECIDED;
    int k = 1;
    for (; k <= 60000 && v.current != VERDICT_STEADY; k++) {
        double e = approaching(k * 1e-3);
        verdict_add(&v, k * 1e-3, e, 1e-6, sqrt(2 * e / 0.01), 0.01);
        if (k == 4001)
            at_four = v.current;
    }
    assert_int_equal(at_four, VERDICT_ACCELERATING);
    assert_int_equal(v.current, VERDICT_STEADY);
    assert_true(k > 6000 && k < 60000);
}

static void a_drift_of_three_percent_a_second_is_never_steady(void **state)
{
    (void)state;
    struct verdict v;
    decide(&v, 10, 12, drifting, 1e-6);
    assert_int_equal(v.current, VERDICT_UNDECIDED);
}

static void growth_to_more_than_twice_is_accelerating(void **state)
{
    (void)state;
    struct verdict v;
    assert_true(fabs(decide(&v, 10, 20, growing, 1e-9) - 4) < 2e-3);
    assert_int_equal(v.current, VERDICT_ACCELERATING);
}

static void stopping_is_rest_a_tenth_of_a_second_later(void **state)
{
    (void)state;
    struct verdict v;
    double t = decide(&v, 10, 20, stopping, 1e-7);
    assert_int_equal(v.current, VERDICT_REST);
    assert_true(t > 1.5 && t < 1.7);
    assert_non_null(strstr(v.evidence, "E_kin / E_elastic"));
}

/* A world starts with grains at rest in the air: that is not what rest means. */
static void the_start_is_not_rest(void **state)
{
    (void)state;
    struct verdict v;
    decide(&v, 10, 2, nothing, 0);
    assert_int_equal(v.current, VERDICT_UNDECIDED);
}

static void a_window_gives_the_means_from_its_start_on(void **state)
{
    (void)state;
    static struct window w;
    double means[WINDOW_VALUES], values[WINDOW_VALUES] = {0};
    window_start(&w);
    for (int k = 1; k <= 100000; k++) { // far more than instants are kept: 3 until t = 60, then 5
        values[0] = k <= 60000 ? 3 : 5;
        values[1] = k;
        window_add(&w, k * 1e-3, 10, values);
    }
    assert_true(window_means(&w, 0, means) == 0);
    assert_true(fabs(means[0] - 3.8) < 1e-12);
    double from = window_means(&w, 80, means);
    assert_true(from <= 80 && from > 79.9);
    assert_true(fabs(means[0] - 5) < 1e-12);
    assert_true(fabs(means[1] - 0.5 * (from * 1000 + 1 + 100000)) < 1e-6 * means[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_steady_series_is_steady_after_four_windows),
        cmocka_unit_test(a_thin_flow_must_stay_steady_for_two_seconds_more),
        cmocka_unit_test(an_approach_is_accelerating_first_and_steady_once_level),
        cmocka_unit_test(a_drift_of_three_percent_a_second_is_never_steady),
        cmocka_unit_test(growth_to_more_than_twice_is_accelerating),
        cmocka_unit_test(stopping_is_rest_a_tenth_of_a_second_later),
        cmocka_unit_test(the_start_is_not_rest),
        cmocka_unit_test(a_window_gives_the_means_from_its_start_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
