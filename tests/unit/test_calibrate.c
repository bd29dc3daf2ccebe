/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Searches and sweeps against oracles whose answer is known: every threshold, every
 * order in which answers can come in, every pattern of answers of a few points. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#include "calibrate/bisect.h"
#include "calibrate/digits.h"
#include "calibrate/root.h"
#include "calibrate/sweep.h"
#include "unit.h"

/* ---- digits ---- */

/* A threshold that lies on a rounding boundary would keep the ends apart for ever. */
static void test_bracket_on_a_rounding_boundary_closes(void **state)
{
    (void)state;
    assert_false(digits_closed(0.2364, 0.2366, 3, 1)); // 0.236 and 0.237
    assert_true(digits_closed(0.23646, 0.23654, 3, 1));
    assert_true(digits_closed(0.2366, 0.2374, 3, 1));
    assert_true(digits_closed(-0.2374, -0.2366, 3, 1));
    assert_false(digits_closed(0, 1e-9, 3, 1));
    assert_true(digits_closed(0, 1e-12, 3, 1));
}

static void test_rounding_is_that_of_the_printed_number(void **state)
{
    (void)state;
    assert_true(digits_round(0.23651, 3) == 0.237);
    assert_true(digits_round(71.24e-9, 3) == 7.12e-8);
    assert_true(digits_round(-1e-300, 1) == -1e-300);
    assert_false(signbit(digits_round(-0.0, 3)));
    assert_true(digits_unit(0.2, 0.25, 3) == 0.001);
    assert_true(digits_unit(-120, 5, 2) == 10);
}

/* ---- bisection ---- */

static enum bisect_answer by_threshold(double at, double threshold)
{
    return at < threshold ? BISECT_RAISE : BISECT_LOWER;
}

/* The point that is still to be answered and needed, number `which` of them (modulo how many there are); -1: none. */
static int open_point(const struct bisect *b, int which)
{
    int open[BISECT_POINTS_MAX], count = 0;
    for (int k = 0; k < b->point_count; k++)
        if (b->points[k].answer == BISECT_PENDING && b->points[k].needed)
            open[count++] = k;
    return count && b->end == BISECT_SEARCHING ? open[which % count] : -1;
}

static void test_every_threshold_is_found(void **state)
{
    (void)state;
    static struct bisect b;
    for (int sections = 1; sections <= 9; sections++)
        for (int digits = 1; digits <= 6; digits++)
            for (int k = 1; k < 200; k++) {
                double threshold = k * 0.00501 + 1e-5 * k * k / 7;
                bisect_start(&b, 0, 2, digits, sections);
                for (int point; (point = open_point(&b, 0)) >= 0;)
                    bisect_put(&b, point, by_threshold(b.points[point].at, threshold));
                assert_int_equal(b.end, BISECT_FOUND);
                assert_true(b.low < threshold && threshold <= b.high);
                assert_true(digits_closed(b.low, b.high, digits, 2));
                double unit = digits_unit(b.low, b.high, digits); // of the larger end: it may have a digit more
                assert_true(fabs(bisect_value(&b) - threshold) <= 0.56 * unit);
                /* The ends, then no more rounds than the width needs. */
                assert_true(b.round_count <= 1 + (int)ceil(log(2 / (0.1 * unit)) / log(sections + 1)));
            }
}

/* Answers come in as workers get ready; the bracket and what is asked next must not depend on it. */
static void test_order_of_answers_does_not_matter(void **state)
{
    (void)state;
    static struct bisect first, other;
    for (int sections = 1; sections <= 5; sections++)
        for (int order = 0; order < 400; order++) {
            bisect_start(&other, 0, 1, 4, sections);
            unsigned shuffle = (unsigned)order * 2654435761u;
            for (int point; (point = open_point(&other, (int)(shuffle >> 20 & 1023))) >= 0;
                 shuffle = shuffle * 1664525u + 1013904223u)
                bisect_put(&other, point, by_threshold(other.points[point].at, 0.2371));
            assert_int_equal(other.end, BISECT_FOUND);
            if (order == 0)
                first = other;
            assert_int_equal(other.round_count, first.round_count);
            assert_memory_equal(other.rounds, first.rounds, sizeof first.rounds);
            assert_int_equal(other.point_count, first.point_count);
            for (int k = 0; k < first.point_count; k++)
                assert_true(other.points[k].at == first.points[k].at);
        }
}

