/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See spectrum.h. FFTW plans by estimate, so that no clock decides; its planner is
 * shared by all threads of a process and is entered by one at a time. */
#include "measure/spectrum.h"

#include <fftw3.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <string.h>

/* ---- zeta ---- */

/* Half an impact: by symmetry about T0/2, F~ is 2 times the cosine transform of it. */
enum { HALF = 2048, TABLE = 1024 };
#define TABLE_TO 1.0 // in 1/tau

static double half_force[HALF + 1]; // D^(3/2) at equal times
static double zeta_table[TABLE + 1];
static pthread_once_t half_once = PTHREAD_ONCE_INIT, table_once = PTHREAD_ONCE_INIT;

static double hertz(double depth)
{
    return depth > 0 ? depth * sqrt(depth) : 0;
}

/* Eq. 43 by Runge-Kutta of fourth order; the first step by D = T - 4/35 T^(7/2), since D^(3/2) has no second derivative at 0. */
static void make_half(void)
{
    double h = 0.5 * ZETA_T0 / HALF, t = h, depth = t - 4.0 / 35 * pow(t, 3.5), rate = 1 - 0.4 * pow(t, 2.5);
    for (int k = 1; k <= HALF; k++) {
        half_force[k] = hertz(depth);
        double a1 = -hertz(depth), r2 = rate + 0.5 * h * a1, a2 = -hertz(depth + 0.5 * h * rate);
        double r3 = rate + 0.5 * h * a2, a3 = -hertz(depth + 0.5 * h * r2);
        double r4 = rate + h * a3, a4 = -hertz(depth + h * r3);
        depth += h / 6 * (rate + 2 * r2 + 2 * r3 + r4);
        rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
}

double zeta(double f)
{
    pthread_once(&half_once, make_half);
    double h = 0.5 * ZETA_T0 / HALF, sum = 0;
    for (int k = 1; k <= HALF; k++) { // Simpson; the value at 0 is 0
        double weight = k == HALF ? 1 : k % 2 ? 4 : 2;
        sum += weight * half_force[k] * cos(2 * M_PI * f * (0.5 * ZETA_T0 - h * k));
    }
    double transform = 2 * h / 3 * sum; // of the whole impact; at f = 0 the impulse, 2
    return 0.25 * transform * transform;
}

static void make_table(void)
{
    for (int k = 0; k <= TABLE; k++)
        zeta_table[k] = zeta(TABLE_TO * k / TABLE);
}

double impact_time(double diameter, double density, double young, double poisson, double speed)
{
    double stiff = young / (1 - poisson * poisson);
    return pow(M_PI * M_PI * density * density / (4 * stiff * stiff * speed), 0.2) * diameter;
}

/* ---- estimate ---- */

size_t spectrum_samples_needed(size_t segments)
{
    return SPECTRUM_SEGMENT_MIN / 2 * (segments + 1);
}

size_t spectrum_segment(size_t n, size_t segments)
{
    return n / (segments + 1) * 2;
}

double spectrum_block_gain(double f, double dt)
{
    double x = M_PI * f * dt, sinc = x > 0 ? sin(x) / x : 1;
    return sinc * sinc;
}

static pthread_mutex_t planner = PTHREAD_MUTEX_INITIALIZER;

/* One window's work space. */
struct transform {
    size_t length;
    double *in;
    fftw_complex *out;
    fftw_plan plan;
};

static void transform_free(struct transform *t)
{
    pthread_mutex_lock(&planner);
    if (t->plan)
        fftw_destroy_plan(t->plan);
    pthread_mutex_unlock(&planner);
    fftw_free(t->in);
    fftw_free(t->out);
}

static enum scree_status transform_make(struct transform *t, size_t length, struct scree_error *err)
{
    *t = (struct transform){.length = length};
    pthread_mutex_lock(&planner);
    t->in = fftw_malloc(length * sizeof *t->in);
    t->out = fftw_malloc((length / 2 + 1) * sizeof *t->out);
    if (t->in && t->out)
        t->plan = fftw_plan_dft_r2c_1d((int)length, t->in, t->out, FFTW_ESTIMATE);
    pthread_mutex_unlock(&planner);
    if (t->plan)
        return SCREE_OK;
    transform_free(t);
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a spectrum of %zu samples", length);
}

enum scree_status spectrum_welch(const double *x, size_t n, size_t stride, double dt, size_t segments, double *power,
                                 struct scree_error *err)
{
    size_t length = spectrum_segment(n, segments), bins = length / 2 + 1;
    if (segments < 1 || length < SPECTRUM_SEGMENT_MIN || length > 1u << 30)
        return scree_fail(err, SCREE_INVALID, NULL, "a spectrum of %zu segments needs at least %zu samples, and there are %zu",
                          segments, spectrum_samples_needed(segments), n);
    struct transform t;
    enum scree_status status = transform_make(&t, length, err);
    if (status)
        return status;
    double mean = 0, square = 0;
    for (size_t k = 0; k < n; k++)
        mean += x[k * stride];
    mean /= (double)n;
    memset(power, 0, bins * sizeof *power);
    for (size_t k = 0; k < length; k++)
        square += pow(sin(M_PI * (double)k / (double)length), 4);
    for (size_t s = 0; s < segments; s++) {
        for (size_t k = 0; k < length; k++) {
            double hann = sin(M_PI * (double)k / (double)length);
            t.in[k] = hann * hann * (x[(s * (length / 2) + k) * stride] - mean);
        }
        fftw_execute(t.plan);
        for (size_t k = 0; k < bins; k++)
            power[k] += (t.out[k][0] * t.out[k][0] + t.out[k][1] * t.out[k][1]) * dt / (square * (double)segments);
    }
    transform_free(&t);
    return SCREE_OK;
}

size_t spectrum_band_count(size_t bins, double df, double width)
{
    double highest = (double)(bins - 1) * df / width; // rounding must not make a band of the highest bin alone
    return highest > 1 ? (size_t)ceil(highest * (1 - 1e-12)) : 1;
}

/* First bin of band b; the bin at 0 is of none. */
static size_t band_first(size_t b, size_t bins, double df, double width)
{
    double first = ceil((double)b * width / df * (1 - 1e-12));
    return first < 1 ? 1 : first < (double)bins ? (size_t)first : bins;
}

double spectrum_band_middle(size_t b, size_t bins, double df, double width)
{
    size_t from = band_first(b, bins, df, width), to = band_first(b + 1, bins, df, width);
    return from < to ? 0.5 * df * (double)(from + to - 1) : ((double)b + 0.5) * width;
}

size_t spectrum_bands(const double *power, size_t bins, double df, double width, double *f, double *band, size_t room)
{
    size_t count = spectrum_band_count(bins, df, width);
    count = count < room ? count : room;
    for (size_t b = 0; b < count; b++) {
        size_t from = band_first(b, bins, df, width), to = band_first(b + 1, bins, df, width);
        double sum = 0;
        for (size_t k = from; k < to; k++)
            sum += power[k];
        f[b] = spectrum_band_middle(b, bins, df, width);
        band[b] = to > from ? sum / (double)(to - from) : 0;
    }
    return count;
}

size_t spectrum_octaves(const double *power, size_t bins, double df, double *f, double *band, size_t room)
{
    size_t count = 0, top = bins; // bins [top / 2, top)
    for (size_t end = bins; end > 1 && count < room; end = (end + 1) / 2)
        count++;
    for (size_t o = count; o-- > 0; top = (top + 1) / 2) {
        size_t from = (top + 1) / 2 > 1 ? (top + 1) / 2 : 1;
        double sum = 0;
        for (size_t k = from; k < top; k++)
            sum += power[k];
        f[o] = df * sqrt((double)from * (double)(top - 1));
        band[o] = sum / (double)(top - from);
    }
    return count;
}

/* ---- fit ---- */

#define FIT_FLOOR  0.02            // share of P_F^0 under which powers hardly count
#define FIT_EDGE   (1.5 / ZETA_T0) // f tau where zeta comes to less; as many frequencies as a fit needs must lie below
#define FIT_LOW    1e-7            // s, tau tried
#define FIT_HIGH   1e-3
#define FIT_COARSE 1.02 // steps of tau: at first, and about the best of those
#define FIT_FINE   1.002
enum { FIT_LEAST = 8, FIT_ROUNDS = 8 };

static double shape_at(double f)
{
    double place = f / TABLE_TO * TABLE;
    size_t k = (size_t)fmin(place, TABLE);
    return k >= TABLE ? 0 : zeta_table[k] + (place - (double)k) * (zeta_table[k + 1] - zeta_table[k]);
}

/* What is fitted: frequencies with power within a range. */
struct fitted {
    const double *f, *power, *range;
    size_t n;
};

static bool usable(const struct fitted *d, size_t k)
{
    return d->f[k] >= d->range[0] && d->f[k] <= d->range[1] && d->power[k] > 0;
}

/* Frequencies that count and lie below an edge. */
static size_t below(double edge, const struct fitted *d)
{
    size_t count = 0;
    for (size_t k = 0; k < d->n; k++)
        count += d->f[k] < edge && usable(d, k);
    return count;
}

/* The best P0 at that tau, by Gauss and Newton in ln P0 from `guess`. */
static struct spectrum_fit fit_at(double tau, double guess, const struct fitted *d)
{
    struct spectrum_fit fit = {.power = guess, .tau = tau};
    double shift = 1;
    for (int round = 0; round < FIT_ROUNDS && fabs(shift) > 1e-6; round++) {
        double sum = 0, weights = 0;
        fit.used = 0;
        fit.misfit = 0;
        for (size_t k = 0; k < d->n; k++) {
            if (!usable(d, k))
                continue;
            double share = d->power[k] / fit.power, off = log((share + FIT_FLOOR) / (shape_at(d->f[k] * tau) + FIT_FLOOR));
            double weight = share / (share + FIT_FLOOR); // -d off / d ln P0
            sum += weight * off;
            weights += weight * weight;
            fit.misfit += off * off;
            fit.used++;
        }
        fit.misfit = sqrt(fit.misfit / (double)fit.used);
        shift = fmin(fmax(sum / weights, -2), 2);
        if (fabs(shift) > 1e-6)
            fit.power *= exp(shift);
    }
    return fit;
}

/* Whether a tau is to be tried: too few frequencies lie below the edge of a longer one. */
static bool within(double tau, double high, const struct fitted *d)
{
    return tau < high && below(FIT_EDGE / tau, d) >= FIT_LEAST;
}

/* The best of tau from `low` to `high` in steps of `ratio`; none is used where none is to be tried. */
static struct spectrum_fit best_fit(double low, double high, double ratio, double guess, const struct fitted *d)
{
    struct spectrum_fit best = {0};
    for (double tau = low; within(tau, high, d); tau *= ratio) {
        struct spectrum_fit fit = fit_at(tau, guess, d);
        if (best.used == 0 || fit.misfit < best.misfit)
            best = fit;
        guess = fit.power;
    }
    return best;
}

enum scree_status spectrum_fit(const double *f, const double *power, size_t n, const double range[2], struct spectrum_fit *out,
                               struct scree_error *err)
{
    const struct fitted data = {f, power, range, n};
    size_t count = below(INFINITY, &data);
    double guess = 0;
    pthread_once(&table_once, make_table);
    for (size_t k = 0; k < n; k++)
        guess += usable(&data, k) ? log(power[k]) : 0;
    *out = (struct spectrum_fit){0};
    if (count < FIT_LEAST)
        return scree_fail(err, SCREE_INVALID, NULL,
                          "a fit of zeta needs at least %d frequencies with power between %.9g and %.9g Hz, and there are %zu",
                          FIT_LEAST, range[0], range[1], count);
    struct spectrum_fit fit = best_fit(FIT_LOW, FIT_HIGH, FIT_COARSE, exp(guess / (double)count), &data);
    if (fit.used == 0 || !within(fit.tau * FIT_COARSE, FIT_HIGH, &data)) // none, or the longest that was tried
        return scree_fail(err, SCREE_INVALID, NULL,
                          "no corner lies between %.9g and %.9g Hz: power falls from the lowest frequencies on", range[0],
                          range[1]);
    *out = best_fit(fit.tau / FIT_COARSE, fit.tau * FIT_COARSE, FIT_FINE, fit.power, &data);
    return SCREE_OK;
}
