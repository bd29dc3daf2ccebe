/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Motion of rigid bodies: see bodies.h.
 *
 * The step is the free grains' with more in it: kicks change velocity and
 * angular momentum (in space), the drift moves the centre of mass and turns the
 * body freely for one step (quat.h; bodies_kernel.c, four at a time). Members get the velocity and spin that the
 * body has at half the step, which is what contact laws are given for free
 * grains too.
 *
 * A member's path is not straight, and nothing kicks it alone. What it strays
 * from the straight path that lists reckon with is measured at every drift, by
 * its way over the step against the velocity at the refresh: gravity, contacts
 * and turning together. */
#include "dem/bodies.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/quat.h"

/* ---- making ---- */

void bodies_free(struct bodies *b)
{
    if (!b)
        return;
    void *const arrays[] = {b->position, b->velocity, b->momentum, b->orientation, b->inverse, b->force, b->torque, b->first,
                            b->id,       b->shape,    b->offset,   b->of,          b->load,    b->twist, b->view};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
    free(b);
}

enum scree_status bodies_create(struct dem *dem, size_t count, struct scree_error *err)
{
    struct bodies *b = memory_rows(1, sizeof *b);
    if (!b)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for bodies");
    dem->bodies = b;
    b->count = count;
    double(**const by_body[])[4] = {&b->position, &b->velocity, &b->momentum, &b->orientation, &b->inverse, &b->force, &b->torque};
    double(**const by_row[])[4] = {&b->offset, &b->load, &b->twist};
    bool whole = true;
    for (size_t k = 0; k < sizeof by_body / sizeof *by_body; k++)
        whole &= (*by_body[k] = memory_rows(count, sizeof **by_body[k])) != NULL;
    for (size_t k = 0; k < sizeof by_row / sizeof *by_row; k++)
        whole &= (*by_row[k] = memory_rows(dem->moving, sizeof **by_row[k])) != NULL;
    b->first = memory_rows(count + 1, sizeof *b->first);
    b->id = memory_rows(count, sizeof *b->id);
    b->shape = memory_rows(count, sizeof *b->shape);
    b->of = memory_rows(dem->moving, sizeof *b->of);
    if (whole && b->first && b->id && b->shape && b->of)
        return SCREE_OK;
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu bodies", count);
}

void bodies_place(struct dem *dem, size_t k)
{
    const struct bodies *b = dem->bodies;
    struct turn turn = quat_turn(quat_load(b->orientation[k]));
    for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
        struct vec3 arm = turn_out(&turn, vec3_load(b->offset[i]));
        vec3_store(dem->arm[i], arm);
        vec3_store3(dem->position[i], vec3_add(vec3_load(b->position[k]), arm));
    }
}

static void fill_body(struct dem *dem, size_t k, const struct dem_body *body, const struct clump *shape, uint32_t id)
{
    struct bodies *b = dem->bodies;
    double dt = dem->step_s, smallest = fmin(shape->inertia[0], fmin(shape->inertia[1], shape->inertia[2]));
    struct turn turn = quat_turn(quat_load(body->orientation));
    struct vec3 spin = vec3_load(body->spin), own = turn_in(&turn, spin);
    own = (struct vec3){own.x * shape->inertia[0], own.y * shape->inertia[1], own.z * shape->inertia[2]};
    memcpy(b->position[k], body->position, sizeof body->position);
    memcpy(b->orientation[k], body->orientation, sizeof body->orientation);
    vec3_store(b->momentum[k], turn_out(&turn, own));
    for (int a = 0; a < 3; a++) {
        b->velocity[k][a] = body->velocity[a] - 0.5 * dem->gravity[a] * dt; // see state.h
        b->inverse[k][a] = 1 / shape->inertia[a];
    }
    b->position[k][3] = shape->mass;
    b->velocity[k][3] = dt / shape->mass;
    b->inverse[k][3] = shape->volume;
    b->id[k] = (uint32_t)k;
    b->shape[k] = body->shape;
    b->first[k + 1] = b->first[k] + (uint32_t)shape->spheres;
    for (size_t s = 0; s < shape->spheres; s++) {
        size_t i = b->first[k] + s;
        memcpy(b->offset[i], shape->sphere[s], 3 * sizeof(double));
        b->of[i] = (uint32_t)k;
        dem->position[i][3] = shape->sphere[s][3];
        dem->velocity[i][3] = dt / shape->mass;
        dem->spin[i][3] = dt / smallest;
        dem->id[i] = id + (uint32_t)s;
        dem->mass[i] = shape->mass / (double)shape->spheres; // a share, so that rows add up
        b->load[i][3] = b->twist[i][3] = 1;
    }
    bodies_place(dem, k);
    for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
        vec3_store3(dem->velocity[i], vec3_add(vec3_load(b->velocity[k]), vec3_cross(spin, vec3_load(dem->arm[i]))));
        vec3_store3(dem->spin[i], spin);
    }
}

void bodies_fill(struct dem *dem, const struct dem_setup *setup)
{
    uint32_t id = (uint32_t)setup->grain_count;
    for (size_t k = 0; k < setup->body_count; k++) {
        const struct clump *shape = &setup->shapes[setup->bodies[k].shape];
        fill_body(dem, k, &setup->bodies[k], shape, id);
        id += (uint32_t)shape->spheres;
    }
}

/* ---- the step ---- */

