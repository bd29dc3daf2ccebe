/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Making, stepping and looking at a world of convex bodies.
 *
 * The step is velocity Verlet, as the paper's; rotation is the free rotation of
 * quat.h between two halves of the torque's kick. Forces see the velocities of
 * half a step before: dashpots are first order in the step, which its twenty
 * steps a contact are made for. */
#include "convex/convex.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

void convex_free(struct convex *c)
{
    if (!c)
        return;
    free(c->shapes);
    free(c->walls);
    free(c->body);
    free(c->order);
    free(c->travel_then);
    free(c->near.pair);
    free(c->wall.pair);
    free(c->old.pair);
    convex_frame_free(c->frame);
    free(c);
}

static enum scree_status check(const struct convex_setup *s, struct scree_error *err)
{
    if (!(s->step_s > 0 && isfinite(s->step_s)))
        return scree_fail(err, SCREE_INVALID, "step_s", "step_s: %g s is no time step", s->step_s);
    if (s->body_count < 1 || s->body_count > UINT32_MAX)
        return scree_fail(err, SCREE_INVALID, "bodies", "bodies: there must be one at least");
    for (size_t k = 0; k < s->body_count; k++) {
        const struct convex_body *b = &s->bodies[k];
        double sum = 0;
        for (int i = 0; i < 3; i++)
            sum += b->position[i] + b->velocity[i] + b->spin[i];
        if (!isfinite(sum) || !(fabs(quat_norm2(quat_load(b->orientation)) - 1) < 1e-6))
            return scree_fail(err, SCREE_INVALID, "bodies", "body %zu has no finite place or no unit orientation", k);
        if (b->shape >= s->shape_count)
            return scree_fail(err, SCREE_INVALID, "bodies", "body %zu has shape %u of %zu", k, b->shape, s->shape_count);
    }
    if (s->gate.present && s->gate.wall >= s->wall_count)
        return scree_fail(err, SCREE_INVALID, "gate", "gate: there is no wall %u", s->gate.wall);
    return SCREE_OK;
}

void convex_look_around(struct body *b)
{
    b->turn = quat_turn(b->spin.orientation);
    const struct vec3 m = b->spin.momentum, own = {m.x * b->inverse.x, m.y * b->inverse.y, m.z * b->inverse.z};
    b->omega = turn_out(&b->turn, own);
}

static void set_body(const struct convex_body *from, const struct composite *shape, struct body *b)
{
    b->shape = shape;
    b->position = vec3_load(from->position);
    b->velocity = vec3_load(from->velocity);
    b->inverse = (struct vec3){1 / shape->inertia[0], 1 / shape->inertia[1], 1 / shape->inertia[2]};
    b->spin.orientation = quat_unit(quat_load(from->orientation));
    struct turn t = quat_turn(b->spin.orientation);
    struct vec3 own = turn_in(&t, vec3_load(from->spin));
    b->spin.momentum = (struct vec3){own.x * shape->inertia[0], own.y * shape->inertia[1], own.z * shape->inertia[2]};
    convex_look_around(b);
}

enum { SKIN_SHARE = 20 }; // of the smallest reach

enum scree_status convex_create(const struct convex_setup *s, struct convex **out, struct scree_error *err)
{
    enum scree_status status = check(s, err);
    if (status)
        return status;
    struct convex *c = memory_rows(1, sizeof *c);
    if (!c)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    c->setup = *s;
    c->bodies = s->body_count;
    c->shapes = memory_rows(s->shape_count, sizeof *c->shapes);
    c->walls = memory_rows(s->wall_count, sizeof *c->walls);
    c->body = memory_rows(c->bodies, sizeof *c->body);
    c->order = memory_rows(c->bodies, sizeof *c->order);
    c->travel_then = memory_rows(c->bodies, sizeof *c->travel_then);
    if (!c->shapes || !c->walls || !c->body || !c->order || !c->travel_then) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world of %zu bodies", c->bodies);
        goto out;
    }
    memcpy(c->shapes, s->shapes, s->shape_count * sizeof *c->shapes);
    if (s->wall_count > 0)
        memcpy(c->walls, s->walls, s->wall_count * sizeof *c->walls);
    c->skin = INFINITY;
    for (size_t k = 0; k < c->bodies; k++) {
        set_body(&s->bodies[k], &c->shapes[s->bodies[k].shape], &c->body[k]);
        c->order[k] = (uint32_t)k;
        c->skin = fmin(c->skin, c->body[k].shape->reach / SKIN_SHARE);
    }
    if (!(status = convex_rebuild(c, err)))
        status = convex_forces(c, err);
