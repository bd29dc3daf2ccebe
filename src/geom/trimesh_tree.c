/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A tree of bounding boxes over a mesh's triangles, and the point of a triangle
 * nearest to another. The tree only ever narrows down which triangles are looked
 * at; what is found is sorted, so its shape cannot show in any result. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "geom/trimesh.h"

/* An inner node's children are `first` and `first + 1`; a leaf (count > 0) holds
 * leaf[first .. first + count). */
struct tree_node {
    double low[3], high[3];
    uint32_t first, count;
};
enum { LEAF_TRIANGLES = 4 };

struct middle { // of a triangle's bounding box
    double at[3];
    uint32_t triangle;
};

static void widen(const struct trimesh *mesh, const struct middle *items, size_t count, struct tree_node *node)
{
    for (int a = 0; a < 3; a++) {
        node->low[a] = INFINITY;
        node->high[a] = -INFINITY;
    }
    for (size_t k = 0; k < count; k++)
        for (int c = 0; c < 3; c++)
            for (int a = 0; a < 3; a++) {
                double x = mesh->vertex[mesh->corner[items[k].triangle][c]][a];
                node->low[a] = fmin(node->low[a], x);
                node->high[a] = fmax(node->high[a], x);
            }
}

static int by_x(const void *a, const void *b)
{
    const struct middle *p = a, *q = b;
    if (p->at[0] != q->at[0])
        return p->at[0] < q->at[0] ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}
static int by_y(const void *a, const void *b)
{
    const struct middle *p = a, *q = b;
    if (p->at[1] != q->at[1])
        return p->at[1] < q->at[1] ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}
static int by_z(const void *a, const void *b)
{
    const struct middle *p = a, *q = b;
    if (p->at[2] != q->at[2])
        return p->at[2] < q->at[2] ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

/* Halves the triangles along the longest side of their box; depth is log2 of their number. */
static void split(struct trimesh *mesh, struct middle *items, size_t from, size_t count, uint32_t at)
{
    static int (*const along[3])(const void *, const void *) = {by_x, by_y, by_z};
    struct tree_node *node = &mesh->node[at];
    widen(mesh, items + from, count, node);
    if (count <= LEAF_TRIANGLES) {
        node->first = (uint32_t)from;
        node->count = (uint32_t)count;
        return;
    }
    int axis = 0;
    for (int a = 1; a < 3; a++)
        if (node->high[a] - node->low[a] > node->high[axis] - node->low[axis])
            axis = a;
    qsort(items + from, count, sizeof *items, along[axis]);
    uint32_t child = (uint32_t)mesh->nodes;
    node->first = child;
    node->count = 0;
    mesh->nodes += 2;
    split(mesh, items, from, count / 2, child);
    split(mesh, items, from + count / 2, count - count / 2, child + 1);
}

enum scree_status trimesh_plant(struct trimesh *mesh, struct scree_error *err)
{
    struct middle *items = memory_rows(mesh->triangles, sizeof *items);
    mesh->node = memory_rows(2 * mesh->triangles, sizeof *mesh->node);
    mesh->leaf = memory_rows(mesh->triangles, sizeof *mesh->leaf);
    if (!items || !mesh->node || !mesh->leaf) {
        free(items);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the tree of %zu triangles", mesh->triangles);
    }
    for (size_t t = 0; t < mesh->triangles; t++) {
        struct tree_node box;
        items[t].triangle = (uint32_t)t;
        widen(mesh, &items[t], 1, &box);
        for (int a = 0; a < 3; a++)
            items[t].at[a] = 0.5 * (box.low[a] + box.high[a]);
    }
    mesh->nodes = 1;
    split(mesh, items, 0, mesh->triangles, 0);
    for (size_t t = 0; t < mesh->triangles; t++)
        mesh->leaf[t] = items[t].triangle;
    free(items);
    return SCREE_OK;
}

static double distance2_to_box(const double low[3], const double high[3], const double point[3])
{
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        double out = low[a] > point[a] ? low[a] - point[a] : point[a] > high[a] ? point[a] - high[a] : 0;
        sum += out * out;
    }
    return sum;
}

size_t trimesh_near(const struct trimesh *mesh, const double point[3], double radius, uint32_t *found, size_t room)
{
    uint32_t stack[64]; // the tree is balanced: at most 24 + 2 deep
    size_t depth = 0, count = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const struct tree_node *node = &mesh->node[stack[--depth]];
        if (distance2_to_box(node->low, node->high, point) > radius * radius)
            continue;
        if (node->count == 0) {
            stack[depth++] = node->first;
            stack[depth++] = node->first + 1;
            continue;
        }
        for (uint32_t k = 0; k < node->count; k++, count++) {
            if (count >= room)
                continue;
            size_t at = count;
            uint32_t t = mesh->leaf[node->first + k];
            for (; at > 0 && found[at - 1] > t; at--)
                found[at] = found[at - 1];
            found[at] = t;
        }
    }
    return count;
}

/* Which part of the triangle's plane the point projects to, by signs of dot
 * products (the regions of its corners, edges and face), as in Ericson's
 * Real-Time Collision Detection, 5.1.5. */
struct nearest trimesh_nearest(const struct trimesh *mesh, uint32_t triangle, const double point[3])
{
    const uint32_t *corner = mesh->corner[triangle];
    struct vec3 p = vec3_load(point), a = vec3_load(mesh->vertex[corner[0]]), b = vec3_load(mesh->vertex[corner[1]]),
                c = vec3_load(mesh->vertex[corner[2]]);
    struct vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a), ap = vec3_sub(p, a), bp = vec3_sub(p, b), cp = vec3_sub(p, c), at;
    struct nearest out;
    double d1 = vec3_dot(ab, ap), d2 = vec3_dot(ac, ap), d3 = vec3_dot(ab, bp), d4 = vec3_dot(ac, bp), d5 = vec3_dot(ab, cp),
           d6 = vec3_dot(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0 && d2 <= 0) {
        at = a;
        out.feature = 4;
    } else if (d3 >= 0 && d4 <= d3) {
        at = b;
        out.feature = 5;
    } else if (d6 >= 0 && d5 <= d6) {
        at = c;
        out.feature = 6;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        at = vec3_add(a, vec3_scale(ab, d1 / (d1 - d3)));
        out.feature = 1;
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        at = vec3_add(a, vec3_scale(ac, d2 / (d2 - d6)));
        out.feature = 3;
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        at = vec3_add(b, vec3_scale(vec3_sub(c, b), w));
        out.feature = 2;
    } else {
        /* On the face: the foot of the perpendicular. By the normal rather than by
         * barycentric weights, so that on a flat of many triangles the height above
         * it does not feel which one is asked. */
        struct vec3 n = vec3_cross(ab, ac);
        at = vec3_sub(p, vec3_scale(n, vec3_dot(ap, n) / vec3_dot(n, n)));
        out.feature = 0;
    }
    vec3_store3(out.point, at);
    return out;
}
