/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A job's force, spectrum, profiles, surface and collapse; see plot.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calibrate/digits.h"
#include "output.h"
#include "plot.h"
#include "plot_chute.h"
#include "plot_force.h"
#include "plot_heap.h"
#include "plot_profiles.h"
#include "plot_read.h"
#include "plot_surface.h"
#include "plot_views.h"

#define FORCE    "basal_force"
#define HEAP     "heap"
#define PROFILES "profiles"
#define SPECTRUM "spectrum" // or its mean, once the job has ended
#define SURFACE  "surface"

enum { WIDTH = 1000, HEIGHT = 340, COMPONENTS = PLOT_FORCE_COMPONENTS };

/* ---- the force ---- */

static const char *const names[COMPONENTS] = {"Fx, downslope", "Fy, cross-slope", "Fz, normal"};
static const char *const colours[COMPONENTS] = {"#0072b2", "#009e73", "#d55e00"};

/* Means over the bins: what carries the weight of the flow. */
static void draw_means(struct picture *p, const cJSON *record, const struct plot_force *t)
{
    char bin[TEXT_MAX];
    double weight = plot_number_of(record, "weight_normal");
    fprintf(p->script, "set xlabel 'time (s), means over %s s'\nset ylabel 'force on the base (N)'\n",
            text_number(digits_round((t->end - t->begin) / PLOT_FORCE_BINS, 2), bin));
    fprintf(p->script,
            "set lmargin at screen 0.09\nset rmargin at screen 0.8\nset xrange [%.9g:%.9g]\nset key outside right top reverse Left "
            "samplen 2\nplot ",
            t->begin, t->end);
    for (int c = COMPONENTS; c-- > 0;)
        fprintf(p->script, "$force using 1:%d with lines lw 1.2 lc rgb '%s' title '%s', ", 2 + 3 * c, colours[c], names[c]);
    if (isfinite(weight))
        fprintf(p->script, "%.9g with lines dt 2 lw 1.5 lc rgb '#000000' title 'weight, normal', ", -weight);
    fprintf(p->script, "NaN notitle\n");
}

/* The largest and the least sample of each bin: the blows. */
static void draw_extremes(struct picture *p)
{
    fprintf(p->script, "set xlabel 'time (s)'\nset ylabel 'largest and least (N)'\nplot ");
    for (int c = COMPONENTS; c-- > 0;)
        fprintf(p->script, "$force using 1:%d:%d with filledcurves fc rgb '%s' fs transparent solid 0.45 noborder title '%s', ",
                3 + 3 * c, 4 + 3 * c, colours[c], names[c]);
    fprintf(p->script, "NaN notitle\nset xrange [*:*]\n");
}

/* ---- the spectrum ---- */

struct spectrum {
    FILE *script;
    int frequency; // column
    size_t columns;
    char names[8][64];
    double least; // power
    size_t rows;
};

/* The last frame of the stream: the frequency is the column in Hz, densities are the others. */
static void take_spectrum(void *context, const struct reader_chunk *chunk)
{
    struct spectrum *s = context;
    s->frequency = -1;
    s->columns = chunk->columns < 8 ? chunk->columns : 8;
    for (size_t c = 0; c < s->columns; c++) {
        const char *unit = cJSON_GetStringValue(cJSON_GetArrayItem(chunk->units, (int)c));
        const char *name = cJSON_GetStringValue(cJSON_GetArrayItem(chunk->column_names, (int)c));
        if (unit && strcmp(unit, "Hz") == 0 && s->frequency < 0)
            s->frequency = (int)c;
        snprintf(s->names[c], sizeof s->names[c], "%.30s (%.30s)", name ? name : "?", unit ? unit : "");
    }
    if (s->frequency < 0)
        return;
    fprintf(s->script, "$spectrum << EOD\n");
    for (size_t r = 0; r < chunk->rows; r++) {
        const double *row = chunk->values + r * chunk->columns;
        if (!(row[s->frequency] > 0))
            continue; // the axis is logarithmic
        for (size_t c = 0; c < s->columns; c++)
            fprintf(s->script, row[c] > 0 ? " %.9g" : " ?", row[c]);
        for (size_t c = 1; c < s->columns && c <= COMPONENTS; c++)
            if (row[c] > 0 && (!(s->least > 0) || row[c] < s->least))
                s->least = row[c];
        putc('\n', s->script);
        s->rows++;
    }
    fprintf(s->script, "EOD\n");
}

