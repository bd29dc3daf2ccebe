/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world of rigid convex bodies and composites of them between planes (seed 001, II).
 *
 * Parts of two bodies are in contact while their cores are apart and their crusts
 * overlap. Each pair of parts knows the gap it had when it was last looked at and
 * how far its bodies' surfaces can have moved since: while that is less, it is not
 * looked at. Results never depend on how a run is cut into calls. */
#ifndef SCREE_CONVEX_CONVEX_H
#define SCREE_CONVEX_CONVEX_H

#include <stdint.h>

#include "convex/law_spring_memory.h"
#include "geom/composite.h"
#include "view.h"

struct convex;

struct convex_body {
    double position[3], velocity[3], spin[3]; // of its centre of mass, m, m/s; in space, rad/s; at t = 0
    double orientation[4];                    // unit quaternion w, x, y, z: own axes into space
    uint32_t shape;
};

/* A plane that bodies touch from the side its normal points to. */
struct convex_wall {
    double point[3], normal[3]; // normal of unit length
    double raised;              // it is not touched below that height, m; 0: everywhere
};

/* One of the walls, which slides up in its own plane, or is gone at once, and rubs while it goes; or a level one in which
 * a hole opens. */
struct convex_gate {
    bool present;
    uint32_t wall;
    double start_s;
    double acceleration; // m/s2; 0: it vanishes
    double speed;        // at most, m/s
    double hole[2][2];   // its sides in x and in y, m; all 0: the whole wall goes
};

struct convex_setup {
    const char *isa; // NULL: the best there is
    double step_s;
    double gravity[3]; // m/s2
    const struct composite *shapes;
    size_t shape_count;
    const struct convex_body *bodies;
    size_t body_count;
    const struct convex_wall *walls;
    size_t wall_count; // the first is the floor, on which the base's force is taken
    struct convex_gate gate;
    struct spring_pair between, at_wall;
    /* The force between two bodies, or a body and a wall, is the mean over the points in which they touch, as in the
     * published code; false: the sum. */
    bool average;
};

/* Copies what it needs. SCREE_INVALID names what is wrong with the set-up. */
enum scree_status convex_create(const struct convex_setup *setup, struct convex **out, struct scree_error *err);
void convex_free(struct convex *convex);

/* Does exactly `steps` time steps, or fails with SCREE_BLOWUP when a body's motion is no longer finite, when two cores
 * overlap (a contact deeper than its crusts) or when a distance was not found. */
enum scree_status convex_advance(struct convex *convex, uint64_t steps, struct scree_error *err);

double convex_time(const struct convex *convex); // s
size_t convex_bodies(const struct convex *convex);
const char *convex_isa(const struct convex *convex);
void convex_set_gravity(struct convex *convex, const double gravity[3]);

/* Mean force of the bodies on the floor over the steps since the last call, N. */
void convex_take_base_force(struct convex *convex, double mean[3]);

/* Fills *out, which is valid until the world is advanced: a row a body, whose radius is that of a sphere of its volume;
 * bodies are their own only member. */
enum scree_status convex_view(struct convex *convex, struct view *out, struct scree_error *err);

/* The state of a body. */
void convex_look(const struct convex *convex, size_t body, struct convex_body *out);

struct convex_sums {
    double kinetic, elastic;        // J; elastic: normal springs
    double momentum[3], angular[3]; // kg m/s; about the origin, N m s
    double speed_mean, speed_max;   // m/s
    size_t contacts;                // points of contact between bodies
    size_t contacts_wall;           // and with walls
    double wall_force[3];           // of the bodies on all walls, N
};
struct convex_sums convex_sums(const struct convex *convex);

/* Over places, motions and memories of contacts, by body. */
uint64_t convex_hash(const struct convex *convex);

/* How often pairs of parts were looked at, how often their nearest corners had changed and were searched for, and lists
 * made; pairs of parts that are listed, memory in use. */
struct convex_counts {
    uint64_t steps, queries, searches, rebuilds;
    size_t pairs, bytes;
};
struct convex_counts convex_counts(const struct convex *convex);

#endif