out:
    if (status)
        convex_free(c);
    else
        *out = c;
    return status;
}

static void kick(struct body *b, double half)
{
    b->velocity = vec3_add(b->velocity, vec3_scale(b->force, half / b->shape->mass));
    b->spin.momentum = vec3_add(b->spin.momentum, vec3_scale(turn_in(&b->turn, b->torque), half));
}

/* No point of the body moves farther than v dt + 2 w reach dt: free rotation changes w meanwhile, less than twofold in
 * steps that resolve it. */
static void drift(struct body *b, double step)
{
    b->position = vec3_add(b->position, vec3_scale(b->velocity, step));
    spinning_first_half(&b->spin, b->inverse, 0.5 * step);
    spinning_second_half(&b->spin, b->inverse, 0.5 * step);
    b->spin.orientation = quat_tidy(b->spin.orientation);
    double turned = sqrt(vec3_dot(b->omega, b->omega));
    convex_look_around(b);
    turned = fmax(turned, sqrt(vec3_dot(b->omega, b->omega)));
    b->travel += step * (sqrt(vec3_dot(b->velocity, b->velocity)) + 2 * turned * b->shape->reach);
}

static enum scree_status step(struct convex *c, struct scree_error *err)
{
    bool moved = false;
    struct vec3 gravity = vec3_load(c->setup.gravity);
    for (size_t k = 0; k < c->bodies; k++) {
        struct body *b = &c->body[k];
        kick(b, 0.5 * c->setup.step_s);
        convex_look_around(b);
        c->gravity_work += b->shape->mass * c->setup.step_s * vec3_dot(gravity, b->velocity);
        drift(b, c->setup.step_s);
        if (!isfinite(b->travel))
            return scree_fail(err, SCREE_BLOWUP, NULL, "step %llu: body %zu's motion is no longer finite",
                              (unsigned long long)c->step, k);
        moved = moved || b->travel - c->travel_then[k] > 0.5 * c->skin;
    }
    c->step++;
    enum scree_status status = moved ? convex_rebuild(c, err) : SCREE_OK;
    if (status || (status = convex_forces(c, err)))
        return status;
    for (size_t k = 0; k < c->bodies; k++) {
        kick(&c->body[k], 0.5 * c->setup.step_s);
        convex_look_around(&c->body[k]);
    }
    c->based = vec3_add(c->based, c->base);
    c->base_steps++;
    return SCREE_OK;
}

enum scree_status convex_advance(struct convex *c, uint64_t steps, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (uint64_t k = 0; k < steps && !status; k++)
        status = step(c, err);
    return status;
}

/* ---- gate, gravity, base ---- */

struct gate_now convex_gate_now(const struct convex *c)
{
    const struct convex_gate *gate = &c->setup.gate;
    double since = (double)c->step * c->setup.step_s - gate->start_s;
    if (!gate->present || since <= 0)
        return (struct gate_now){.stands = gate->present};
    if (gate->acceleration <= 0)
        return (struct gate_now){.stands = false};
    double full = gate->speed / gate->acceleration, gaining = fmin(since, full);
    return (struct gate_now){.stands = true,
                             .lift = 0.5 * gate->acceleration * gaining * gaining + gate->speed * (since - gaining),
                             .speed = gate->acceleration * gaining};
}