/* The fit, where there is one, in black, its corner marked. */
static void draw_spectrum(struct picture *p, const cJSON *record, const struct spectrum *s)
{
    double corner = plot_number_of(record, "spectrum_corner"), power = plot_number_of(record, "spectrum_power");
    bool fitted = corner > 0 && power > 0;
    fprintf(p->script, "set logscale xy\nset format xy '%%.0e'\nset xlabel 'frequency (Hz)'\nset ylabel 'power, two-sided "
                       "(N2/Hz)'\n");
    fprintf(p->script, "set xrange [*:*] noextend\nset yrange [%.3g:*]\n", 0.3 * s->least);
    if (fitted)
        fprintf(p->script,
                "set arrow 1 from %.9g, graph 0 to %.9g, graph 1 nohead dt 3 lw 1.5 lc rgb '#444444'\n"
                "set label 1 'corner %.3g kHz, P0 %.3g N2/Hz' at %.9g, graph 0.06 right offset -1,0 tc rgb '#444444'\n",
                corner, corner, corner / 1e3, power, corner);
    fprintf(p->script, "plot ");
    for (size_t c = 0; c < s->columns; c++) {
        bool fit = c > COMPONENTS;
        if ((int)c == s->frequency || (fit && !fitted))
            continue;
        fprintf(p->script, "$spectrum using %d:%zu with lines lw %s lc rgb '%s' title ", s->frequency + 1, c + 1,
                fit ? "2 dt 2" : "1.2", fit || c == 0 ? "#000000" : colours[c - 1]);
        picture_quote(p, s->names[c]);
        fprintf(p->script, ", ");
    }
    fprintf(
        p->script,
        "NaN notitle\nunset arrow\nunset label\nunset logscale\nset format xy '%%g'\nset xrange [*:*] extend\nset yrange [*:*]\n");
}

/* The newest frame of what there is: means, once the job has ended; a running job's last window until then. */
static enum outcome read_newest(struct link *link, const cJSON *record, const char *means, const char *windows,
                                void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err)
{
    const char *stream = plot_chunks_of(record, means) > 0 ? means : windows;
    uint64_t last = plot_chunks_of(record, stream);
    return last > 0 ? plot_read_chunk(link, record, stream, last - 1, take, context, err) : OUTCOME_DONE;
}

/* A continuum has no collisions, hence no blows to show. */
static bool has_blows(const cJSON *record)
{
    return plot_chunks_of(record, SURFACE) == 0;
}

/* What there is of a flow down a chute: four snapshots spread over it, layers as of a third of it. */
static enum outcome read_chute(struct link *link, const cJSON *record, struct plot_chute *plot, struct scree_error *err)
{
    uint64_t snapshots = plot_chunks_of(record, "snapshots"), layers = plot_chunks_of(record, "layers");
    enum outcome outcome = plot_read_stream(link, record, "walls", plot_chute_take_walls, plot, err);
    for (uint64_t k = 0; k < PLOT_CHUTE_FRAMES && snapshots > 0 && !outcome; k++) {
        static const int percent[PLOT_CHUTE_FRAMES] = {10, 22, 38, 100};
        uint64_t at = (snapshots - 1) * (uint64_t)percent[k] / 100;
        outcome = plot_read_chunk(link, record, "snapshots", at, plot_chute_take_snapshot, plot, err);
    }
    if (!outcome)
        outcome = plot_read_stream(link, record, "fragments", plot_chute_take_bodies, plot, err);
    if (!outcome)
        outcome = plot_read_stream(link, record, "flow", plot_chute_take_flow, plot, err);
    if (!outcome && layers > 0)
        outcome = plot_read_chunk(link, record, "layers", layers / 3, plot_chute_take_layers, plot, err);
    return outcome;
}

static int rows_of(const cJSON *record)
{
    bool force = plot_chunks_of(record, FORCE) > 0;
    return (plot_chunks_of(record, "walls") > 0 ? PLOT_CHUTE_ROWS : 0) + force + (force && has_blows(record)) +
           (plot_chunks_of(record, SPECTRUM) > 0) + (plot_chunks_of(record, PROFILES) > 0) + (plot_chunks_of(record, SURFACE) > 0) +
           (plot_chunks_of(record, HEAP) > 0) + (int)plot_views_rows(record);
}

/* Where the next plot goes: a row of `rows`, from the top, under the title. */
static void place_row(struct picture *p, int row, int rows)
{
    double high = 0.95 / rows;
    fprintf(p->script, "set origin 0,%.6g\nset size 1,%.6g\n", 0.95 - (row + 1) * high, high);
}

