/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Corners of bodies against walls, gates and the rims of holes; compiled once per instruction set. */
#include <math.h>

#include "convex/corners.h"
#include "convex/pressing.h"

/* What is under a gate, or has come past it, is not touched by it. */
static bool past_gate(const struct gate_now *gate, const struct pair *p, double z, double height)
{
    return !gate->stands || z < gate->lift || (p->slot == NO_CONTACT && height < 0 && !gate->hole);
}

/* How far a corner at x is from a level wall with a hole, which has two sides, and from which way. Over the hole the rim's
 * nearest point is what it may touch: where a corner comes off the wall that is the same. */
static double from_rim(const double hole[2][2], struct vec3 x, double height, struct vec3 *away)
{
    const double aside[4] = {x.x - hole[0][0], hole[0][1] - x.x, x.y - hole[1][0], hole[1][1] - x.y};
    static const struct vec3 inwards[4] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    int nearest = 0;
    for (int k = 1; k < 4; k++)
        nearest = aside[k] < aside[nearest] ? k : nearest;
    double in = aside[nearest] > 0 ? aside[nearest] : 0, far = sqrt(in * in + height * height);
    if (far > 0)
        *away = vec3_scale(vec3_add(vec3_scale(*away, height), vec3_scale(inwards[nearest], in)), 1 / far);
    return far;
}

/* A corner at x from its body's centre, `height` over the wall, that is nearer than the crust. */
static enum scree_status meet_corner(struct convex *c, struct group *g, const struct side *s, const struct gate_now *gate,
                                     struct pair *p, struct vec3 x, double height, struct vec3 away, struct scree_error *err)
{
    struct vec3 centre = vec3_load(s->body->position);
    if (gate->partial && past_gate(gate, p, centre.z + x.z, height)) {
        convex_part(c, p);
        return SCREE_OK;
    }
    enum scree_status status = convex_touch(c, p, 1, err);
    if (status)
        return status;
    struct contact *contact = &c->contact[p->slot];
    double crust = s->part->radius;
    vec3_store3(contact->facing, vec3_scale(away, -1));
    vec3_store3(contact->point, vec3_add(centre, vec3_sub(x, vec3_scale(away, 0.5 * (height + crust)))));
    contact->slip[3] = crust - height;
    contact->roll[3] = 1;
    g->touching++;
    return SCREE_OK;
}

SIMD_INLINE double least_of(v4 a)
{
    double low = a[0] < a[1] ? a[0] : a[1], high = a[2] < a[3] ? a[2] : a[3];
    return low < high ? low : high;
}

/* The corners of a part against a wall, four heights at once; lowers *gap to their least, m: negative where they touch. */
static enum scree_status meet_wall(struct convex *c, struct group *g, const struct side *s, const struct gate_now *gate,
                                   struct pair *pair, double *gap, struct scree_error *err)
{
    const struct convex_wall *wall = &c->walls[g->b];
    struct vec3 normal = vec3_load(wall->normal), centre = vec3_load(s->body->position);
    double at = vec3_dot(vec3_sub(centre, vec3_load(wall->point)), normal), crust = s->part->radius;
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < s->part->vertices && !status; k += 4) {
        v4 over = v4_all(at) + heights(s, normal, k);
        if (!gate->hole && m4_bits(over < v4_all(crust)) == 0) {
            *gap = least_of(over) - crust < *gap ? least_of(over) - crust : *gap;
            for (size_t l = k; l < k + 4; l++)
                convex_part(c, &pair[l]);
            continue;
        }
        for (size_t l = k; l < k + 4 && l < s->part->vertices && !status; l++) {
            struct vec3 away = normal, x = corner(s, l);
            double height = over[l - k];
            if (gate->hole)
                height = from_rim(gate->hole, vec3_add(centre, x), height, &away);
            *gap = height - crust < *gap ? height - crust : *gap;
            if (height < crust)
                status = meet_corner(c, g, s, gate, &pair[l], x, height, away, err);
            else
                convex_part(c, &pair[l]);
        }
    }
    return status;
}

static enum scree_status meet_group(struct convex *c, struct group *g, struct scree_error *err)
{
    struct body *a = &c->body[g->a];
    const struct gate_now gate = convex_gate_now(c, g->b);
    double gap = INFINITY;
    g->touching = 0;
    c->body[c->first_wall + g->b].velocity[2] = gate.speed; // a wall is a body that nothing moves but its gate's motion
    for (size_t p = 0; p < a->shape->parts; p++) {
        struct side s = side_of(c, a, p);
        enum scree_status status = meet_wall(c, g, &s, &gate, &c->wall.pair[g->first + a->outline->from[p]], &gap, err);
        if (status)
            return status;
    }
    g->due = gap > 0 ? c->travel[g->a] + gap : 0;
    return SCREE_OK;
}

enum scree_status PER_ISA(convex_meet_walls)(struct convex *c, struct scree_error *err);
enum scree_status PER_ISA(convex_meet_walls)(struct convex *c, struct scree_error *err)
{
    struct pressing pressing = {.convex = c, .law = &c->setup.at_wall};
    enum scree_status status = SCREE_OK;
    c->mets = 0;
    for (uint32_t k = 0; k < c->wall.groups; k++) {
        struct group *g = &c->wall.group[k];
        if (c->travel[g->a] < g->due)
            continue;
        if ((status = meet_group(c, g, err)))
            return status;
        c->met[c->mets] = k;
        c->mets += g->touching > 0;
    }
    for (size_t k = 0; k < c->mets; k++) {
        const struct group *g = &c->wall.group[c->met[k]];
        struct body *a = &c->body[g->a];
        for (size_t p = 0; p < a->outline->corners; p++)
            press_pair(&pressing, &c->wall.pair[g->first + p], a, &c->body[c->first_wall + g->b], share_of(c, g));
    }
    press_rest(&pressing);
    if (c->setup.wall_count > 0)
        c->base = vec3_load(c->body[c->first_wall].force);
    return SCREE_OK;
}
