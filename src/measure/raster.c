/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See raster.h. A pixel is covered when its centre is inside an outline, or nearer
 * to it than the corners' balls. */
#include "measure/raster.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static double turn(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static int by_place(const void *x, const void *y)
{
    const double *a = x, *b = y;
    return a[0] != b[0] ? (a[0] < b[0] ? -1 : 1) : (a[1] > b[1]) - (a[1] < b[1]);
}

/* Hull by Andrew (1979). */
void raster_outline(const struct view *view, uint32_t part, int axis0, int axis1, struct raster_outline *out)
{
    double point[RASTER_CORNERS_MAX][2];
    size_t n = 0, kept = 0, from = view->part_start[part], to = view->part_start[part + 1];
    for (size_t k = from; k < to && n < RASTER_CORNERS_MAX; k++, n++) {
        point[n][0] = view->corner[k][axis0];
        point[n][1] = view->corner[k][axis1];
    }
    out->radius = n > 0 ? view->corner[from][3] : 0;
    qsort(point, n, sizeof *point, by_place);
    double(*hull)[2] = out->point;
    for (size_t k = 0; k < n; k++) { // below
        while (kept >= 2 && turn(hull[kept - 2], hull[kept - 1], point[k]) <= 0)
            kept--;
        memcpy(hull[kept++], point[k], sizeof *hull);
    }
    for (size_t k = n, below = kept + 1; k-- > 1;) { // above, back again
        while (kept >= below && turn(hull[kept - 2], hull[kept - 1], point[k - 1]) <= 0)
            kept--;
        if (kept < RASTER_CORNERS_MAX)
            memcpy(hull[kept++], point[k - 1], sizeof *hull);
    }
    out->count = n > 1 && kept > 1 ? kept - 1 : n;
    for (int a = 0; a < 2; a++) {
        out->low[a] = INFINITY;
        out->high[a] = -INFINITY;
        for (size_t k = 0; k < n; k++) {
            out->low[a] = fmin(out->low[a], point[k][a] - out->radius);
            out->high[a] = fmax(out->high[a], point[k][a] + out->radius);
        }
    }
}

static double square_to_edge(const double p[2], const double a[2], const double b[2])
{
    double along[2] = {b[0] - a[0], b[1] - a[1]}, from[2] = {p[0] - a[0], p[1] - a[1]};
    double length2 = along[0] * along[0] + along[1] * along[1];
    double at = length2 > 0 ? fmin(1, fmax(0, (from[0] * along[0] + from[1] * along[1]) / length2)) : 0;
    double x = from[0] - at * along[0], y = from[1] - at * along[1];
    return x * x + y * y;
}

static bool covers(const struct raster_outline *o, const double p[2])
{
    bool inside = o->count >= 3;
    double nearest = INFINITY;
    for (size_t k = 0; k < o->count; k++) {
        const double *a = o->point[k], *b = o->point[(k + 1) % o->count];
        inside = inside && turn(a, b, p) >= 0;
        nearest = fmin(nearest, square_to_edge(p, a, b));
    }
    return inside || nearest <= o->radius * o->radius;
}

void raster_pixels(double low, double high, double pixel, size_t count, size_t *from, size_t *to)
{
    *from = (size_t)fmin((double)count, fmax(0, ceil(low / pixel - 0.5)));
    *to = (size_t)fmin((double)count, fmax(0, ceil(high / pixel - 0.5)));
}

/* Towards the camera: the highest centre, or that with the least y. */
static double nearness(const struct view_body *b, enum raster_camera camera)
{
    return camera == RASTER_ABOVE ? b->position[2] : -b->position[1];
}

/* Of bodies that are equally near the first is seen. */
static void cover(const struct view *view, uint32_t body, enum raster_camera camera, const struct raster_outline *o,
                  struct raster *r)
{
    size_t x0, x1, y0, y1;
    const double near = nearness(&view->body[body], camera);
    raster_pixels(o->low[0], o->high[0], r->pixel, r->columns, &x0, &x1);
    raster_pixels(o->low[1], o->high[1], r->pixel, r->lines, &y0, &y1);
    for (size_t x = x0; x < x1; x++)
        for (size_t y = y0; y < y1; y++) {
            const double p[2] = {((double)x + 0.5) * r->pixel, ((double)y + 0.5) * r->pixel};
            uint32_t *seen = &r->body[x * r->lines + y];
            if ((*seen == RASTER_NOTHING || near > nearness(&view->body[*seen], camera)) && covers(o, p))
                *seen = body;
        }
}

/* Every part of every body. */
static void cover_all(const struct view *view, enum raster_camera camera, int axis, struct raster *r)
{
    struct raster_outline o;
    for (uint32_t k = 0; k < view->bodies; k++)
        for (uint32_t p = view->body[k].part_first; p < view->body[k].part_first + view->body[k].parts; p++) {
            raster_outline(view, p, 0, axis, &o);
            cover(view, k, camera, &o, r);
        }
}

static double farthest(const struct view *view, int axis)
{
    double most = 0;
    for (size_t k = 0; k < view->bodies; k++)
        for (uint32_t p = view->body[k].part_first; p < view->body[k].part_first + view->body[k].parts; p++)
            for (uint32_t c = view->part_start[p]; c < view->part_start[p + 1]; c++)
                most = fmax(most, view->corner[c][axis] + view->corner[c][3]);
    return most;
}

enum scree_status raster_draw(const struct view *view, enum raster_camera camera, double length, double across, double pixel,
                              struct raster *out, struct scree_error *err)
{
    const int axis = camera == RASTER_ABOVE ? 1 : 2;
    double extent = isinf(across) ? pixel * ceil(farthest(view, axis) / pixel) : across;
    pixel = fmax(pixel, sqrt(length * extent / RASTER_PIXELS_MAX));
    *out = (struct raster){
        .columns = (size_t)fmax(1, round(length / pixel)), .lines = (size_t)fmax(1, round(extent / pixel)), .pixel = pixel};
    const size_t pixels = out->columns * out->lines;
    if (!(out->body = memory_rows(pixels, sizeof *out->body)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image of %zu times %zu pixels", out->columns, out->lines);
    memset(out->body, 0xff, pixels * sizeof *out->body);
    _Static_assert(RASTER_NOTHING == 0xffffffffu, "what memset writes");
    cover_all(view, camera, axis, out);
    return SCREE_OK;
}

void raster_free(struct raster *r)
{
    free(r->body);
    r->body = NULL;
}
