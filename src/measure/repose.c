/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See repose.h. Rings are cut into cells as long as they are wide; the highest body in
 * each is the surface there. */
#include "measure/repose.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/line.h"
#include "measure/measure.h"

#define LOW  0.2
#define HIGH 0.8

static const struct scree_column surface_columns[] = {{"radius", "m"}, {"height", "m"}};
static const struct scree_stream surface_stream = {
    "heap_surface", "height of the heap under a hopper by distance from its axis, mean over azimuth, at the end", surface_columns,
    2, true};
static const struct scree_stream *const streams[] = {&surface_stream};

/* The first ring has four cells, each next one 2 pi more. */
static size_t cells_up_to(size_t ring)
{
    return (size_t)ceil(M_PI * (double)(ring * ring));
}

static void find_tops(const struct view *view, double floor, double ledge, double width, size_t rings, double *top)
{
    for (size_t k = 0; k < view->bodies; k++) {
        const double *x = view->body[k].position, dx = x[0] - 0.5 * floor, dy = x[1] - 0.5 * floor;
        size_t ring = (size_t)fmin((double)rings, sqrt(dx * dx + dy * dy) / width);
        if (ring >= rings || x[2] > ledge)
            continue;
        size_t from = cells_up_to(ring), cells = cells_up_to(ring + 1) - from;
        size_t cell = from + (size_t)((atan2(dy, dx) / (2 * M_PI) + 0.5) * (double)cells) % cells;
        top[cell] = fmax(top[cell], x[2] + cbrt(3 * view->body[k].volume / (4 * M_PI)));
    }
}

static void fit(struct repose *r)
{
    struct line line = {0};
    for (size_t k = 0; k < r->rings; k++) {
        const double *row = r->row[k];
        if (row[1] < LOW * r->height || row[1] > HIGH * r->height)
            continue;
        line_add(&line, 1, row[0], row[1]);
    }
    r->angle = line.w >= 3 ? -atan(line_slope(&line)) * 180 / M_PI : NAN;
}

enum scree_status repose_measure(const struct view *view, double floor, double ledge, double width, struct repose *out,
                                 struct scree_error *err)
{
    *out = (struct repose){.rings = (size_t)fmax(1, 0.5 * floor / width)};
    double *top = memory_rows(cells_up_to(out->rings), sizeof *top);
    out->row = memory_rows(out->rings, sizeof *out->row);
    if (!top || !out->row) {
        free(top);
        repose_free(out);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the surface of a heap");
    }
    find_tops(view, floor, ledge, width, out->rings, top);
    for (size_t ring = 0; ring < out->rings; ring++) {
        size_t from = cells_up_to(ring), to = cells_up_to(ring + 1);
        out->row[ring][0] = ((double)ring + 0.5) * width;
        for (size_t cell = from; cell < to; cell++)
            out->row[ring][1] += top[cell] / (double)(to - from);
        out->height = fmax(out->height, out->row[ring][1]);
    }
    for (size_t k = 0; k < view->bodies; k++)
        out->left += view->body[k].position[2] > ledge ? 1.0 / (double)view->bodies : 0;
    fit(out);
    free(top);
    return SCREE_OK;
}

void repose_free(struct repose *r)
{
    free(r->row);
    r->row = NULL;
}

/* ---- the measurement ---- */

static bool wanted(const struct measure_context *context)
{
    return context->site.ledge_z > 0;
}

static enum scree_status measure(const struct measure_context *context, const struct measure_now *now, struct repose *out,
                                 struct scree_error *err)
{
    const struct measure_site *site = &context->site;
    return repose_measure(now->grains, site->length_x, site->ledge_z, site->diameter, out, err);
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct repose r;
    enum scree_status status = measure(context, now, &r, err);
    if (!status)
        status = series_put_frame(state, context->sink, context->time_s, r.row[0], r.rings, err);
    repose_free(&r);
    return status;
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    struct repose r;
    (void)state;
    if (!now->grains || measure(context, now, &r, NULL))
        return 0;
    repose_free(&r);
    const struct scree_number all[] = {
        {"hopper_share", "1", "of the bodies, still in the hopper", r.left},
        {"heap_height", "m", "of the heap's highest ring", r.height},
        {"repose_angle", "deg", "slope of the heap between 20 and 80 % of that, mean over azimuth", r.angle},
    };
    return measure_numbers(out, room, all, isnan(r.angle) ? 2 : 3);
}

const struct measurement measure_repose = {
    .kind = SCENARIO_DEM,
    .needs = MEASURE_END_VIEW,
    .size = sizeof(struct series),
    .streams = streams,
    .stream_count = 1,
    .wanted = wanted,
    .close = close,
    .numbers = numbers,
};
