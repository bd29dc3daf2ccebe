/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pictures of bodies from above and from aside while they move, the raster that the
 * run-out is read from (seed 001, III.C): what `scree plot` draws of a collapse. A
 * row is a pixel that shows a body; place and speed are that body's, which tells
 * bodies apart and the flowing from those at rest. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "measure/measure.h"
#include "measure/raster.h"

enum { COLUMNS = 4 };
static const struct scree_column above_columns[COLUMNS] = {{"x", "m"}, {"y", "m"}, {"z", "m"}, {"speed", "m/s"}};
static const struct scree_column aside_columns[COLUMNS] = {{"x", "m"}, {"z", "m"}, {"y", "m"}, {"speed", "m/s"}};
static const struct scree_stream above_stream = {
    "view_above", "from above, a row a covered pixel: its middle x, y; of the body that is seen there height of the centre, speed",
    above_columns, COLUMNS, true};
static const struct scree_stream aside_stream = {
    "view_aside",
    "from the side, along y, a row a covered pixel: its middle x, z; of the body that is seen there y of the centre, speed",
    aside_columns, COLUMNS, true};
static const struct scree_stream *const streams[] = {[RASTER_ABOVE] = &above_stream, [RASTER_ASIDE] = &aside_stream};

struct state {
    double looked_s; // when, last
    struct series series[RASTER_CAMERAS];
};

static size_t covered(const struct raster *r)
{
    size_t count = 0;
    for (size_t k = 0; k < r->columns * r->lines; k++)
        count += r->body[k] != RASTER_NOTHING;
    return count;
}

static void row_of(const struct view *view, const struct raster *r, size_t k, int axis, double row[COLUMNS])
{
    const struct view_body *b = &view->body[r->body[k]];
    row[0] = ((double)(k / r->lines) + 0.5) * r->pixel;
    row[1] = ((double)(k % r->lines) + 0.5) * r->pixel;
    row[2] = b->position[axis];
    row[3] = sqrt(vec3_square(b->velocity));
}

/* `axis` is the one that is looked along. */
static enum scree_status put(struct series *series, const struct measure_context *context, const struct view *view,
                             const struct raster *r, int axis, struct scree_error *err)
{
    const size_t count = covered(r);
    if (count == 0)
        return SCREE_OK; // all are out of the picture: no frame
    double(*rows)[COLUMNS] = memory_rows(count, sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a picture of %zu pixels", count);
    for (size_t k = 0, row = 0; row < count; k++)
        if (r->body[k] != RASTER_NOTHING)
            row_of(view, r, k, axis, rows[row++]);
    enum scree_status status = series_put_frame(series, context->sink, context->time_s, rows[0], count, err);
    free(rows);
    return status;
}

static enum scree_status look(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct state *s = state;
    const struct measure_site *site = &context->site;
    const double pixel = site->diameter / (double)context->job->record.views.pixels;
    enum scree_status status = SCREE_OK;
    s->looked_s = context->time_s;
    for (enum raster_camera c = RASTER_ABOVE; c < RASTER_CAMERAS && !status; c++) {
        struct raster r;
        const bool above = c == RASTER_ABOVE;
        status = raster_draw(now->grains, c, site->length_x, above ? site->width_y : INFINITY, pixel, &r, err);
        if (!status)
            status = put(&s->series[c], context, now->grains, &r, above ? 2 : 1, err);
        raster_free(&r);
    }
    return status;
}

/* The end, too, which the run-out is of. */
static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    const struct state *s = state;
    return context->time_s > s->looked_s ? look(state, context, now, err) : SCREE_OK;
}

const struct measurement measure_views = {
    .name = "views",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = RASTER_CAMERAS,
    .first = look,
    .sample = look,
    .close = close,
};
