/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The theory of one Hertz impact against published and exact numbers, and the
 * estimator of spectra against signals whose spectrum is known. */
#include "unit.h"

#include "base/rng.h"
#include "measure/spectrum.h"

/* ---- theory ---- */

/* Depth of an impact by velocity Verlet, eq. 43, at `steps` steps until it is over; its force D^(3/2) into `force`. */
static size_t impact(double step, double *force, size_t room)
{
    double depth = 0, rate = 1, pull = 0;
    size_t n = 0;
    do {
        force[n++] = pull;
        rate -= 0.5 * step * pull;
        depth += step * rate;
        pull = depth > 0 ? depth * sqrt(depth) : 0;
        rate -= 0.5 * step * pull;
    } while (pull > 0 && n < room);
    return n;
}

/* S0-01, 02: the transform agrees with the definition's own numbers. */
static void zeta_has_its_published_corner(void **state)
{
    (void)state;
    near(zeta(0), 1, 1e-7);
    near(zeta(ZETA_CORNER), 0.529342, 1e-5);
    near(zeta(0.200), 0.528164, 1e-5);
    near(zeta(2 * ZETA_CORNER), zeta(ZETA_CORNER) / 10, 2e-6); // f_c = min{f: zeta(2 f) < zeta(f) / 10}
    assert_true(zeta(0.396) > zeta(0.198) / 10);
    double sum = 0, exact = 2 * 0.4 * pow(1.25, 0.4) * tgamma(0.4) * tgamma(0.5) / tgamma(0.9);
    near(ZETA_T0, exact, 1e-11);
    for (int k = 0; k < 40000; k++) // to f = 20; beyond, eq. 50 leaves 1e-9
        sum += zeta((k + 0.5) * 5e-4) * 5e-4;
    near(sum, ZETA_INTEGRAL, 2e-6);
}

/* S0-02, by an impact computed step by step and 200 steps long, and the plain sum of eq. 44. */
static void zeta_is_the_transform_of_an_impact(void **state)
{
    (void)state;
    static double force[400];
    double step = ZETA_T0 / 200;
    size_t n = impact(step, force, 400);
    near((double)n * step, ZETA_T0, 1.1 * step);
    for (double f = 0.05; f < 0.5; f += 0.05) {
        double re = 0, im = 0, whole = 0;
        for (size_t k = 0; k < n; k++) {
            re += force[k] * cos(2 * M_PI * f * (double)k * step);
            im += force[k] * sin(2 * M_PI * f * (double)k * step);
            whole += force[k];
        }
        near(zeta(f), (re * re + im * im) / (whole * whole), 1e-3);
        near(whole * step, 2, 2e-3);
    }
}

/* S0-04: zeros lie near (k - 1/4) / T0, not at k / T0 as printed; S0-03: and maxima are the asymptote's only roughly. */
static void zeros_and_maxima_are_where_the_errata_say(void **state)
{
    (void)state;
    const double zeros[] = {1.804, 2.762, 3.755, 4.753, 5.751}, maxima[] = {2.162, 3.178, 4.193, 5.203, 6.211};
    const double heights[] = {0.0012875, 0.00018867, 4.739e-05, 1.616e-05, 6.687e-06};
    const double front = 81 * M_PI / (1024 * 1.8540747 * 1.8540747); // eq. 50: 0.653 (f / f_c)^-5
    near(front, 0.0722904, 1e-7);
    near(front * pow(0.2 * 3.22, -5), 0.65261, 1e-5);
    near(front * pow(ZETA_CORNER * ZETA_T0, -5), 0.6601, 1e-4);
    const double ratios[] = {2.71464, 0.94469, 0.89882, 0.88060, 0.87276}; // exact T0; rounded ones make it 1 % more
    for (int k = 0; k < 5; k++) {
        double lowest = zeros[k], highest = maxima[k];
        for (double x = zeros[k] - 0.02; x < zeros[k] + 0.02; x += 1e-4)
            lowest = zeta(x / ZETA_T0) < zeta(lowest / ZETA_T0) ? x : lowest;
        for (double x = maxima[k] - 0.02; x < maxima[k] + 0.02; x += 1e-4)
            highest = zeta(x / ZETA_T0) > zeta(highest / ZETA_T0) ? x : highest;
        near(lowest, zeros[k], 1e-3);
        near(highest, maxima[k], 2e-3);
        near(zeta(highest / ZETA_T0), heights[k], 0.01 * heights[k]);
        double at = k + 2 - 0.75, asymptote = front * pow(at, -5);
        near(zeta(at / ZETA_T0) / asymptote, ratios[k], 1e-3 * ratios[k]);
    }
}

