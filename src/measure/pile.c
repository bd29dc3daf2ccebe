/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See pile.h. */
#include "measure/pile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "measure/measure.h"
#include "measure/raster.h"

/* Highest point of an outline (y, z) over a line at y. */
static double top_at(const struct raster_outline *o, double y)
{
    double top = -INFINITY;
    for (size_t k = 0; k < o->count; k++) {
        const double *a = o->point[k], *b = o->point[(k + 1) % o->count];
        double width = b[0] - a[0], at = width != 0 ? fmin(1, fmax(0, (y - a[0]) / width)) : a[1] < b[1];
        double aside = y - (a[0] + at * width), cap2 = o->radius * o->radius - aside * aside;
        if (cap2 >= 0)
            top = fmax(top, a[1] + at * (b[1] - a[1]) + sqrt(cap2));
    }
    return top;
}

static void raise(const struct raster_outline *o, double pixel, double *top, size_t lines)
{
    size_t from, to;
    raster_pixels(o->low[0], o->high[0], pixel, lines, &from, &to);
    for (size_t y = from; y < to; y++)
        top[y] = fmax(top[y], top_at(o, ((double)y + 0.5) * pixel));
}

/* As a camera in front sees them: the highest part over each line. */
static void raise_all(const struct view *view, double pixel, double *top, size_t lines)
{
    struct raster_outline front;
    for (size_t k = 0; k < view->bodies; k++)
        for (uint32_t p = view->body[k].part_first; p < view->body[k].part_first + view->body[k].parts; p++) {
            raster_outline(view, p, 1, 2, &front);
            raise(&front, pixel, top, lines);
        }
}

size_t pile_first_below(const double *share, size_t count, size_t from, double threshold)
{
    size_t k = from;
    while (k < count && share[k] >= threshold)
        k++;
    return k;
}

static int by_size(const void *x, const void *y)
{
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

static void read_rasters(const struct raster *r, size_t from, double *share, double *top, struct pile *out)
{
    for (size_t x = 0; x < r->columns; x++) {
        size_t covered = 0;
        for (size_t y = 0; y < r->lines; y++)
            covered += r->body[x * r->lines + y] != RASTER_NOTHING;
        share[x] = (double)covered / (double)r->lines;
    }
    out->runout = r->pixel * (double)pile_first_below(share, r->columns, from, 0.1);
    out->runout_least = r->pixel * (double)pile_first_below(share, r->columns, from, 0.2);
    out->runout_most = r->pixel * (double)pile_first_below(share, r->columns, from, 0.01);
    for (size_t y = 0; y < r->lines; y++)
        out->height += top[y] / (double)r->lines;
    qsort(top, r->lines, sizeof *top, by_size);
    out->height_low = top[r->lines / 4];
    out->height_high = top[3 * r->lines / 4];
}

static void sum_up(const struct view *view, struct pile *out)
{
    double mass = 0;
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        mass += b->mass;
        out->speed_mean += sqrt(vec3_square(b->velocity)) / (double)view->bodies;
        for (int a = 0; a < 3; a++)
            out->centre[a] += b->mass * b->position[a];
    }
    for (int a = 0; a < 3; a++)
        out->centre[a] /= mass;
    for (size_t k = 0; k < view->contacts; k++) {
        out->contacts += view->contact[k].b < VIEW_WALL ? 2.0 / (double)view->bodies : 0;
        out->overlap = fmax(out->overlap, view->contact[k].overlap);
    }
}

enum scree_status pile_measure(const struct view *view, double length, double width, double from, double pixel, struct pile *out,
                               struct scree_error *err)
{
    struct raster r;
    *out = (struct pile){0};
    enum scree_status status = raster_draw(view, RASTER_ABOVE, length, width, pixel, &r, err);
    if (status)
        return status;
    double *share = memory_rows(r.columns, sizeof *share), *top = memory_rows(r.lines, sizeof *top);
    if (share && top) {
        raise_all(view, r.pixel, top, r.lines);
        read_rasters(&r, (size_t)fmax(0, from / r.pixel), share, top, out);
        sum_up(view, out);
    } else {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image's sums");
    }
    free(share);
    free(top);
    raster_free(&r);
    return status;
}

