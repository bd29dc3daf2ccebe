/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Distances of four pairs of parts side by side, by the corners that each was nearest at last time: what holds good is what
 * GJK would end with, and where it does not, geom/gjk.c is asked. For sources that are compiled per instruction set.
 * Private to this folder. */
#ifndef SCREE_CONVEX_DISTANCE4_H
#define SCREE_CONVEX_DISTANCE4_H

#include "convex/corners.h"

#define FLAT     1e-12 // as in geom/gjk.c
#define TOUCHING 1e-26 // square of the distance over that of the size, as there
#define ROUNDING 4e-15 // by which the corners' own heights along v may differ from v.v, over the square of their size

/* Two parts that are to be measured. */
struct looked {
    struct group *group;
    struct pair *pair;
    struct side a, b;
};

/* A row a pair. */
struct distance4 {
    _Alignas(32) double on_a[4][4]; // where a is nearest, from its centre, m; [3] the distance, m
    double way[4][4];               // from there to where b is nearest, m; [3] the distance is no less than that
    unsigned sure;                  // bits: the distance is right
};

SIMD_INLINE struct x3 side_by_side(const struct vec3 v[4])
{
    return (struct x3){v4_set(v[0].x, v[1].x, v[2].x, v[3].x), v4_set(v[0].y, v[1].y, v[2].y, v[3].y),
                       v4_set(v[0].z, v[1].z, v[2].z, v[3].z)};
}

/* The k-th of the corners that the pairs were nearest at, or the first where there are fewer. */
SIMD_INLINE void nearest_corners(const struct looked l[4], int k, struct x3 *a, struct x3 *b)
{
    struct vec3 of_a[4], of_b[4];
    for (int i = 0; i < 4; i++) {
        const struct gjk_cache *cache = &l[i].pair->cache;
        int at = k < cache->count ? k : 0;
        of_a[i] = corner(&l[i].a, cache->a[at]);
        of_b[i] = corner(&l[i].b, cache->b[at]);
    }
    *a = side_by_side(of_a);
    *b = side_by_side(of_b);
}

/* Shares of one to three corners of the difference in its point that is nearest to the origin; false where that lies on
 * the rim or the corners span nothing. */
SIMD_INLINE m4 shares_of(const struct x3 w[3], v4 count, v4 share[3])
{
    const v4 zero = v4_all(0), one = v4_all(1);
    struct x3 e = x3_sub(w[1], w[0]), f = x3_sub(w[2], w[0]), n = x3_cross(e, f), p = x3_scale(w[0], v4_all(-1));
    v4 ee = x3_dot(e, e), nn = x3_dot(n, n), over = one / nn;
    v4 edge = -x3_dot(e, w[0]) / ee;
    v4 second = x3_dot(x3_cross(p, f), n) * over, third = x3_dot(x3_cross(e, p), n) * over;
    m4 corner = count == one, face = count == v4_all(3);
    share[1] = v4_select(face, second, v4_select(corner, zero, edge));
    share[2] = v4_select(face, third, zero);
    share[0] = one - share[1] - share[2];
    m4 spans = v4_select(face, nn, ee) > v4_select(face, v4_all(FLAT) * ee * x3_dot(f, f), zero);
    return corner | (spans & (share[0] > zero) & (share[1] > zero) & ((share[2] > zero) | ~face));
}

SIMD_INLINE v4 squares_max(const struct x3 w[3])
{
    return v4_max(v4_max(x3_dot(w[0], w[0]), x3_dot(w[1], w[1])), x3_dot(w[2], w[2]));
}

/* How far apart the four are along v at least, times |v|. */
SIMD_INLINE v4 least_along(const struct looked l[4], struct x3 v, v4 apart)
{
    double high[2][4] __attribute__((aligned(32)));
    for (int i = 0; i < 4; i++) {
        struct vec3 d = {v.x[i], v.y[i], v.z[i]};
        high[0][i] = highest(&l[i].b, vec3_scale(d, -1));
        high[1][i] = highest(&l[i].a, d);
    }
    return apart - v4_load(high[0]) - v4_load(high[1]);
}

/* From a's centre to b's. */
SIMD_INLINE struct x3 centres_apart(const struct looked l[4])
{
    v4 unused;
    return x3_sub(rows_load(l[0].b.body->position, l[1].b.body->position, l[2].b.body->position, l[3].b.body->position, &unused),
                  rows_load(l[0].a.body->position, l[1].a.body->position, l[2].a.body->position, l[3].a.body->position, &unused));
}

SIMD_INLINE void distances_out(struct x3 on_a, struct x3 v, v4 distance, v4 least, m4 sure, struct distance4 *out)
{
    rows_store(out->on_a[0], out->on_a[1], out->on_a[2], out->on_a[3], on_a, distance);
    rows_store(out->way[0], out->way[1], out->way[2], out->way[3], v, least);
    out->sure = m4_bits(sure);
}

/* Each has one to three corners to begin with. No others are nearer if none is along v. */
SIMD_INLINE void distance_again4(const struct looked l[4], struct distance4 *out)
{
    struct x3 on_a[3], w[3], apart = centres_apart(l);
    v4 share[3], count = v4_set(l[0].pair->cache.count, l[1].pair->cache.count, l[2].pair->cache.count, l[3].pair->cache.count);
    for (int k = 0; k < 3; k++) {
        nearest_corners(l, k, &on_a[k], &w[k]);
        w[k] = x3_add(x3_sub(w[k], on_a[k]), apart);
    }
    m4 within = shares_of(w, count, share);
    struct x3 v = x3_scale(w[0], share[0]), at = x3_scale(on_a[0], share[0]);
    for (int k = 1; k < 3; k++) {
        v = x3_add(v, x3_scale(w[k], share[k]));
        at = x3_add(at, x3_scale(on_a[k], share[k]));
    }
    v4 size2 = squares_max(w), vv = x3_dot(v, v), distance = v4_sqrt(vv), least = least_along(l, v, x3_dot(v, apart));
    m4 sure = within & (vv > v4_all(TOUCHING) * size2) & (vv - least <= v4_all(ROUNDING) * size2);
    distances_out(at, v, distance, least / distance, sure, out);
}

/* Parts with one corner each. */
SIMD_INLINE void distance_round4(const struct looked l[4], struct distance4 *out)
{
    struct vec3 of_a[4], of_b[4];
    for (int i = 0; i < 4; i++) {
        of_a[i] = corner(&l[i].a, 0);
        of_b[i] = corner(&l[i].b, 0);
    }
    struct x3 a = side_by_side(of_a), b = side_by_side(of_b);
    struct x3 v = x3_add(x3_sub(b, a), centres_apart(l));
    v4 distance = v4_sqrt(x3_dot(v, v));
    distances_out(a, v, distance, distance, distance > v4_all(0), out);
}

#endif
