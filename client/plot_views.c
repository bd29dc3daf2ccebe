/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_views.h. Pixels are drawn as squares of their size: hue tells how fast a
 * body is, shade how deep it lies, since bodies at rest would else be one blot. */
#include "plot_views.h"

#include <math.h>

#include "output.h"
#include "plot_read.h"

enum { ASIDE, ABOVE };
static const char *const streams[PLOT_VIEWS_CAMERAS] = {"view_aside", "view_above"};

/* When a collapse begins and how long it takes: gate, or hole, and tau_c = sqrt(H_0 / g); NaN where there is none. */
struct scales {
    double from_s, tau_s, speed; // sqrt(g H_0), m/s
    double width, gate_x;        // m
    bool gate;
};

static struct scales scales_of(const cJSON *record)
{
    const cJSON *params = json_get(json_get(record, "spec"), "params");
    double gravity = json_number(params, "gravity_m_s2", NAN), height = plot_number_of(record, "column_height");
    bool gate = json_get(params, "column_m") != NULL;
    return (struct scales){.from_s = json_number(params, "settle_s", NAN),
                           .tau_s = gate ? sqrt(height / gravity) : NAN,
                           .speed = gate ? sqrt(height * gravity) : NAN,
                           .width = json_number(params, "width_m", json_number(params, "floor_m", NAN)),
                           .gate_x = json_number(params, "column_m", NAN),
                           .gate = gate};
}

/* ---- reading ---- */

size_t plot_views_rows(const cJSON *record)
{
    uint64_t frames = plot_chunks_of(record, streams[ASIDE]), above = plot_chunks_of(record, streams[ABOVE]);
    frames = above < frames ? above : frames;
    return frames < PLOT_VIEWS_ROWS ? (size_t)frames : PLOT_VIEWS_ROWS;
}

static void take_time(void *context, const struct reader_chunk *chunk)
{
    *(double *)context = chunk->t0_s;
}

/* One frame, and where it goes. */
struct taking {
    struct plot_views *views;
    int camera;
    size_t row;
};

static void take(void *context, const struct reader_chunk *chunk)
{
    const struct taking *t = context;
    struct plot_views *v = t->views;
    int x = reader_column(chunk, "x"), speed = reader_column(chunk, "speed");
    int up = reader_column(chunk, t->camera == ASIDE ? "z" : "y"), depth = reader_column(chunk, t->camera == ASIDE ? "y" : "z");
    if (x < 0 || up < 0 || depth < 0 || speed < 0)
        return;
    v->time[t->row] = chunk->t0_s;
    fprintf(v->script, "$view%d_%zu << EOD\n", t->camera, t->row);
    for (size_t r = 0; r < chunk->rows; r++) {
        const double *row = chunk->values + r * chunk->columns, *before = row - chunk->columns;
        double away = t->camera == ASIDE ? row[depth] : -row[depth];
        fprintf(v->script, "%.6g %.6g %.6g %.6g\n", 100 * row[x], 100 * row[up], away, row[speed]);
        v->far = fmax(v->far, row[x]);
        v->fast = fmax(v->fast, row[speed]);
        v->high = t->camera == ASIDE ? fmax(v->high, row[up]) : v->high;
        v->nearest[t->camera] = fmin(v->nearest[t->camera], away);
        v->farthest[t->camera] = fmax(v->farthest[t->camera], away);
        if (r > 0 && row[up] > before[up])
            v->pixel[t->camera] = fmin(v->pixel[t->camera], row[up] - before[up]);
    }
    fprintf(v->script, "EOD\n");
}

/* When frames are of: every `every_s` from first_s on, but the last one, which is of the end. */
struct span {
    uint64_t frames;
    double first_s, every_s, last_s;
};

