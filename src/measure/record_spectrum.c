/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Spectra of the force on the base while it comes in: one for every window of
 * blocks (protocols 1.10), each component, corrected for what averaging over blocks takes.
 * The same comes out of the stored stream `basal_force` by spectrum.h. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/history.h"
#include "measure/spectrum.h"

static const struct scree_column columns[] = {{"f", "Hz"}, {"Px", "N2/Hz"}, {"Py", "N2/Hz"}, {"Pz", "N2/Hz"}};
enum { COLUMNS = 4 };
#define DOC "power of the force on the base, two-sided (the integral over both signs of f is the variance), "
static const struct scree_stream bands = {"spectrum", DOC "mean over bands; a frame a window", columns, COLUMNS, true};
static const struct scree_stream octaves = {"spectrum_octaves", DOC "mean over octaves; a frame a window", columns, COLUMNS, true};
static const struct scree_column mean_columns[] = {
    {"f", "Hz"}, {"Px", "N2/Hz"}, {"Py", "N2/Hz"}, {"Pz", "N2/Hz"}, {"Pz_fit", "N2/Hz"}};
enum { MEAN_COLUMNS = COLUMNS + 1 };
static const struct scree_stream means = {
    "spectrum_mean", DOC "mean over bands and the summary's windows; Pz_fit: P_F^0 zeta(f tau) as fitted, 0: no fit", mean_columns,
    MEAN_COLUMNS, true};
static const struct scree_stream *const streams[] = {&bands, &octaves, &means};
enum { BANDS, OCTAVES, MEANS, STREAMS };

enum { OCTAVES_MAX = 40, BANDS_MAX = 4096 };
enum { BLOCKS = HISTORY_BUFFERS, WORK, BUFFERS }; // blocks of the window, three components each; scratch
enum { WINDOWS, FORCE_Z, HEAD };                  // of the history: windows, their mean F_z, then bands

struct state {
    struct history history;
    struct series series[STREAMS];
    struct measure_buffer buffers[BUFFERS];
};

/* What the job makes of a window. */
struct shape {
    double dt;      // of a block, s
    size_t samples; // blocks a window
    size_t segments, bins, bands;
    double df, width; // Hz
};

static struct shape shape_of(const struct measure_context *context)
{
    const struct job_spec *job = context->job;
    double steps = fmax(1, round(job->record.basal_force.every_s / job->time.step_s)), dt = steps * job->time.step_s;
    struct shape s = {.dt = dt,
                      .samples = (size_t)fmin(1e9, round(job->record.spectrum.window_s / dt)),
                      .segments = (size_t)job->record.spectrum.segments};
    size_t length = spectrum_segment(s.samples, s.segments);
    s.bins = length / 2 + 1;
    s.df = length > 0 ? 1 / ((double)length * dt) : 1;
    s.width = fmax(fmax(job->record.spectrum.band_hz, s.df), 0.5 / dt / (BANDS_MAX - 1));
    s.bands = spectrum_band_count(s.bins, s.df, s.width);
    s.bands = s.bands < BANDS_MAX ? s.bands : BANDS_MAX;
    return s;
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    struct state *s = state;
    struct shape shape = shape_of(context);
    if (shape.samples < spectrum_samples_needed(shape.segments))
        return scree_fail(err, SCREE_INVALID, "record.spectrum.window_s",
                          "record.spectrum.window_s: a window holds %zu blocks of the force, and %zu segments need at least %zu",
                          shape.samples, shape.segments, spectrum_samples_needed(shape.segments));
    s->buffers[BLOCKS].most = 3 * shape.samples;
    return history_start(&s->history, s->buffers, HEAD + 3 * shape.bands, err);
}

