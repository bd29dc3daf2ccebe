/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bodies above a floor, turned every way, none touching another, as dense as is
 * cheap to have them, so that they need not fall far.
 *
 * Bodies that fill the ball around them well stand on a lattice of such balls. Thin
 * ones reach into each other's: they are put in one by one at random places below a
 * ceiling that rises with every try that fails, in proportion to 1 / area, so that
 * boxes of any width are filled as densely. */
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/rng.h"
#include "geom/gjk.h"
#include "scenario/rigid.h"

enum { STREAM_POUR = 5 };  // of random numbers
#define LATTICE_SHARE 0.25 // solid fraction of a lattice of balls from which on it is used
#define ROOM          1.05 // of a lattice's cell, over what is across a ball
#define RISE          0.5  // of the ceiling a failed try, of a body's volume over the area

/* Uniform over all orientations (Shoemake 1992). */
static void any_way(struct rng *rng, double orientation[4])
{
    double u = rng_uniform(rng, 0, 1), a = rng_uniform(rng, 0, 2 * M_PI), b = rng_uniform(rng, 0, 2 * M_PI);
    orientation[0] = sqrt(1 - u) * sin(a);
    orientation[1] = sqrt(1 - u) * cos(a);
    orientation[2] = sqrt(u) * sin(b);
    orientation[3] = sqrt(u) * cos(b);
}

/* With room to either side where there is some: balls exactly above each other would stay there. */
static void on_lattice(struct rng *rng, size_t count, double length, double width, double across, struct convex_body *bodies)
{
    const double least = ROOM * across;
    size_t along = (size_t)fmax(1, floor(length / least)), over = (size_t)fmax(1, floor(width / least));
    const double cell[2] = {length / (double)along, width / (double)over};
    for (size_t k = 0; k < count; k++) {
        struct convex_body *b = &bodies[k];
        const size_t at[2] = {k % along, k / along % over};
        for (int a = 0; a < 2; a++) {
            double room = 0.5 * fmax(0, cell[a] - across);
            b->position[a] = ((double)at[a] + 0.5) * cell[a] + rng_uniform(rng, -room, room);
        }
        b->position[2] = ((double)(k / (along * over)) + 0.5) * across;
        any_way(rng, b->orientation);
    }
}

/* ---- one by one ---- */

static struct gjk_core core_of(const struct composite *shape, size_t part, const struct convex_body *b)
{
    return (struct gjk_core){shape->part[part].vertex, shape->part[part].vertices, quat_turn(quat_load(b->orientation)),
                             vec3_load(b->position)};
}

static bool touch(const struct composite *shape, const struct convex_body *a, const struct convex_body *b)
{
    double between2 = 0;
    for (int i = 0; i < 3; i++)
        between2 += (a->position[i] - b->position[i]) * (a->position[i] - b->position[i]);
    if (between2 > 4 * shape->reach * shape->reach)
        return false;
    for (size_t p = 0; p < shape->parts; p++)
        for (size_t q = 0; q < shape->parts; q++) {
            struct gjk_core ca = core_of(shape, p, a), cb = core_of(shape, q, b);
            struct gjk_cache cache = {0};
            struct gjk_result r;
            if (gjk_distance(&ca, &cb, &cache, &r) != GJK_APART || r.distance <= shape->part[p].radius + shape->part[q].radius)
                return true;
        }
    return false;
}

/* How far a body turned like that reaches along each axis of space from its centre. */
static void extent(const struct composite *shape, const struct convex_body *b, double low[3], double high[3])
{
    const struct turn turn = quat_turn(quat_load(b->orientation));
    for (int i = 0; i < 3; i++)
        low[i] = high[i] = 0;
    for (size_t p = 0; p < shape->parts; p++)
        for (size_t v = 0; v < shape->part[p].vertices; v++) {
            double x[3];
            vec3_store3(x, turn_out(&turn, vec3_load(shape->part[p].vertex[v])));
            for (int i = 0; i < 3; i++) {
                low[i] = fmin(low[i], x[i] - shape->part[p].radius);
                high[i] = fmax(high[i], x[i] + shape->part[p].radius);
            }
        }
}

/* Somewhere in the box below the ceiling, no deeper than two bodies; the way it is turned always fits. */
static void try_place(const struct composite *shape, struct rng *rng, const double size[2], double ceiling, struct convex_body *b)
{
    double low[3], high[3], floor_z = fmax(0, ceiling - 4 * shape->reach);
    any_way(rng, b->orientation);
    extent(shape, b, low, high);
    for (int i = 0; i < 2; i++)
        b->position[i] = rng_uniform(rng, -low[i], size[i] - high[i]);
    b->position[2] = rng_uniform(rng, floor_z - low[2], fmax(floor_z - low[2], ceiling - high[2]));
}

static enum scree_status one_by_one(struct rng *rng, const struct composite *shape, size_t count, const double size[2],
                                    struct convex_body *bodies, struct scree_error *err)
{
    double ceiling = 2 * shape->reach, rise = RISE * shape->volume / (size[0] * size[1]);
    double *under = memory_rows(count, sizeof *under); // the ceiling that each was put in under
    if (!under)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu bodies", count);
    for (size_t k = 0, first = 0; k < count; k++) {
        bool placed = false;
        while (!placed) {
            try_place(shape, rng, size, ceiling, &bodies[k]);
            while (first < k && under[first] < ceiling - 6 * shape->reach) // out of reach of all tries to come
                first++;
            placed = true;
            for (size_t other = first; other < k && placed; other++)
                placed = !touch(shape, &bodies[k], &bodies[other]);
            ceiling += placed ? 0 : rise;
        }
        under[k] = ceiling;
    }
    free(under);
    return SCREE_OK;
}

enum scree_status rigid_pour(const struct job_spec *job, size_t count, double length, double width, struct rigid_plan *plan,
                             struct scree_error *err)
{
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_POUR);
    const double across = 2 * plan->shape.reach, size[2] = {length, width};
    plan->bodies = memory_rows(count, sizeof *plan->bodies);
    if (!plan->bodies)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu bodies", count);
    plan->setup.bodies = plan->bodies;
    plan->setup.body_count = count;
    if (plan->shape.volume < LATTICE_SHARE * across * across * across)
        return one_by_one(&rng, &plan->shape, count, size, plan->bodies, err);
    on_lattice(&rng, count, length, width, across, plan->bodies);
    return SCREE_OK;
}
