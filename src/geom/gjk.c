/* SPDX-License-Identifier: GPL-3.0-or-later */
/* GJK over vertex lists. The point of the simplex that is nearest to the origin
 * is found by looking at every vertex, edge, triangle and the tetrahedron in turn
 * and keeping the nearest that lies within its own: more arithmetic than walking
 * Voronoi regions, but nothing can be classified inconsistently. A face or
 * tetrahedron whose Gram determinant is rounding alone is passed over, so a flat
 * tetrahedron in a warm simplex never holds the origin: it counts as outside. */
#include "geom/gjk.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define FLAT      1e-12 // Gram determinant over the product of squared edges: below it the simplex is degenerate
#define CONVERGED 1e-13 // |v|^2 - v.w over |v|^2: no vertex is nearer by more than a part in 10^13
#define TOUCHING  1e-13 // distance over size below which cores touch

struct corner {
    struct vec3 w, a; // b's point - a's point; a's point
    uint8_t at_a, at_b;
};
struct simplex {
    struct corner corner[4];
    double share[4];
    int count;
};

static struct vec3 place(const struct gjk_core *c, size_t vertex, struct vec3 origin)
{
    return vec3_add(turn_out(&c->turn, vec3_load(c->vertex[vertex])), vec3_sub(c->centre, origin));
}

static uint8_t support(const struct gjk_core *c, struct vec3 direction)
{
    struct vec3 d = turn_in(&c->turn, direction);
    size_t best = 0;
    double most = -INFINITY;
    for (size_t k = 0; k < c->vertices; k++) {
        double height = vec3_dot(d, vec3_load(c->vertex[k]));
        if (height > most) {
            most = height;
            best = k;
        }
    }
    return (uint8_t)best;
}

static struct corner corner_of(const struct gjk_core *a, const struct gjk_core *b, uint8_t at_a, uint8_t at_b)
{
    struct corner c = {.a = place(a, at_a, a->centre), .at_a = at_a, .at_b = at_b};
    c.w = vec3_sub(place(b, at_b, a->centre), c.a);
    return c;
}

/* ---- the nearest point of a simplex ---- */

/* Shares of an edge's, a triangle's or a tetrahedron's corners in the point of its span that is nearest to the origin;
 * false when the simplex is flat or the point is not within it. Solves G s = -E x0 with G the Gram matrix of the edges. */
static bool edge_shares(const struct vec3 x[], double s[])
{
    struct vec3 e = vec3_sub(x[1], x[0]);
    double g = vec3_dot(e, e);
    if (!(g > 0))
        return false;
    s[1] = -vec3_dot(e, x[0]) / g;
    s[0] = 1 - s[1];
    return s[0] > 0 && s[1] > 0;
}
static bool triangle_shares(const struct vec3 x[], double s[])
{
    struct vec3 e = vec3_sub(x[1], x[0]), f = vec3_sub(x[2], x[0]), n = vec3_cross(e, f);
    double nn = vec3_dot(n, n);
    if (!(nn > FLAT * vec3_dot(e, e) * vec3_dot(f, f)))
        return false;
    struct vec3 p = vec3_scale(x[0], -1);
    s[1] = vec3_dot(vec3_cross(p, f), n) / nn;
    s[2] = vec3_dot(vec3_cross(e, p), n) / nn;
    s[0] = 1 - s[1] - s[2];
    return s[0] > 0 && s[1] > 0 && s[2] > 0;
}
static bool tetrahedron_shares(const struct vec3 x[], double s[])
{
    struct vec3 e = vec3_sub(x[1], x[0]), f = vec3_sub(x[2], x[0]), g = vec3_sub(x[3], x[0]), fg = vec3_cross(f, g);
    double det = vec3_dot(e, fg);
    if (!(det * det > FLAT * vec3_dot(e, e) * vec3_dot(f, f) * vec3_dot(g, g)))
        return false;
    struct vec3 p = vec3_scale(x[0], -1);
    s[1] = vec3_dot(p, fg) / det;
    s[2] = vec3_dot(e, vec3_cross(p, g)) / det;
    s[3] = vec3_dot(e, vec3_cross(f, p)) / det;
    s[0] = 1 - s[1] - s[2] - s[3];
    return s[0] > 0 && s[1] > 0 && s[2] > 0 && s[3] > 0;
}

static bool shares_of(const struct vec3 x[], int count, double s[])
{
    switch (count) {
    case 1:
        s[0] = 1;
        return true;
    case 2:
        return edge_shares(x, s);
    case 3:
        return triangle_shares(x, s);
    default:
        return tetrahedron_shares(x, s);
    }
}

/* Reduces the simplex to the part that holds its nearest point, which it returns, among those with all corners of `must`:
 * the corner just found is always one. Keeps no corner when rounding leaves none that does. */
