/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bodies that rest, collapse and rest again (seed 001, IV): how fast they are on the
 * way, the network of contacts just before the gate goes, and what kind of collapse
 * it was. A world without a gate is looked at at its end.
 *
 * The paper tells kinds of collapse by eye; the rules here are ours. `stable`: the
 * centre of mass has come less than 5 % of its first distance from the back wall.
 * `staggered`: the mean speed stayed below a quarter of its peak for two tau_c =
 * sqrt(H_0 / g) and then exceeded half of it. Else `buckling` when, by the time that
 * the upper or the middle fifth of the column has come forward by a tenth of L_0, the
 * middle is ahead, and `top_driven` when the top is. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "measure/measure.h"
#include "measure/packing.h"
#include "measure/pile.h"

enum heap_regime { HEAP_STABLE, HEAP_TOP_DRIVEN, HEAP_BUCKLING, HEAP_STAGGERED };

#define STABLE  0.05
#define LEADS   0.1
#define HALTED  0.25
#define AGAIN   0.5
#define HALT_TC 2.0
enum { PIXELS = 20 }; // a diameter of the sphere of a body's volume, as pile.c

static const struct scree_column heap_columns[] = {
    {"time", "s"},     {"mean_speed", "m/s"}, {"speed_ratio", "1"}, {"centre_x", "m"},
    {"centre_z", "m"}, {"core_top", "m"},     {"top_x", "m"},       {"middle_x", "m"},
};
enum { COLUMNS = sizeof heap_columns / sizeof *heap_columns };
static const struct scree_column pdf_columns[] = {{"ratio", "1"}, {"density", "1"}};
static const struct scree_column fabric_columns[] = {{"angle", "deg"}, {"share", "1"}};
static const struct scree_column region_columns[] = {
    {"bodies", "1"}, {"contacts", "1"}, {"ground", "1"}, {"sides", "1"}, {"gate", "1"}};
static const struct scree_stream heap_stream = {"heap",
                                                "mean speed of the bodies, and over sqrt(g H_0), 0 before the gate goes; centre of "
                                                "mass; highest centre in the rear half of the "
                                                "column; how far forward its upper and middle fifths have come",
                                                heap_columns, COLUMNS, false};
static const struct scree_stream pdf_stream = {
    "force_pdf", "contact forces between bodies over their mean, middle of a bin, when the gate goes", pdf_columns, 2, true};
static const struct scree_stream fabric_stream = {
    "fabric", "angles of lines between centres of touching bodies with x, seen along y, when the gate goes", fabric_columns, 2,
    true};
static const struct scree_stream region_stream = {
    "regions", "points of contact when the gate goes: in all, in the half by the gate, in the upper half of that", region_columns,
    5, true};
static const struct scree_stream *const streams[] = {&heap_stream, &pdf_stream, &fabric_stream, &region_stream};
enum { HEAP, PDF, FABRIC, REGIONS, STREAMS };

struct state {
    struct packing packing;
    double went;           // 1: the gate has gone, the rest holds
    double height, centre; // H_0; of mass, from the back wall, m
    double top, middle;    // when they were first told apart: how far the upper and the middle fifth had come, m
    double told;           // 1: they are
    double peak, halted_s; // of the mean speed over sqrt(g H_0); time below a quarter of it
    double staggered;      // 1: it came to a halt and went on
    double now_centre;     // newest
    struct series series[STREAMS];
    struct measure_buffer start; // x, z of every body when the gate went
};

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    struct state *s = state;
    (void)context;
    (void)err;
    s->start.most = (size_t)2 * SPEC_GRAINS_MAX;
    return SCREE_OK;
}

static double column_length(const struct measure_context *context)
{
    return context->site.gate ? context->site.gate_x : context->site.length_x;
}

/* The column as it stands. */
static enum scree_status look_at_column(struct state *s, const struct measure_context *context, const struct view *view,
                                        struct scree_error *err)
{
    const struct measure_site *site = &context->site;
    struct pile pile;
    enum scree_status status = pile_measure(view, site->length_x, site->width_y, 0, site->diameter / PIXELS, &pile, err);
    if (status || (status = measure_buffer_resize(&s->start, 2 * view->bodies, err)))
        return status;
    s->height = pile.height;
    s->centre = s->now_centre = pile.centre[0];
    packing_measure(view, column_length(context), pile.height, &s->packing);
    for (size_t k = 0; k < view->bodies; k++) {
        s->start.values[2 * k] = view->body[k].position[0];
        s->start.values[2 * k + 1] = view->body[k].position[2];
    }
    s->went = 1;
    return SCREE_OK;
}

/* How far bodies that started between two heights have come forward, mean. */
static double forward(const struct state *s, const struct view *view, double from, double to)
{
    double sum = 0, count = 0;
    for (size_t k = 0; k < view->bodies; k++)
        if (s->start.values[2 * k + 1] >= from && s->start.values[2 * k + 1] < to) {
            sum += view->body[k].position[0] - s->start.values[2 * k];
            count++;
        }
    return count > 0 ? sum / count : 0;
}