/* S0-05: the moving mean's coefficient is 0.27 +- 0.02, not 0.33 as printed. */
static void the_moving_mean_falls_by_the_fifth_power(void **state)
{
    (void)state;
    for (int x = 3; x <= 8; x++) {
        double sum = 0;
        for (int k = 0; k < 400; k++)
            sum += zeta((x - 0.5 + (k + 0.5) / 400) / ZETA_T0) / 400;
        near(sum * pow(x / ZETA_T0 / ZETA_CORNER, 5), 0.27, 0.02);
    }
}

/* S0-06: tau of eq. 42. */
static void impact_time_is_of_a_sphere_on_a_fixed_one(void **state)
{
    (void)state;
    double tau = impact_time(2e-3, 2530, 74e9, 0.22, 0.14);
    near(tau, 3.591e-6, 0.001e-6);
    near(ZETA_T0 * tau, 1.156e-5, 0.001e-5);
    near(ZETA_CORNER / tau, 55.6e3, 0.1e3);
    near(tau * pow(4, -0.2), 2.721e-6, 0.001e-6);
}

/* ---- estimate ---- */

static const double range[2] = {2e3, 150e3};
enum { SAMPLES = 1 << 16 };
static double signal[SAMPLES], power[SAMPLES], f[SAMPLES], band[SAMPLES];

/* Parseval: the integral over both signs is the variance; a white signal's power is variance times dt. */
static void the_integral_is_the_variance(void **state)
{
    (void)state;
    struct rng rng = rng_start(5, 1);
    double mean = 0, variance = 0, dt = 2.5e-6, sum = 0;
    for (size_t k = 0; k < SAMPLES; k++)
        mean += (signal[k] = 3 + rng_uniform(&rng, 0, 1)) / SAMPLES;
    for (size_t k = 0; k < SAMPLES; k++)
        variance += (signal[k] - mean) * (signal[k] - mean) / SAMPLES;
    assert_int_equal(spectrum_welch(signal, SAMPLES, 1, dt, 8, power, NULL), SCREE_OK);
    size_t length = spectrum_segment(SAMPLES, 8), bins = length / 2 + 1;
    double df = 1 / ((double)length * dt);
    for (size_t k = 0; k < bins; k++)
        sum += df * power[k] * (k == 0 || k == bins - 1 ? 1 : 2);
    near(sum / variance, 1, 0.02);
    near(variance, 1.0 / 12, 0.001);
    size_t count = spectrum_bands(power, bins, df, 1e3, f, band, SAMPLES);
    assert_int_equal(count, 200);                  // up to Nyquist, whose own bin makes no band
    for (size_t b = 1, wild = 0; b < count; b++) { // each of some 36 bins in 8 segments
        wild += fabs(band[b] / (variance * dt) - 1) > 0.3;
        assert_true(wild < 4);
        near(f[b], ((double)b + 0.5) * 1e3, df);
    }
}

/* A sine shows at its own frequency with half its squared amplitude, whatever the stride. */
static void a_sine_keeps_its_power_and_place(void **state)
{
    (void)state;
    enum { N = 4096 };
    double dt = 1e-3, sum = 0;
    for (size_t k = 0; k < N; k++) {
        signal[3 * k] = signal[3 * k + 2] = 1e9; // the other components of a force
        signal[3 * k + 1] = 7 + 2 * sin(2 * M_PI * 100 * (double)k * dt);
    }
    assert_int_equal(spectrum_welch(signal + 1, N, 3, dt, 4, power, NULL), SCREE_OK);
    size_t length = spectrum_segment(N, 4), best = 1;
    for (size_t k = 1; k <= length / 2; k++) {
        sum += 2 * power[k] / ((double)length * dt);
        best = power[k] > power[best] ? k : best;
    }
    near((double)best / ((double)length * dt), 100, 1 / ((double)length * dt));
    near(sum, 2, 0.01);
}

