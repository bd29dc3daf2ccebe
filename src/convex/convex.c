/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Making, stepping and looking at a world of convex bodies.
 *
 * The step is velocity Verlet, as the paper's; rotation is the free rotation of
 * quat.h between two halves of the torque's kick (motion_kernel.c). Forces see the velocities of
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
    void *const owned[] = {c->shapes,    c->outlines, c->own,        c->walls,      c->body,       c->corner,    c->celled,
                           c->start,     c->found,    c->met,        c->travel,     c->near.group, c->near.pair, c->wall.group,
                           c->wall.pair, c->old,      c->near.spare, c->wall.spare, c->contact,    c->spare};
    for (size_t k = 0; k < sizeof owned / sizeof *owned; k++)
        free(owned[k]);
    convex_frame_free(c->frame);
    free(c);
}

extern const struct convex_kernels convex_kernels_v2, convex_kernels_v3, convex_kernels_v4;

const struct convex_kernels *convex_kernels_for(enum cpu_isa isa)
{
    static const struct convex_kernels *const all[CPU_ISA_COUNT] = {&convex_kernels_v2, &convex_kernels_v3, &convex_kernels_v4};
    return all[isa];
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
    const struct turn turn = quat_turn(quat_load(b->orientation));
    const struct vec3 m = vec3_load(b->momentum), own = {m.x * b->inverse[0], m.y * b->inverse[1], m.z * b->inverse[2]};
    for (int i = 0; i < 3; i++)
        vec3_store3(b->axis[i], turn.column[i]);
    vec3_store3(b->omega, turn_out(&turn, own));
}

/* With what differs between shapes but not between times. */
static void make_body(const struct composite *shape, const struct outline *outline, struct body *b)
{
    *b = (struct body){.shape = shape, .outline = outline, .orientation = {1, 0, 0, 0}};
    if (!shape)
        return; // fills up the last four, or is a wall
    for (int i = 0; i < 3; i++)
        b->inverse[i] = 1 / shape->inertia[i];
    b->inverse[3] = shape->reach;
    b->velocity[3] = 1 / shape->mass;
    b->momentum[3] = shape->mass;
}

static void set_body(const struct convex_body *from, struct body *b)
{
    quat_store(b->orientation, quat_unit(quat_load(from->orientation)));
    vec3_store3(b->position, vec3_load(from->position));
    vec3_store3(b->velocity, vec3_load(from->velocity));
    struct turn t = quat_turn(quat_load(b->orientation));
    struct vec3 own = turn_in(&t, vec3_load(from->spin));
    vec3_store3(b->momentum,
                (struct vec3){own.x * b->shape->inertia[0], own.y * b->shape->inertia[1], own.z * b->shape->inertia[2]});
    convex_look_around(b);
}

static size_t filled_up(size_t count)
{
    return (count + 3) / 4 * 4;
}

/* Outlines of all shapes, one after the other; NULL memory is left to the caller to see. */
static void make_outlines(struct convex *c, size_t shapes)
{
    size_t all = 0;
    for (size_t s = 0; s < shapes; s++)
        for (size_t p = 0; p < c->shapes[s].parts; p++)
            all += filled_up(c->shapes[s].part[p].vertices);
    c->own = memory_rows(3 * all, sizeof *c->own);
    for (size_t s = 0, at = 0; c->own && s < shapes; s++) {
        struct outline *o = &c->outlines[s];
        double *own = c->own + 3 * at;
        for (size_t p = 0; p < c->shapes[s].parts; p++) {
            o->from[p] = o->corners;
            o->corners += filled_up(c->shapes[s].part[p].vertices);
        }
        for (size_t p = 0; p < c->shapes[s].parts; p++) {
            const struct composite_part *part = &c->shapes[s].part[p];
            for (size_t k = 0; k < filled_up(part->vertices); k++)
                for (size_t i = 0; i < 3; i++)
                    own[i * o->corners + o->from[p] + k] = part->vertex[k < part->vertices ? k : 0][i];
        }
        o->own = own;
        o->ball = c->shapes[s].parts == 1 && c->shapes[s].part->vertices == 1 && vec3_square(c->shapes[s].part->vertex[0]) == 0;
        at += o->corners;
        c->corners = c->corners > o->corners ? c->corners : o->corners;
    }
}

