/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which parts of which bodies may touch before some body has moved half the skin.
 * Bodies are sorted along x and swept; lists are in the order of body and part
 * numbers, whatever the order along x, so that sums of forces never change their order. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

int convex_compare(const void *x, const void *y)
{
    const struct pair *a = x, *b = y;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    if (a->b != b->b)
        return a->b < b->b ? -1 : 1;
    if (a->part_a != b->part_a)
        return a->part_a < b->part_a ? -1 : 1;
    return a->part_b < b->part_b ? -1 : a->part_b > b->part_b;
}

static enum scree_status add(struct list *list, uint32_t a, uint32_t b, size_t part_a, size_t part_b, struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&list->pair, &list->room, list->count + 1, sizeof *list->pair, err);
    if (!status)
        list->pair[list->count++] = (struct pair){.a = a, .b = b, .part_a = (uint16_t)part_a, .part_b = (uint16_t)part_b};
    return status;
}

/* Puts the new list in order and takes over what the old one knew of the same parts. */
static void carry_over(struct list *list, const struct list *old)
{
    if (list->count > 0)
        qsort(list->pair, list->count, sizeof *list->pair, convex_compare);
    for (size_t k = 0, o = 0; k < list->count; k++) {
        while (o < old->count && convex_compare(&old->pair[o], &list->pair[k]) < 0)
            o++;
        if (o < old->count && convex_compare(&old->pair[o], &list->pair[k]) == 0)
            list->pair[k] = old->pair[o];
    }
}

static void swap(struct list *list, struct list *old)
{
    struct list kept = *list;
    *list = *old;
    *old = kept;
    list->count = 0;
}

/* Bodies hardly change places along x between two lists: insertion is nearly linear. */
static void sort_along_x(struct convex *c)
{
    for (size_t k = 1; k < c->bodies; k++) {
        uint32_t body = c->order[k];
        double x = c->body[body].position.x;
        size_t at = k;
        for (; at > 0 && c->body[c->order[at - 1]].position.x > x; at--)
            c->order[at] = c->order[at - 1];
        c->order[at] = body;
    }
}

static enum scree_status find_near(struct convex *c, double reach_max, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < c->bodies && !status; k++)
        for (size_t other = k + 1; other < c->bodies && !status; other++) {
            uint32_t i = c->order[k], j = c->order[other], a = i < j ? i : j, b = i < j ? j : i;
            struct vec3 d = vec3_sub(c->body[j].position, c->body[i].position);
            const struct composite *sa = c->body[a].shape, *sb = c->body[b].shape;
            if (d.x > c->body[i].shape->reach + reach_max + c->skin)
                break;
            double reach = sa->reach + sb->reach + c->skin;
            if (vec3_dot(d, d) > reach * reach)
                continue;
            for (size_t p = 0; p < sa->parts && !status; p++)
                for (size_t q = 0; q < sb->parts && !status; q++)
                    status = add(&c->near, a, b, p, q, err);
        }
    return status;
}

static enum scree_status find_walls(struct convex *c, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    bool gate = convex_gate_now(c).stands;
    for (uint32_t a = 0; a < c->bodies; a++)
        for (uint32_t w = 0; w < c->setup.wall_count; w++) {
            const struct body *body = &c->body[a];
            struct vec3 from = vec3_sub(body->position, vec3_load(c->walls[w].point));
            double far = vec3_dot(from, vec3_load(c->walls[w].normal)), reach = body->shape->reach + c->skin;
            bool is_gate = c->setup.gate.present && w == c->setup.gate.wall; // which has another side, and goes
            if (far > reach || (is_gate && (!gate || far < -reach)))
                continue;
            for (size_t p = 0; p < body->shape->parts && !status; p++)
                for (size_t v = 0; v < body->shape->part[p].vertices && !status; v++)
                    status = add(&c->wall, a, w, p, v, err);
            if (status)
                return status;
        }
    return SCREE_OK;
}

enum scree_status convex_rebuild(struct convex *c, struct scree_error *err)
{
    double reach_max = 0;
    for (size_t k = 0; k < c->bodies; k++) {
        reach_max = fmax(reach_max, c->body[k].shape->reach);
        c->travel_then[k] = c->body[k].travel;
    }
    sort_along_x(c);
    swap(&c->near, &c->old);
    enum scree_status status = find_near(c, reach_max, err);
    if (status)
        return status;
    carry_over(&c->near, &c->old);
    swap(&c->wall, &c->old);
    if ((status = find_walls(c, err)))
        return status;
    carry_over(&c->wall, &c->old);
    c->counts.rebuilds++;
    return SCREE_OK;
}
