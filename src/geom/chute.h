/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The apparatus of seed 003 as triangles: a straight accelerator that runs
 * tangentially into a curved chute, both of the same trapezoidal section
 * (Figure 1), and the gate across the accelerator.
 *
 * x is horizontal and downslope from the join at x = 0, y across, z up. The
 * profile is that of eq. 1, z = height - drop asinh(x / length); upslope of
 * x = 0 it goes on along its tangent. Across, the section is a flat floor with
 * two sides that lean outwards, upright to the profile; on these stand guards,
 * and plates close both ends, so that what bounces stays. */
#ifndef SCREE_GEOM_CHUTE_H
#define SCREE_GEOM_CHUTE_H

#include <stdint.h>

#include "geom/trimesh.h"

struct chute {
    double height, drop, steepness; // of eq. 1: 0.3 m, 0.085 m, 11.765 1/m
    double run;                     // horizontal length of the curved part, m
    double accelerator;             // length of the straight part along itself, m
    double floor, width;            // of the section: flat floor, and across the tops of the sides, m
    double side_rad;                // of the sides to the floor's plane
    double guard;                   // height of upright guards on top of the sides, m (ours: nothing leaves sideways)
    double gate;                    // distance of the gate from x = 0 along the accelerator, m
    double flatness;                // the curve is nowhere farther than this from its chords, m
};

double chute_z(const struct chute *c, double x);     // of the profile, m
double chute_slope(const struct chute *c, double x); // angle below the horizontal, rad
double chute_arc(const struct chute *c, double x);   // length along the profile from x = 0, negative upslope, m

/* Height of a point above the profile, normal to it where the point stands, m. */
double chute_height(const struct chute *c, const double point[3]);

/* A point by its length along the accelerator (negative upslope of x = 0), across, and normal to it. */
void chute_accelerator_point(const struct chute *c, double along, double across, double normal, double out[3]);

/* Floor, sides, guards and end plates, normals inwards; `is_accelerator` (owned by the caller) tells the
 * triangles upslope of x = 0. Open at the top: it is a wall, not a body. */
enum scree_status chute_mesh(const struct chute *c, struct trimesh **out, uint8_t **is_accelerator, struct scree_error *err);
/* Whether a triangle of any mesh in this frame lies upslope of x = 0, by its middle. */
bool chute_upslope(const struct trimesh *mesh, size_t triangle);
/* The gate: a plate across the accelerator, guards included. */
enum scree_status chute_gate(const struct chute *c, struct trimesh **out, struct scree_error *err);

#endif
