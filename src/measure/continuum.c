/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world of continuum records: the deposit along time, and its points. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/deposit.h"
#include "measure/frames.h"
#include "measure/measure.h"

/* ---- deposit, under `record.bulk` ---- */

enum { SURFACE, STILL, INERTIAL, BUFFERS };
struct state {
    struct deposit last;
    double volume;
    uint64_t steps, rows, sweeps, unconverged;
    struct series series;
    struct measure_buffer buffers[BUFFERS]; // empty between samples
};
#define SETTLED_S 0.3 // after the gate began to lift, before which nothing can have come to rest
#define NODES_MAX ((size_t)1 << 28)

/* Rest ends jobs, so samples are needed even where nobody records them. */
static bool wanted(const struct measure_context *context)
{
    (void)context;
    return true;
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    (void)context;
    (void)err;
    for (int k = 0; k < BUFFERS; k++)
        ((struct state *)state)->buffers[k].most = NODES_MAX;
    return SCREE_OK;
}

static enum scree_status look(struct state *s, const struct measure_context *context, const struct continuum_view *view,
                              struct scree_error *err)
{
    const struct deposit_site site = {.bed = context->site.bed, .gate = context->site.gate_x, .start = context->site.gate_s};
    const size_t layers = (size_t)continuum_layers(view, 0), need[BUFFERS] = {layers, layers, view->nodes};
    for (int k = 0; k < BUFFERS; k++) {
        enum scree_status status = measure_buffer_resize(&s->buffers[k], need[k], err);
        if (status)
            return status;
    }
    struct deposit_lines lines = {layers, s->buffers[SURFACE].values, s->buffers[STILL].values, s->buffers[INERTIAL].values};
    const struct deposit before = s->last;
    deposit_measure(view, &site, &lines, &s->last);
    if (view->step > s->steps) {
        s->last.front_speed = (s->last.run_out - before.run_out) / (s->last.time_s - before.time_s);
        s->last.sweeps = (double)(view->sweeps - s->sweeps) / (double)(view->step - s->steps);
    }
    for (int k = 0; k < BUFFERS; k++)
        s->buffers[k].count = 0;
    s->volume = view->volume;
    s->steps = view->step;
    s->rows = view->rows;
    s->sweeps = view->sweeps;
    s->unconverged = view->unconverged;
    return SCREE_OK;
}

static enum scree_status first(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    return look(state, context, now->points, err);
}