static enum outcome read_span(struct link *link, const cJSON *record, struct span *out, struct scree_error *err)
{
    const char *stream = streams[ASIDE];
    const uint64_t n = out->frames = plot_chunks_of(record, stream);
    double before_s = 0;
    enum outcome outcome = plot_read_chunk(link, record, stream, 0, take_time, &out->first_s, err);
    if (!outcome && n > 2)
        outcome = plot_read_chunk(link, record, stream, n - 2, take_time, &before_s, err);
    if (!outcome)
        outcome = plot_read_chunk(link, record, stream, n - 1, take_time, &out->last_s, err);
    out->every_s = n > 2 ? (before_s - out->first_s) / (double)(n - 2) : 1;
    return outcome;
}

/* Frames at the gate, 1, 2 and 4 tau_c after it, and the last; or spread evenly over what there is. */
static void choose(const struct scales *s, const struct span *span, size_t rows, uint64_t out[PLOT_VIEWS_ROWS])
{
    static const double steps[PLOT_VIEWS_ROWS] = {0, 1, 2, 4, INFINITY};
    const double from_s = s->from_s >= span->first_s && s->from_s < span->last_s ? s->from_s : span->first_s;
    const bool scaled = rows == PLOT_VIEWS_ROWS && from_s == s->from_s && from_s + 4 * s->tau_s < span->last_s;
    for (size_t k = 0; k < rows; k++) {
        double time = from_s + (scaled ? steps[k] * s->tau_s : (span->last_s - from_s) * (double)k / fmax(1, (double)rows - 1));
        double at = fmin((time - span->first_s) / span->every_s, (double)span->frames);
        uint64_t frame = (uint64_t)(k == 0 ? floor(at + 1e-6) : round(at)); // the gate still stands in the first
        uint64_t least = k > 0 ? out[k - 1] + 1 : 0, most = span->frames - (rows - k);
        frame = frame < least ? least : frame;
        out[k] = frame < most ? frame : most;
    }
}

enum outcome plot_views_read(struct link *link, const cJSON *record, struct plot_views *v, struct scree_error *err)
{
    const struct scales scales = scales_of(record);
    struct span span;
    uint64_t frame[PLOT_VIEWS_ROWS];
    v->rows = plot_views_rows(record);
    for (int c = 0; c < PLOT_VIEWS_CAMERAS; c++) {
        v->pixel[c] = v->nearest[c] = INFINITY;
        v->farthest[c] = -INFINITY;
    }
    if (v->rows == 0)
        return OUTCOME_DONE;
    enum outcome outcome = read_span(link, record, &span, err);
    if (!outcome)
        choose(&scales, &span, v->rows, frame);
    for (size_t k = 0; k < v->rows; k++)
        for (int c = 0; c < PLOT_VIEWS_CAMERAS && !outcome; c++) {
            struct taking taking = {v, c, k};
            outcome = plot_read_chunk(link, record, streams[c], frame[k], take, &taking, err);
        }
    return outcome;
}

/* ---- drawing ---- */

enum { TITLE_MAX = 80 };

/* The speed that is drawn in red: of a fall from H_0 / 2, or the fastest. */
static double fast_of(const struct plot_views *v, const struct scales *s)
{
    return isfinite(s->speed) ? s->speed : fmax(v->fast, 1e-9);
}

/* A value of the summary with its bounds, as lines across a panel, and what the panel's title says of it; lengths in cm. */
static void mark(FILE *script, const cJSON *record, const char *name, const char *least, const char *most, bool upright,
                 char title[TITLE_MAX])
{
    const double value[] = {100 * plot_number_of(record, name), 100 * plot_number_of(record, least),
                            100 * plot_number_of(record, most)};
    *title = '\0';
    if (!isfinite(value[0]))
        return;
    for (int k = 0; k < 3; k++)
        fprintf(script,
                upright ? "set arrow from first %.6g, graph 0 to first %.6g, graph 1 nohead front lw 1.5 dt %d lc rgb '#000000'\n"
                        : "set arrow from graph 0, first %.6g to graph 1, first %.6g nohead front lw 1.5 dt %d lc rgb '#000000'\n",
                value[k], value[k], k ? 3 : 1);
    snprintf(title, TITLE_MAX, "%s %.3g cm (%.3g to %.3g)", upright ? "L" : "H", value[0], value[1], value[2]);
}

