/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One record for each contact that forms, with the relative velocity at the first
 * step with overlap (protocols 1.9): at most one step after touch, so biased by
 * one step of gravity at most. Contacts with the base count; a contact that forms
 * again is a new one. The summary's percentile (S0-16) comes from a histogram in
 * ln v, so that no run is too long for it. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/history.h"

static const struct scree_column columns[] = {
    {"time", "s"}, {"x", "m"}, {"y", "m"}, {"z", "m"}, {"dn", "m/s"}, {"dt", "m/s"}, {"a", "1"}, {"b", "1"}, {"partner", "1"},
};
enum { COLUMNS = sizeof columns / sizeof *columns };
static const struct scree_stream stream = {"collisions",
                                           "contacts that formed: place between the surfaces, normal and tangential relative "
                                           "speed, ids (b of a wall: its number), partner: "
                                           "0 a moving grain, 1 a grain of the base, 2 a wall of the base, 3 another wall",
                                           columns, COLUMNS, false};
static const struct scree_stream *const streams[] = {&stream};

/* Bins of equal width in ln(dn), from 1e-7 to 1e2 m/s: 1 % wide. */
enum { BINS = 2080 };
#define LOWEST 1e-7
#define WIDTH  0.01
enum { COUNT, NORMAL2, TANGENTIAL2, FIRST_BIN, SUMS = FIRST_BIN + BINS }; // of the history

struct state {
    struct history history;
    double kept_s; // time of the last instant
    struct series series;
    struct measure_buffer buffers[HISTORY_BUFFERS];
};

#define KEEP_PER_S 20.0 // instants of the history, at whole multiples of 0.05 s

static size_t chunk(const struct measure_context *context)
{
    return (size_t)context->job->record.collisions.chunk;
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    struct state *s = state;
    (void)context;
    return history_start(&s->history, s->buffers, SUMS, err);
}

static size_t bin_of(double speed)
{
    double place = log(speed / LOWEST) / WIDTH;
    return place > 0 ? (size_t)fmin(place, BINS - 1) : 0;
}

static enum scree_status note(struct state *s, const struct measure_context *context, const struct view_formation *f,
                              struct scree_error *err)
{
    double *sums = history_sums(s->buffers);
    double slide2 = f->tangential[0] * f->tangential[0] + f->tangential[1] * f->tangential[1] + f->tangential[2] * f->tangential[2];
    double partner = f->b < VIEW_WALL ? f->fixed : f->fixed ? 2 : 3;
    const double row[COLUMNS] = {f->time_s,    f->place[0], f->place[1],       f->place[2], f->approach,
                                 sqrt(slide2), f->a,        f->b & ~VIEW_WALL, partner};
    /* All before that instant have been seen when the first after it comes: instants follow collisions, never slices. */
    double instant = floor(f->time_s * KEEP_PER_S * (1 + 1e-12)) / KEEP_PER_S;
    if (instant > s->kept_s) {
        enum scree_status status = history_keep(&s->history, s->buffers, instant, err);
        if (status)
            return status;
        s->kept_s = instant;
    }
    bool of_grains = f->b < VIEW_WALL || f->fixed; // side walls and ceilings are none
    if (of_grains && f->place[1] >= context->site.region[0] && f->place[1] < context->site.region[1]) {
        sums[COUNT] += 1;
        sums[NORMAL2] += f->approach * f->approach;
        sums[TANGENTIAL2] += slide2;
        sums[FIRST_BIN + bin_of(fabs(f->approach))] += 1;
    }
    if (f->time_s < context->job->record.collisions.from_s)
        return SCREE_OK;
    return series_add(&s->series, context->sink, f->time_s, row, err);
}

static enum scree_status formed(void *state, struct measure_context *context, const struct view_formation *formations, size_t count,
                                struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < count && !status; k++)
        status = note(state, context, &formations[k], err);
    return status;
}

/* The speed below which a share of the collisions lies; linear within a bin of ln v. */
static double percentile(const double *sums, double share)
{
    double below = 0, wanted = share * sums[COUNT];
    for (size_t k = 0; k < BINS; k++) {
        double here = sums[FIRST_BIN + k];
        if (here > 0 && below + here >= wanted)
            return LOWEST * exp(WIDTH * ((double)k + (wanted - below) / here));
        below += here;
    }
    return 0;
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    double *sums = memory_rows(SUMS, sizeof *sums);
    (void)now;
    if (!sums)
        return 0;
    double from = history_since(&s->history, s->buffers, measure_window_from(context), sums), span = context->time_s - from;
    double count = sums[COUNT], moving = fmax(1, context->here.grains), per = count > 0 ? count : 1;
    const struct scree_number all[] = {
        {"collisions", "1", "contacts that formed in the window between grains, or with the base", count},
        {"collisions_per_s", "1/s", "the same over the window's length", span > 0 ? count / span : 0},
        {"collisions_per_grain_s", "1/s", "and over the moving grains, each contact counted once",
         span > 0 ? count / span / moving : 0},
        {"impact_normal2", "m2/s2", "mean squared normal speed of impact", sums[NORMAL2] / per},
        {"impact_tangential2", "m2/s2", "mean squared tangential speed of impact", sums[TANGENTIAL2] / per},
        {"impact_median", "m/s", "median normal speed of impact", percentile(sums, 0.5)},
        {"impact_p999", "m/s", "normal speed that 1 of 1000 impacts exceeds", percentile(sums, 0.999)},
    };
    free(sums);
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
}

static bool sound(const void *state, const struct measure_context *context)
{
    const struct state *s = state;
    (void)context;
    return history_sound(&s->history, s->buffers, SUMS);
}

const struct measurement measure_collisions = {
    .name = "collisions",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_FORMATIONS,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .buffers = offsetof(struct state, buffers),
    .buffer_count = HISTORY_BUFFERS,
    .chunk = chunk,
    .start = start,
    .formed = formed,
    .numbers = numbers,
    .sound = sound,
};