/* ---- the measurement ---- */

enum { PIXELS = 20 }; // a diameter of the sphere of a body's volume: the paper's 0.43 mm

enum { BODY_COLUMNS = 15 };
static const struct scree_column body_columns[BODY_COLUMNS] = {
    {"id", "1"}, {"shape", "1"}, {"mass", "kg"}, {"x", "m"},    {"y", "m"},    {"z", "m"},       {"qw", "1"},       {"qx", "1"},
    {"qy", "1"}, {"qz", "1"},    {"vx", "m/s"},  {"vy", "m/s"}, {"vz", "m/s"}, {"volume", "m3"}, {"contacts", "1"},
};
static const struct scree_stream bodies_stream = {"bodies", "every body at the end; qw to qz: own axes into space", body_columns,
                                                  BODY_COLUMNS, true};
static const struct scree_stream *const streams[] = {&bodies_stream};

static bool wanted(const struct measure_context *context)
{
    return context->site.length_x > 0;
}

static enum scree_status close(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    const struct view *view = now->grains;
    double(*rows)[BODY_COLUMNS] = memory_rows(view->bodies, sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu bodies", view->bodies);
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        const double row[BODY_COLUMNS] = {
            b->id,          b->shape,          b->mass,           b->position[0],    b->position[1],
            b->position[2], b->orientation[0], b->orientation[1], b->orientation[2], b->orientation[3],
            b->velocity[0], b->velocity[1],    b->velocity[2],    b->volume,         0};
        memcpy(rows[k], row, sizeof row);
    }
    for (size_t k = 0; k < view->contacts; k++) {
        rows[view->contact[k].a][BODY_COLUMNS - 1]++;
        if (view->contact[k].b < VIEW_WALL)
            rows[view->contact[k].b][BODY_COLUMNS - 1]++;
    }
    enum scree_status status = series_put_frame(state, context->sink, context->time_s, rows[0], view->bodies, err);
    free(rows);
    return status;
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct measure_site *site = &context->site;
    struct pile p;
    (void)state;
    if (!now->grains ||
        pile_measure(now->grains, site->length_x, site->width_y, 0.5 * site->gate_x, site->diameter / PIXELS, &p, NULL))
        return 0;
    const struct scree_number all[] = {
        {"runout", "m", "first column of pixels beyond the middle of the first heap of which less than 10 % is covered, from above",
         p.runout},
        {"runout_least", "m", "the same with 20 %", p.runout_least},
        {"runout_most", "m", "the same with 1 %", p.runout_most},
        {"pile_height", "m", "highest body over each line across, mean", p.height},
        {"pile_height_low", "m", "first quartile of it", p.height_low},
        {"pile_height_high", "m", "third quartile of it", p.height_high},
        {"centre_x", "m", "of mass, from the back wall", p.centre[0]},
        {"centre_z", "m", "of mass, above the floor", p.centre[2]},
        {"body_contacts", "1", "coordination number: points in which bodies touch each other, twice, over bodies", p.contacts},
        {"mean_speed", "m/s", "of the bodies, now", p.speed_mean},
        {"largest_overlap", "m", "of any contact, now", p.overlap},
    };
    enum { OF_A_BOX = 6 }; // those that a heap against a back wall has, and one under a hopper has not
    size_t from = site->ledge_z > 0 ? OF_A_BOX : 0;
    return measure_numbers(out, room, all + from, sizeof all / sizeof *all - from);
}

const struct measurement measure_pile = {
    .kind = SCENARIO_DEM,
    .needs = MEASURE_END_VIEW,
    .size = sizeof(struct series),
    .streams = streams,
    .stream_count = 1,
    .wanted = wanted,
    .close = close,
    .numbers = numbers,
};