double convex_time(const struct convex *c)
{
    return (double)c->step * c->setup.step_s;
}

size_t convex_bodies(const struct convex *c)
{
    return c->bodies;
}

/* Forces of the step that is over have it already: the change is felt from the next on. */
void convex_set_gravity(struct convex *c, const double gravity[3])
{
    memcpy(c->setup.gravity, gravity, sizeof c->setup.gravity);
}

void convex_take_base_force(struct convex *c, double mean[3])
{
    vec3_store3(mean, c->base_steps > 0 ? vec3_scale(c->based, 1 / (double)c->base_steps) : c->base);
    c->based = (struct vec3){0, 0, 0};
    c->base_steps = 0;
}

/* ---- looking ---- */

void convex_look(const struct convex *c, size_t body, struct convex_body *out)
{
    const struct body *b = &c->body[body];
    *out = (struct convex_body){.shape = (uint32_t)(b->shape - c->shapes)};
    vec3_store3(out->position, b->position);
    vec3_store3(out->velocity, b->velocity);
    vec3_store3(out->spin, b->omega);
    quat_store(out->orientation, b->spin.orientation);
}

struct convex_sums convex_sums(const struct convex *c)
{
    struct convex_sums s = {0};
    struct vec3 momentum = {0, 0, 0}, angular = {0, 0, 0}, wall = {0, 0, 0};
    for (size_t k = 0; k < c->bodies; k++) {
        const struct body *b = &c->body[k];
        struct vec3 p = vec3_scale(b->velocity, b->shape->mass), spin = turn_out(&b->turn, b->spin.momentum);
        double speed = sqrt(vec3_dot(b->velocity, b->velocity));
        s.kinetic += 0.5 * vec3_dot(p, b->velocity) + 0.5 * vec3_dot(spin, b->omega);
        momentum = vec3_add(momentum, p);
        angular = vec3_add(angular, vec3_add(spin, vec3_cross(b->position, p)));
        s.speed_mean += speed / (double)c->bodies;
        s.speed_max = fmax(s.speed_max, speed);
        wall = vec3_add(wall, vec3_sub(vec3_scale(vec3_load(c->setup.gravity), b->shape->mass), b->force));
    }
    for (size_t k = 0; k < c->near.count; k++)
        if (c->near.pair[k].touches) {
            s.contacts++;
            s.elastic += c->near.pair[k].elastic;
        }
    for (size_t k = 0; k < c->wall.count; k++)
        if (c->wall.pair[k].touches) {
            s.contacts_wall++;
            s.elastic += c->wall.pair[k].elastic;
        }
    vec3_store3(s.momentum, momentum);
    vec3_store3(s.angular, angular);
    vec3_store3(s.wall_force, wall); // contacts between bodies cancel in the sum
    return s;
}

static void mix(uint64_t *hash, const void *bytes, size_t count)
{
    for (size_t k = 0; k < count; k++)
        *hash = (*hash ^ ((const unsigned char *)bytes)[k]) * 0x100000001b3U;
}

uint64_t convex_hash(const struct convex *c)
{
    uint64_t hash = 0xcbf29ce484222325U;
    for (size_t k = 0; k < c->bodies; k++) {
        mix(&hash, &c->body[k].position, sizeof c->body[k].position);
        mix(&hash, &c->body[k].velocity, sizeof c->body[k].velocity);
        mix(&hash, &c->body[k].spin, sizeof c->body[k].spin);
    }
    const struct list *lists[] = {&c->near, &c->wall};
    for (int l = 0; l < 2; l++)
        for (size_t k = 0; k < lists[l]->count; k++)
            if (lists[l]->pair[k].touches)
                mix(&hash, &lists[l]->pair[k].memory, sizeof lists[l]->pair[k].memory);
    return hash;
}

struct convex_counts convex_counts(const struct convex *c)
{
    struct convex_counts counts = c->counts;
    counts.steps = c->step;
    counts.pairs = c->near.count;
    return counts;
}
