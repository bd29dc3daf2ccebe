/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rigid bodies made of convex parts that may overlap. Volume, mass and inertia
 * count what parts share once, exactly, by inclusion and exclusion. What touches
 * is each part's core, shrunk by a crust, with that crust around it: as in the
 * published code of seed 001 two bodies are in contact while their cores are
 * still apart. Corners are rounded by the crust; the mass is the sharp body's. */
#ifndef SCREE_GEOM_COMPOSITE_H
#define SCREE_GEOM_COMPOSITE_H

#include "geom/polyhedron.h"

enum { COMPOSITE_PARTS_MAX = 16, COMPOSITE_LOOP_MAX = 2 * (POLYHEDRON_VERTICES_MAX + POLYHEDRON_FACES_MAX) }; // Euler: 2 E

struct composite_part {
    size_t vertices;
    double vertex[POLYHEDRON_VERTICES_MAX][3]; // of the core, from the centre of mass along the own axes, m
    double radius;                             // the crust's thickness; a sphere is one vertex with its radius, m
    size_t faces;                              // of the core; 0: it is round
    double normal[POLYHEDRON_FACES_MAX][3];    // outwards, along the own axes
    uint16_t first[POLYHEDRON_FACES_MAX + 1];  // where each face's corners begin
    uint8_t loop[COMPOSITE_LOOP_MAX];          // vertices, face by face, counter-clockwise seen from outside
};

struct composite {
    double mass, volume; // kg, m3
    double inertia[3];   // about the centre of mass along the own axes, which are principal, kg m2
    double reach;        // from the centre of mass to the farthest point, m
    size_t parts;
    struct composite_part part[COMPOSITE_PARTS_MAX];
};

/* Convex parts in one frame, the same density, kg/m3, throughout. `axes` (may be NULL): q turns own axes into that
 * frame. Refuses parts that are not joined to the others, by number, and a crust that a part has no core under. */
enum scree_status composite_create(const struct polyhedron *part, size_t parts, double density, double crust, struct composite *out,
                                   struct quat *axes, struct scree_error *err);

/* The cross of seed 001, III.B: two boxes length x width x thickness that cross at right angles. */
enum scree_status composite_cross(double length, double width, double thickness, double density, double crust,
                                  struct composite *out, struct scree_error *err);

/* Four six-sided legs from the centre towards the corners of a regular tetrahedron. */
enum scree_status composite_tetrapod(double leg, double radius, double density, double crust, struct composite *out,
                                     struct scree_error *err);

enum scree_status composite_sphere(double radius, double density, struct composite *out, struct scree_error *err);

/* Spheres (x, y, z, radius) glued together, m: what they share counts once. Refuses, by number, one that meets none of the
 * others. Volume and inertia are integrated over chords: to a part in 10^4. */
enum scree_status composite_spheres(const double (*sphere)[4], size_t spheres, double density, struct composite *out,
                                    struct scree_error *err);

/* Mass, principal moments and axes out of the integrals of a body of density 1 in some frame; `centre` and `axes` are its
 * centre of mass there and the turn of its own axes into it. */
enum scree_status composite_weigh(const struct moments *moments, double density, struct composite *out, struct vec3 *centre,
                                  struct quat *axes, struct scree_error *err);

#endif
