/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Contacts: where parts touch, what the law says of it, and who feels it. */
#include <math.h>
#include <string.h>

#include "convex/state.h"

static struct gjk_core core_of(const struct body *b, size_t part)
{
    const struct composite_part *p = &b->shape->part[part];
    return (struct gjk_core){p->vertex, p->vertices, b->turn, b->position};
}

static struct vec3 velocity_at(const struct body *b, struct vec3 point)
{
    return vec3_add(b->velocity, vec3_cross(b->omega, vec3_sub(point, b->position)));
}

static void touch(struct convex *c, struct pair *p, const struct spring_pair *law, struct spring_motion *motion)
{
    p->touches = true;
    p->result = spring_memory_step(law, motion, c->setup.step_s, &p->memory);
    p->elastic = 0.5 * law->stiffness * motion->overlap * motion->overlap;
}

static void part_company(struct pair *p)
{
    p->touches = false;
    p->memory = (struct spring_memory){.slip = {0, 0, 0}};
}

static enum scree_status look_at_pair(struct convex *c, struct pair *p, struct scree_error *err)
{
    const struct body *a = &c->body[p->a], *b = &c->body[p->b];
    double crust = a->shape->part[p->part_a].radius + b->shape->part[p->part_b].radius;
    struct gjk_core ca = core_of(a, p->part_a), cb = core_of(b, p->part_b);
    struct gjk_result r;
    c->counts.queries++;
    enum gjk_state state = gjk_distance(&ca, &cb, &p->cache, &r);
    if (state != GJK_APART)
        return scree_fail(err, SCREE_BLOWUP, NULL,
                          state == GJK_INSIDE ? "step %llu: bodies %u and %u are deeper in each other than their crusts of %g m"
                                              : "step %llu: the distance of bodies %u and %u was not found (crusts of %g m)",
                          (unsigned long long)c->step, p->a, p->b, crust);
    double overlap = crust - r.distance;
    if (overlap <= 0) {
        if (p->touches)
            part_company(p);
        p->looked = a->travel + b->travel - overlap;
        return SCREE_OK;
    }
    p->looked = 0;
    double from_a = a->shape->part[p->part_a].radius, from_b = b->shape->part[p->part_b].radius;
    p->point = vec3_scale(vec3_add(vec3_add(r.on_a, r.on_b), vec3_scale(r.normal, from_a - from_b)), 0.5);
    struct spring_motion motion = {.overlap = overlap,
                                   .normal = r.normal,
                                   .velocity = vec3_sub(velocity_at(a, p->point), velocity_at(b, p->point)),
                                   .spin = vec3_sub(a->omega, b->omega)};
    touch(c, p, &c->setup.between, &motion);
    return SCREE_OK;
}

/* What is under the gate, or has come past it, is not touched by it. */
static bool past_gate(const struct gate_now *gate, const struct pair *p, struct vec3 x, double height)
{
    return !gate->stands || x.z < gate->lift || (!p->touches && height < 0);
}

static void look_at_wall(struct convex *c, struct pair *p, const struct gate_now *gate)
{
    bool is_gate = c->setup.gate.present && p->b == c->setup.gate.wall;
    const struct body *a = &c->body[p->a];
    const struct convex_wall *wall = &c->walls[p->b];
    const struct composite_part *part = &a->shape->part[p->part_a];
    struct vec3 normal = vec3_load(wall->normal);
    struct vec3 x = vec3_add(a->position, turn_out(&a->turn, vec3_load(part->vertex[p->part_b])));
    double height = vec3_dot(vec3_sub(x, vec3_load(wall->point)), normal), overlap = part->radius - height;
    if (is_gate && past_gate(gate, p, x, height)) {
        if (p->touches)
            part_company(p);
        p->looked = 0;
        return;
    }
    if (overlap <= 0) {
        if (p->touches)
            part_company(p);
        p->looked = a->travel - overlap;
        return;
    }
    p->looked = 0;
    p->point = vec3_sub(x, vec3_scale(normal, 0.5 * (height + part->radius)));
    struct spring_motion motion = {
        .overlap = overlap, .normal = vec3_scale(normal, -1), .velocity = velocity_at(a, p->point), .spin = a->omega};
    motion.velocity.z -= is_gate ? gate->speed : 0;
    touch(c, p, &c->setup.at_wall, &motion);
}

static void feel(struct body *b, const struct pair *p, double share)
{
    struct vec3 force = vec3_scale(p->result.force, share);
    b->force = vec3_add(b->force, force);
    b->torque = vec3_add(b->torque, vec3_cross(vec3_sub(p->point, b->position), force));
    b->torque = vec3_add(b->torque, vec3_scale(p->result.torque, share));
}

/* Pairs of the same two bodies stand side by side in a list: `from` to the returned end. */
static size_t same_bodies(const struct list *list, size_t from, size_t *touching)
{
    size_t end = from;
    for (*touching = 0; end < list->count && list->pair[end].a == list->pair[from].a && list->pair[end].b == list->pair[from].b;
         end++)
        *touching += list->pair[end].touches;
    return end;
}

static void hand_out(struct convex *c, struct list *list, bool walls)
{
    size_t touching;
    for (size_t k = 0; k < list->count;) {
        size_t end = same_bodies(list, k, &touching);
        double share = c->setup.average && touching > 0 ? 1.0 / (double)touching : 1;
        for (; k < end; k++) {
            struct pair *p = &list->pair[k];
            if (!p->touches)
                continue;
            p->share = share;
            feel(&c->body[p->a], p, share);
            if (!walls)
                feel(&c->body[p->b], p, -share);
            else if (p->b == 0)
                c->base = vec3_sub(c->base, vec3_scale(p->result.force, share));
        }
    }
}

enum scree_status convex_forces(struct convex *c, struct scree_error *err)
{
    for (size_t k = 0; k < c->bodies; k++) {
        struct body *b = &c->body[k];
        b->force = vec3_scale(vec3_load(c->setup.gravity), b->shape->mass);
        b->torque = (struct vec3){0, 0, 0};
    }
    for (size_t k = 0; k < c->near.count; k++) {
        struct pair *p = &c->near.pair[k];
        enum scree_status status = SCREE_OK;
        if (c->body[p->a].travel + c->body[p->b].travel >= p->looked && (status = look_at_pair(c, p, err)))
            return status;
    }
    struct gate_now gate = convex_gate_now(c);
    for (size_t k = 0; k < c->wall.count; k++)
        if (c->body[c->wall.pair[k].a].travel >= c->wall.pair[k].looked)
            look_at_wall(c, &c->wall.pair[k], &gate);
    c->base = (struct vec3){0, 0, 0};
    hand_out(c, &c->near, false);
    hand_out(c, &c->wall, true);
    return SCREE_OK;
}