/* After a restart the search is made anew from its answers in the order of its points: it must be the same one. */
static void test_a_replay_gives_the_same_state(void **state)
{
    (void)state;
    static struct bisect live, again;
    for (int sections = 1; sections <= 4; sections++)
        for (unsigned seed = 1; seed < 300; seed++) {
            unsigned shuffle = seed * 2654435761u;
            bisect_start(&live, -1, 1, 3, sections);
            for (int point; (point = open_point(&live, (int)(shuffle >> 18 & 255))) >= 0;
                 shuffle = shuffle * 1664525u + 1013904223u) {
                unsigned dice = shuffle >> 8 & 15; // now and then an answer against the grain, or none
                enum bisect_answer answer = by_threshold(live.points[point].at, 0.3);
                if (live.points[point].round > 0 && dice == 0)
                    answer = answer == BISECT_RAISE ? BISECT_LOWER : BISECT_RAISE;
                if (live.points[point].round > 0 && dice == 1)
                    answer = BISECT_NEITHER;
                bisect_put(&live, point, answer);
            }
            bisect_start(&again, -1, 1, 3, sections);
            for (int k = 0; k < again.point_count; k++)
                if (live.points[k].answer != BISECT_PENDING)
                    bisect_put(&again, k, live.points[k].answer);
            assert_memory_equal(&again, &live, sizeof live);
        }
}

/* Every pattern of three answers to the five points of a round, and every order of them. */
static void test_every_pattern_of_a_round(void **state)
{
    (void)state;
    enum { SECTIONS = 5, PATTERNS = 243 };
    for (int pattern = 0; pattern < PATTERNS; pattern++)
        for (int order = 0; order < 120; order++) {
            static struct bisect b;
            enum bisect_answer answers[SECTIONS];
            for (int k = 0, rest = pattern; k < SECTIONS; k++, rest /= 3)
                answers[k] = rest % 3 == 0 ? BISECT_RAISE : rest % 3 == 1 ? BISECT_LOWER : BISECT_NEITHER;
            bisect_start(&b, 0, 6, 6, SECTIONS);
            bisect_put(&b, 0, BISECT_RAISE);
            bisect_put(&b, 1, BISECT_LOWER);
            for (int left = SECTIONS, rest = order; left > 0 && b.round_count == 1; rest /= left, left--) {
                int point = open_point(&b, rest % left);
                if (point >= 0)
                    bisect_put(&b, point, answers[point - 2]);
            }
            /* By hand: the lowest `lower`, and the highest `raise` below it. */
            double high = 6, low = 0;
            for (int k = SECTIONS; k-- > 0;)
                high = answers[k] == BISECT_LOWER ? k + 1 : high;
            for (int k = 0; k + 1 < high && k < SECTIONS; k++)
                low = answers[k] == BISECT_RAISE ? k + 1 : low;
            assert_int_equal(b.round_count, 2);
            assert_true(fabs(b.rounds[1].low - low) < 1e-12 && fabs(b.rounds[1].high - high) < 1e-12);
            assert_int_equal(b.end, low == 0 && high == 6 ? BISECT_STUCK : BISECT_SEARCHING);
        }
}

static void test_ends_are_verified_first(void **state)
{
    (void)state;
    static const struct {
        enum bisect_answer low, high;
        enum bisect_end end;
    } cases[] = {{BISECT_RAISE, BISECT_LOWER, BISECT_SEARCHING}, {BISECT_RAISE, BISECT_RAISE, BISECT_SAME_ENDS},
                 {BISECT_LOWER, BISECT_LOWER, BISECT_SAME_ENDS}, {BISECT_LOWER, BISECT_RAISE, BISECT_REVERSED},
                 {BISECT_NEITHER, BISECT_LOWER, BISECT_STUCK},   {BISECT_RAISE, BISECT_NEITHER, BISECT_STUCK},
                 {BISECT_NEITHER, BISECT_NEITHER, BISECT_STUCK}};
    for (size_t k = 0; k < COUNT(cases); k++)
        for (int turned = 0; turned < 2; turned++) {
            static struct bisect b;
            bisect_start(&b, 0, 1, 3, 2);
            assert_int_equal(b.point_count, 2);
            bisect_put(&b, turned, turned ? cases[k].high : cases[k].low);
            assert_int_equal(b.point_count, 2); // nothing is asked before both ends have answered
            assert_int_equal(b.end, BISECT_SEARCHING);
            bisect_put(&b, !turned, turned ? cases[k].low : cases[k].high);
            assert_int_equal(b.end, cases[k].end);
            assert_int_equal(b.point_count, cases[k].end == BISECT_SEARCHING ? 4 : 2);
        }
}

