/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenarios that are calculations, through the production path: targets S0-09, S0-11, S0-12, S1-02, S1-04, S1-05. */
#include "summary.h"

#include <math.h>

static enum scree_status none(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    (void)context;
    (void)err;
    fail_msg("a calculation put a chunk of %s", chunk->stream->name);
    return SCREE_OK;
}

/* One step that puts nothing. */
static struct summary calculate(const struct job_spec *job)
{
    const struct summary out = run(job, &(struct scree_sink){.put = none});
    assert_int_equal(out.steps, 1);
    return out;
}

static void near_to(double value, double expect, double tolerance)
{
    if (!(fabs(value - expect) <= tolerance))
        fail_msg("%.9g is not %.9g within %g", value, expect, tolerance);
}

/* ---- plastic yield ---- */

struct yielding {
    double threshold, deepest, force_max;
    bool grows, unloading;
};

static double resistance(const struct yielding *y, double x)
{
    if (y->unloading && y->grows) { // radius R = x_m^(3/2) / F_m: F = sqrt(R) (x - x_0)^(3/2), F(x_m) = F_m
        double radius = pow(y->deepest, 1.5) / y->force_max, left = x - (y->deepest - y->deepest / radius);
        return left > 0 ? sqrt(radius) * pow(left, 1.5) : 0;
    }
    if (y->unloading) {
        double left = x - (y->deepest - pow(y->force_max, 2.0 / 3));
        return left > 0 ? pow(left, 1.5) : 0;
    }
    return x < y->threshold ? pow(fmax(0, x), 1.5) : 0.5 * sqrt(y->threshold) * (3 * x - y->threshold);
}

/* The motion itself, x'' = -F, by Verlet: knows nothing of energies. */
static double impact_by_steps(double threshold, double speed, bool grows)
{
    struct yielding y = {.threshold = threshold, .grows = grows};
    double x = 0, v = speed, h = 2e-5, force = 0;
    do {
        v -= 0.5 * h * force;
        x += h * v;
        if (v < 0 && !y.unloading && x > threshold) {
            y.deepest = x;
            y.force_max = force;
            y.unloading = true;
        }
        force = resistance(&y, x);
        v -= 0.5 * h * force;
    } while (x > 0 && (force > 0 || v > 0));
    return -v / speed;
}

/* S0-09. */
static void yield_thresholds_are_those_of_both_laws(void **state)
{
    (void)state;
    const double speed[] = {0.7, 0.8, 1, 1.5, 2, 4}, e[] = {0.9977, 0.9901, 0.97, 0.9211, 0.8827, 0.7904};
    struct job_spec job;
    job_defaults(&job, scenario_find("plastic_yield"));
    struct plastic_yield_params *p = (struct plastic_yield_params *)(void *)job.params;
    for (int k = 0; k < 6; k++) {
        p->at_m_s = speed[k] * p->speed_m_s;
        struct summary o = calculate(&job);
        double printed = number(&o, "threshold_printed"), thornton = number(&o, "threshold_thornton");
        near_to(printed, 0.7505, 5e-4);
        near_to(thornton, 0.7841, 5e-4);
        near_to(number(&o, "onset_printed"), 0.75, 5e-3);
        near_to(number(&o, "onset_thornton"), 0.65995 * 1.2, 5e-4);
        near_to(number(&o, "restitution_printed"), e[k], 2e-4);
        near_to(number(&o, "restitution_printed"), impact_by_steps(printed, speed[k], false), 1e-4);
        near_to(number(&o, "restitution_thornton"), impact_by_steps(thornton, speed[k], true), 1e-4);
        /* Thornton's closed form. */
        double x = fmin(1, number(&o, "onset_thornton") / p->at_m_s), x2 = x * x;
        near_to(number(&o, "restitution_thornton"),
                sqrt(6 * sqrt(3) / 5) * sqrt(1 - x2 / 6) * pow(x / (x + 2 * sqrt(1.2 - x2 / 5)), 0.25), 1e-4);
    }
}

/* ---- damping ---- */

/* S0-11, S0-12: the right scale, the published one and the printed one, and what each does to the spheres. */
static void damping_comes_out_right_published_or_as_printed(void **state)
{
    (void)state;
    const double beta[] = {71.2e-9, 45.06e-9, 35.6e-9}, e[] = {0.97, 0.9809, 0.9849};
    for (int k = 0; k < 3; k++) {
        struct job_spec job;
        job_defaults(&job, scenario_find("damping"));
        ((struct damping_params *)(void *)job.params)->length = k;
        struct summary o = calculate(&job);
        near_to(number(&o, "damping_ratio"), 0.026486, 5e-5);
        near_to(number(&o, "beta"), beta[k], 1e-3 * beta[k]);
        near_to(number(&o, "restitution"), e[k], 3e-4);
    }
}

/* ---- contact parameters ---- */

/* S1-02, 04, 05: the spheres of Table II, and the crosses of Table I, whose k_n is that against a wall. */
static void contact_parameters_are_those_of_the_tables(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, scenario_find("contact_parameters"));
    struct contact_parameters_params *p = (struct contact_parameters_params *)(void *)job.params;
    struct summary o = calculate(&job);
    near_to(number(&o, "stiffness"), 7.34e5, 1e-3 * 7.34e5);
    near_to(number(&o, "stiffness_t"), 225900, 1e-3 * 225900);
    near_to(number(&o, "rate_t"), 39730, 1e-3 * 39730);
    near_to(number(&o, "contact_time"), 8.658e-6, 1e-3 * 8.658e-6);
    near_to(number(&o, "stiffness_r"), 0.1115, 1e-3 * 0.1115);
    *p = (struct contact_parameters_params){.partner = CONTACT_WALL,
                                            .mass_kg = 2.4024e-4,
                                            .radius_m = 4.207e-3,
                                            .overlap_m = 5e-5,
                                            .speed_m_s = 2.426,
                                            .restitution = 0.85,
                                            .restitution_t = 1,
                                            .steps_per_contact = 20};
    o = calculate(&job);
    near_to(number(&o, "stiffness"), 4.83e5, 2e-3 * 4.83e5);
    p->stiffness = 4.5e5;
    o = calculate(&job);
    near_to(number(&o, "largest_overlap"), 5.18e-5, 2e-3 * 5.18e-5);
    near_to(number(&o, "contact_time"), 7.3e-5, 5e-3 * 7.3e-5);
    near_to(number(&o, "step"), number(&o, "contact_time") / 20, 1e-12);
}

/* ---- as worlds ---- */

static void there_is_nothing_to_record(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error error;
    job_defaults(&job, scenario_find("damping"));
    job.record.bulk.on = true;
    assert_int_equal(job_check(&job, 0, &error), SCREE_INVALID);
    assert_error(&error, SCREE_INVALID, "record.bulk", "record.bulk: scenario damping is a calculation, without a world to record");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(yield_thresholds_are_those_of_both_laws),
        cmocka_unit_test(damping_comes_out_right_published_or_as_printed),
        cmocka_unit_test(contact_parameters_are_those_of_the_tables),
        cmocka_unit_test(there_is_nothing_to_record),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
