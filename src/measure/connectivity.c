/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The base-connected set, sample by sample (protocols 1.8): by both rules of what
 * counts as a contact, since at a contact's end eq. 5 pulls. */
#include "measure/connectivity.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/line.h"
#include "measure/coarse.h"
#include "measure/connect.h"
#include "measure/history.h"

static const struct scree_column columns[] = {{"time", "s"}, {"joined", "1"}, {"reach", "m"}, {"joined_pushing", "1"}};
enum { COLUMNS = sizeof columns / sizeof *columns };
static const struct scree_stream stream = {"connectivity",
                                           "grains that chains of contacts join to the base: their share of all that move, the "
                                           "highest centre; share by contacts that push",
                                           columns, COLUMNS, false};
static const struct scree_stream *const streams[] = {&stream};

enum { ROOTS = HISTORY_BUFFERS, BUFFERS };
enum { ALL, JOINED, PUSHING, SUMS }; // a height: weights of all grains, of those joined, of those joined by pushing contacts
#define KEEP_EVERY 50                // samples between instants

struct state {
    struct history history;
    uint64_t samples;
    struct series series;
    struct measure_buffer buffers[BUFFERS];
};

double connectivity_lambda(const double *z, const double *joined, const double *all, size_t n, double top, double diameter)
{
    struct line line = {0};
    for (size_t k = 0; k < n; k++) {
        if (!(z[k] > 0 && z[k] <= top && joined[k] > 0.02))
            continue;
        line_add(&line, all[k], z[k] / diameter, log(joined[k]));
    }
    double slope = line_slope(&line);
    return slope < 0 ? -1 / slope : 0;
}

static struct coarse_grid grid_of(const struct measure_context *c)
{
    return coarse_grid_of(c->site.base_z, c->site.diameter, c->site.area_z > 0 ? c->site.area_z : 1, c->site.layers);
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    struct state *s = state;
    return history_start(&s->history, s->buffers, SUMS * grid_of(context).count, err);
}

/* What one rule gives: shares of the moving grains within the region, their reach, weights by height. */
static void look(struct state *s, const struct measure_context *context, const struct view *view, enum connect_rule rule,
                 uint32_t *root, double *share, double *reach)
{
    struct coarse_grid grid = grid_of(context);
    const double *region = context->site.region;
    uint32_t rows = (uint32_t)(view->moving + view->fixed);
    size_t seen = 0, joined = 0;
    connect_base(view, rule, root);
    *reach = context->site.base_z;
    for (uint32_t i = 0; i < rows; i++) {
        const double *x = view->position[i];
        if (x[1] < region[0] || x[1] >= region[1])
            continue;
        bool of_base = root[i] == root[rows];
        const double one = 1, is = of_base;
        double *sums = history_sums(s->buffers);
        if (rule == CONNECT_OVERLAP)
            coarse_add(&grid, x[2], false, &one, 1, sums + ALL, SUMS);
        coarse_add(&grid, x[2], false, &is, 1, sums + (rule == CONNECT_OVERLAP ? JOINED : PUSHING), SUMS);
        if (i >= view->moving)
            continue;
        seen++;
        joined += of_base;
        *reach = of_base ? fmax(*reach, x[2]) : *reach;
    }
    *share = seen > 0 ? (double)joined / (double)seen : 0;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    uint32_t *root = measure_scratch(&s->buffers[ROOTS], connect_rows(now->grains) * sizeof *root, err);
    if (!root)
        return SCREE_NO_MEMORY;
    double row[COLUMNS] = {context->time_s}, unused;
    look(s, context, now->grains, CONNECT_OVERLAP, root, &row[1], &row[2]);
    look(s, context, now->grains, CONNECT_PUSH, root, &row[3], &unused);
    enum scree_status status = SCREE_OK;
    if (++s->samples % KEEP_EVERY == 0)
        status = history_keep(&s->history, s->buffers, context->time_s, err);
    return status ? status : series_add(&s->series, context->sink, context->time_s, row, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    struct coarse_grid grid = grid_of(context);
    double *sums = memory_rows(SUMS * grid.count, sizeof *sums), *rows = memory_rows(4 * grid.count, sizeof *rows);
    size_t count = 0;
    (void)now;
    if (sums && rows && s->samples > 0) {
        double *z = rows, *all = z + grid.count, *joined = all + grid.count, *pushing = joined + grid.count;
        history_since(&s->history, s->buffers, measure_window_from(context), sums);
        for (size_t k = 0; k < grid.count; k++) {
            z[k] = coarse_height(&grid, k) - context->site.base_z;
            all[k] = sums[k * SUMS + ALL];
            joined[k] = all[k] > 0 ? sums[k * SUMS + JOINED] / all[k] : 0;
            pushing[k] = all[k] > 0 ? sums[k * SUMS + PUSHING] / all[k] : 0;
        }
        double top = 2 * (context->here.centre_z - context->site.base_z), d = grid.diameter;
        const struct scree_number numbers_of[] = {
            {"lambda", "1",
             "extent of chains of contacts from the base, in diameters: P_C ~ exp(-z / (lambda d)); 0: P_C does not fall",
             connectivity_lambda(z, joined, all, grid.count, top, d)},
            {"lambda_pushing", "1", "the same by contacts that push", connectivity_lambda(z, pushing, all, grid.count, top, d)},
        };
        count = measure_numbers(out, room, numbers_of, 2);
    }
    free(sums);
    free(rows);
    return count;
}

static bool sound(const void *state, const struct measure_context *context)
{
    const struct state *s = state;
    return history_sound(&s->history, s->buffers, SUMS * grid_of(context).count);
}

const struct measurement measure_connectivity = {
    .name = "connectivity",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .buffers = offsetof(struct state, buffers),
    .buffer_count = BUFFERS,
    .start = start,
    .sample = sample,
    .numbers = numbers,
    .sound = sound,
};