static void test_points_above_a_lower_one_are_spared_and_may_still_answer(void **state)
{
    (void)state;
    static struct bisect b;
    int lower, raise;
    bisect_start(&b, 0, 4, 3, 3);
    bisect_put(&b, 0, BISECT_RAISE);
    bisect_put(&b, 1, BISECT_LOWER);
    bisect_put(&b, 3, BISECT_LOWER); // of points at 1, 2, 3 the middle one
    assert_true(b.points[2].needed);
    assert_false(b.points[4].needed);
    bisect_put(&b, 2, BISECT_RAISE);
    assert_int_equal(b.round_count, 2); // did not wait for the one at 3
    assert_true(b.low == 1 && b.high == 2);
    assert_false(bisect_contradiction(&b, &lower, &raise));
    bisect_put(&b, 4, BISECT_RAISE); // it had ended all the same, and against the others
    assert_true(b.low == 1 && b.high == 2);
    assert_true(bisect_contradiction(&b, &lower, &raise));
    assert_int_equal(lower, 3);
    assert_int_equal(raise, 4);
}

static void test_a_missing_answer_stops_only_what_depends_on_it(void **state)
{
    (void)state;
    static struct bisect b;
    bisect_start(&b, 0, 3, 3, 2);
    bisect_put(&b, 0, BISECT_RAISE);
    bisect_put(&b, 1, BISECT_LOWER);
    bisect_put(&b, 2, BISECT_NEITHER);
    bisect_put(&b, 3, BISECT_LOWER);
    assert_int_equal(b.end, BISECT_SEARCHING); // 0..2 holds it still
    assert_true(b.low == 0 && b.high == 2);
    bisect_put(&b, 4, BISECT_NEITHER);
    bisect_put(&b, 5, BISECT_NEITHER);
    assert_int_equal(b.end, BISECT_STUCK);
    assert_int_equal(open_point(&b, 0), -1);
}

/* A threshold of 0 has no significant digits; tiny brackets have no numbers left between their ends. */
static void test_brackets_that_cannot_agree_end(void **state)
{
    (void)state;
    static struct bisect b;
    static const double ends[][2] = {{0, 1}, {-1, 0.5}, {1e-300, 2e-300}, {-1e15, 1e15}, {1, 1 + 1e-15}};
    for (size_t k = 0; k < COUNT(ends); k++)
        for (int sections = 1; sections <= BISECT_SECTIONS_MAX; sections++) {
            double threshold = ends[k][0] < 0 ? 0 : ends[k][0] * (1 + 1e-16) + (ends[k][0] == 0 ? 1e-200 : 0);
            bisect_start(&b, ends[k][0], ends[k][1], 9, sections);
            for (int point; (point = open_point(&b, 0)) >= 0;)
                bisect_put(&b, point,
                           point == 0   ? BISECT_RAISE
                           : point == 1 ? BISECT_LOWER
                                        : by_threshold(b.points[point].at, threshold));
            assert_int_equal(b.end, BISECT_FOUND);
            assert_true(b.low < b.high);
        }
}

static void test_rounds_left_count_down(void **state)
{
    (void)state;
    static struct bisect b;
    bisect_start(&b, 0, 1, 3, 1);
    bisect_put(&b, 0, BISECT_RAISE);
    bisect_put(&b, 1, BISECT_LOWER);
    for (int left = bisect_rounds_left(&b), point; (point = open_point(&b, 0)) >= 0;) {
        bisect_put(&b, point, by_threshold(b.points[point].at, 0.237));
        assert_true(bisect_rounds_left(&b) <= left + 4); // the last digit's unit shrinks with the numbers
        left = bisect_rounds_left(&b);
    }
    assert_int_equal(bisect_rounds_left(&b), 0);
}

/* ---- roots ---- */

static double linear(double x)
{
    return 3 * x - 1;
}
static double cubic(double x)
{
    return x * x * x;
}
static double steep(double x)
{
    return exp(20 * x);
}
static double falling(double x)
{
    return 1 / (1 + x * x * 40);
}
static double step(double x)
{
    return x < 0.4123 ? 0 : 1;
}
static double scattered(double x)
{
    return x + 0.001 * sin(1e6 * x);
}

static void solve(struct root *r, double (*f)(double), double target, int digits)
{
    root_start(r, 0, 1, target, digits);
    for (int k = 0; k < r->point_count; k++)
        root_put(r, k, f(r->points[k].at), false);
}

