/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Small convex polyhedra, kept both as vertices and as half-spaces: vertices are
 * what distances are measured from, half-spaces are what can be shrunk and
 * intersected exactly. Everything here runs once, while a world is made, by
 * trying all triples: no case is special, and sizes are small. */
#ifndef SCREE_GEOM_POLYHEDRON_H
#define SCREE_GEOM_POLYHEDRON_H

#include <stddef.h>
#include <stdint.h>

#include "base/quat.h"
#include "base/status.h"

enum { POLYHEDRON_VERTICES_MAX = 64, POLYHEDRON_FACES_MAX = 96 };

struct polyhedron {
    size_t faces, vertices;
    double plane[POLYHEDRON_FACES_MAX][4];     // outward unit normal n and offset c: inside is n.x <= c, m
    double vertex[POLYHEDRON_VERTICES_MAX][3]; // m
};

/* Integrals over a body: of 1, of x, of x x^T (xx, yy, zz, xy, xz, yz), m3, m4, m5. */
struct moments {
    double volume, first[3], second[6];
};

/* A box of `size` about its centre. */
enum scree_status polyhedron_box(const double size[3], struct polyhedron *out, struct scree_error *err);

/* An upright regular prism about its centre; `sides` corners at `radius` from the axis z. */
enum scree_status polyhedron_prism(int sides, double radius, double height, struct polyhedron *out, struct scree_error *err);

/* From its corners. Refuses, by number, a vertex that is no corner of the hull
 * of all (a list that is not convex) and one given twice, and a list without volume. */
enum scree_status polyhedron_create(const double (*vertex)[3], size_t vertices, struct polyhedron *out, struct scree_error *err);

/* The same, turned by q and then moved. */
void polyhedron_place(const struct polyhedron *p, struct quat q, struct vec3 at, struct polyhedron *out);

/* Every face moved inwards by `depth`. Refuses when nothing is left. */
enum scree_status polyhedron_shrink(const struct polyhedron *p, double depth, struct polyhedron *out, struct scree_error *err);

/* What two have in common; out->vertices is 0 when that has no volume. */
enum scree_status polyhedron_intersect(const struct polyhedron *a, const struct polyhedron *b, struct polyhedron *out,
                                       struct scree_error *err);

/* A face's corners, as the numbers of vertices, counter-clockwise seen from outside; returns how many: none where planes of
 * others cut the face off. */
size_t polyhedron_face(const struct polyhedron *p, size_t face, uint8_t corner[POLYHEDRON_VERTICES_MAX]);

/* Exact, by tetrahedra over the faces. */
void polyhedron_moments(const struct polyhedron *p, struct moments *out);

#endif