static enum scree_status make_arrays(struct convex *c, const struct convex_setup *s, struct scree_error *err)
{
    c->shapes = memory_rows(s->shape_count, sizeof *c->shapes);
    c->outlines = memory_rows(s->shape_count, sizeof *c->outlines);
    c->walls = memory_rows(s->wall_count, sizeof *c->walls);
    c->first_wall = filled_up(c->bodies);
    c->body = memory_rows(c->first_wall + s->wall_count, sizeof *c->body);
    c->travel = memory_rows(c->first_wall, sizeof *c->travel);
    c->celled = memory_rows(c->bodies, sizeof *c->celled);
    c->start = memory_rows(c->bodies + 2, sizeof *c->start);
    if (c->shapes && c->outlines) {
        memcpy(c->shapes, s->shapes, s->shape_count * sizeof *c->shapes);
        make_outlines(c, s->shape_count);
    }
    c->corner = memory_rows(c->bodies, 3 * c->corners * sizeof *c->corner);
    if (!c->shapes || !c->outlines || !c->own || !c->walls || !c->body || !c->travel || !c->celled || !c->start || !c->corner)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world of %zu bodies", c->bodies);
    if (s->wall_count > 0)
        memcpy(c->walls, s->walls, s->wall_count * sizeof *c->walls);
    return SCREE_OK;
}

enum scree_status convex_create(const struct convex_setup *s, struct convex **out, struct scree_error *err)
{
    enum cpu_isa isa;
    enum scree_status status = check(s, err);
    if (status || (status = cpu_choose(s->isa, &isa, err)))
        return status;
    struct convex *c = memory_rows(1, sizeof *c);
    if (!c)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    c->setup = *s;
    c->setup.isa = cpu_isa_name(isa);
    c->kernels = convex_kernels_for(isa);
    c->bodies = s->body_count;
    if ((status = make_arrays(c, s, err)))
        goto out;
    c->ease = 1;
    for (size_t k = 0; k < s->shape_count; k++) {
        size_t most = c->shapes[k].parts * c->shapes[k].parts;
        c->near.block = c->near.block > most ? c->near.block : most;
    }
    c->wall.block = c->corners;
    for (size_t k = 0; k < c->bodies; k++) {
        uint32_t shape = s->bodies[k].shape;
        make_body(&c->shapes[shape], &c->outlines[shape], &c->body[k]);
        set_body(&s->bodies[k], &c->body[k]);
    }
    for (size_t k = c->bodies; k < c->first_wall + s->wall_count; k++)
        make_body(NULL, NULL, &c->body[k]);
    if (!(status = convex_rebuild(c, err)))
        status = convex_forces(c, err);
out:
    if (status)
        convex_free(c);
    else
        *out = c;
    return status;
}

static enum scree_status not_finite(const struct convex *c, struct scree_error *err)
{
    size_t k = 0;
    while (k + 1 < c->bodies && isfinite(c->travel[k]))
        k++;
    return scree_fail(err, SCREE_BLOWUP, NULL, "step %llu: body %zu's motion is no longer finite", (unsigned long long)c->step, k);
}

