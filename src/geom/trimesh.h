/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Surfaces of triangles: walls of any shape, and the polyhedra that give clumps
 * their mass. A mesh is checked when it is made, so that whoever gets one may
 * rely on it: finite, no degenerate triangle, no edge with more than two
 * triangles, neighbours turning the same way round, closed where that was asked. */
#ifndef SCREE_GEOM_TRIMESH_H
#define SCREE_GEOM_TRIMESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct trimesh {
    size_t vertices, triangles;
    double (*vertex)[3];   // m
    uint32_t (*corner)[3]; // of each triangle, counter-clockwise seen from outside
    struct tree_node *node;
    size_t nodes;
    uint32_t *leaf; // triangles in the order of the tree's leaves
};

enum { TRIMESH_VERTICES_MAX = 1 << 24, TRIMESH_TRIANGLES_MAX = 1 << 24 };

/* Copies what it is given. Vertices at the same place, to the bit, become one.
 * SCREE_INVALID names the triangle at fault. Owned by the caller. */
enum scree_status trimesh_create(const double (*vertex)[3], size_t vertices, const uint32_t (*corner)[3], size_t triangles,
                                 bool closed, struct trimesh **out, struct scree_error *err);
void trimesh_free(struct trimesh *mesh);

/* A mesh out of the bytes of a file: STL, binary or ASCII, or OBJ (vertices and
 * faces; polygons are cut into fans; other statements of the format are passed
 * over, and anything that is not the format is refused with its line or
 * triangle). Lengths are in metres, times `scale`. */
enum scree_status trimesh_parse(const char *bytes, size_t size, double scale, bool closed, struct trimesh **out,
                                struct scree_error *err);
enum scree_status trimesh_read(const char *path, double scale, bool closed, struct trimesh **out, struct scree_error *err);

/* Whether it encloses a space: every edge has two triangles. */
enum scree_status trimesh_check_closed(const struct trimesh *mesh, struct scree_error *err);

/* Of the solid inside a closed mesh, for density 1. */
struct solid {
    double volume;     // m3; positive when triangles turn outwards
    double centre[3];  // of mass, m
    double inertia[6]; // about the centre: xx, yy, zz, xy, xz, yz of the tensor (products with their minus sign), kg m2
};
/* Exact: sums over the tetrahedra between the triangles and one vertex. */
struct solid trimesh_solid(const struct trimesh *mesh);

/* Where a triangle is nearest to a point: on its face, an edge or a vertex. */
struct nearest {
    double point[3];
    int feature; // 0: face; 1..3: edge from corner k - 1 to the next; 4..6: corner k - 4
};
struct nearest trimesh_nearest(const struct trimesh *mesh, uint32_t triangle, const double point[3]);

/* Triangles whose distance to the point may be below `radius`: a superset, by
 * bounding boxes, ascending. Writes at most `room`, returns how many there are. */
size_t trimesh_near(const struct trimesh *mesh, const double point[3], double radius, uint32_t *found, size_t room);

/* The bounding box of the whole mesh. */
void trimesh_bounds(const struct trimesh *mesh, double low[3], double high[3]);

/* trimesh_tree.c, called by trimesh_create. */
enum scree_status trimesh_plant(struct trimesh *mesh, struct scree_error *err);

#endif
