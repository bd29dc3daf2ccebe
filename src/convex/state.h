/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world of convex bodies keeps. Private to this folder. */
#ifndef SCREE_CONVEX_STATE_H
#define SCREE_CONVEX_STATE_H

#include "convex/convex.h"
#include "geom/gjk.h"

struct body {
    struct vec3 position, velocity; // m, m/s
    struct spinning spin;           // orientation, angular momentum along the own axes
    struct vec3 inverse;            // 1 / I along the own axes, 1/(kg m2)
    struct turn turn;               // of the orientation
    struct vec3 omega;              // in space, rad/s
    struct vec3 force, torque;      // in space, about the centre, N, N m
    const struct composite *shape;
    double travel; // no point of it has moved farther since t = 0, m
};

/* Two parts of two bodies, or a vertex of a part and a wall. */
struct pair {
    uint32_t a, b;           // bodies; b is a wall's number in the list of walls
    uint16_t part_a, part_b; // part_b: the vertex, in the list of walls
    struct gjk_cache cache;
    double looked; // both bodies' travel at which it must be looked at again, m
    bool touches;
    struct spring_memory memory;
    struct vec3 point; // of contact, m
    struct spring_result result;
    double elastic; // J
};

struct list {
    struct pair *pair;
    size_t count, room;
};

struct convex {
    struct convex_setup setup; // its pointers are not looked at
    struct composite *shapes;
    struct convex_wall *walls;
    struct body *body;
    uint32_t *order; // bodies along x
    size_t bodies;
    struct list near, wall, old; // old: the list that is being replaced
    double skin;                 // m
    double *travel_then;         // by body
    uint64_t step;
    struct convex_counts counts;
};

/* Makes the lists anew; contacts keep their memory. */
enum scree_status convex_rebuild(struct convex *convex, struct scree_error *err);

/* Forces and torques of all contacts and of gravity. */
enum scree_status convex_forces(struct convex *convex, struct scree_error *err);

#endif