/* Rows (f, Px, Py, Pz) of the window's bands and octaves, and what is kept of them. */
static enum scree_status transform(struct state *s, const struct shape *shape, double *work, double (*band)[COLUMNS],
                                   double (*octave)[COLUMNS], size_t *octave_count, struct scree_error *err)
{
    const double *blocks = s->buffers[BLOCKS].values;
    double *sums = history_sums(s->buffers), *power = work, *f = power + shape->bins, *value = f + BANDS_MAX;
    for (size_t a = 0; a < 3; a++) {
        enum scree_status status = spectrum_welch(blocks + a, shape->samples, 3, shape->dt, shape->segments, power, err);
        if (status)
            return status;
        for (size_t k = 0; k < shape->bins; k++)
            power[k] /= spectrum_block_gain((double)k * shape->df, shape->dt);
        size_t count = spectrum_bands(power, shape->bins, shape->df, shape->width, f, value, shape->bands);
        for (size_t k = 0; k < count; k++) {
            band[k][0] = f[k];
            band[k][1 + a] = value[k];
            sums[HEAD + 3 * k + a] += value[k];
        }
        *octave_count = spectrum_octaves(power, shape->bins, shape->df, f, value, OCTAVES_MAX);
        for (size_t k = 0; k < *octave_count; k++) {
            octave[k][0] = f[k];
            octave[k][1 + a] = value[k];
        }
    }
    sums[WINDOWS] += 1;
    for (size_t k = 0; k < shape->samples; k++)
        sums[FORCE_Z] += blocks[3 * k + 2] / (double)shape->samples;
    return SCREE_OK;
}

static enum scree_status put_window(struct state *s, const struct measure_context *context, struct scree_error *err)
{
    struct shape shape = shape_of(context);
    size_t rows = shape.bands + OCTAVES_MAX, octave_count = 0;
    double *work = measure_scratch(&s->buffers[WORK], (shape.bins + 2 * BANDS_MAX + COLUMNS * rows) * sizeof *work, err);
    if (!work)
        return SCREE_NO_MEMORY;
    double(*band)[COLUMNS] = (double(*)[COLUMNS])(void *)(work + shape.bins + 2 * BANDS_MAX),
    (*octave)[COLUMNS] = band + shape.bands;
    enum scree_status status = transform(s, &shape, work, band, octave, &octave_count, err);
    s->buffers[BLOCKS].count = 0;
    if (status || (status = history_keep(&s->history, s->buffers, context->time_s, err)) ||
        (status = series_put_frame(&s->series[BANDS], context->sink, context->time_s, band[0], shape.bands, err)))
        return status;
    return series_put_frame(&s->series[OCTAVES], context->sink, context->time_s, octave[0], octave_count, err);
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    struct measure_buffer *blocks = &s->buffers[BLOCKS];
    size_t at = blocks->count;
    enum scree_status status = measure_buffer_resize(blocks, at + 3, err);
    if (status)
        return status;
    for (size_t a = 0; a < 3; a++)
        blocks->values[at + a] = now->base_force[a];
    return blocks->count == blocks->most ? put_window(s, context, err) : SCREE_OK;
}

/* Mean over the summary's windows: rows of bands, the mean force; returns how many windows. */
static double mean_of(const struct state *s, const struct measure_context *context, double *sums, double (*band)[COLUMNS])
{
    struct shape shape = shape_of(context);
    history_since(&s->history, s->buffers, measure_window_from(context), sums);
    for (size_t k = 0; k < shape.bands; k++) {
        band[k][0] = spectrum_band_middle(k, shape.bins, shape.df, shape.width);
        for (size_t a = 0; a < 3; a++)
            band[k][1 + a] = sums[WINDOWS] > 0 ? sums[HEAD + 3 * k + a] / sums[WINDOWS] : 0;
    }
    return sums[WINDOWS];
}

