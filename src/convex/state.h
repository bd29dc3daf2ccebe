/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world of convex bodies keeps. Private to this folder. */
#ifndef SCREE_CONVEX_STATE_H
#define SCREE_CONVEX_STATE_H

#include "convex/convex.h"
#include "convex/kernels.h"
#include "geom/gjk.h"
#include "geom/patch.h"

/* Rows of four numbers: a step moves four bodies side by side. What contacts read and write comes first, in three lines of
 * cache. */
struct body {
    _Alignas(64) double position[4]; // m
    double velocity[4];              // m/s; [3] 1 / mass, 1/kg
    double omega[4];                 // in space, rad/s
    double force[4], torque[4];      // in space, about the centre, N, N m
    const struct composite *shape;
    const struct outline *outline;
    uint64_t placed;                    // 1 + the step at which its corners in space are; 0: never
    _Alignas(32) double orientation[4]; // w, x, y, z: own axes into space
    double momentum[4];                 // angular, along the own axes, N m s; [3] mass, kg
    double inverse[4];                  // 1 / I along the own axes, 1/(kg m2); [3] reach, m
    double axis[3][4];                  // own axes in space
    double listed[4];                   // where its centre was when lists were made, m; [3] how far it may go from there, m
};

/* Corners of a shape's parts as columns x, y, z, of which four are looked at at once: each part's are filled up to a
 * multiple of four by its first. */
struct outline {
    size_t corners;                   // of all parts, filled up
    size_t from[COMPOSITE_PARTS_MAX]; // where a part's begin
    const double *own;                // x, then y, then z, along the own axes, m
    bool ball;                        // its only corner is its centre, whichever way it is turned
};

/* A point in which parts of two bodies, or a corner of a body and a wall, touch. Rows of four numbers, as bodies have. */
struct contact {
    _Alignas(32) double slip[4]; // the law's memory: its slip, m; [3] overlap, m
    double roll[4];              // its rolling spring, N m; [3] share among the points of a patch
    double normal[4];            // the normal that those two are across; [3] elastic energy, J
    double facing[4];            // from a to b, now
    double point[4];             // m
    double force[4];             // on a, before shares, N; [3] its component that pushes apart
    double moment[4];            // on a beyond the force's, before shares, N m; [3] the share that bodies feel
    uint32_t next;               // of the same pair, or NO_CONTACT
    bool slides, rolls;
};

/* Two parts of two bodies, or a corner and a wall. */
struct pair {
    double due;    // both bodies' travel at which it must be looked at again, m; 0: at every step, as while it touches
    uint32_t slot; // the first of its contacts, or NO_CONTACT
    struct gjk_cache cache;
    struct patch_faces faces; // with which they touch, if with any
};
#define NO_CONTACT UINT32_MAX

/* Two bodies with all pairs of their parts, part by part of a; or a body and a wall with all its corners, filled up as in
 * its outline. */
struct group {
    uint32_t a, b; // b: the number of the wall
    uint32_t first, touching;
    double due; // as that of a pair: the least of them
};

/* Groups and blocks of pairs: a group keeps its block for as long as it is listed. */
struct list {
    struct group *group; // in the order of a, then b
    size_t groups, group_room;
    struct pair *pair;
    size_t pairs;            // of all groups
    size_t block, pair_room; // pairs in a block: the most that a group has
    size_t blocks;           // in use and free
    uint32_t *spare;         // where blocks that are free begin, the last first
    size_t spares, spare_room;
};

/* A body in a cell, and two that are near each other: what making lists needs. */
struct celled {
    double position[3], reach; // with its margin, m
    uint32_t body;
};
struct found {
    uint32_t a, b;
};

#define CONVEX_EASE_MAX 6.0