static struct vec3 nearest(struct simplex *s, unsigned must)
{
    struct simplex best = {.count = 0};
    struct vec3 nearest = {0, 0, 0};
    double least = INFINITY;
    /* A point of the whole span that lies within is nearest of all: the usual case of a warm simplex, at the price of one set. */
    const struct vec3 all[4] = {s->corner[0].w, s->corner[1].w, s->corner[2].w, s->corner[3].w};
    if (shares_of(all, s->count, s->share)) {
        for (int k = 0; k < s->count && s->count < 4; k++)
            nearest = vec3_add(nearest, vec3_scale(all[k], s->share[k]));
        return nearest;
    }
    for (unsigned set = 1; set + 1 < 1U << s->count; set++) {
        struct simplex part = {.count = 0};
        struct vec3 x[4], v = {0, 0, 0};
        if ((set & must) != must)
            continue;
        for (int k = 0; k < s->count; k++)
            if (set >> k & 1) {
                x[part.count] = s->corner[k].w;
                part.corner[part.count++] = s->corner[k];
            }
        if (!shares_of(x, part.count, part.share))
            continue;
        for (int k = 0; k < part.count; k++)
            v = vec3_add(v, vec3_scale(x[k], part.share[k]));
        double vv = vec3_dot(v, v);
        if (vv < least) {
            least = vv;
            nearest = v;
            best = part;
        }
    }
    *s = best;
    return nearest;
}

/* ---- the search ---- */

static void start(const struct gjk_core *a, const struct gjk_core *b, const struct gjk_cache *cache, struct simplex *s)
{
    s->count = 0;
    for (int k = 0; k < cache->count && k < 4; k++)
        if (cache->a[k] < a->vertices && cache->b[k] < b->vertices)
            s->corner[s->count++] = corner_of(a, b, cache->a[k], cache->b[k]);
    if (s->count == 0)
        s->corner[s->count++] = corner_of(a, b, 0, 0);
}

static bool holds(const struct simplex *s, const struct corner *c)
{
    for (int k = 0; k < s->count; k++)
        if (s->corner[k].at_a == c->at_a && s->corner[k].at_b == c->at_b)
            return true;
    return false;
}

static void conclude(const struct gjk_core *a, const struct simplex *s, struct vec3 v, double vv, struct gjk_cache *cache,
                     struct gjk_result *out)
{
    struct vec3 on_a = {0, 0, 0};
    cache->count = (uint8_t)s->count;
    for (int k = 0; k < s->count; k++) {
        cache->a[k] = s->corner[k].at_a;
        cache->b[k] = s->corner[k].at_b;
        on_a = vec3_add(on_a, vec3_scale(s->corner[k].a, s->share[k]));
    }
    out->distance = sqrt(vv);
    out->on_a = vec3_add(a->centre, on_a);
    out->on_b = vec3_add(out->on_a, v);
    out->normal = vv > 0 ? vec3_scale(v, 1 / out->distance) : (struct vec3){0, 0, 0};
}

enum gjk_state gjk_distance(const struct gjk_core *a, const struct gjk_core *b, struct gjk_cache *cache, struct gjk_result *out)
{
    struct simplex s = {.count = 0};
    start(a, b, cache, &s);
    double size2 = 0;
    struct vec3 v = nearest(&s, 0);
    double vv = vec3_dot(v, v);
    enum gjk_state state = GJK_UNSURE;
    for (out->iterations = 1; out->iterations <= GJK_ITERATIONS; out->iterations++) {
        for (int k = 0; k < s.count; k++)
            size2 = fmax(size2, vec3_dot(s.corner[k].w, s.corner[k].w));
        if (s.count == 4 || vv <= TOUCHING * TOUCHING * size2) {
            state = GJK_INSIDE;
            break;
        }
        struct corner c = corner_of(a, b, support(a, v), support(b, vec3_scale(v, -1)));
        /* w's own rounding is a share of its size: below that nothing is nearer. */
        double gain = vv - vec3_dot(v, c.w), rounding = 1e-15 * sqrt(vv * fmax(size2, vec3_dot(c.w, c.w)));
        if (gain <= CONVERGED * vv + rounding || holds(&s, &c)) {
            state = GJK_APART;
            break;
        }
        struct simplex grown = s;
        grown.corner[grown.count++] = c;
        struct vec3 next = nearest(&grown, 1U << s.count);
        double nn = grown.count == 4 ? 0 : grown.count == 0 ? vv : vec3_dot(next, next);
        if (nn >= vv) { // rounding keeps the search from coming nearer
            state = GJK_APART;
            break;
        }
        s = grown;
        v = next;
        vv = nn;
    }
    conclude(a, &s, v, vv, cache, out);
    return state;
}
