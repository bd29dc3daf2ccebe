/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What bodies feel of contacts: their law four at once, their forces handed out one after the other in the order in which
 * contacts were given. For sources that are compiled per instruction set. Private to this folder. */
#ifndef SCREE_CONVEX_PRESSING_H
#define SCREE_CONVEX_PRESSING_H

#include "convex/law_spring_memory4.h"
#include "convex/state.h"

struct pressing {
    struct convex *convex;
    const struct spring_pair *law;
    struct contact *contact[4];
    struct body *a[4], *b[4];
    double share[4]; // of the result, for the sake of other contacts of the same bodies
    int count;
};

#define BODIES4(body, member)     (body)[0]->member, (body)[1]->member, (body)[2]->member, (body)[3]->member
#define LOAD4(rows, member, rest) rows_load(BODIES4(rows, member), rest)

/* A body's surface at a point: its velocity, and the point from its centre. */
SIMD_INLINE struct x3 velocity_at(struct body *const body[4], struct x3 point, struct x3 *arm, struct x3 *spin)
{
    v4 unused;
    *arm = x3_sub(point, LOAD4(body, position, &unused));
    *spin = LOAD4(body, omega, &unused);
    return x3_add(LOAD4(body, velocity, &unused), x3_cross(*spin, *arm));
}

SIMD_INLINE void press_four(struct pressing *p)
{
    struct contact *const *contact = p->contact;
    v4 unused, share;
    struct spring_motion4 motion;
    struct spring_memory4 memory;
    struct x3 arm_a, arm_b, spin_a, spin_b;
    memory.slip = LOAD4(contact, slip, &motion.overlap);
    memory.torque = LOAD4(contact, roll, &share);
    memory.normal = LOAD4(contact, normal, &unused);
    motion.normal = LOAD4(contact, facing, &unused);
    struct x3 point = LOAD4(contact, point, &unused);
    struct x3 velocity_a = velocity_at(p->a, point, &arm_a, &spin_a), velocity_b = velocity_at(p->b, point, &arm_b, &spin_b);
    motion.velocity = x3_sub(velocity_a, velocity_b);
    motion.spin = x3_sub(spin_a, spin_b);
    struct spring_result4 r = spring_memory_step4(p->law, &motion, p->convex->setup.step_s, &memory);
    v4 felt = share * v4_set(p->share[0], p->share[1], p->share[2], p->share[3]);
    v4 elastic = v4_all(0.5 * p->law->stiffness) * motion.overlap * motion.overlap;
    unsigned slides = m4_bits(r.slides), rolls = m4_bits(r.rolls);
    rows_store(BODIES4(contact, slip), memory.slip, motion.overlap);
    rows_store(BODIES4(contact, roll), memory.torque, share);
    rows_store(BODIES4(contact, normal), memory.normal, elastic);
    rows_store(BODIES4(contact, force), r.force, r.normal);
    rows_store(BODIES4(contact, moment), r.torque, felt);
    struct x3 force = x3_scale(r.force, felt), torque = x3_scale(r.torque, felt);
    double on[3][4][4] __attribute__((aligned(32)));
    rows_store(on[0][0], on[0][1], on[0][2], on[0][3], force, v4_all(0));
    rows_store(on[1][0], on[1][1], on[1][2], on[1][3], x3_add(x3_cross(arm_a, force), torque), v4_all(0));
    rows_store(on[2][0], on[2][1], on[2][2], on[2][3], x3_add(x3_cross(arm_b, force), torque), v4_all(0));
    for (int l = 0; l < p->count; l++) {
        struct body *a = p->a[l], *b = p->b[l];
        contact[l]->slides = slides >> l & 1;
        contact[l]->rolls = rolls >> l & 1;
        v4_store(a->force, v4_load(a->force) + v4_load(on[0][l]));
        v4_store(a->torque, v4_load(a->torque) + v4_load(on[1][l]));
        v4_store(b->force, v4_load(b->force) - v4_load(on[0][l]));
        v4_store(b->torque, v4_load(b->torque) - v4_load(on[2][l]));
    }
    p->count = 0;
}

/* The contacts that are left, fewer than four: the first stands in for those that are not there. */
SIMD_INLINE void press_rest(struct pressing *p)
{
    if (p->count == 0)
        return;
    for (int l = p->count; l < 4; l++) {
        p->contact[l] = p->contact[0];
        p->a[l] = p->a[0];
        p->b[l] = p->b[0];
        p->share[l] = p->share[0];
    }
    press_four(p);
}

/* All contacts of a pair. None may begin before the rest is pressed: they would move in memory. */
SIMD_INLINE void press_pair(struct pressing *p, const struct pair *pair, struct body *a, struct body *b, double share)
{
    for (uint32_t slot = pair->slot, next; slot != NO_CONTACT; slot = next) {
        struct contact *contact = &p->convex->contact[slot];
        next = contact->next;
        p->contact[p->count] = contact;
        p->a[p->count] = a;
        p->b[p->count] = b;
        p->share[p->count] = share;
        if (++p->count == 4)
            press_four(p);
    }
}

#endif
