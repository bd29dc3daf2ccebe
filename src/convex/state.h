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
    double share;   // of the result that the bodies feel
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
    double gravity_work;     // since the start, J
    struct vec3 base, based; // force on the floor, N: now, summed over `base_steps`
    uint64_t base_steps;
    struct frame *frame; // what a view shows; NULL until one is asked for
};

void convex_frame_free(struct frame *frame);

/* Whether the gate stands, how far it has risen, m, and how fast it does, m/s. */
struct gate_now {
    bool stands;
    double lift, speed;
};
struct gate_now convex_gate_now(const struct convex *convex);

/* Turn and spin of a body from its orientation and angular momentum. */
void convex_look_around(struct body *body);

/* Order of pairs in a list: negative, zero, positive. */
int convex_compare(const void *x, const void *y);

/* Makes the lists anew; contacts keep their memory. */
enum scree_status convex_rebuild(struct convex *convex, struct scree_error *err);

/* Forces and torques of all contacts and of gravity. */
enum scree_status convex_forces(struct convex *convex, struct scree_error *err);

#endif