static void judge(struct measure_context *context, const struct deposit *d)
{
    struct verdict *verdict = &context->verdict;
    bool rest = context->site.gate && d->time_s >= SETTLED_S && d->fastest < DEPOSIT_REST;
    verdict->current = rest ? VERDICT_REST : VERDICT_UNDECIDED;
    int length = snprintf(verdict->evidence, sizeof verdict->evidence, "fastest point at %.3g m/s (rest: below %g)", d->fastest,
                          DEPOSIT_REST);
    if (context->site.gate)
        snprintf(verdict->evidence + length, sizeof verdict->evidence - (size_t)length, ", %.4g s after the gate began to lift",
                 d->time_s);
    if (rest && (context->job->stop.when & STOP_REST))
        context->stop = true;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    enum scree_status status = look(s, context, now->points, err);
    if (status)
        return status;
    judge(context, &s->last);
    if (!s->series.values)
        return SCREE_OK;
    double row[DEPOSIT_COLUMNS];
    deposit_row(&s->last, row);
    return series_add(&s->series, context->sink, context->time_s, row, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    const struct deposit *d = &s->last;
    const struct measure_site *site = &context->site;
    (void)now;
    const struct scree_number of_collapse[] = {
        {"run_out", "m", "from the gate to where the deposit is 2 mm deep, at the side wall", d->run_out},
        {"furthest", "m", "of a point 2 mm above the bed, from the back wall", d->furthest},
        {"height_back", "m", "of the surface over the bed at the back wall", d->height_back},
        {"since_gate", "s", "since the gate began to lift; params.gate_wait_s more since the start", d->time_s},
        {"aspect_ratio", "1", "a, of the column: height over the bed over length", site->height / site->gate_x},
        {"run_out_ratio", "1", "(furthest - L0) / L0", (d->furthest - site->gate_x) / site->gate_x},
        {"height_ratio", "1", "H0 over the height at the back wall", site->height / d->height_back},
    };
    const struct scree_number all[] = {
        {"fastest", "m/s", "point", d->fastest},
        {"surface_angle", "deg", "of the surface over the middle of the box, against the horizontal", d->surface_angle},
        {"surface_volume", "m3", "under the free surface, bed included", d->surface_volume},
        {"material_volume", "m3", "of all points, which never changes", s->volume},
        {"volume_lost", "%", "by which the surface holds less than the material", 100 * (1 - d->surface_volume / s->volume)},
        {"overfull", "%", "of the material, beyond what nodes can hold", 100 * d->overfull / s->volume},
        {"sweeps_per_step", "1", "of the solver", (double)s->sweeps / fmax(1, (double)s->steps)},
        {"unconverged_steps", "1", "whose sweeps ran out before params.continuum.tolerance", (double)s->unconverged},
        {"residual_mean", "1", "squared, of the last step", d->residual_mean},
        {"residual_largest", "1", "squared, of the last step", d->residual_largest},
        {"rows", "1", "nodes with material", (double)s->rows},
    };
    size_t count = site->gate ? measure_numbers(out, room, of_collapse, sizeof of_collapse / sizeof *of_collapse) : 0;
    return count + measure_numbers(out + count, room - count, all, sizeof all / sizeof *all);
}

static const struct scree_stream *const deposit_streams[] = {&deposit_stream};
const struct measurement measure_deposit = {
    .name = "bulk",
    .kind = SCENARIO_MPM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = deposit_streams,
    .stream_count = 1,
    .buffers = offsetof(struct state, buffers),
    .buffer_count = BUFFERS,
    .wanted = wanted,
    .start = start,
    .first = first,
    .sample = sample,
    .numbers = numbers,
};

/* ---- points: grains of the same volume, so that readers of grains' frames take them as they are ---- */

static const struct scree_column columns[FRAME_COLUMNS] = {
    {"id", "1"},   {"x", "m"},      {"y", "m"},      {"z", "m"},      {"radius", "m"}, {"vx", "m/s"},  {"vy", "m/s"},
    {"vz", "m/s"}, {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}, {"mass", "kg"},  {"fixed", "1"},
};
static const struct scree_stream snapshots_stream = {"snapshots", "every material point's state, a chunk an instant", columns,
                                                     FRAME_COLUMNS, true};
static const struct scree_stream points_stream = {"grains", "every material point's state at the end", columns, FRAME_COLUMNS,
                                                  true};

static size_t frames(const struct measure_context *context)
{
    (void)context;
    return 0;
}

static enum scree_status put(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    const struct continuum_view *view = now->points;
    double(*rows)[FRAME_COLUMNS] = memory_rows(view->points, sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu points", view->points);
    for (size_t p = 0; p < view->points; p++) {
        double *row = rows[view->id[p]], volume = view->position[p][3];
        row[FRAME_ID] = view->id[p];
        for (int a = 0; a < 3; a++) {
            row[FRAME_X + a] = view->position[p][a];
            row[FRAME_VX + a] = view->velocity[p][a];
        }
        row[FRAME_RADIUS] = cbrt(volume / (4.0 / 3.0 * M_PI));
        row[FRAME_MASS] = view->density * volume;
    }
    enum scree_status status = series_put_frame(state, context->sink, view->time_s, rows[0], view->points, err);
    free(rows);
    return status;
}

static const struct scree_stream *const snapshots_streams[] = {&snapshots_stream};
const struct measurement measure_point_snapshots = {
    .name = "snapshots",
    .kind = SCENARIO_MPM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct series),
    .streams = snapshots_streams,
    .stream_count = 1,
    .chunk = frames,
    .first = put,
    .sample = put,
};

static const struct scree_stream *const points_streams[] = {&points_stream};
const struct measurement measure_points = {
    .kind = SCENARIO_MPM,
    .size = sizeof(struct series),
    .streams = points_streams,
    .stream_count = 1,
    .chunk = frames,
    .close = put,
};
