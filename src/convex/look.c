/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world of convex bodies as measurements see it (view.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

/* Arrays of a view: a row a body. */
struct frame {
    uint32_t *id;
    double (*position)[4], (*velocity)[4], (*spin)[4];
    struct view_body *body;
    struct view_contact *contact;
    size_t room; // of contacts
    uint32_t *part_start;
    double (*corner)[4];
};

void convex_frame_free(struct frame *f)
{
    if (!f)
        return;
    free(f->id);
    free(f->position);
    free(f->velocity);
    free(f->spin);
    free(f->body);
    free(f->contact);
    free(f->part_start);
    free(f->corner);
    free(f);
}

static struct frame *make_frame(const struct convex *c)
{
    struct frame *f = calloc(1, sizeof *f);
    size_t bodies = c->bodies, parts = 0, corners = 0;
    if (!f)
        return NULL;
    for (size_t k = 0; k < bodies; k++) {
        parts += c->body[k].shape->parts;
        for (size_t p = 0; p < c->body[k].shape->parts; p++)
            corners += c->body[k].shape->part[p].vertices;
    }
    f->part_start = memory_rows(parts + 1, sizeof *f->part_start);
    f->corner = memory_rows(corners, sizeof *f->corner);
    f->id = memory_rows(bodies, sizeof *f->id);
    f->position = memory_rows(bodies, sizeof *f->position);
    f->velocity = memory_rows(bodies, sizeof *f->velocity);
    f->spin = memory_rows(bodies, sizeof *f->spin);
    f->body = memory_rows(bodies, sizeof *f->body);
    if (f->part_start && f->corner && f->id && f->position && f->velocity && f->spin && f->body)
        return f;
    convex_frame_free(f);
    return NULL;
}

/* Corners of a body from row `at` on; returns the next free row. */
static uint32_t show_parts(const struct body *b, uint32_t first, uint32_t at, struct frame *f)
{
    const struct turn turn = body_turn(b);
    for (size_t p = 0; p < b->shape->parts; p++) {
        const struct composite_part *part = &b->shape->part[p];
        f->part_start[first + p] = at;
        for (size_t v = 0; v < part->vertices; v++, at++) {
            vec3_store(f->corner[at], vec3_add(vec3_load(b->position), turn_out(&turn, vec3_load(part->vertex[v]))));
            f->corner[at][3] = part->radius;
        }
    }
    f->part_start[first + b->shape->parts] = at;
    return at;
}

static void show_bodies(const struct convex *c, struct frame *f)
{
    uint32_t part = 0, corner = 0;
    for (size_t k = 0; k < c->bodies; k++) {
        const struct body *b = &c->body[k];
        struct view_body *v = &f->body[k];
        f->id[k] = (uint32_t)k;
        const struct turn turn = body_turn(b);
        vec3_store(f->position[k], vec3_load(b->position));
        f->position[k][3] = cbrt(3 * b->shape->volume / (4 * M_PI));
        vec3_store(f->velocity[k], vec3_load(b->velocity));
        f->velocity[k][3] = b->shape->mass;
        vec3_store(f->spin[k], vec3_load(b->omega));
        *v = (struct view_body){.id = (uint32_t)k,
                                .shape = (uint32_t)(b->shape - c->shapes),
                                .first = (uint32_t)k,
                                .members = 1,
                                .mass = b->shape->mass,
                                .volume = b->shape->volume,
                                .part_first = part,
                                .parts = (uint32_t)b->shape->parts};
        corner = show_parts(b, part, corner, f);
        part += v->parts;
        vec3_store3(v->position, vec3_load(b->position));
        vec3_store3(v->velocity, vec3_load(b->velocity));
        vec3_store3(v->spin, vec3_load(b->omega));
        vec3_store3(v->momentum, turn_out(&turn, vec3_load(b->momentum)));
        quat_store(v->orientation, quat_load(b->orientation));
    }
}

/* What the law gave to a is what b gives it: signs turn round for the force of a on b. */
static void show_contact(const struct convex *c, const struct group *g, const struct contact *p, bool wall, struct view_contact *v)
{
    const struct spring_pair *law = wall ? &c->setup.at_wall : &c->setup.between;
    const struct body *a = &c->body[g->a], *b = wall ? NULL : &c->body[g->b];
    struct vec3 force = vec3_scale(vec3_load(p->force), p->moment[3]), torque = vec3_scale(vec3_load(p->moment), p->moment[3]);
    struct vec3 point = vec3_load(p->point), normal = vec3_load(p->normal), closing = body_velocity_at(a, point);
    *v = (struct view_contact){.a = g->a,
                               .b = wall ? VIEW_WALL + g->b : g->b,
                               .on_base = wall && g->b == 0,
                               .overlap = sqrt(2 * p->normal[3] / law->stiffness),
                               .force_normal = p->force[3] * p->moment[3],
                               .elastic = p->normal[3] * p->moment[3]};
    if (b)
        closing = vec3_sub(closing, body_velocity_at(b, point));
    vec3_store3(v->normal, normal);
    vec3_store3(v->point, point);
    v->approach = vec3_dot(closing, normal);
    vec3_store3(v->force, vec3_scale(force, -1));
    vec3_store3(v->torque_a, vec3_add(torque, vec3_cross(vec3_sub(point, vec3_load(a->position)), force)));
    if (b)
        vec3_store3(v->torque_b, vec3_scale(vec3_add(torque, vec3_cross(vec3_sub(point, vec3_load(b->position)), force)), -1));
}

static size_t show_contacts(const struct convex *c, const struct list *list, bool wall, struct view_contact *to)
{
    size_t shown = 0;
    for (size_t k = 0; k < list->groups; k++) {
        const struct group *g = &list->group[k];
        size_t pairs = wall ? c->body[g->a].outline->corners : pairs_between(&c->body[g->a], &c->body[g->b]);
        for (size_t p = 0; p < pairs; p++)
            for (uint32_t slot = list->pair[g->first + p].slot; slot != NO_CONTACT; slot = c->contact[slot].next)
                show_contact(c, g, &c->contact[slot], wall, &to[shown++]);
    }
    return shown;
}

enum scree_status convex_view(struct convex *c, struct view *out, struct scree_error *err)
{
    size_t contacts = 0;
    if (!c->frame && !(c->frame = make_frame(c)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to look at %zu bodies", c->bodies);
    struct frame *f = c->frame;
    enum scree_status status = memory_grow((void **)&f->contact, &f->room, c->contacts - c->spares + 1, sizeof *f->contact, err);
    if (status)
        return status;
    show_bodies(c, f);
    contacts = show_contacts(c, &c->near, false, f->contact);
    contacts += show_contacts(c, &c->wall, true, f->contact + contacts);
    *out = (struct view){.time_s = convex_time(c),
                         .step_s = c->setup.step_s,
                         .step = c->step,
                         .moving = c->bodies,
                         .id = f->id,
                         .position = (const double(*)[4])f->position,
                         .velocity = (const double(*)[4])f->velocity,
                         .spin = (const double(*)[4])f->spin,
                         .bodies = c->bodies,
                         .body = f->body,
                         .part_start = f->part_start,
                         .corner = (const double(*)[4])f->corner,
                         .contacts = contacts,
                         .contact = f->contact,
                         .gravity_work = c->gravity_work};
    memcpy(out->gravity, c->setup.gravity, sizeof out->gravity);
    vec3_store3(out->base_force, c->base);
    return SCREE_OK;
}
