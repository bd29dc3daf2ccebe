/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The equation of an impact and the fit of a decaying oscillation, against closed forms: targets S0-01, S0-11, S0-17. */
#include "unit.h"

#include <math.h>

#include "base/rng.h"
#include "calibrate/impact.h"
#include "calibrate/oscillation.h"

static void near_to(double value, double expect, double tolerance)
{
    if (!(fabs(value - expect) <= tolerance))
        fail_msg("%.17g is not %.17g within %g", value, expect, tolerance);
}

/* S0-01: T0 = 2 (2/5) (5/4)^(2/5) B(2/5, 1/2); the deepest point is (5/4)^(2/5). */
static void an_elastic_impact_is_hertz_s(void **state)
{
    (void)state;
    double duration, beta = exp(lgamma(0.4) + lgamma(0.5) - lgamma(0.9)), deepest = 0;
    near_to(impact_restitution(0, &duration), 1, 1e-9);
    near_to(duration, 0.8 * pow(1.25, 0.4) * beta, 1e-6);
    near_to(duration, 3.218065, 1e-6);
    struct impact impact;
    impact_start(&impact, 0);
    for (int k = 0; k < 40000; k++) {
        impact_advance(&impact, 1e-4);
        deepest = fmax(deepest, impact.overlap);
    }
    near_to(deepest, 1.093362, 1e-6);
    near_to(deepest, pow(1.25, 0.4), 1e-7);
    assert_true(impact.overlap == 0 && impact_force(&impact) == 0);
    near_to(impact.time, 4, 1e-9);
    near_to(impact.end, duration, 1e-6);
}

/* S0-11: b = 0.026486 gives e = 0.97; 0.0265, as printed, gives 0.96998. */
static void damping_and_restitution_invert_each_other(void **state)
{
    (void)state;
    double unused;
    near_to(impact_damping(0.97), 0.026486, 5e-7);
    near_to(impact_restitution(0.0265, &unused), 0.96998, 5e-6);
    for (double e = 0.1; e < 0.99; e += 0.11)
        near_to(impact_restitution(impact_damping(e), &unused), e, 1e-9);
    near_to(impact_damping(1), 0, 1e-10);
}

/* Of how an impact is cut into stretches nothing shows. */
static void stretches_do_not_show(void **state)
{
    (void)state;
    struct impact whole, pieces;
    impact_start(&whole, 0.05);
    impact_start(&pieces, 0.05);
    impact_advance(&whole, 2);
    for (int k = 0; k < 7; k++)
        impact_advance(&pieces, 2.0 / 7);
    near_to(pieces.overlap, whole.overlap, 1e-7);
    near_to(pieces.rate, whole.rate, 1e-7);
}

static void oscillate(double *u, int count, double interval, double rate, double decay, double noise)
{
    struct rng rng = rng_start(7, 0);
    for (int k = 0; k < count; k++) {
        double t = k * interval;
        u[k] = 3 * sin(0.4 + rate * t) * exp(-decay * t) + rng_uniform(&rng, -noise, noise);
    }
}

enum { SAMPLES = 400 };

static void an_oscillation_is_fitted(void **state)
{
    (void)state;
    double u[SAMPLES];
    struct oscillation o;
    const double rates[] = {50, 101.44, 400}, decays[] = {0, 10.399, 60};
    for (int k = 0; k < 3; k++) {
        oscillate(u, SAMPLES, 1e-3, rates[k], decays[k], 0);
        assert_true(oscillation_fit(u, SAMPLES, 1e-3, &o));
        near_to(o.rate, rates[k], 1e-6 * rates[k]);
        near_to(o.decay, decays[k], 1e-6 * rates[k]);
        near_to(hypot(o.cosine, o.sine), 3, 1e-6);
        near_to(o.misfit, 0, 1e-9);
    }
    oscillate(u, SAMPLES, 1e-3, 101.44, 10.399, 0.03); // 1 % of noise
    assert_true(oscillation_fit(u, SAMPLES, 1e-3, &o));
    near_to(o.rate, 101.44, 0.002 * 101.44);
    near_to(o.decay, 10.399, 0.03 * 10.399);
    assert_true(o.misfit > 0.005 && o.misfit < 0.1);
}

static void what_does_not_oscillate_is_not_fitted(void **state)
{
    (void)state;
    double u[SAMPLES] = {0};
    struct oscillation o;
    assert_false(oscillation_fit(u, 0, 1e-3, &o));
    assert_false(oscillation_fit(u, SAMPLES, 1e-3, &o));
    for (int k = 0; k < SAMPLES; k++)
        u[k] = exp(-0.01 * k);
    assert_false(oscillation_fit(u, SAMPLES, 1e-3, &o));
    oscillate(u, SAMPLES, 1e-3, 10, 1, 0); // half a period and a bit
    assert_false(oscillation_fit(u, SAMPLES, 1e-3, &o));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_elastic_impact_is_hertz_s),
        cmocka_unit_test(damping_and_restitution_invert_each_other),
        cmocka_unit_test(stretches_do_not_show),
        cmocka_unit_test(an_oscillation_is_fitted),
        cmocka_unit_test(what_does_not_oscillate_is_not_fitted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