struct convex {
    struct convex_setup setup; // its pointers are not looked at
    const struct convex_kernels *kernels;
    struct composite *shapes;
    struct outline *outlines;
    double *own; // corners of all outlines
    struct convex_wall *walls;
    struct body *body; // bodies, filled up to a multiple of four by ones that nothing moves, then walls as such
    size_t bodies, first_wall;
    double *travel; // of each body: no point of it has moved farther since t = 0, m
    double *corner; // of all bodies, from their centres along the axes of space, m: see corners_of
    size_t corners; // the most that a shape has
    struct list near, wall;
    struct group *old; // groups of the list that is being replaced
    size_t old_room;
    struct contact *contact;
    size_t contacts, contact_room; // in use and free
    uint32_t *spare;               // slots that are free, the last first
    size_t spares, spare_room;
    double ease;           // by which margins are wider than they need be at rest, 1 to CONVEX_EASE_MAX
    uint64_t listed_at;    // step at which lists were made
    struct celled *celled; // bodies by cells
    uint32_t *start;       // where cells begin, then where bodies' pairs do
    struct found *found;   // pairs in the order in which they were found
    size_t founds, found_room;
    uint32_t *met; // groups that were due in this step
    size_t mets, met_room;
    uint64_t step;
    struct convex_counts counts;
    double gravity_work;     // since the start, J
    struct vec3 base, based; // force on the floor, N: now, summed over `base_steps`
    uint64_t base_steps;
    struct frame *frame; // what a view shows; NULL until one is asked for
};

void convex_frame_free(struct frame *frame);

/* Of a wall that does not stand for good, or not all the way down: whether it stands, its lower edge, m, how fast that rises,
 * m/s, and the hole that has opened in it, or NULL. */
struct gate_now {
    bool partial, stands;
    double lift, speed;
    const double (*hole)[2];
};
struct gate_now convex_gate_now(const struct convex *convex, uint32_t wall);

static inline struct turn body_turn(const struct body *b)
{
    return (struct turn){.column = {vec3_load(b->axis[0]), vec3_load(b->axis[1]), vec3_load(b->axis[2])}};
}
static inline struct vec3 body_velocity_at(const struct body *b, struct vec3 point)
{
    return vec3_add(vec3_load(b->velocity), vec3_cross(vec3_load(b->omega), vec3_sub(point, vec3_load(b->position))));
}
static inline size_t pairs_between(const struct body *a, const struct body *b)
{
    return a->shape->parts * b->shape->parts;
}
static inline size_t pairs_of(const struct convex *c, const struct list *list, const struct group *g)
{
    return list == &c->wall ? c->body[g->a].outline->corners : pairs_between(&c->body[g->a], &c->body[g->b]);
}

/* What each contact of a group counts. */
static inline double share_of(const struct convex *c, const struct group *g)
{
    return c->setup.average && g->touching > 1 ? 1.0 / (double)g->touching : 1;
}

/* Axes and spin of a body from its orientation and angular momentum. */
void convex_look_around(struct body *body);

/* Gives a pair as many contacts as `points`; those that are new remember nothing. And the end of all that it has. */
enum scree_status convex_touch(struct convex *convex, struct pair *pair, size_t points, struct scree_error *err);
void convex_part_now(struct convex *convex, struct pair *pair);
static inline void convex_part(struct convex *convex, struct pair *pair)
{
    if (pair->slot != NO_CONTACT)
        convex_part_now(convex, pair);
}
/* Puts contacts where they lie in the order of lists, in which they are walked. */
void convex_tidy(struct convex *convex);
size_t convex_points(const struct convex *convex, const struct pair *pair);

/* Makes the lists anew; contacts keep their memory. */
enum scree_status convex_rebuild(struct convex *convex, struct scree_error *err);
/* Makes room for groups, and gives one a block of pairs that know nothing. */
enum scree_status convex_list_room(struct list *list, size_t groups, struct scree_error *err);
enum scree_status convex_take_block(struct list *list, struct group *group, struct scree_error *err);

/* Forces and torques of all contacts and of gravity. */
enum scree_status convex_forces(struct convex *convex, struct scree_error *err);

#endif
