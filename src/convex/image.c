/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See image.h. Images come from outside: nothing in one is believed before it is
 * looked at. */
#include "convex/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

void convex_image_free(struct convex_image *image)
{
    free(image->body);
    free(image->order);
    free(image->who);
    free(image->pair);
    *image = (struct convex_image){0};
}

/* ---- numbers in a row, in one order for both ways ---- */

static void put3(double **row, struct vec3 v)
{
    vec3_store3(*row, v);
    *row += 3;
}

static struct vec3 take3(const double **row)
{
    struct vec3 v = vec3_load(*row);
    *row += 3;
    return v;
}

static void save_body(const struct body *b, double then, double row[CONVEX_IMAGE_BODY])
{
    double *at = row;
    put3(&at, b->position);
    put3(&at, b->velocity);
    quat_store(at, b->spin.orientation);
    at += 4;
    put3(&at, b->spin.momentum);
    put3(&at, b->force);
    put3(&at, b->torque);
    at[0] = b->travel;
    at[1] = then;
}

static bool load_body(const double row[CONVEX_IMAGE_BODY], struct body *b, double *then)
{
    const double *at = row;
    for (int k = 0; k < CONVEX_IMAGE_BODY; k++)
        if (!isfinite(row[k]))
            return false;
    b->position = take3(&at);
    b->velocity = take3(&at);
    b->spin.orientation = quat_load(at);
    at += 4;
    b->spin.momentum = take3(&at);
    b->force = take3(&at);
    b->torque = take3(&at);
    b->travel = at[0];
    *then = at[1];
    convex_look_around(b);
    return fabs(quat_norm2(b->spin.orientation) - 1) < 1e-6;
}

static uint32_t packed(const uint8_t bytes[4])
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static void unpack(uint32_t word, uint8_t bytes[4])
{
    for (int k = 0; k < 4; k++)
        bytes[k] = (uint8_t)(word >> 8 * k);
}

enum { TOUCHES = 1, SLIDES = 2, ROLLS = 4, COUNT_AT = 8 }; // bits of a pair's flags; the cache's count above them

static void save_pair(const struct pair *p, uint32_t who[CONVEX_IMAGE_WHO], double row[CONVEX_IMAGE_PAIR])
{
    who[0] = p->a;
    who[1] = p->b;
    who[2] = p->part_a | (uint32_t)p->part_b << 16;
    who[3] = (p->touches ? TOUCHES : 0) | (p->result.slides ? SLIDES : 0) | (p->result.rolls ? ROLLS : 0) |
             (uint32_t)p->cache.count << COUNT_AT;
    who[4] = packed(p->cache.a);
    who[5] = packed(p->cache.b);
    double *at = row;
    put3(&at, p->memory.slip);
    put3(&at, p->memory.torque);
    put3(&at, p->memory.normal);
    put3(&at, p->point);
    put3(&at, p->result.force);
    put3(&at, p->result.torque);
    const double rest[] = {p->result.normal, p->elastic, p->share, p->looked};
    memcpy(at, rest, sizeof rest);
}

static void load_pair(const uint32_t who[CONVEX_IMAGE_WHO], const double row[CONVEX_IMAGE_PAIR], struct pair *p)
{
    const double *at = row;
    *p = (struct pair){.a = who[0], .b = who[1], .part_a = (uint16_t)who[2], .part_b = (uint16_t)(who[2] >> 16)};
    p->touches = who[3] & TOUCHES;
    p->result.slides = who[3] & SLIDES;
    p->result.rolls = who[3] & ROLLS;
    p->cache.count = (uint8_t)(who[3] >> COUNT_AT);
    unpack(who[4], p->cache.a);
    unpack(who[5], p->cache.b);
    p->memory.slip = take3(&at);
    p->memory.torque = take3(&at);
    p->memory.normal = take3(&at);
    p->point = take3(&at);
    p->result.force = take3(&at);
    p->result.torque = take3(&at);
    p->result.normal = at[0];
    p->elastic = at[1];
    p->share = at[2];
    p->looked = at[3];
}

/* Whether a pair's numbers are those of parts, vertices and walls that there are. */
static bool sound(const struct convex *c, const struct pair *p, bool wall)
{
    if (p->a >= c->bodies || p->b >= (wall ? c->setup.wall_count : c->bodies) || (!wall && p->a >= p->b))
        return false;
    const struct composite *a = c->body[p->a].shape;
    if (p->part_a >= a->parts || p->cache.count > 4)
        return false;
    size_t vertices = a->part[p->part_a].vertices;
    if (wall)
        return p->part_b < vertices && p->cache.count == 0;
    const struct composite *b = c->body[p->b].shape;
    if (p->part_b >= b->parts)
        return false;
    for (int k = 0; k < p->cache.count; k++)
        if (p->cache.a[k] >= vertices || p->cache.b[k] >= b->part[p->part_b].vertices)
            return false;
    return true;
}

