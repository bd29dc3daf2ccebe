/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Slots of contacts, and the forces of a step. */
#include <math.h>

#include "base/memory.h"
#include "convex/state.h"

enum scree_status convex_touch(struct convex *c, struct pair *pair, struct scree_error *err)
{
    if (c->spares > 0) {
        pair->slot = c->spare[--c->spares];
    } else {
        enum scree_status status = memory_grow((void **)&c->contact, &c->contact_room, c->contacts + 1, sizeof *c->contact, err);
        if (status || (status = memory_grow((void **)&c->spare, &c->spare_room, c->contacts + 1, sizeof *c->spare, err)))
            return status;
        pair->slot = (uint32_t)c->contacts++;
    }
    c->contact[pair->slot] = (struct contact){.share = 1};
    return SCREE_OK;
}

void convex_part(struct convex *c, struct pair *pair)
{
    if (pair->slot == NO_CONTACT)
        return;
    c->spare[c->spares++] = pair->slot; // there is room for all
    pair->slot = NO_CONTACT;
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
