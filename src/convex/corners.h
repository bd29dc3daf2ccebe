/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Corners of bodies in space: put there once a step, when they are first asked for; four at once are then measured along
 * a direction. For sources that are compiled per instruction set. Private to this folder. */
#ifndef SCREE_CONVEX_CORNERS_H
#define SCREE_CONVEX_CORNERS_H

#include <math.h>

#include "base/lanes.h"
#include "convex/state.h"

/* From the body's centre along the axes of space: x, then y, then z of all. */
SIMD_INLINE const double *corners_of(struct convex *c, struct body *b)
{
    double *x = c->corner + (size_t)(b - c->body) * 3 * c->corners;
    if (b->placed == c->step + 1)
        return x;
    const double *own = b->outline->own;
    const size_t n = b->outline->corners;
    for (size_t k = 0; k < n; k += 4) {
        v4 u = v4_load(own + k), v = v4_load(own + n + k), w = v4_load(own + 2 * n + k);
        for (int i = 0; i < 3; i++)
            v4_store(x + (size_t)i * c->corners + k,
                     u * v4_all(b->axis[0][i]) + v * v4_all(b->axis[1][i]) + w * v4_all(b->axis[2][i]));
    }
    b->placed = c->step + 1;
    return x;
}

/* The corners of a part: x, with y and z `stride` farther. */
struct side {
    const struct body *body;
    const struct composite_part *part;
    const double *x;
    size_t stride;
};

SIMD_INLINE struct side side_of(struct convex *c, struct body *b, size_t part)
{
    const struct outline *o = b->outline;
    if (o->ball)
        return (struct side){b, b->shape->part, o->own, o->corners};
    return (struct side){b, &b->shape->part[part], corners_of(c, b) + o->from[part], c->corners};
}

SIMD_INLINE struct vec3 corner(const struct side *s, size_t k)
{
    return (struct vec3){s->x[k], s->x[s->stride + k], s->x[2 * s->stride + k]};
}

SIMD_INLINE v4 heights(const struct side *s, struct vec3 d, size_t k)
{
    return v4_all(d.x) * v4_load(s->x + k) + v4_all(d.y) * v4_load(s->x + s->stride + k) +
           v4_all(d.z) * v4_load(s->x + 2 * s->stride + k);
}

/* How far the part reaches along d from its body's centre, times |d|. */
SIMD_INLINE double highest(const struct side *s, struct vec3 d)
{
    v4 most = v4_all(-INFINITY);
    for (size_t k = 0; k < s->part->vertices; k += 4)
        most = v4_max(most, heights(s, d, k));
    double low = most[0] > most[1] ? most[0] : most[1], high = most[2] > most[3] ? most[2] : most[3];
    return low > high ? low : high;
}

/* How many corners are higher along d than that; one may be counted again where the part's are filled up. */
SIMD_INLINE int corners_above(const struct side *s, struct vec3 d, double height)
{
    int count = 0;
    for (size_t k = 0; k < s->part->vertices; k += 4)
        count += __builtin_popcount(m4_bits(heights(s, d, k) >= v4_all(height)));
    return count;
}

#endif