/* Of F_z. False where it cannot be fitted. */
static bool fit_of(const struct measure_context *context, double (*band)[COLUMNS], size_t count, struct spectrum_fit *fit)
{
    const double range[2] = {context->job->record.spectrum.fit_from_hz, context->job->record.spectrum.fit_to_hz};
    double *f = memory_rows(2 * count, sizeof *f), *power = f + count;
    *fit = (struct spectrum_fit){0};
    if (!f)
        return false;
    for (size_t k = 0; k < count; k++) {
        f[k] = band[k][0];
        power[k] = band[k][3];
    }
    bool fitted = !spectrum_fit(f, power, count, range, fit, NULL);
    free(f);
    return fitted;
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct state *s = state;
    struct shape shape = shape_of(context);
    struct spectrum_fit fit;
    double *sums = memory_rows(s->history.width, sizeof *sums);
    double(*band)[COLUMNS] = memory_rows(shape.bands, sizeof *band), (*row)[MEAN_COLUMNS] = memory_rows(shape.bands, sizeof *row);
    enum scree_status status = SCREE_OK;
    (void)now;
    if (!sums || !band || !row) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a spectrum");
    } else if (mean_of(s, context, sums, band) > 0) {
        bool fitted = fit_of(context, band, shape.bands, &fit);
        for (size_t k = 0; k < shape.bands; k++) {
            memcpy(row[k], band[k], sizeof band[k]);
            row[k][COLUMNS] = fitted ? fit.power * zeta(row[k][0] * fit.tau) : 0;
        }
        status = series_put_frame(&s->series[MEANS], context->sink, context->time_s, row[0], shape.bands, err);
    }
    free(sums);
    free(band);
    free(row);
    return status;
}

static size_t write_numbers(const struct measure_context *context, double windows, double force, double (*band)[COLUMNS],
                            size_t bands_count, struct scree_number *out, size_t room)
{
    struct spectrum_fit fit;
    bool fitted = fit_of(context, band, bands_count, &fit);
    double d = context->site.diameter, area = context->site.area_z;
    /* High-frequency variance, the fit's over both signs of f, over the squared mean force; made intensive by A / d^2
     * (protocols 1.10). */
    double variance = fitted ? 2 * ZETA_INTEGRAL * fit.power / fit.tau : 0;
    const struct scree_number all[] = {
        {"spectrum_windows", "1", "windows that the spectrum is the mean of", windows},
        {"spectrum_power", "N2/Hz", "P_F^0 of F_z, fitted with an impact's spectrum over the job's range; 0: no fit", fit.power},
        {"spectrum_corner", "Hz", "corner frequency f_c / tau of that fit; 0: no fit", fitted ? ZETA_CORNER / fit.tau : 0},
        {"spectrum_tau", "s", "time scale tau of that fit", fit.tau},
        {"spectrum_misfit", "1", "root mean square of ln P about that fit", fit.misfit},
        {"force_fluctuation", "1", "dF^2: high-frequency variance of F_z over its squared mean, times area over d^2",
         force != 0 && area > 0 ? area / (d * d) * variance / (force * force) : 0},
    };
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    struct shape shape = shape_of(context);
    double *sums = memory_rows(s->history.width, sizeof *sums), windows;
    double(*band)[COLUMNS] = memory_rows(shape.bands, sizeof *band);
    size_t count = 0;
    (void)now;
    if (sums && band) {
        windows = mean_of(s, context, sums, band);
        const struct scree_number none = {"spectrum_windows", "1", "0: the run ended before record.spectrum.window_s was over", 0};
        count = windows > 0 ? write_numbers(context, windows, sums[FORCE_Z] / windows, band, shape.bands, out, room)
                            : measure_numbers(out, room, &none, 1);
    }
    free(sums);
    free(band);
    return count;
}

static bool sound(const void *state, const struct measure_context *context)
{
    const struct state *s = state;
    const struct measure_buffer *blocks = &s->buffers[BLOCKS];
    return history_sound(&s->history, s->buffers, HEAD + 3 * shape_of(context).bands) && blocks->count % 3 == 0 &&
           blocks->count < blocks->most;
}

const struct measurement measure_spectrum = {
    .name = "spectrum",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_BASE_FORCE,
    .every_of = "basal_force",
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = STREAMS,
    .buffers = offsetof(struct state, buffers),
    .buffer_count = BUFFERS,
    .start = start,
    .sample = sample,
    .close = close,
    .numbers = numbers,
    .sound = sound,
};