static enum scree_status step(struct convex *c, struct scree_error *err)
{
    double beyond = c->kernels->move(c);
    if (!isfinite(beyond))
        return not_finite(c, err);
    c->step++;
    enum scree_status status = beyond > 0 ? convex_rebuild(c, err) : SCREE_OK;
    if (status || (status = convex_forces(c, err)))
        return status;
    c->kernels->kick(c);
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

struct gate_now convex_gate_now(const struct convex *c, uint32_t wall)
{
    const struct convex_gate *gate = &c->setup.gate;
    double raised = c->walls[wall].raised, since = (double)c->step * c->setup.step_s - gate->start_s;
    if (!gate->present || wall != gate->wall)
        return (struct gate_now){.partial = raised > 0, .stands = true, .lift = raised};
    if (since <= 0)
        return (struct gate_now){.partial = true, .stands = true, .lift = raised};
    if (gate->hole[0][0] < gate->hole[0][1])
        return (struct gate_now){.partial = true, .stands = true, .lift = raised, .hole = gate->hole};
    if (gate->acceleration <= 0)
        return (struct gate_now){.partial = true};
    double full = gate->speed / gate->acceleration, gaining = fmin(since, full);
    return (struct gate_now){.partial = true,
                             .stands = true,
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
    vec3_store3(out->position, vec3_load(b->position));
    vec3_store3(out->velocity, vec3_load(b->velocity));
    vec3_store3(out->spin, vec3_load(b->omega));
    quat_store(out->orientation, quat_load(b->orientation));
}

static void sum_contacts(const struct convex *c, const struct list *list, size_t *points, double *elastic)
{
    for (size_t k = 0; k < list->groups; k++)
        for (size_t p = 0; p < pairs_of(c, list, &list->group[k]); p++)
            for (uint32_t slot = list->pair[list->group[k].first + p].slot; slot != NO_CONTACT; slot = c->contact[slot].next) {
                ++*points;
                *elastic += c->contact[slot].normal[3] * c->contact[slot].moment[3];
            }
}

struct convex_sums convex_sums(const struct convex *c)
{
    struct convex_sums s = {0};
    struct vec3 momentum = {0, 0, 0}, angular = {0, 0, 0}, wall = {0, 0, 0};
    for (size_t k = 0; k < c->bodies; k++) {
        const struct body *b = &c->body[k];
        const struct turn turn = body_turn(b);
        struct vec3 velocity = vec3_load(b->velocity), p = vec3_scale(velocity, b->shape->mass);
        struct vec3 spin = turn_out(&turn, vec3_load(b->momentum));
        double speed = sqrt(vec3_dot(velocity, velocity));
        s.kinetic += 0.5 * vec3_dot(p, velocity) + 0.5 * vec3_dot(spin, vec3_load(b->omega));
        momentum = vec3_add(momentum, p);
        angular = vec3_add(angular, vec3_add(spin, vec3_cross(vec3_load(b->position), p)));
        s.speed_mean += speed / (double)c->bodies;
        s.speed_max = fmax(s.speed_max, speed);
        wall = vec3_add(wall, vec3_sub(vec3_scale(vec3_load(c->setup.gravity), b->shape->mass), vec3_load(b->force)));
    }
    sum_contacts(c, &c->near, &s.contacts, &s.elastic);
    sum_contacts(c, &c->wall, &s.contacts_wall, &s.elastic);
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

static void mix_contacts(const struct convex *c, const struct list *list, uint64_t *hash)
{
    for (size_t k = 0; k < list->groups; k++)
        for (size_t p = 0; p < pairs_of(c, list, &list->group[k]); p++)
            for (uint32_t slot = list->pair[list->group[k].first + p].slot; slot != NO_CONTACT; slot = c->contact[slot].next) {
                mix(hash, c->contact[slot].slip, 3 * sizeof(double));
                mix(hash, c->contact[slot].roll, 3 * sizeof(double));
                mix(hash, c->contact[slot].normal, 3 * sizeof(double));
            }
}

uint64_t convex_hash(const struct convex *c)
{
    uint64_t hash = 0xcbf29ce484222325U;
    for (size_t k = 0; k < c->bodies; k++) {
        const struct body *b = &c->body[k];
        mix(&hash, b->position, 3 * sizeof(double));
        mix(&hash, b->velocity, 3 * sizeof(double));
        mix(&hash, b->orientation, sizeof b->orientation);
        mix(&hash, b->momentum, 3 * sizeof(double));
    }
    mix_contacts(c, &c->near, &hash);
    mix_contacts(c, &c->wall, &hash);
    return hash;
}

struct convex_counts convex_counts(const struct convex *c)
{
    struct convex_counts counts = c->counts;
    const struct list *lists[] = {&c->near, &c->wall};
    counts.steps = c->step;
    counts.pairs = c->near.pairs;
    counts.bytes = c->first_wall * (sizeof *c->body + sizeof *c->travel) +
                   c->bodies * (3 * c->corners * sizeof *c->corner + sizeof *c->celled + sizeof *c->start) +
                   c->found_room * sizeof *c->found + c->contact_room * sizeof *c->contact + c->spare_room * sizeof *c->spare;
    for (int l = 0; l < 2; l++)
        counts.bytes += lists[l]->group_room * sizeof(struct group) + lists[l]->pair_room * sizeof(struct pair) +
                        lists[l]->spare_room * sizeof(uint32_t);
    counts.bytes += c->old_room * sizeof *c->old + c->met_room * sizeof *c->met;
    return counts;
}

const char *convex_isa(const struct convex *c)
{
    return c->setup.isa;
}
