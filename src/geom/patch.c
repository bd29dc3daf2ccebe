/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See patch.h. One face is cut by the planes through the other's edges along its
 * normal (Sutherland and Hodgman 1974). Of more corners than are kept those that
 * reach farthest in directions fixed to the face stand for all: which these are does
 * not change while the bodies rest. */
#include "geom/patch.h"

#include <math.h>

enum { OUTLINE_MAX = 2 * POLYHEDRON_VERTICES_MAX };
#define ALIGNED 1e-6 // cosines within which both faces are as good: it is a's then, whatever rounding says

struct outline {
    size_t corners;
    struct vec3 corner[OUTLINE_MAX];
};

static uint8_t facing(const struct patch_side *s, struct vec3 direction, double *aligned)
{
    struct vec3 d = turn_in(&s->turn, direction);
    size_t best = 0;
    *aligned = -INFINITY;
    for (size_t k = 0; k < s->part->faces; k++) {
        double along = vec3_dot(d, vec3_load(s->part->normal[k]));
        if (along > *aligned) {
            *aligned = along;
            best = k;
        }
    }
    return (uint8_t)best;
}

struct patch_faces patch_find(const struct patch_side *a, const struct patch_side *b, struct vec3 normal)
{
    struct patch_faces faces;
    double of_a, of_b;
    faces.a = facing(a, normal, &of_a);
    faces.b = facing(b, vec3_scale(normal, -1), &of_b);
    faces.plane = of_b > of_a + ALIGNED ? PATCH_ON_B : PATCH_ON_A;
    return faces;
}

static void outline_of(const struct patch_side *s, uint8_t face, struct outline *out)
{
    size_t first = s->part->first[face];
    out->corners = s->part->first[face + 1] - first;
    for (size_t k = 0; k < out->corners; k++)
        out->corner[k] = vec3_add(s->centre, turn_out(&s->turn, vec3_load(s->part->vertex[s->part->loop[first + k]])));
}

/* What lies on the inner side of a plane. */
static void cut(const struct outline *from, struct vec3 on, struct vec3 inwards, struct outline *to)
{
    to->corners = 0;
    for (size_t k = 0; k < from->corners; k++) {
        struct vec3 x = from->corner[k], y = from->corner[k + 1 < from->corners ? k + 1 : 0];
        double hx = vec3_dot(vec3_sub(x, on), inwards), hy = vec3_dot(vec3_sub(y, on), inwards);
        if (hx >= 0 && to->corners < OUTLINE_MAX)
            to->corner[to->corners++] = x;
        if ((hx >= 0) != (hy >= 0) && to->corners < OUTLINE_MAX)
            to->corner[to->corners++] = vec3_add(x, vec3_scale(vec3_sub(y, x), hx / (hx - hy)));
    }
}

/* What of `face` is over `base`, seen along base's normal. */
static void common(const struct outline *base, struct vec3 normal, struct outline *face)
{
    struct outline rest;
    for (size_t k = 0; k < base->corners && face->corners > 0; k++) {
        struct vec3 from = base->corner[k], to = base->corner[k + 1 < base->corners ? k + 1 : 0];
        cut(face, from, vec3_cross(normal, vec3_sub(to, from)), &rest);
        *face = rest;
    }
}

/* Keeps the corners that reach farthest in eight directions along the base: turned by a tenth from its first edge, since
 * shapes that are symmetric about it would tie. */
static void thin_out(const struct outline *base, struct vec3 normal, struct outline *face)
{
    static const double way[PATCH_POINTS_MAX][2] = {{0.995, 0.0998},   {0.633, 0.774},   {-0.0998, 0.995}, {-0.774, 0.633},
                                                    {-0.995, -0.0998}, {-0.633, -0.774}, {0.0998, -0.995}, {0.774, -0.633}};
    struct vec3 u = vec3_sub(base->corner[1], base->corner[0]), v = vec3_cross(normal, u);
    struct outline kept = {.corners = 0};
    bool taken[OUTLINE_MAX] = {false};
    for (size_t w = 0; w < PATCH_POINTS_MAX; w++) {
        struct vec3 d = vec3_add(vec3_scale(u, way[w][0]), vec3_scale(v, way[w][1]));
        size_t best = 0;
        for (size_t k = 1; k < face->corners; k++)
            if (vec3_dot(vec3_sub(face->corner[k], face->corner[best]), d) > 0)
                best = k;
        if (!taken[best])
            kept.corner[kept.corners++] = face->corner[best];
        taken[best] = true;
    }
    *face = kept;
}

/* Half the length of the sides that meet in a corner. */
static double weight_of(const struct outline *o, size_t k)
{
    struct vec3 before = vec3_sub(o->corner[k], o->corner[k > 0 ? k - 1 : o->corners - 1]);
    struct vec3 after = vec3_sub(o->corner[k + 1 < o->corners ? k + 1 : 0], o->corner[k]);
    return 0.5 * (sqrt(vec3_dot(before, before)) + sqrt(vec3_dot(after, after)));
}

/* Of the common part the corners lower than `most` over the base, the first `kept` numbers of at[]; none if one is not over it. */
static size_t pressing(const struct outline *base, struct vec3 normal, const struct outline *face, double most,
                       uint8_t at[OUTLINE_MAX])
{
    size_t kept = 0;
    for (size_t k = 0; k < face->corners; k++) {
        double height = vec3_dot(vec3_sub(face->corner[k], base->corner[0]), normal);
        if (height <= 0)
            return 0;
        if (height < most)
            at[kept++] = (uint8_t)k;
    }
    return kept;
}

static void share_out(struct patch *p)
{
    double first = 0, second = 0;
    for (size_t k = 0; k < p->points; k++) { // share: the weight yet
        first += p->point[k].share * p->point[k].overlap;
        second += p->point[k].share * p->point[k].overlap * p->point[k].overlap;
    }
    if (!(first > 0)) // a part without an extent
        p->points = 0;
    for (size_t k = 0; k < p->points; k++)
        p->point[k].share *= second / (first * first);
}

void patch_measure(const struct patch_side *a, const struct patch_side *b, struct patch_faces faces, struct patch *out)
{
    const bool on_b = faces.plane == PATCH_ON_B;
    const struct patch_side *under = on_b ? b : a, *over = on_b ? a : b;
    const uint8_t its = on_b ? faces.b : faces.a;
    const double crusts = a->part->radius + b->part->radius, thicker = over->part->radius - under->part->radius;
    const struct vec3 normal = turn_out(&under->turn, vec3_load(under->part->normal[its]));
    struct outline base, face;
    uint8_t at[OUTLINE_MAX];
    outline_of(under, its, &base);
    outline_of(over, on_b ? faces.a : faces.b, &face);
    common(&base, normal, &face);
    out->normal = on_b ? vec3_scale(normal, -1) : normal;
    out->points = pressing(&base, normal, &face, crusts, at);
    if (out->points > PATCH_POINTS_MAX) {
        thin_out(&base, normal, &face);
        out->points = pressing(&base, normal, &face, crusts, at);
    }
    for (size_t k = 0; k < out->points; k++) {
        struct vec3 x = face.corner[at[k]];
        double height = vec3_dot(vec3_sub(x, base.corner[0]), normal);
        out->point[k].overlap = crusts - height;
        /* Midway between the surfaces: back by half the height, and by half of what the upper crust is thicker. */
        out->point[k].at = vec3_sub(x, vec3_scale(normal, 0.5 * (height + thicker)));
        out->point[k].share = weight_of(&face, at[k]);
    }
    share_out(out);
}
