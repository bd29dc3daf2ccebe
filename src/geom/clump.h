/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rigid bodies of spheres. The spheres are what touches; mass, volume and
 * inertia are those of the polyhedron that they are inscribed in (seed 003,
 * 3.2: a cube keeps its corners' mass although nothing touches with them). */
#ifndef SCREE_GEOM_CLUMP_H
#define SCREE_GEOM_CLUMP_H

#include <stddef.h>

#include "base/quat.h"
#include "base/status.h"
#include "geom/trimesh.h"

enum { CLUMP_SPHERES_MAX = 64 };

struct clump {
    double mass, volume; // kg, m3
    double inertia[3];   // about the centre of mass along the body's own axes, which are principal, kg m2
    double reach;        // from the centre of mass to the farthest point of a sphere, m
    size_t spheres;
    double sphere[CLUMP_SPHERES_MAX][4]; // centre from the centre of mass along the own axes, and radius, m
};

/* A block of `size` with spheres of `radius` packed in rows along its edges, as
 * many as fit: sizes must be multiples of the diameter (to 1e-6). Spheres that
 * have neighbours on all six sides can touch nothing and are left out. */
enum scree_status clump_block(const double size[3], double radius, double density, struct clump *out, struct scree_error *err);

/* Adds a sphere of `radius` in each of the eight corners of such a block, touching its three faces there. */
enum scree_status clump_add_corners(const double size[3], double radius, struct clump *clump, struct scree_error *err);

/* Any body: spheres in some frame, mass, centre of mass and inertia tensor about
 * it (xx, yy, zz, xy, xz, yz) in the same frame. Turns it into principal axes;
 * `axes` (may be NULL) says how: q turns own axes into the given frame. Refuses no spheres,
 * mass or moments that are not positive, and moments that no body has. */
enum scree_status clump_create(const double (*sphere)[4], size_t spheres, double mass, const double centre[3],
                               const double inertia[6], double volume, struct clump *out, struct quat *axes,
                               struct scree_error *err);

/* Spheres inside a closed convex mesh, which gives volume, mass and inertia
 * exactly. Refuses a sphere that leaves it, by number, and a hollow shape. */
enum scree_status clump_inscribe(const struct trimesh *mesh, const double (*sphere)[4], size_t spheres, double density,
                                 struct clump *out, struct quat *axes, struct scree_error *err);

#endif
