/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Slots of contacts, and the forces of a step. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

static enum scree_status begin(struct convex *c, struct pair *pair, struct scree_error *err)
{
    uint32_t slot;
    if (c->spares > 0) {
        slot = c->spare[--c->spares];
    } else {
        enum scree_status status = memory_grow((void **)&c->contact, &c->contact_room, c->contacts + 1, sizeof *c->contact, err);
        if (status || (status = memory_grow((void **)&c->spare, &c->spare_room, c->contacts + 1, sizeof *c->spare, err)))
            return status;
        slot = (uint32_t)c->contacts++;
    }
    c->contact[slot] = (struct contact){.next = pair->slot};
    pair->slot = slot;
    return SCREE_OK;
}

static void end(struct convex *c, struct pair *pair)
{
    c->spare[c->spares++] = pair->slot; // there is room for all
    pair->slot = c->contact[pair->slot].next;
}

enum scree_status convex_touch(struct convex *c, struct pair *pair, size_t points, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    size_t now = convex_points(c, pair);
    for (; now < points && !status; now++)
        status = begin(c, pair, err);
    for (; now > points; now--)
        end(c, pair);
    return status;
}

void convex_part_now(struct convex *c, struct pair *pair)
{
    while (pair->slot != NO_CONTACT)
        end(c, pair);
}

size_t convex_points(const struct convex *c, const struct pair *pair)
{
    size_t points = 0;
    for (uint32_t slot = pair->slot; slot != NO_CONTACT; slot = c->contact[slot].next)
        points++;
    return points;
}

static uint32_t number_pair(struct convex *c, struct pair *pair, uint32_t *to, uint32_t count)
{
    uint32_t slot = pair->slot, next;
    if (slot != NO_CONTACT)
        pair->slot = count;
    for (; slot != NO_CONTACT; slot = next) {
        next = c->contact[slot].next;
        to[slot] = count++;
        c->contact[slot].next = next == NO_CONTACT ? NO_CONTACT : count;
    }
    return count;
}

/* Gives the contacts of a list new numbers, in to[], from `count` on; pairs and chains have them at once. */
static uint32_t number_anew(struct convex *c, struct list *list, uint32_t *to, uint32_t count)
{
    for (size_t k = 0; k < list->groups; k++)
        for (size_t p = 0; p < pairs_of(c, list, &list->group[k]); p++)
            count = number_pair(c, &list->pair[list->group[k].first + p], to, count);
    return count;
}

/* In place: each contact in the way of another changes places with it. The list of free slots is lent as the numbers' place. */
void convex_tidy(struct convex *c)
{
    uint32_t *to = c->spare, used, count;
    for (size_t k = 0; k < c->contacts; k++)
        to[k] = NO_CONTACT;
    used = count = number_anew(c, &c->wall, to, number_anew(c, &c->near, to, 0));
    for (size_t k = 0; k < c->contacts; k++)
        if (to[k] == NO_CONTACT)
            to[k] = count++;
    for (uint32_t k = 0; k < c->contacts; k++)
        while (to[k] != k) {
            const uint32_t other = to[k];
            const struct contact moved = c->contact[other];
            c->contact[other] = c->contact[k];
            c->contact[k] = moved;
            to[k] = to[other];
            to[other] = other;
        }
    c->contacts = used;
    c->spares = 0;
}

enum scree_status convex_forces(struct convex *c, struct scree_error *err)
{
    struct vec3 gravity = vec3_load(c->setup.gravity);
    for (size_t k = 0; k < c->bodies; k++) {
        struct body *b = &c->body[k];
        vec3_store3(b->force, vec3_scale(gravity, b->momentum[3]));
        vec3_store3(b->torque, (struct vec3){0, 0, 0});
    }
    for (size_t k = c->first_wall; k < c->first_wall + c->setup.wall_count; k++)
        memset(c->body[k].force, 0, sizeof c->body[k].force);
    c->base = (struct vec3){0, 0, 0};
    size_t most = c->near.groups > c->wall.groups ? c->near.groups : c->wall.groups;
    enum scree_status status = memory_grow((void **)&c->met, &c->met_room, most + 1, sizeof *c->met, err);
    if (status || (status = c->kernels->meet(c, err)))
        return status;
    return c->kernels->meet_walls(c, err);
}