static void test_every_root_is_found(void **state)
{
    (void)state;
    const struct {
        double (*f)(double);
        double target, root, away; // away: from the root, beyond the digits
    } cases[] = {{linear, 0.5, 0.5, 0},        {linear, 0, 1 / 3.0, 0},        {cubic, 0.2, cbrt(0.2), 0},
                 {steep, 50, log(50) / 20, 0}, {steep, 4e8, log(4e8) / 20, 0}, {falling, 0.1, sqrt(0.225), 0},
                 {step, 0.5, 0.4123, 0},       {scattered, 0.6, 0.6, 0.0011}};
    static struct root r;
    for (size_t k = 0; k < COUNT(cases); k++)
        for (int digits = 1; digits <= 6; digits++) {
            solve(&r, cases[k].f, cases[k].target, digits);
            assert_int_equal(r.end, ROOT_FOUND);
            assert_true(fabs(root_value(&r) - cases[k].root) <= 0.56 * digits_unit(r.low, r.high, digits) + cases[k].away);
            assert_true((cases[k].f(r.low) - cases[k].target) * (cases[k].f(r.high) - cases[k].target) <= 0);
            assert_true(r.point_count <= 7 + 8 * digits); // far below the 128 there is room for
        }
    solve(&r, linear, 0.5, 3);
    assert_int_equal(r.point_count, 3); // a straight line is met at once
    solve(&r, cubic, 0.2, 3);
    assert_true(r.point_count <= 14);
}

static void test_root_at_an_end(void **state)
{
    (void)state;
    static struct root r;
    solve(&r, linear, -1, 3);
    assert_int_equal(r.end, ROOT_FOUND);
    assert_true(root_value(&r) == 0 && r.low == 0 && r.high == 0);
    solve(&r, linear, 2, 3);
    assert_true(r.end == ROOT_FOUND && root_value(&r) == 1);
}

static void test_root_needs_a_change_of_side(void **state)
{
    (void)state;
    static struct root r;
    solve(&r, cubic, 2, 3);
    assert_int_equal(r.end, ROOT_SAME_SIDE);
    assert_int_equal(r.point_count, 2);
    solve(&r, cubic, -1, 3);
    assert_int_equal(r.end, ROOT_SAME_SIDE);
}

static void test_root_without_a_number_is_stuck(void **state)
{
    (void)state;
    static struct root r;
    root_start(&r, 0, 1, 0.5, 3);
    root_put(&r, 1, 1, false); // either end may answer first
    assert_int_equal(r.point_count, 2);
    root_put(&r, 0, 0, true);
    assert_int_equal(r.end, ROOT_STUCK);
    root_start(&r, 0, 1, 0.5, 3);
    root_put(&r, 0, 0, false);
    root_put(&r, 1, NAN, false);
    assert_int_equal(r.end, ROOT_STUCK);
    root_start(&r, 0, 1, 0.3, 3);
    root_put(&r, 0, 0, false);
    root_put(&r, 1, 1, false);
    root_put(&r, 2, 0.1, false);
    root_put(&r, 3, 0, true);
    assert_int_equal(r.end, ROOT_STUCK);
    assert_true(r.points[2].low < r.points[2].high);
}

/* ---- sweeps ---- */

static void test_ranges(void **state)
{
    (void)state;
    static const struct {
        struct sweep_range range;
        size_t count;
        double second, last;
    } cases[] = {{{.from = 22, .to = 24, .step = 0.1}, 21, 22.1, 24},
                 {{.from = 24, .to = 22, .step = -0.5}, 5, 23.5, 22},
                 {{.from = 0, .to = 1, .step = 0.3}, 4, 0.3, 0.9},
                 {{.from = 0.1, .to = 0.3, .count = 3}, 3, 0.2, 0.3},
                 {{.from = 1, .to = 1000, .count = 4, .log = true}, 4, 10, 1000},
                 {{.from = 1, .to = 100, .step = 10, .log = true}, 3, 10, 100},
                 {{.from = 100, .to = 1, .step = 0.1, .log = true}, 3, 10, 1},
                 {{.from = 5, .to = 5, .count = 1}, 1, 5, 5},
                 {{.from = 5, .to = 5, .step = 2}, 1, 5, 5}};
    for (size_t k = 0; k < COUNT(cases); k++) {
        size_t count = 0;
        assert_int_equal(sweep_range_count(&cases[k].range, "r", &count, NULL), SCREE_OK);
        assert_int_equal(count, cases[k].count);
        assert_true(sweep_range_at(&cases[k].range, count, 0) == cases[k].range.from);
        if (count > 1)
            assert_true(sweep_range_at(&cases[k].range, count, 1) == cases[k].second);
        assert_true(sweep_range_at(&cases[k].range, count, count - 1) == cases[k].last);
    }
}

