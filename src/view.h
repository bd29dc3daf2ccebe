/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world shows once a sample, read-only. Measurements read views and nothing else.
 *
 * Arrays are in the world's memory order, which changes now and then; `id` names
 * the grain for good. Everything is valid until the world is advanced. */
#ifndef SCREE_VIEW_H
#define SCREE_VIEW_H

#include <stddef.h>
#include <stdint.h>

struct view_contact {
    uint32_t a, b;                   // rows of the grains; b is VIEW_WALL + wall for a wall
    uint32_t on_base;                // 1: b is a grain of the base, or a wall of it
    double overlap;                  // m
    double normal[3];                // from a to b
    double point[3];                 // where they touch, in worlds of rigid bodies; zero in others, m
    double approach;                 // rate of overlap, m/s (positive while loading)
    double force[3];                 // of a on b, N, normal and tangential together
    double force_normal;             // component along the normal, N; slightly negative at the end of a damped contact
    double torque_a[3], torque_b[3]; // on each grain, N m
    double elastic;                  // energy stored in the normal, tangential, torsion and rolling springs, J
};
#define VIEW_WALL 0x80000000u

/* A rigid body. Its members are rows [first, first + members), which are spheres
 * that move with it; a member's mass is a share of its body's. */
struct view_body {
    uint32_t id, shape, first, members;
    double mass, volume;                      // kg, m3
    double position[3], velocity[3], spin[3]; // of the centre of mass, m, m/s; in space, rad/s
    double momentum[3];                       // angular, about the centre of mass, N m s
    double orientation[4];                    // unit quaternion w, x, y, z: own principal axes into space
    uint32_t part_first, parts;               // of view.part_start; 0 parts: it is its members
};

/* A contact at the first step with overlap, before it exerted any force. */
struct view_formation {
    double time_s;
    uint32_t a, b;        // ids of the grains; b is VIEW_WALL + wall for a wall
    uint32_t fixed;       // 1: b is a grain of the base or a wall of it
    double place[3];      // midway between the surfaces, inside the periodic box, m
    double normal[3];     // from a to b
    double approach;      // normal relative speed, m/s, positive while closing
    double tangential[3]; // relative velocity of the surfaces across the normal, spins included, m/s
};

struct trimesh;

struct view {
    double time_s, step_s;
    uint64_t step;
    double length[3]; // of the domain, m; 0 where it is unbounded
    int periodic[3];
    double gravity[3];    // m/s2
    size_t moving, fixed; // grains: rows 0 .. moving-1 move, moving .. moving+fixed-1 are the base
    const uint32_t *id;
    const double (*position)[4]; // x, y, z (inside the periodic box), radius, m
    const double (*velocity)[4]; // at this step's time, m/s; [3] mass, kg
    const double (*spin)[4];     // rad/s; [3] moment of inertia, kg m2; 0 for members of bodies
    size_t bodies;               // 0 where grains are free
    const struct view_body *body;
    /* Corners of bodies' convex parts: part p is the hull of rows [part_start[p], part_start[p + 1]) of `corner`, in space,
     * each with a ball of radius [3] around it, m. NULL where no body has parts. */
    const uint32_t *part_start;
    const double (*corner)[4];
    size_t contacts;
    const struct view_contact *contact;
    const struct trimesh *base_mesh; // the wall of triangles that counts as the base; NULL: there is none
    double base_force[3];            // of the flow on fixed grains and floor at this step, N
    /* Ledger since the start, J; dissipated parts are zero unless the world keeps a ledger. */
    double gravity_work;
    double dissipated_normal, dissipated_tangential, dissipated_torsion, dissipated_rolling;
};

#endif