static struct body_batch batch_of(struct dem *dem, struct part *part)
{
    struct bodies *b = dem->bodies;
    bool any = part->from < part->to;
    return (struct body_batch){.from = any ? b->of[part->from] : 0,
                               .to = any ? b->of[part->to - 1] + 1 : 0,
                               .first = b->first,
                               .centre = b->position,
                               .velocity = b->velocity,
                               .momentum = b->momentum,
                               .orientation = b->orientation,
                               .force = b->force,
                               .torque = b->torque,
                               .inverse = (const double(*)[4])b->inverse,
                               .offset = (const double(*)[4])b->offset,
                               .speed0 = (const double(*)[4])dem->velocity0,
                               .place = dem->position,
                               .speed = dem->velocity,
                               .spin = dem->spin,
                               .arm = dem->arm,
                               .load = b->load,
                               .twist = b->twist,
                               .strayed2 = part->strayed2,
                               .step = dem->step_s};
}

static void bodies_drift(struct dem *dem, struct part *part)
{
    struct body_batch batch = batch_of(dem, part);
    for (int a = 0; a < 3; a++)
        batch.kick[a] = dem->gravity[a] * dem->step_s;
    dem->kernels->bodies_drift(&batch);
}

static void bodies_kick(struct dem *dem, struct part *part)
{
    struct bodies *b = dem->bodies;
    _Alignas(32) double unused[4] = {0}; // members do not stray by their own load
    const struct sink sink = {b->load, b->twist, b->load, unused};
    const struct body_batch batch = batch_of(dem, part);
    kick_rows(dem, part, &sink);
    dem->kernels->bodies_gather(&batch);
}

/* ---- housekeeping ---- */

static size_t bodies_next(const struct dem *dem, size_t row)
{
    return dem->bodies->first[dem->bodies->of[row] + 1];
}

static const double *bodies_whereabouts(const struct dem *dem, size_t row)
{
    return dem->bodies->position[dem->bodies->of[row]];
}

static void bodies_wrap(struct dem *dem, int8_t (*boxes)[4])
{
    struct bodies *b = dem->bodies;
    for (size_t k = 0; k < b->count; k++) {
        int8_t out[4] = {0};
        order_boxes(dem, b->position[k], out);
        for (size_t i = b->first[k]; i < b->first[k + 1]; i++)
            memcpy(boxes[i], out, sizeof out);
        for (int a = 0; a < 3; a++)
            if (out[a]) {
                b->position[k][a] -= out[a] * dem->length[a];
                dem->wrapped_work += b->position[k][3] * dem->gravity[a] * out[a] * dem->length[a];
            }
    }
}

static void bodies_nudge(struct dem *dem, const double change[3])
{
    struct bodies *b = dem->bodies;
    for (int a = 0; a < 3; a++) {
        for (size_t k = 0; k < b->count; k++)
            b->velocity[k][a] += change[a];
        for (size_t i = 0; i < dem->moving; i++)
            dem->velocity[i][a] += change[a];
    }
}

static double bodies_potential(const struct dem *dem)
{
    const struct bodies *b = dem->bodies;
    double sum = 0;
    for (size_t k = 0; k < b->count; k++) {
        const double *x = b->position[k];
        sum += x[3] * (dem->gravity[0] * x[0] + dem->gravity[1] * x[1] + dem->gravity[2] * x[2]);
    }
    return sum;
}

/* Elements of an array go where `to` says. */
static void scatter(void *array, size_t size, const uint32_t *to, size_t count, char *scratch)
{
    for (size_t k = 0; k < count; k++)
        memcpy(scratch + to[k] * size, (char *)array + k * size, size);
    memcpy(array, scratch, count * size);
}

/* Bodies stand in the order of their rows. */
static enum scree_status bodies_follow(struct dem *dem, const uint32_t *new_row, struct scree_error *err)
{
    struct bodies *b = dem->bodies;
    enum scree_status status = SCREE_OK;
    uint32_t *to = memory_rows(b->count, sizeof *to), *size = memory_rows(b->count, sizeof *size);
    uint32_t *starts = memory_rows(dem->moving, sizeof *starts); // of a new row: 1 + the body that begins there
    char *scratch = memory_rows(dem->moving, sizeof *b->offset);
    if (!to || !size || !starts || !scratch) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to sort %zu bodies", b->count);
        goto out;
    }
    for (size_t k = 0; k < b->count; k++) {
        size[k] = b->first[k + 1] - b->first[k];
        starts[new_row[b->first[k]]] = (uint32_t)k + 1;
    }
    uint32_t place = 0, row = 0;
    for (size_t i = 0; i < dem->moving; i++)
        if (starts[i])
            to[starts[i] - 1] = place++;
    void *const arrays[] = {b->position, b->velocity, b->momentum, b->orientation, b->inverse, b->force, b->torque};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        scatter(arrays[k], sizeof *b->position, to, b->count, scratch);
    scatter(b->id, sizeof *b->id, to, b->count, scratch);
    scatter(b->shape, sizeof *b->shape, to, b->count, scratch);
    scatter(size, sizeof *size, to, b->count, scratch);
    scatter(b->offset, sizeof *b->offset, new_row, dem->moving, scratch);
    for (size_t k = 0; k < b->count; k++) {
        b->first[k] = row;
        for (uint32_t s = 0; s < size[k]; s++)
            b->of[row++] = (uint32_t)k;
    }
    b->first[b->count] = row;
    dem_cut(dem);
out:
    free(to);
    free(size);
    free(starts);
    free(scratch);
    return status;
}

const struct motion motion_bodies = {.drift = bodies_drift,
                                     .kick = bodies_kick,
                                     .next = bodies_next,
                                     .place = bodies_whereabouts,
                                     .wrap = bodies_wrap,
                                     .nudge = bodies_nudge,
                                     .potential = bodies_potential,
                                     .follow = bodies_follow};
