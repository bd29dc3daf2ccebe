/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which bodies may touch before some centre has moved half the skin. Bodies are
 * sorted along the axis they are spread out along most, and swept; lists are in the
 * order of their numbers, whatever the order along that axis, so that sums of forces
 * never change their order. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

static int compare(const void *x, const void *y)
{
    const struct group *a = x, *b = y;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return a->b < b->b ? -1 : a->b > b->b;
}

enum scree_status convex_list_room(struct list *list, size_t groups, size_t pairs, struct scree_error *err)
{
    if (pairs >= NO_CONTACT)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "too many parts of bodies are near each other: %zu pairs", pairs);
    enum scree_status status = memory_grow((void **)&list->group, &list->group_room, groups, sizeof *list->group, err);
    return status ? status : memory_grow((void **)&list->pair, &list->pair_room, pairs, sizeof *list->pair, err);
}

static enum scree_status add(struct list *list, uint32_t a, uint32_t b, struct scree_error *err)
{
    enum scree_status status = convex_list_room(list, list->groups + 1, 0, err);
    if (!status)
        list->group[list->groups++] = (struct group){.a = a, .b = b};
    return status;
}

static size_t pairs_of(const struct convex *c, const struct list *list, const struct group *g)
{
    return list == &c->wall ? c->body[g->a].outline->corners : pairs_between(&c->body[g->a], &c->body[g->b]);
}

/* Puts the new list in order and takes over what the old one knew of the same bodies; contacts of those that are no
 * longer near, as with a gate that has gone, end. */
static enum scree_status carry_over(struct convex *c, struct list *list, struct list *old, struct scree_error *err)
{
    size_t pairs = 0, o = 0;
    if (list->groups > 0)
        qsort(list->group, list->groups, sizeof *list->group, compare);
    for (size_t k = 0; k < list->groups; k++)
        pairs += pairs_of(c, list, &list->group[k]);
    enum scree_status status = convex_list_room(list, list->groups, pairs, err);
    if (status)
        return status;
    list->pairs = 0;
    for (size_t k = 0; k < list->groups; k++) {
        struct group *g = &list->group[k];
        size_t count = pairs_of(c, list, g);
        for (; o < old->groups && compare(&old->group[o], g) < 0; o++)
            for (size_t p = 0; p < pairs_of(c, list, &old->group[o]); p++)
                convex_part(c, &old->pair[old->group[o].first + p]);
        bool known = o < old->groups && compare(&old->group[o], g) == 0;
        struct pair *to = &list->pair[list->pairs];
        if (known)
            memcpy(to, &old->pair[old->group[o].first], count * sizeof *to);
        else
            for (size_t p = 0; p < count; p++)
                to[p] = (struct pair){.slot = NO_CONTACT};
        if (known)
            *g = old->group[o++];
        g->first = (uint32_t)list->pairs;
        list->pairs += count;
    }
    for (; o < old->groups; o++)
        for (size_t p = 0; p < pairs_of(c, list, &old->group[o]); p++)
            convex_part(c, &old->pair[old->group[o].first + p]);
    return SCREE_OK;
}

static void swap(struct list *list, struct list *old)
{
    struct list kept = *list;
    *list = *old;
    *old = kept;
    list->groups = list->pairs = 0;
}

static int widest_axis(const struct convex *c)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    int axis = 0;
    for (size_t k = 0; k < c->bodies; k++)
        for (int i = 0; i < 3; i++) {
            low[i] = fmin(low[i], c->body[k].position[i]);
            high[i] = fmax(high[i], c->body[k].position[i]);
        }
    for (int i = 1; i < 3; i++)
        axis = high[i] - low[i] > high[axis] - low[axis] ? i : axis;
    return axis;
}

/* Bodies hardly change places between two lists: insertion is nearly linear. */
static void sort_along(struct convex *c)
{
    int axis = c->along = widest_axis(c);
    for (size_t k = 1; k < c->bodies; k++) {
        uint32_t body = c->order[k];
        double x = c->body[body].position[axis];
        size_t at = k;
        for (; at > 0 && c->body[c->order[at - 1]].position[axis] > x; at--)
            c->order[at] = c->order[at - 1];
        c->order[at] = body;
    }
}

static enum scree_status find_near(struct convex *c, double reach_max, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < c->bodies && !status; k++) {
        const struct body *one = &c->body[c->order[k]];
        double far = one->shape->reach + reach_max + c->skin;
        for (size_t other = k + 1; other < c->bodies && !status; other++) {
            const struct body *two = &c->body[c->order[other]];
            double d[3], reach = one->shape->reach + two->shape->reach + c->skin;
            for (int i = 0; i < 3; i++)
                d[i] = two->position[i] - one->position[i];
            if (d[c->along] > far)
                break;
            if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > reach * reach)
                continue;
            uint32_t i = c->order[k], j = c->order[other];
            status = add(&c->near, i < j ? i : j, i < j ? j : i, err);
        }
    }
    return status;
}

static enum scree_status find_walls(struct convex *c, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (uint32_t a = 0; a < c->bodies; a++)
        for (uint32_t w = 0; w < c->setup.wall_count && !status; w++) {
            const struct body *body = &c->body[a];
            const struct gate_now gate = convex_gate_now(c, w);
            struct vec3 from = vec3_sub(vec3_load(body->position), vec3_load(c->walls[w].point));
            double far = vec3_dot(from, vec3_load(c->walls[w].normal)), reach = body->shape->reach + c->skin;
            if (far <= reach && gate.stands && !(gate.partial && far < -reach)) // which has another side
                status = add(&c->wall, a, w, err);
        }
    return status;
}

enum scree_status convex_rebuild(struct convex *c, struct scree_error *err)
{
    double reach_max = 0;
    for (size_t k = 0; k < c->bodies; k++) {
        reach_max = fmax(reach_max, c->body[k].shape->reach);
        for (int i = 0; i < 3; i++)
            c->body[k].listed[i] = c->body[k].position[i];
    }
    sort_along(c);
    swap(&c->near, &c->old);
    enum scree_status status = find_near(c, reach_max, err);
    if (status || (status = carry_over(c, &c->near, &c->old, err)))
        return status;
    swap(&c->wall, &c->old);
    if ((status = find_walls(c, err)) || (status = carry_over(c, &c->wall, &c->old, err)))
        return status;
    c->counts.rebuilds++;
    return SCREE_OK;
}
