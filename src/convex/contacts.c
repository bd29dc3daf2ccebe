/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Slots of contacts, and the forces of a step. */
#include <math.h>

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
    c->contact[slot] = (struct contact){.share = 1, .next = pair->slot};
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

void convex_part(struct convex *c, struct pair *pair)
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

enum scree_status convex_forces(struct convex *c, struct scree_error *err)
{
    struct vec3 gravity = vec3_load(c->setup.gravity);
    for (size_t k = 0; k < c->bodies; k++) {
        struct body *b = &c->body[k];
        vec3_store3(b->force, vec3_scale(gravity, b->momentum[3]));
        vec3_store3(b->torque, (struct vec3){0, 0, 0});
    }
    c->base = (struct vec3){0, 0, 0};
    enum scree_status status = c->kernels->meet(c, err);
    return status ? status : c->kernels->meet_walls(c, err);
}