static void means_over_bands_and_octaves(void **state)
{
    (void)state;
    enum { BINS = 65 };
    for (size_t k = 0; k < BINS; k++)
        power[k] = k == 0 ? 1e9 : (double)k;
    size_t bands = spectrum_bands(power, BINS, 10, 100, f, band, 100);
    assert_int_equal(bands, 7); // bins at 10 .. 640 Hz
    near(band[0], 5, 1e-12);    // 10 .. 90: the one at 0 is of none
    near(band[1], 14.5, 1e-12); // 100 .. 190
    near(f[1], 145, 1e-9);
    near(band[6], 62, 1e-12); // 600 .. 640
    near(f[6], 620, 1e-9);
    assert_int_equal(spectrum_bands(power, BINS, 10, 10, f, band, 100), 64); // a bin a band
    near(f[5], 50, 1e-9);
    near(band[5], 5, 1e-12);
    size_t octaves = spectrum_octaves(power, BINS, 10, f, band, 100);
    size_t top = octaves - 1;
    near(band[top], 0.5 * (33 + 64), 1e-12);
    near(f[top], 10 * sqrt(33 * 64), 1e-9);
    near(f[0], 10, 1e-9);
    near(band[0], 1, 1e-12);
    for (size_t k = 1; k < octaves; k++)
        assert_true(f[k] > f[k - 1]);
}

