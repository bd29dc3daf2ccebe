/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Convex polyhedra by trial of all triples: three vertices may span a face, three
 * planes may meet in a vertex. O(n^4), for n < 100 and once a world: slower than
 * an incremental hull and free of its special cases. Tolerances are shares of the
 * body's own extent, so that a body of 0.1 mm is treated as one of 1 m. */
#include "geom/polyhedron.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#define SAME 1e-10 // share of the extent within which points and planes are one

static double extent_of(const double (*vertex)[3], size_t vertices)
{
    double extent = 0;
    for (size_t k = 1; k < vertices; k++)
        for (int i = 0; i < 3; i++)
            extent = fmax(extent, fabs(vertex[k][i] - vertex[0][i]));
    return extent;
}

static bool add_plane(struct polyhedron *p, const double plane[4], double extent)
{
    for (size_t k = 0; k < p->faces; k++) {
        const double *q = p->plane[k];
        double turned = fabs(q[0] - plane[0]) + fabs(q[1] - plane[1]) + fabs(q[2] - plane[2]);
        if (turned < 1e-8 && fabs(q[3] - plane[3]) < 1e-8 * extent)
            return true;
    }
    if (p->faces == POLYHEDRON_FACES_MAX)
        return false;
    memcpy(p->plane[p->faces++], plane, sizeof *p->plane);
    return true;
}

/* The plane through three vertices, outwards, if all others lie behind it. */
static bool spans_face(const double (*vertex)[3], size_t vertices, const size_t at[3], double extent, double plane[4])
{
    struct vec3 a = vec3_load(vertex[at[0]]);
    struct vec3 n = vec3_cross(vec3_sub(vec3_load(vertex[at[1]]), a), vec3_sub(vec3_load(vertex[at[2]]), a));
    double length = sqrt(vec3_dot(n, n));
    if (length <= 1e-8 * extent * extent)
        return false;
    n = vec3_scale(n, 1 / length);
    bool before = false, behind = false;
    for (size_t k = 0; k < vertices; k++) {
        double height = vec3_dot(n, vec3_sub(vec3_load(vertex[k]), a));
        before = before || height > SAME * extent;
        behind = behind || height < -SAME * extent;
    }
    if (before == behind) // the plane cuts the body, or all lie in it
        return false;
    if (before)
        n = vec3_scale(n, -1);
    vec3_store3(plane, n);
    plane[3] = vec3_dot(n, a);
    return true;
}

/* A corner lies on three faces whose normals span space. */
static bool is_corner(const struct polyhedron *p, size_t vertex, double extent)
{
    struct vec3 x = vec3_load(p->vertex[vertex]), on[POLYHEDRON_FACES_MAX];
    size_t count = 0;
    for (size_t k = 0; k < p->faces; k++) {
        struct vec3 n = vec3_load(p->plane[k]);
        if (fabs(vec3_dot(n, x) - p->plane[k][3]) < 1e-8 * extent)
            on[count++] = n;
    }
    for (size_t a = 0; a < count; a++)
        for (size_t b = 0; b < a; b++)
            for (size_t c = 0; c < b; c++)
                if (fabs(vec3_dot(on[a], vec3_cross(on[b], on[c]))) > 1e-9)
                    return true;
    return false;
}

static enum scree_status find_faces(struct polyhedron *p, double extent, struct scree_error *err)
{
    size_t n = p->vertices, at[3];
    double plane[4];
    for (at[0] = 0; at[0] < n; at[0]++)
        for (at[1] = 0; at[1] < at[0]; at[1]++)
            for (at[2] = 0; at[2] < at[1]; at[2]++)
                if (spans_face((const double(*)[3])p->vertex, n, at, extent, plane) && !add_plane(p, plane, extent))
                    return scree_fail(err, SCREE_INVALID, NULL, "a body has more than %d faces", POLYHEDRON_FACES_MAX);
    return SCREE_OK;
}