static void test_ranges_that_are_refused(void **state)
{
    (void)state;
    static const struct {
        struct sweep_range range;
        const char *message;
    } cases[] = {
        {{.from = 0, .to = 1}, "r: one of \"step\" and \"count\" is expected, and not 0"},
        {{.from = 0, .to = 1, .step = 1, .count = 2}, "r: one of \"step\" and \"count\" is expected, and not 0"},
        {{.from = 0, .to = 1, .step = -0.1}, "r: a step of -0.1 does not lead from 0 to 1"},
        {{.from = 1, .to = 10, .step = 0.5, .log = true}, "r: a factor of 0.5 does not lead from 1 to 10"},
        {{.from = 1, .to = 10, .step = 1, .log = true}, "r: a factor of 1 does not lead from 1 to 10"},
        {{.from = 0, .to = 10, .count = 3, .log = true}, "r: a logarithmic range needs ends above 0"},
        {{.from = 0, .to = 1, .count = 2.5}, "r: \"count\" must be a whole number from 1 on"},
        {{.from = 0, .to = 1, .count = -3}, "r: \"count\" must be a whole number from 1 on"},
        {{.from = 0, .to = 1, .count = 1}, "r: one value cannot stand at both ends of a range"},
        {{.from = 0, .to = 1, .step = 1e-9}, "r: 1e+09 values are more than the 4096 trials that a sweep may have"},
        {{.from = 0, .to = 1e300, .step = 1e-300}, "r: inf values are more than the 4096 trials that a sweep may have"},
        {{.from = 0, .to = 1, .count = 1e18}, "r: 1e+18 values are more than the 4096 trials that a sweep may have"},
    };
    for (size_t k = 0; k < COUNT(cases); k++) {
        struct scree_error err = {0};
        size_t count;
        assert_int_equal(sweep_range_count(&cases[k].range, "r", &count, &err), SCREE_INVALID);
        assert_error(&err, SCREE_INVALID, "r", cases[k].message);
    }
}

/* Every combination once, replicas next to each other. */
static void test_a_grid_is_run_through_once(void **state)
{
    (void)state;
    const struct sweep sweep = {.counts = {3, 1, 4}, .axes = 3, .replicas = 2};
    bool seen[3][4][2] = {0};
    size_t trials, values[SWEEP_AXES_MAX], replica;
    assert_int_equal(sweep_trials(&sweep, &trials, NULL), SCREE_OK);
    assert_int_equal(trials, 24);
    for (size_t k = 0; k < trials; k++) {
        sweep_trial(&sweep, k, values, &replica);
        assert_int_equal(replica, k % 2);
        assert_int_equal(values[2], k / 2 % 4);
        assert_int_equal(values[1], 0);
        assert_false(seen[values[0]][values[2]][replica]);
        seen[values[0]][values[2]][replica] = true;
    }
}

static void test_a_grid_has_a_stated_maximum(void **state)
{
    (void)state;
    struct sweep sweep = {.counts = {64, 64}, .axes = 2, .replicas = 1};
    struct scree_error err = {0};
    size_t trials;
    assert_int_equal(sweep_trials(&sweep, &trials, &err), SCREE_OK);
    sweep.replicas = 2;
    assert_int_equal(sweep_trials(&sweep, &trials, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "grid", "grid: 8192 trials are more than the 4096 that a sweep may have");
    sweep = (struct sweep){.axes = SWEEP_AXES_MAX, .replicas = 64};
    for (size_t k = 0; k < SWEEP_AXES_MAX; k++)
        sweep.counts[k] = 4096; // their product overflows every integer
    assert_int_equal(sweep_trials(&sweep, &trials, &err), SCREE_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bracket_on_a_rounding_boundary_closes),
        cmocka_unit_test(test_rounding_is_that_of_the_printed_number),
        cmocka_unit_test(test_every_threshold_is_found),
        cmocka_unit_test(test_order_of_answers_does_not_matter),
        cmocka_unit_test(test_a_replay_gives_the_same_state),
        cmocka_unit_test(test_every_pattern_of_a_round),
        cmocka_unit_test(test_ends_are_verified_first),
        cmocka_unit_test(test_points_above_a_lower_one_are_spared_and_may_still_answer),
        cmocka_unit_test(test_a_missing_answer_stops_only_what_depends_on_it),
        cmocka_unit_test(test_brackets_that_cannot_agree_end),
        cmocka_unit_test(test_rounds_left_count_down),
        cmocka_unit_test(test_every_root_is_found),
        cmocka_unit_test(test_root_at_an_end),
        cmocka_unit_test(test_root_needs_a_change_of_side),
        cmocka_unit_test(test_root_without_a_number_is_stuck),
        cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_ranges_that_are_refused),
        cmocka_unit_test(test_a_grid_is_run_through_once),
        cmocka_unit_test(test_a_grid_has_a_stated_maximum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
