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
    void *const owned[] = {image->body, image->group, image->group_due, image->who, image->pair_due, image->contact};
    for (size_t k = 0; k < sizeof owned / sizeof *owned; k++)
        free(owned[k]);
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

static void save_body(const struct body *b, double travel, double row[CONVEX_IMAGE_BODY])
{
    double *at = row;
    put3(&at, vec3_load(b->position));
    put3(&at, vec3_load(b->velocity));
    quat_store(at, quat_load(b->orientation));
    at += 4;
    put3(&at, vec3_load(b->momentum));
    put3(&at, vec3_load(b->force));
    put3(&at, vec3_load(b->torque));
    put3(&at, vec3_load(b->listed));
    *at++ = b->listed[3];
    *at = travel;
}

static bool load_body(const double row[CONVEX_IMAGE_BODY], struct body *b, double *travel)
{
    const double *at = row;
    for (int k = 0; k < CONVEX_IMAGE_BODY; k++)
        if (!isfinite(row[k]))
            return false;
    vec3_store3(b->position, take3(&at));
    vec3_store3(b->velocity, take3(&at));
    quat_store(b->orientation, quat_load(at));
    at += 4;
    vec3_store3(b->momentum, take3(&at));
    vec3_store3(b->force, take3(&at));
    vec3_store3(b->torque, take3(&at));
    vec3_store3(b->listed, take3(&at));
    b->listed[3] = *at++;
    *travel = *at;
    b->placed = 0;
    convex_look_around(b);
    return fabs(quat_norm2(quat_load(b->orientation)) - 1) < 1e-6;
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

enum { FLAT = 1, ALONG_B = 2, FACE_A_AT = 8, FACE_B_AT = 16, COUNT_AT = 8 }; // bits of words

static void save_pair(const struct convex *c, const struct pair *p, uint32_t who[CONVEX_IMAGE_WHO])
{
    who[0] = (uint32_t)convex_points(c, p) | (uint32_t)p->cache.count << COUNT_AT;
    who[1] = packed(p->cache.a);
    who[2] = packed(p->cache.b);
    who[3] = p->faces.plane ? FLAT | (p->faces.plane == PATCH_ON_B ? ALONG_B : 0U) | (uint32_t)p->faces.a << FACE_A_AT |
                                  (uint32_t)p->faces.b << FACE_B_AT
                            : 0;
}

static size_t load_pair(const uint32_t who[CONVEX_IMAGE_WHO], struct pair *p)
{
    p->cache.count = (uint8_t)(who[0] >> COUNT_AT);
    unpack(who[1], p->cache.a);
    unpack(who[2], p->cache.b);
    const uint8_t plane = !(who[3] & FLAT) ? PATCH_NONE : who[3] & ALONG_B ? PATCH_ON_B : PATCH_ON_A;
    p->faces = (struct patch_faces){(uint8_t)(who[3] >> FACE_A_AT), (uint8_t)(who[3] >> FACE_B_AT), plane};
    return who[0] & 0xff;
}

static void save_contact(const struct contact *p, double row[CONVEX_IMAGE_CONTACT])
{
    const double *const vectors[] = {p->slip, p->roll, p->normal, p->point, p->force, p->moment};
    double *at = row;
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        put3(&at, vec3_load(vectors[k]));
    const double rest[] = {p->force[3], p->normal[3], p->moment[3], p->slides, p->rolls};
    memcpy(at, rest, sizeof rest);
}

static void load_contact(const double row[CONVEX_IMAGE_CONTACT], struct contact *p)
{
    double *const vectors[] = {p->slip, p->roll, p->normal, p->point, p->force, p->moment};
    const double *at = row;
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        vec3_store3(vectors[k], take3(&at));
    p->force[3] = at[0];
    p->normal[3] = at[1];
    p->moment[3] = at[2];
    p->slides = at[3] != 0;
    p->rolls = at[4] != 0;
}

/* Whether the corners and faces that two parts remember are there. */
static bool sound_pair(const struct pair *p, size_t points, const struct composite_part *a, const struct composite_part *b)
{
    const struct gjk_cache *cache = &p->cache;
    for (int k = 0; k < cache->count && k < 4; k++)
        if (cache->a[k] >= a->vertices || cache->b[k] >= b->vertices)
            return false;
    return cache->count <= 4 && points <= PATCH_POINTS_MAX && (!p->faces.plane || (p->faces.a < a->faces && p->faces.b < b->faces));
}

static bool sound_corner(const struct pair *p, size_t points)
{
    return p->cache.count == 0 && !p->faces.plane && points <= 1;
}

/* ---- both ways ---- */

/* How far an image has been written. */
struct writing {
    const struct convex_image *image;
    size_t group, pair, contact;
};

static void save_list(const struct convex *c, const struct list *list, struct writing *at)
{
    const struct convex_image *m = at->image;
    for (size_t k = 0; k < list->groups; k++, at->group++) {
        const struct group *g = &list->group[k];
        m->group[at->group][0] = g->a;
        m->group[at->group][1] = g->b;
        m->group_due[at->group] = g->due;
        for (const struct pair *p = list->pair + g->first; p < list->pair + g->first + pairs_of(c, list, g); p++, at->pair++) {
            m->pair_due[at->pair] = p->due;
            save_pair(c, p, m->who[at->pair]);
            for (uint32_t slot = p->slot; slot != NO_CONTACT; slot = c->contact[slot].next)
                save_contact(&c->contact[slot], m->contact[at->contact++]);
        }
    }
}

enum scree_status convex_save(const struct convex *c, struct convex_image *image, struct scree_error *err)
{
    struct convex_image m = {.scalars = {.bodies = c->bodies,
                                         .near = c->near.groups,
                                         .wall = c->wall.groups,
                                         .pairs = c->near.pairs + c->wall.pairs,
                                         .contacts = c->contacts - c->spares,
                                         .step = c->step,
                                         .queries = c->counts.queries,
                                         .searches = c->counts.searches,
                                         .rebuilds = c->counts.rebuilds,
                                         .listed_at = c->listed_at,
                                         .ease = c->ease,
                                         .base_steps = c->base_steps,
                                         .gravity_work = c->gravity_work}};
    memcpy(m.scalars.gravity, c->setup.gravity, sizeof m.scalars.gravity);
    vec3_store3(m.scalars.base, c->base);
    vec3_store3(m.scalars.based, c->based);
    size_t groups = c->near.groups + c->wall.groups;
    m.body = memory_rows(c->bodies, sizeof *m.body);
    m.group = memory_rows(groups, sizeof *m.group);
    m.group_due = memory_rows(groups, sizeof *m.group_due);
    m.who = memory_rows(m.scalars.pairs, sizeof *m.who);
    m.pair_due = memory_rows(m.scalars.pairs, sizeof *m.pair_due);
    m.contact = memory_rows(m.scalars.contacts, sizeof *m.contact);
    *image = m;
    if (!m.body || !m.group || !m.group_due || !m.who || !m.pair_due || !m.contact) {
        convex_image_free(image);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a copy of %zu bodies", c->bodies);
    }
    for (size_t k = 0; k < c->bodies; k++)
        save_body(&c->body[k], c->travel[k], m.body[k]);
    struct writing at = {&m, 0, 0, 0};
    save_list(c, &c->near, &at);
    save_list(c, &c->wall, &at);
    return SCREE_OK;
}

static enum scree_status damaged(const char *what, struct scree_error *err)
{
    return scree_fail(err, SCREE_CORRUPT, NULL, "the image of a world of bodies is damaged: %s", what);
}

/* How far an image has been read. */
struct reading {
    const struct convex_image *image;
    size_t group, pair, contact;
};

static enum scree_status load_pairs(struct convex *c, struct reading *r, struct list *list, struct group *g, bool wall,
                                    struct scree_error *err)
{
    const struct composite *a = c->body[g->a].shape, *b = wall ? NULL : c->body[g->b].shape;
    size_t count = pairs_of(c, list, g);
    enum scree_status status = convex_take_block(list, g, err);
    if (status)
        return status;
    list->pairs += count;
    if (r->pair + count > r->image->scalars.pairs)
        return damaged("pairs are missing", err);
    for (size_t k = 0; k < count && !status; k++, r->pair++) {
        struct pair *p = &list->pair[g->first + k];
        p->due = r->image->pair_due[r->pair];
        size_t points = load_pair(r->image->who[r->pair], p);
        if (wall ? !sound_corner(p, points) : !sound_pair(p, points, &a->part[k / b->parts], &b->part[k % b->parts]))
            return damaged("a pair of parts", err);
        if (points > r->image->scalars.contacts - r->contact)
            return damaged("contacts are missing", err);
        if (points == 0 || (status = convex_touch(c, p, points, err)))
            continue;
        for (uint32_t slot = p->slot; slot != NO_CONTACT; slot = c->contact[slot].next)
            load_contact(r->image->contact[r->contact++], &c->contact[slot]);
        g->touching++;
    }
    return status;
}

static enum scree_status load_list(struct convex *c, struct reading *r, size_t count, bool wall, struct list *list,
                                   struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    list->groups = list->pairs = list->blocks = list->spares = 0;
    for (size_t k = 0; k < count && !status; k++, r->group++) {
        if ((status = convex_list_room(list, list->groups + 1, err)))
            break;
        const uint32_t *who = r->image->group[r->group];
        struct group *g = &list->group[list->groups++];
        *g = (struct group){.a = who[0], .b = who[1], .due = r->image->group_due[r->group]};
        bool ordered = k == 0 || g[-1].a < g->a || (g[-1].a == g->a && g[-1].b < g->b);
        if (g->a >= c->bodies || g->b >= (wall ? c->setup.wall_count : c->bodies) || (!wall && g->a >= g->b) || !ordered)
            return damaged("a pair of bodies", err);
        status = load_pairs(c, r, list, g, wall, err);
    }
    return status;
}

enum scree_status convex_load(const struct convex_image *image, const struct convex_setup *setup, struct convex **out,
                              struct scree_error *err)
{
    const struct convex_scalars *s = &image->scalars;
    struct reading r = {.image = image};
    struct convex *c = NULL;
    if (s->bodies != setup->body_count)
        return damaged("it has another number of bodies", err);
    if (!(s->ease >= 1 && s->ease <= CONVEX_EASE_MAX))
        return damaged("the width of margins", err);
    enum scree_status status = convex_create(setup, &c, err);
    if (status)
        return status;
    c->step = s->step;
    c->counts.queries = s->queries;
    c->counts.searches = s->searches;
    c->counts.rebuilds = s->rebuilds;
    c->listed_at = s->listed_at;
    c->ease = s->ease;
    c->base_steps = s->base_steps;
    c->gravity_work = s->gravity_work;
    c->base = vec3_load(s->base);
    c->based = vec3_load(s->based);
    memcpy(c->setup.gravity, s->gravity, sizeof c->setup.gravity);
    c->contacts = c->spares = 0;
    for (size_t k = 0; k < c->bodies && !status; k++)
        if (!load_body(image->body[k], &c->body[k], &c->travel[k]))
            status = damaged("the state of a body", err);
    if (!status && !(status = load_list(c, &r, s->near, false, &c->near, err)) &&
        !(status = load_list(c, &r, s->wall, true, &c->wall, err)) && (r.pair != s->pairs || r.contact != s->contacts))
        status = damaged("there is more than belongs to it", err);
    if (status)
        convex_free(c);
    else
        *out = c;
    return status;
}