static enum outcome write_script(struct link *link, const cJSON *record, struct picture *p, struct plot_force *t,
                                 struct scree_error *err)
{
    const char *id = json_text(record, "id"), *title = json_text(record, "title"), *state = json_text(record, "state");
    struct spectrum spectrum = {.script = p->script, .frequency = -1};
    struct plot_profiles profiles = {.script = p->script};
    struct plot_chute chute = {.script = p->script};
    struct plot_surface surface = {.script = p->script};
    struct plot_heap heap = {.script = p->script};
    struct plot_views views = {.script = p->script};
    int row = 0, rows = rows_of(record);
    char heading[200];
    enum outcome outcome = plot_read_stream(link, record, FORCE, plot_force_take, t, err);
    if (!outcome)
        outcome = read_newest(link, record, SPECTRUM "_mean", SPECTRUM, take_spectrum, &spectrum, err);
    if (!outcome)
        outcome = read_newest(link, record, PROFILES "_mean", PROFILES, plot_profiles_take, &profiles, err);
    if (!outcome)
        outcome = read_chute(link, record, &chute, err);
    if (!outcome)
        outcome = plot_read_stream(link, record, SURFACE, plot_surface_take, &surface, err);
    if (!outcome)
        outcome = plot_read_stream(link, record, HEAP, plot_heap_take, &heap, err);
    plot_heap_end(&heap);
    if (!outcome)
        outcome = plot_views_read(link, record, &views, err);
    if (outcome)
        return outcome;
    snprintf(heading, sizeof heading, "%.20s  %.60s  %.20s  %.20s", id, json_text(record, "scenario"), state,
             json_text(record, "verdict"));
    plot_force_write(p, "$force", t);
    fprintf(p->script, "set multiplot ");
    picture_title(p, "title", heading, title);
    for (int k = 0; chute.walls > 0 && k < PLOT_CHUTE_ROWS; k++, row++)
        plot_chute_draw(&chute, k, 0.95 - 0.95 * (row + 1) / rows, 0.95 / rows);
    for (size_t k = 0; k < views.rows; k++, row++)
        plot_views_draw(&views, record, k, 0.95 - 0.95 * (row + 1) / rows, 0.95 / rows);
    if (plot_chunks_of(record, FORCE) > 0) {
        place_row(p, row++, rows);
        draw_means(p, record, t);
        if (has_blows(record)) {
            place_row(p, row++, rows);
            draw_extremes(p);
        }
    }
    if (surface.frames > 0) {
        const cJSON *wait = json_get(json_get(json_get(record, "spec"), "params"), "gate_wait_s");
        place_row(p, row++, rows);
        plot_surface_draw(p, &surface, cJSON_IsNumber(wait) ? wait->valuedouble : 0);
    }
    place_row(p, row, rows);
    if (spectrum.rows > 0) {
        draw_spectrum(p, record, &spectrum);
        row++;
    }
    if (profiles.rows > 0) {
        plot_profiles_draw(&profiles, 0.95 - 0.95 * (row + 1) / rows, 0.95 / rows);
        row++;
    }
    if (heap.rows > 0)
        plot_heap_draw(&heap, record, 0.95 - 0.95 * (row + 1) / rows, 0.95 / rows);
    fprintf(p->script, "unset multiplot\n");
    return OUTCOME_DONE;
}

enum outcome plot_job(struct link *link, const cJSON *record, const char *file, struct scree_error *err)
{
    const char *id = json_text(record, "id");
    struct picture picture;
    if (rows_of(record) == 0) {
        outcome_fail(err, OUTCOME_REFUSED, "%.20s has no force on a base to draw", id ? id : "the job");
        scree_hint(err, "record.basal_force must be on, and its first chunk be there");
        return OUTCOME_REFUSED;
    }
    struct plot_force *trace = calloc(1, sizeof *trace);
    if (!trace)
        return outcome_fail(err, OUTCOME_FAILED, "no memory for a picture");
    trace->end = json_number(record, "time_s", 0);
    enum outcome outcome = picture_start(&picture, file, WIDTH, rows_of(record) * HEIGHT, err);
    if (!outcome && !(outcome = write_script(link, record, &picture, trace, err)))
        outcome = picture_draw(&picture, err);
    picture_free(&picture);
    free(trace);
    return outcome;
}
