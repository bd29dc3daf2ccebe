/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See trimesh.h. Making, checking and integrating; the tree is in trimesh_tree.c. */
#include "geom/trimesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"

/* Twice the area over the longest edge squared below which a triangle is a line. */
#define FLATTEST 1e-9

/* ---- vertices at the same place become one ---- */

struct placed {
    double at[3];
    uint32_t index;
};

static int by_place(const void *a, const void *b)
{
    const struct placed *p = a, *q = b;
    for (int k = 0; k < 3; k++)
        if (p->at[k] != q->at[k])
            return p->at[k] < q->at[k] ? -1 : 1;
    return (p->index > q->index) - (p->index < q->index);
}

/* Fills the mesh's vertices, each place once, in the order of first mention, and `renamed` by old index. */
static enum scree_status weld(struct trimesh *mesh, const double (*vertex)[3], size_t count, uint32_t *renamed,
                              struct scree_error *err)
{
    struct placed *places = memory_rows(count, sizeof *places);
    uint32_t *first = memory_rows(count, sizeof *first);
    enum scree_status status = SCREE_OK;
    if (!places || !first) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu vertices", count);
        goto out;
    }
    for (size_t k = 0; k < count; k++) {
        for (int a = 0; a < 3; a++)
            places[k].at[a] = vertex[k][a] + 0.0; // one zero out of two
        places[k].index = (uint32_t)k;
    }
    qsort(places, count, sizeof *places, by_place);
    for (size_t k = 0; k < count; k++) {
        bool same = k > 0 && memcmp(places[k].at, places[k - 1].at, sizeof places->at) == 0;
        first[places[k].index] = same ? first[places[k - 1].index] : places[k].index;
    }
    for (size_t k = 0; k < count; k++) {
        if (first[k] != k) {
            renamed[k] = renamed[first[k]];
            continue;
        }
        renamed[k] = (uint32_t)mesh->vertices;
        memcpy(mesh->vertex[mesh->vertices++], vertex[k], sizeof *mesh->vertex);
    }
out:
    free(places);
    free(first);
    return status;
}

/* ---- checks ---- */

static struct vec3 corner_of(const struct trimesh *mesh, size_t triangle, int corner)
{
    return vec3_load(mesh->vertex[mesh->corner[triangle][corner]]);
}

static enum scree_status check_triangle(const struct trimesh *mesh, size_t t, struct scree_error *err)
{
    struct vec3 a = corner_of(mesh, t, 0), b = corner_of(mesh, t, 1), c = corner_of(mesh, t, 2);
    struct vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a), bc = vec3_sub(c, b), cross = vec3_cross(ab, ac);
    double longest = fmax(vec3_dot(ab, ab), fmax(vec3_dot(ac, ac), vec3_dot(bc, bc)));
    if (!isfinite(longest) || longest > 1e24)
        return scree_fail(err, SCREE_INVALID, NULL, "triangle %zu has a corner that is not a number or beyond 1e12 m", t);
    if (!(sqrt(vec3_dot(cross, cross)) > FLATTEST * longest))
        return scree_fail(err, SCREE_INVALID, NULL,
                          "triangle %zu is degenerate: its corners lie on a line (near %.6g, %.6g, %.6g m)", t, a.x, a.y, a.z);
    return SCREE_OK;
}

struct edge {
    uint32_t low, high, triangle;
    bool forward; // the triangle runs along it from low to high
};