enum scree_status polyhedron_create(const double (*vertex)[3], size_t vertices, struct polyhedron *out, struct scree_error *err)
{
    if (vertices < 4 || vertices > POLYHEDRON_VERTICES_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "a convex body has 4 to %d vertices, not %zu", POLYHEDRON_VERTICES_MAX,
                          vertices);
    for (size_t k = 0; k < vertices; k++)
        for (int i = 0; i < 3; i++)
            if (!isfinite(vertex[k][i]))
                return scree_fail(err, SCREE_INVALID, NULL, "vertex %zu is not finite", k);
    *out = (struct polyhedron){.vertices = vertices};
    memcpy(out->vertex, vertex, vertices * sizeof *vertex);
    double extent = extent_of(vertex, vertices);
    enum scree_status status = find_faces(out, extent, err);
    if (status)
        return status;
    struct moments m;
    polyhedron_moments(out, &m);
    if (out->faces < 4 || !(m.volume > 1e-9 * extent * extent * extent))
        return scree_fail(err, SCREE_INVALID, NULL, "a convex body of %zu vertices has no volume", vertices);
    for (size_t k = 0; k < vertices; k++) {
        for (size_t other = 0; other < k; other++)
            if (extent_of((const double(*)[3])(const double[2][3]){{vertex[k][0], vertex[k][1], vertex[k][2]},
                                                                   {vertex[other][0], vertex[other][1], vertex[other][2]}},
                          2) < SAME * extent)
                return scree_fail(err, SCREE_INVALID, NULL, "vertices %zu and %zu are the same point", other, k);
        if (!is_corner(out, k, extent))
            return scree_fail(err, SCREE_INVALID, NULL, "vertex %zu is no corner of the hull of all: the list is not convex", k);
    }
    return SCREE_OK;
}

enum scree_status polyhedron_box(const double size[3], struct polyhedron *out, struct scree_error *err)
{
    double vertex[8][3];
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++)
            vertex[k][i] = (k >> i & 1 ? 0.5 : -0.5) * size[i];
    return polyhedron_create((const double(*)[3])vertex, 8, out, err);
}

enum scree_status polyhedron_prism(int sides, double radius, double height, struct polyhedron *out, struct scree_error *err)
{
    double vertex[POLYHEDRON_VERTICES_MAX][3];
    if (sides < 3 || sides > POLYHEDRON_VERTICES_MAX / 2)
        return scree_fail(err, SCREE_INVALID, NULL, "a prism has 3 to %d sides, not %d", POLYHEDRON_VERTICES_MAX / 2, sides);
    for (int k = 0; k < 2 * sides; k++) {
        double angle = 2 * M_PI * (k / 2) / sides;
        vertex[k][0] = radius * cos(angle);
        vertex[k][1] = radius * sin(angle);
        vertex[k][2] = (k % 2 ? 0.5 : -0.5) * height;
    }
    return polyhedron_create((const double(*)[3])vertex, 2 * (size_t)sides, out, err);
}

void polyhedron_place(const struct polyhedron *p, struct quat q, struct vec3 at, struct polyhedron *out)
{
    struct turn t = quat_turn(q);
    struct polyhedron placed = *p;
    for (size_t k = 0; k < p->vertices; k++)
        vec3_store3(placed.vertex[k], vec3_add(turn_out(&t, vec3_load(p->vertex[k])), at));
    for (size_t k = 0; k < p->faces; k++) {
        struct vec3 n = turn_out(&t, vec3_load(p->plane[k]));
        vec3_store3(placed.plane[k], n);
        placed.plane[k][3] = p->plane[k][3] + vec3_dot(n, at);
    }
    *out = placed;
}

/* ---- from planes to vertices ---- */

/* Where three planes meet; false when they do so nowhere, or badly. */
static bool meet(const double *p, const double *q, const double *r, struct vec3 *x)
{
    struct vec3 a = vec3_load(p), b = vec3_load(q), c = vec3_load(r), bc = vec3_cross(b, c);
    double det = vec3_dot(a, bc);
    if (fabs(det) < 1e-9)
        return false;
    struct vec3 sum = vec3_add(vec3_scale(bc, p[3]), vec3_scale(vec3_cross(c, a), q[3]));
    *x = vec3_scale(vec3_add(sum, vec3_scale(vec3_cross(a, b), r[3])), 1 / det);
    return true;
}

static bool is_new_vertex(const struct polyhedron *p, struct vec3 x, double extent)
{
    for (size_t k = 0; k < p->faces; k++)
        if (vec3_dot(vec3_load(p->plane[k]), x) > p->plane[k][3] + SAME * extent)
            return false;
    for (size_t k = 0; k < p->vertices; k++) {
        struct vec3 d = vec3_sub(x, vec3_load(p->vertex[k]));
        if (vec3_dot(d, d) < 1e-16 * extent * extent)
            return false;
    }
    return true;
}