static void follow(struct state *s, const struct measure_context *context, const double row[COLUMNS], double interval_s)
{
    const double speed = row[2], top = row[6], middle = row[7];
    double g = fabs(context->gravity[2]);
    if (s->told == 0 && fmax(top, middle) > LEADS * column_length(context)) {
        s->told = 1;
        s->top = top;
        s->middle = middle;
    }
    if (s->peak > 0.05 && speed > AGAIN * s->peak && s->halted_s > HALT_TC * sqrt(s->height / g))
        s->staggered = 1;
    s->peak = fmax(s->peak, speed);
    s->halted_s = speed < HALTED * s->peak ? s->halted_s + interval_s : 0;
    s->now_centre = row[3];
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    const struct view *view = now->grains;
    const struct measure_site *site = &context->site;
    double row[COLUMNS] = {context->time_s}, mass = 0, interval_s = (double)now->every * view->step_s;
    enum scree_status status = SCREE_OK;
    if (site->gate && s->went == 0 && context->time_s + interval_s * (1 + 1e-9) > site->gate_s)
        status = look_at_column(s, context, view, err);
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        mass += b->mass;
        row[1] += sqrt(vec3_square(b->velocity)) / (double)view->bodies;
        row[3] += b->mass * b->position[0];
        row[4] += b->mass * b->position[2];
        if (b->position[0] < 0.5 * column_length(context))
            row[5] = fmax(row[5], b->position[2]);
    }
    row[3] /= mass;
    row[4] /= mass;
    if (!status && s->went > 0 && site->gate) {
        row[2] = row[1] / sqrt(fabs(context->gravity[2]) * s->height);
        row[6] = forward(s, view, 0.8 * s->height, INFINITY);
        row[7] = forward(s, view, 0.4 * s->height, 0.6 * s->height);
        follow(s, context, row, interval_s);
    }
    return status ? status : series_add(&s->series[HEAP], context->sink, context->time_s, row, err);
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct state *s = state;
    double pdf[FORCE_BINS][2], fabric[FABRIC_BINS][2];
    enum scree_status status = s->went > 0 ? SCREE_OK : look_at_column(s, context, now->grains, err);
    for (int k = 0; k < FORCE_BINS; k++) {
        pdf[k][0] = (k + 0.5) * FORCE_BIN;
        pdf[k][1] = s->packing.force_pdf[k];
    }
    for (int k = 0; k < FABRIC_BINS; k++) {
        fabric[k][0] = (k + 0.5) * 180.0 / FABRIC_BINS;
        fabric[k][1] = s->packing.fabric[k];
    }
    if (status || (status = series_put_frame(&s->series[PDF], context->sink, context->time_s, pdf[0], FORCE_BINS, err)) ||
        (status = series_put_frame(&s->series[FABRIC], context->sink, context->time_s, fabric[0], FABRIC_BINS, err)))
        return status;
    return series_put_frame(&s->series[REGIONS], context->sink, context->time_s, &s->packing.region[0].bodies, PACKING_REGIONS,
                            err);
}
_Static_assert(sizeof(struct packing_region) == 5 * sizeof(double), "a region is a row");

static double regime_of(const struct state *s)
{
    if (fabs(s->now_centre - s->centre) < STABLE * s->centre)
        return HEAP_STABLE;
    if (s->staggered > 0)
        return HEAP_STAGGERED;
    return s->told > 0 && s->middle > s->top ? HEAP_BUCKLING : HEAP_TOP_DRIVEN;
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    const struct packing_region *all = &s->packing.region[0];
    (void)now;
    if (!(s->went > 0))
        return 0;
    const struct scree_number column[] = {
        {"column_height", "m", "H_0: highest body over each line across, mean, when the gate goes", s->height},
        {"column_contacts", "1", "coordination number then: points of contact between bodies, twice, over bodies",
         all->bodies > 0 ? 2 * all->contacts / all->bodies : 0},
        {"force_most", "1", "largest contact force over the mean then", s->packing.force_most},
        {"fabric_level", "1", "mean of cos 2 theta of branches with the level, seen from the side: 1 level, -1 upright",
         s->packing.anisotropy},
        {"janssen_share", "1", "of the weight, carried by walls then", s->packing.janssen},
        {"peak_speed", "1", "largest mean speed over sqrt(g H_0) after the gate has gone", s->peak},
        {"centre_shift", "1", "how far the centre of mass came, over its first distance from the back wall",
         s->centre > 0 ? s->now_centre / s->centre - 1 : 0},
        {"regime", "1", "0 stable, 1 driven from the top, 2 buckling, 3 staggered (src/measure/heap.c has the rules)",
         regime_of(s)},
    };
    return measure_numbers(out, room, column, context->site.gate ? sizeof column / sizeof *column : 5);
}

static bool sound(const void *state, const struct measure_context *context)
{
    const struct state *s = state;
    return s->start.count == (s->went > 0 ? 2 * context->moving : 0);
}

const struct measurement measure_heap = {
    .name = "heap",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW | MEASURE_END_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = STREAMS,
    .buffers = offsetof(struct state, start),
    .buffer_count = 1,
    .start = start,
    .sample = sample,
    .close = close,
    .numbers = numbers,
    .sound = sound,
};