/* ---- both ways ---- */

enum scree_status convex_save(const struct convex *c, struct convex_image *image, struct scree_error *err)
{
    size_t pairs = c->near.count + c->wall.count;
    *image = (struct convex_image){.scalars = {.bodies = c->bodies,
                                               .near = c->near.count,
                                               .wall = c->wall.count,
                                               .step = c->step,
                                               .queries = c->counts.queries,
                                               .rebuilds = c->counts.rebuilds,
                                               .base_steps = c->base_steps,
                                               .gravity_work = c->gravity_work}};
    memcpy(image->scalars.gravity, c->setup.gravity, sizeof image->scalars.gravity);
    vec3_store3(image->scalars.base, c->base);
    vec3_store3(image->scalars.based, c->based);
    image->body = memory_rows(c->bodies, sizeof *image->body);
    image->order = memory_rows(c->bodies, sizeof *image->order);
    image->who = memory_rows(pairs, sizeof *image->who);
    image->pair = memory_rows(pairs, sizeof *image->pair);
    if (!image->body || !image->order || !image->who || !image->pair) {
        convex_image_free(image);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a copy of %zu bodies", c->bodies);
    }
    for (size_t k = 0; k < c->bodies; k++) {
        save_body(&c->body[k], c->travel_then[k], image->body[k]);
        image->order[k] = c->order[k];
    }
    for (size_t k = 0; k < pairs; k++)
        save_pair(k < c->near.count ? &c->near.pair[k] : &c->wall.pair[k - c->near.count], image->who[k], image->pair[k]);
    return SCREE_OK;
}

static enum scree_status damaged(const char *what, struct scree_error *err)
{
    return scree_fail(err, SCREE_CORRUPT, NULL, "the image of a world of bodies is damaged: %s", what);
}

static enum scree_status load_list(struct convex *c, const struct convex_image *image, size_t from, size_t count, bool wall,
                                   struct list *list, struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&list->pair, &list->room, count, sizeof *list->pair, err);
    list->count = 0;
    for (size_t k = 0; k < count && !status; k++) {
        struct pair *p = &list->pair[k];
        load_pair(image->who[from + k], image->pair[from + k], p);
        if (!sound(c, p, wall) || (k > 0 && convex_compare(p - 1, p) >= 0))
            return damaged("a pair of parts", err);
        list->count++;
    }
    return status;
}

static enum scree_status load_order(struct convex *c, const uint32_t *order, struct scree_error *err)
{
    bool *seen = memory_rows(c->bodies, sizeof *seen);
    enum scree_status status = seen ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    for (size_t k = 0; k < c->bodies && !status; k++) {
        if (order[k] >= c->bodies || seen[order[k]])
            status = damaged("the order of bodies", err);
        else
            seen[c->order[k] = order[k]] = true;
    }
    free(seen);
    return status;
}

enum scree_status convex_load(const struct convex_image *image, const struct convex_setup *setup, struct convex **out,
                              struct scree_error *err)
{
    const struct convex_scalars *s = &image->scalars;
    struct convex *c = NULL;
    if (s->bodies != setup->body_count)
        return damaged("it has another number of bodies", err);
    enum scree_status status = convex_create(setup, &c, err);
    if (status)
        return status;
    c->step = s->step;
    c->counts.queries = s->queries;
    c->counts.rebuilds = s->rebuilds;
    c->base_steps = s->base_steps;
    c->gravity_work = s->gravity_work;
    c->base = vec3_load(s->base);
    c->based = vec3_load(s->based);
    memcpy(c->setup.gravity, s->gravity, sizeof c->setup.gravity);
    for (size_t k = 0; k < c->bodies && !status; k++)
        if (!load_body(image->body[k], &c->body[k], &c->travel_then[k]))
            status = damaged("the state of a body", err);
    if (!status && !(status = load_order(c, image->order, err)) &&
        !(status = load_list(c, image, 0, s->near, false, &c->near, err)))
        status = load_list(c, image, s->near, s->wall, true, &c->wall, err);
    if (status)
        convex_free(c);
    else
        *out = c;
    return status;
}