/* Vertices anew from planes; none when what the planes enclose has no volume. */
static enum scree_status find_vertices(struct polyhedron *p, double extent, struct scree_error *err)
{
    struct vec3 x;
    p->vertices = 0;
    for (size_t a = 0; a < p->faces; a++)
        for (size_t b = 0; b < a; b++)
            for (size_t c = 0; c < b; c++) {
                if (!meet(p->plane[a], p->plane[b], p->plane[c], &x) || !is_new_vertex(p, x, extent))
                    continue;
                if (p->vertices == POLYHEDRON_VERTICES_MAX)
                    return scree_fail(err, SCREE_INVALID, NULL, "a body has more than %d vertices", POLYHEDRON_VERTICES_MAX);
                vec3_store3(p->vertex[p->vertices++], x);
            }
    struct moments m = {0};
    if (p->vertices >= 4)
        polyhedron_moments(p, &m);
    if (!(m.volume > 1e-9 * extent * extent * extent))
        p->vertices = 0;
    return SCREE_OK;
}

enum scree_status polyhedron_shrink(const struct polyhedron *p, double depth, struct polyhedron *out, struct scree_error *err)
{
    double extent = extent_of(p->vertex, p->vertices);
    *out = *p;
    for (size_t k = 0; k < p->faces; k++)
        out->plane[k][3] -= depth;
    enum scree_status status = find_vertices(out, extent, err);
    if (!status && out->vertices == 0)
        return scree_fail(err, SCREE_INVALID, NULL, "a crust of %g m leaves nothing of a body of %g m", depth, extent);
    return status;
}

enum scree_status polyhedron_intersect(const struct polyhedron *a, const struct polyhedron *b, struct polyhedron *out,
                                       struct scree_error *err)
{
    double extent = fmax(extent_of(a->vertex, a->vertices), extent_of(b->vertex, b->vertices));
    *out = *a;
    for (size_t k = 0; k < b->faces; k++)
        if (!add_plane(out, b->plane[k], extent))
            return scree_fail(err, SCREE_INVALID, NULL, "the common part of two bodies has more than %d faces",
                              POLYHEDRON_FACES_MAX);
    return find_vertices(out, extent, err);
}

/* ---- moments ---- */

/* Adds the tetrahedron (0, a, b, c): its volume is det / 6, the mean of x x^T over
 * it (sum of its corners' x x^T + s s^T) / 20 with s the corners' sum. */
static void add_tetrahedron(struct moments *m, struct vec3 a, struct vec3 b, struct vec3 c)
{
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    double det = vec3_dot(a, vec3_cross(b, c)), x[3][3], s[3];
    vec3_store3(x[0], a);
    vec3_store3(x[1], b);
    vec3_store3(x[2], c);
    m->volume += det / 6;
    for (int i = 0; i < 3; i++) {
        s[i] = x[0][i] + x[1][i] + x[2][i];
        m->first[i] += det / 24 * s[i];
    }
    for (int k = 0; k < 6; k++) {
        int i = row[k], j = column[k];
        m->second[k] += det / 120 * (x[0][i] * x[0][j] + x[1][i] * x[1][j] + x[2][i] * x[2][j] + s[i] * s[j]);
    }
}

size_t polyhedron_face(const struct polyhedron *p, size_t face, uint8_t corner[POLYHEDRON_VERTICES_MAX])
{
    const struct vec3 n = vec3_load(p->plane[face]);
    const double extent = extent_of((const double(*)[3])p->vertex, p->vertices);
    size_t count = 0;
    for (size_t k = 0; k < p->vertices; k++)
        if (fabs(vec3_dot(n, vec3_load(p->vertex[k])) - p->plane[face][3]) < 1e-8 * extent)
            corner[count++] = (uint8_t)k;
    /* Each next one leaves all others on its left. */
    for (size_t k = 1; k + 1 < count; k++)
        for (size_t other = k + 1; other < count; other++) {
            struct vec3 from = vec3_load(p->vertex[corner[k - 1]]);
            struct vec3 side =
                vec3_cross(vec3_sub(vec3_load(p->vertex[corner[k]]), from), vec3_sub(vec3_load(p->vertex[corner[other]]), from));
            if (vec3_dot(side, n) < 0) {
                uint8_t kept = corner[k];
                corner[k] = corner[other];
                corner[other] = kept;
            }
        }
    return count;
}

void polyhedron_moments(const struct polyhedron *p, struct moments *out)
{
    assert(p->vertices > 0);
    uint8_t at[POLYHEDRON_VERTICES_MAX];
    *out = (struct moments){0};
    for (size_t face = 0; face < p->faces; face++) {
        size_t count = polyhedron_face(p, face, at);
        for (size_t k = 1; k + 1 < count; k++)
            add_tetrahedron(out, vec3_load(p->vertex[at[0]]), vec3_load(p->vertex[at[k]]), vec3_load(p->vertex[at[k + 1]]));
    }
}