static int by_ends(const void *a, const void *b)
{
    const struct edge *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    if (p->high != q->high)
        return p->high < q->high ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

/* One edge's triangles, edge[0 .. count). */
static enum scree_status check_edge(const struct trimesh *mesh, const struct edge *edge, size_t count, bool closed,
                                    struct scree_error *err)
{
    const double *x = mesh->vertex[edge->low];
    if (count > 2)
        return scree_fail(err, SCREE_INVALID, NULL,
                          "the mesh is not a surface: triangle %u shares its edge at %.6g, %.6g, %.6g m with %zu others",
                          edge[2].triangle, x[0], x[1], x[2], count - 1);
    if (count == 2 && edge[0].forward == edge[1].forward)
        return scree_fail(err, SCREE_INVALID, NULL, "triangle %u is turned the other way round than its neighbour %u",
                          edge[1].triangle, edge[0].triangle);
    if (count == 1 && closed)
        return scree_fail(err, SCREE_INVALID, NULL,
                          "the mesh is open: triangle %u has no neighbour along its edge at %.6g, %.6g, %.6g m", edge->triangle,
                          x[0], x[1], x[2]);
    return SCREE_OK;
}

static enum scree_status check_edges(const struct trimesh *mesh, bool closed, struct scree_error *err)
{
    size_t count = 3 * mesh->triangles;
    struct edge *edges = memory_rows(count, sizeof *edges);
    if (!edges)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu edges", count);
    for (size_t t = 0; t < mesh->triangles; t++)
        for (int k = 0; k < 3; k++) {
            uint32_t p = mesh->corner[t][k], q = mesh->corner[t][(k + 1) % 3];
            edges[3 * t + (size_t)k] = (struct edge){p < q ? p : q, p < q ? q : p, (uint32_t)t, p < q};
        }
    qsort(edges, count, sizeof *edges, by_ends);
    enum scree_status status = SCREE_OK;
    for (size_t k = 0, end; k < count && !status; k = end) {
        for (end = k + 1; end < count && edges[end].low == edges[k].low && edges[end].high == edges[k].high; end++)
            ;
        status = check_edge(mesh, &edges[k], end - k, closed, err);
    }
    free(edges);
    return status;
}

enum scree_status trimesh_check_closed(const struct trimesh *mesh, struct scree_error *err)
{
    return check_edges(mesh, true, err);
}

static enum scree_status take_corners(struct trimesh *mesh, const uint32_t (*corner)[3], size_t vertices, const uint32_t *renamed,
                                      struct scree_error *err)
{
    for (size_t t = 0; t < mesh->triangles; t++) {
        for (int k = 0; k < 3; k++) {
            if (corner[t][k] >= vertices)
                return scree_fail(err, SCREE_INVALID, NULL, "triangle %zu names vertex %u of %zu", t, corner[t][k], vertices);
            mesh->corner[t][k] = renamed[corner[t][k]];
        }
        enum scree_status status = check_triangle(mesh, t, err);
        if (status)
            return status;
    }
    return SCREE_OK;
}

enum scree_status trimesh_create(const double (*vertex)[3], size_t vertices, const uint32_t (*corner)[3], size_t triangles,
                                 bool closed, struct trimesh **out, struct scree_error *err)
{
    if (triangles == 0)
        return scree_fail(err, SCREE_INVALID, NULL, "the mesh has no triangle");
    if (vertices > TRIMESH_VERTICES_MAX || triangles > TRIMESH_TRIANGLES_MAX)
        return scree_fail(err, SCREE_INVALID, NULL, "%zu vertices and %zu triangles: at most %d of each are taken", vertices,
                          triangles, TRIMESH_TRIANGLES_MAX);
    struct trimesh *mesh = memory_rows(1, sizeof *mesh);
    uint32_t *renamed = memory_rows(vertices, sizeof *renamed);
    enum scree_status status = SCREE_OK;
    if (mesh) {
        mesh->triangles = triangles;
        mesh->vertex = memory_rows(vertices, sizeof *mesh->vertex);
        mesh->corner = memory_rows(triangles, sizeof *mesh->corner);
    }
    if (!mesh || !renamed || !mesh->vertex || !mesh->corner)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a mesh of %zu triangles", triangles);
    for (size_t k = 0; k < vertices && !status; k++)
        if (!isfinite(vertex[k][0] + vertex[k][1] + vertex[k][2]))
            status = scree_fail(err, SCREE_INVALID, NULL, "vertex %zu of the mesh is not a number", k);
    if (!status && !(status = weld(mesh, vertex, vertices, renamed, err)) &&
        !(status = take_corners(mesh, corner, vertices, renamed, err)) && !(status = check_edges(mesh, closed, err)))
        status = trimesh_plant(mesh, err);
    free(renamed);
    if (status)
        trimesh_free(mesh);
    else
        *out = mesh;
    return status;
}

void trimesh_free(struct trimesh *mesh)
{
    if (!mesh)
        return;
    free(mesh->vertex);
    free(mesh->corner);
    free(mesh->node);
    free(mesh->leaf);
    free(mesh);
}

void trimesh_bounds(const struct trimesh *mesh, double low[3], double high[3])
{
    for (int a = 0; a < 3; a++) {
        low[a] = INFINITY;
        high[a] = -INFINITY;
        for (size_t k = 0; k < mesh->vertices; k++) {
            low[a] = fmin(low[a], mesh->vertex[k][a]);
            high[a] = fmax(high[a], mesh->vertex[k][a]);
        }
    }
}

/* A tetrahedron (0, a, b, c) of density 1 has volume V = a.(b x c) / 6 and second
 * moments int x x^T = V / 20 (a a^T + b b^T + c c^T + s s^T), s = a + b + c.
 * Taken from one vertex of the mesh rather than from the origin, so that a body
 * far from it loses no figures. */
struct solid trimesh_solid(const struct trimesh *mesh)
{
    const struct vec3 origin = vec3_load(mesh->vertex[0]);
    double volume = 0, first[3] = {0}, second[3][3] = {{0}};
    for (size_t t = 0; t < mesh->triangles; t++) {
        double x[4][3];
        for (int k = 0; k < 3; k++)
            vec3_store3(x[k], vec3_sub(corner_of(mesh, t, k), origin));
        struct vec3 a = vec3_load(x[0]), b = vec3_load(x[1]), c = vec3_load(x[2]);
        vec3_store3(x[3], vec3_add(vec3_add(a, b), c));
        double v = vec3_dot(a, vec3_cross(b, c)) / 6;
        volume += v;
        for (int i = 0; i < 3; i++) {
            first[i] += v / 4 * x[3][i];
            for (int j = 0; j < 3; j++)
                for (int k = 0; k < 4; k++)
                    second[i][j] += v / 20 * x[k][i] * x[k][j];
        }
    }
    struct solid solid = {.volume = volume};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            second[i][j] -= first[i] * first[j] / volume;
    double trace = second[0][0] + second[1][1] + second[2][2];
    const int pair[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    for (int i = 0; i < 3; i++) {
        solid.inertia[i] = trace - second[i][i];
        solid.inertia[3 + i] = -second[pair[i][0]][pair[i][1]];
        solid.centre[i] = mesh->vertex[0][i] + first[i] / volume;
    }
    return solid;
}
