/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A flow of softened grains (protocols 1.15) is the flow of glass: Young's modulus
 * over 1000, with beta and the time step times 1000^(2/5), leaves beta / tau, and so
 * the restitution of an impact at any speed, as it is, and costs sixteen times less.
 * Depth and profiles agree within their scatter; frequencies scale with 1 / tau. */
#include "summary.h"

#include <math.h>

#define SOFTER 1000.0
enum { HEIGHTS = 16 * 6 };

struct outcome {
    struct summary summary;
    double profile[HEIGHTS][10];
};

static enum scree_status keep(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct outcome *o = context;
    (void)err;
    if (strcmp(chunk->stream->name, "profiles_mean") == 0) {
        assert_int_equal(chunk->rows, HEIGHTS);
        assert_int_equal(chunk->stream->column_count, 10);
        memcpy(o->profile, chunk->values, sizeof o->profile);
    }
    return SCREE_OK;
}

/* The second half of two seconds at 24.5 degrees; moduli over `softer`. */
static void flow(double softer, int64_t seed, struct outcome *o)
{
    struct job_spec job;
    double slower = pow(softer, 0.4);
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = 6;
    p->nz = 6;
    p->slope_deg = 24.5;
    job.seed = seed;
    p->base_seed = seed;
    job.material.young_Pa /= softer;
    job.material.beta_s *= slower;
    job.time.step_s *= slower;
    job.time.end_s = 2;
    job.stop.when = 0;
    job.record.basal_force.every_s = 10 * job.time.step_s;
    job.record.profiles = (struct record_profiles){true, 1e-3, 0.1};
    job.record.spectrum.on = true;
    job.record.spectrum.window_s = 0.25;
    job.record.spectrum.band_hz /= slower;
    job.record.spectrum.fit_from_hz /= slower;
    job.record.spectrum.fit_to_hz /= slower;
    const struct scree_sink sink = {.put = keep, .context = o};
    o->summary = run(&job, &sink);
}

static const char *const same[] = {"depth", "depth_half", "mean_fraction", "mean_downslope", "mean_temperature"};
enum { SAME = 5, GLASS = 3, SOFT = 6 };

/* Mean and scatter of a number over realisations. */
static void mean_of(const struct outcome *o, int count, const char *name, double *mean, double *scatter)
{
    double sum = 0, sum2 = 0;
    for (int k = 0; k < count; k++) {
        sum += number(&o[k].summary, name) / count;
        sum2 += number(&o[k].summary, name) * number(&o[k].summary, name) / count;
    }
    *mean = sum;
    *scatter = sqrt(fmax(0, sum2 - sum * sum) * count / (count - 1));
}

/* Means over realisations of base and filling differ by less than three standard errors of the difference, and by little. */
static void softened_grains_flow_as_glass_does(void **state)
{
    (void)state;
    static struct outcome glass[GLASS], soft[SOFT];
    static const double within[SAME] = {0.1, 0.1, 0.03, 0.25, 0.3};
    for (int k = 0; k < GLASS; k++)
        flow(1, k + 1, &glass[k]);
    for (int k = 0; k < SOFT; k++)
        flow(SOFTER, k + 1, &soft[k]);
    for (int k = 0; k < SAME; k++) {
        double a, b, sa, sb;
        mean_of(glass, GLASS, same[k], &a, &sa);
        mean_of(soft, SOFT, same[k], &b, &sb);
        double standard = sqrt(sa * sa / GLASS + sb * sb / SOFT);
        print_message("%s: glass %.4g +- %.2g, softened %.4g +- %.2g\n", same[k], a, sa, b, sb);
        assert_true(fabs(b - a) < 3 * standard + 0.01 * a);
        assert_true(fabs(b / a - 1) < within[k]);
    }
    for (int h = 8; h < 20; h++) { // 1.1 to 3.9 diameters over the base
        double a = 0, b = 0;
        for (int k = 0; k < GLASS; k++)
            a += glass[k].profile[h][1] / GLASS;
        for (int k = 0; k < SOFT; k++)
            b += soft[k].profile[h][1] / SOFT;
        assert_true(fabs(b - a) < 0.03);
    }
    for (int k = 0; k < SOFT; k++) // the base of softened grains is one, not a pressed cake of them (protocols 1.3)
        assert_true(number(&soft[k].summary, "fixed_per_d2") > 1.1 && number(&soft[k].summary, "fixed_per_d2") < 1.6);
    double corner, power, corner_soft, power_soft, scatter;
    mean_of(glass, GLASS, "spectrum_corner", &corner, &scatter);
    mean_of(soft, SOFT, "spectrum_corner", &corner_soft, &scatter);
    mean_of(glass, GLASS, "spectrum_power", &power, &scatter);
    mean_of(soft, SOFT, "spectrum_power", &power_soft, &scatter);
    print_message("corner in 1 / tau: ratio %.3f, power: ratio %.3f\n", corner_soft / corner * pow(SOFTER, 0.4),
                  power_soft / power);
    assert_true(fabs(corner_soft / corner * pow(SOFTER, 0.4) - 1) < 0.15);
    assert_true(power_soft / power > 0.5 && power_soft / power < 2); // rate and impulse of impacts do not know E
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(softened_grains_flow_as_glass_does)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