static void too_few_samples_say_how_many_are_needed(void **state)
{
    (void)state;
    struct scree_error err = {0};
    assert_int_equal(spectrum_welch(signal, 71, 1, 1, 8, power, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "", "a spectrum of 8 segments needs at least 72 samples, and there are 71");
    assert_int_equal(spectrum_welch(signal, 72, 1, 1, 8, power, NULL), SCREE_OK);
    struct spectrum_fit fit;
    const double few[] = {3e3, 4e3, 5e3, 6e3, 7e3, 8e3, 9e3, 151e3}, one[] = {1, 1, 1, 1, 1, 1, 1, 1};
    assert_int_equal(spectrum_fit(few, one, 8, range, &fit, &err), SCREE_INVALID);
    assert_non_null(strstr(err.message, "at least 8 frequencies with power between 2000 and 150000 Hz, and there are 7"));
}

/* ---- a Poisson train of impacts, S0-30 ---- */

static double hertz_table[2001]; // D^(3/2) over T / T0

/* Integral of the force of an impact of impulse 1 from its start to time t (in tau). */
static double impulse_until(double t)
{
    double x = t / ZETA_T0 * 2000;
    if (x <= 0)
        return 0;
    if (x >= 2000)
        return 1;
    size_t k = (size_t)x;
    return hertz_table[k] + (x - (double)k) * (hertz_table[k + 1] - hertz_table[k]);
}

static void make_table(void)
{
    static double force[2100];
    size_t n = impact(ZETA_T0 / 2000, force, 2100);
    double sum = 0;
    for (size_t k = 0; k <= 2000; k++) {
        hertz_table[k] = sum;
        sum += k + 1 < n ? 0.5 * (force[k] + force[k + 1]) : 0;
    }
    for (size_t k = 0; k <= 2000; k++)
        hertz_table[k] /= sum;
}

/* Means over blocks of dt of `count` impacts of impulse J at random instants. */
static void add_train(double *x, size_t n, double dt, size_t count, double impulse, double tau, uint64_t seed)
{
    struct rng rng = rng_start(seed, 1);
    for (size_t i = 0; i < count; i++) {
        double start = rng_uniform(&rng, 0, 1) * (double)n * dt;
        for (size_t k = (size_t)(start / dt); k < n; k++) {
            double from = impulse_until(((double)k * dt - start) / tau), to = impulse_until(((double)(k + 1) * dt - start) / tau);
            x[k] += impulse * (to - from) / dt;
            if (to >= 1)
                break;
        }
    }
}

enum { TRAIN = 1 << 20 };
static double train[TRAIN];

/* P = r J^2 zeta(f tau) from blocks of the force, corrected for what averaging takes: fixes every factor of 2. */
static void a_poisson_train_has_campbells_spectrum(void **state)
{
    (void)state;
    double dt = 2.5e-6, tau = 4e-6, impulse = 3e-6, count = 150000, rate = count / (TRAIN * dt), p0 = rate * impulse * impulse;
    make_table();
    memset(train, 0, sizeof train);
    add_train(train, TRAIN, dt, (size_t)count, impulse, tau, 7);
    assert_int_equal(spectrum_welch(train, TRAIN, 1, dt, 64, power, NULL), SCREE_OK);
    size_t length = spectrum_segment(TRAIN, 64), bins = length / 2 + 1;
    double df = 1 / ((double)length * dt);
    for (size_t k = 0; k < bins; k++)
        power[k] /= spectrum_block_gain((double)k * df, dt);
    const double ranges[][2] = {{1e3, 8e3}, {0.18 / tau, 0.22 / tau}, {0.30 / tau, 0.34 / tau}}, expect[] = {1.0, 0.528, 0.176};
    for (int r = 0; r < 3; r++) {
        double sum = 0, theory = 0, number = 0;
        for (size_t k = 1; k < bins; k++)
            if ((double)k * df >= ranges[r][0] && (double)k * df < ranges[r][1]) {
                sum += power[k] / p0;
                theory += zeta((double)k * df * tau);
                number += 1;
            }
        near(theory / number, expect[r], 0.01);
        near(sum / theory, 1, 0.02);
    }
    size_t count_of = spectrum_bands(power, bins, df, 1e3, f, band, SAMPLES);
    struct spectrum_fit fit;
    assert_int_equal(spectrum_fit(f, band, count_of, range, &fit, NULL), SCREE_OK);
    near(fit.power / p0, 1, 0.03);
    near(fit.tau / tau, 1, 0.02);
    assert_int_equal(fit.used, 148);
    /* The fit's variance is the train's: r J^2 2 int zeta / tau, which dF^2 rests on. */
    double mean = 0, variance = 0;
    for (size_t k = 0; k < TRAIN; k++)
        mean += train[k] / TRAIN;
    for (size_t k = 0; k < TRAIN; k++)
        variance += (train[k] - mean) * (train[k] - mean) / TRAIN;
    near(mean / (rate * impulse), 1, 0.005);
    double left = 0; // what the means over blocks leave of the variance
    for (int k = 0; k < 40000; k++)
        left += 2 * p0 * zeta((k + 0.5) * 50 * tau) * spectrum_block_gain((k + 0.5) * 50, dt) * 50;
    near(variance / left, 1, 0.02);
    near(left / (2 * ZETA_INTEGRAL * p0 / tau), 0.966, 0.005);
}

/* A slow part ten thousand times as strong below the window of the fit changes neither number; nor does one that
 * reaches into its lowest bands do more than a little. */
static void a_slow_part_does_not_move_the_fit(void **state)
{
    (void)state;
    enum { N = 200 };
    double tau = 3.2e-6, at[N], flat[N], red[N];
    struct spectrum_fit clean, fit;
    for (size_t k = 0; k < N; k++) {
        at[k] = 1e3 * ((double)k + 0.5);
        flat[k] = 2e-7 * zeta(at[k] * tau);
        red[k] = flat[k] + (at[k] < 2e3 ? 2e-3 : 2e-7 * pow(at[k] / 4e3, -4));
    }
    assert_int_equal(spectrum_fit(at, flat, N, range, &clean, NULL), SCREE_OK);
    near(clean.tau / tau, 1, 3e-3);
    near(clean.power / 2e-7, 1, 2e-3);
    assert_true(clean.misfit < 0.01);
    assert_int_equal(spectrum_fit(at, red, N, range, &fit, NULL), SCREE_OK);
    near(fit.tau / tau, 1, 0.1);
    near(fit.power / 2e-7, 1, 0.15);
}

/* Chains of lasting contacts redden the whole range: any P_F^0 would be the range's choice. */
static void power_that_falls_from_the_lowest_on_is_not_fitted(void **state)
{
    (void)state;
    enum { N = 200 };
    double at[N], red[N];
    struct spectrum_fit fit = {.power = 1};
    struct scree_error err = {0};
    for (size_t k = 0; k < N; k++) {
        at[k] = 1e3 * ((double)k + 0.5);
        red[k] = 2e-7 * pow(at[k] / 4e3, -3);
    }
    assert_int_equal(spectrum_fit(at, red, N, range, &fit, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "", "no corner lies between 2000 and 150000 Hz: power falls from the lowest frequencies on");
    assert_true(fit.power == 0 && fit.tau == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zeta_has_its_published_corner),
        cmocka_unit_test(zeta_is_the_transform_of_an_impact),
        cmocka_unit_test(zeros_and_maxima_are_where_the_errata_say),
        cmocka_unit_test(the_moving_mean_falls_by_the_fifth_power),
        cmocka_unit_test(impact_time_is_of_a_sphere_on_a_fixed_one),
        cmocka_unit_test(the_integral_is_the_variance),
        cmocka_unit_test(a_sine_keeps_its_power_and_place),
        cmocka_unit_test(means_over_bands_and_octaves),
        cmocka_unit_test(too_few_samples_say_how_many_are_needed),
        cmocka_unit_test(a_poisson_train_has_campbells_spectrum),
        cmocka_unit_test(a_slow_part_does_not_move_the_fit),
        cmocka_unit_test(power_that_falls_from_the_lowest_on_is_not_fitted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