static void title_aside(const struct plot_views *v, const struct scales *s, size_t row, const char *marked)
{
    double after = v->time[row] - s->from_s;
    after = fabs(after) < 1e-9 ? 0 : after; // rounded
    if (s->gate)
        fprintf(v->script, "set title '%.3g s %s the gate", fabs(after), after < 0 ? "before" : "after");
    else
        fprintf(v->script, "set title '%.3g s", v->time[row]);
    if (isfinite(s->tau_s))
        fprintf(v->script, ", %.2g sqrt(H0 / g)", fabs(after) / s->tau_s);
    if (*marked) // on a line of its own: both are wider than the panel
        fprintf(v->script, "'.\"\\n\".'%s", marked);
    fprintf(v->script, "'\n");
}

static void title_above(const struct plot_views *v, const struct scales *s, size_t row, const char *marked)
{
    if (row == 0)
        fprintf(v->script, "set title 'hue: speed, blue 0 to red %.2g m/s; shade: depth'\n", fast_of(v, s));
    else
        fprintf(v->script, "set title '%s'\n", marked);
}

static void draw_pixels(const struct plot_views *v, const struct scales *s, size_t row, int camera)
{
    const double fast = fast_of(v, s), half = 60 * v->pixel[camera]; // cm; they overlap, else seams show
    const double depth = fmax(v->farthest[camera] - v->nearest[camera], 1e-9);
    fprintf(v->script,
            "plot $view%d_%zu using 1:2:(%.6g):(%.6g):(hsv2rgb(0.62*(1-($4<%.6g?$4/%.6g:1)),0.85,1-0.65*($3-(%.6g))/%.6g)) with "
            "boxxyerror fs solid 1 noborder lc rgb variable notitle\nunset arrow\n",
            camera, row, half, half, fast, fast, v->nearest[camera], depth);
}

void plot_views_draw(const struct plot_views *v, const cJSON *record, size_t row, double low, double high)
{
    const struct scales scales = scales_of(record), *s = &scales;
    const bool measured = row + 1 == v->rows && s->gate;
    char marked[TITLE_MAX] = "";
    fprintf(v->script, "unset key\nunset grid\nset size ratio -1\nset xrange [0:%.6g] noextend\nset xlabel 'x (cm)'\n",
            102 * v->far);
    for (int c = 0; c < PLOT_VIEWS_CAMERAS; c++) {
        fprintf(v->script, "set origin 0,%.6g\nset size 1,%.6g\nset lmargin at screen %.3g\nset rmargin at screen %.3g\n", low,
                high, c ? 0.57 : 0.07, c ? 0.98 : 0.48);
        fprintf(v->script, "set ylabel '%s (cm)'\nset yrange [0:%.6g]\n", c == ASIDE ? "z" : "y",
                100 * (c == ASIDE ? 1.1 * v->high : s->width));
        if (s->gate)
            fprintf(v->script, "set arrow from first %.6g, graph 0 to first %.6g, graph 1 nohead back lc rgb '#999999'\n",
                    100 * s->gate_x, 100 * s->gate_x);
        if (measured && c == ABOVE)
            mark(v->script, record, "runout", "runout_least", "runout_most", true, marked);
        if (measured && c == ASIDE)
            mark(v->script, record, "pile_height", "pile_height_low", "pile_height_high", false, marked);
        (c == ASIDE ? title_aside : title_above)(v, s, row, marked);
        draw_pixels(v, s, row, c);
    }
    fprintf(v->script, "unset title\nset size noratio\nset grid\nset xrange [*:*] extend\nset yrange [*:*]\nset key default\n"
                       "unset lmargin\nunset rmargin\n");
}
