/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The law of law_spring_memory.c for four contacts side by side: the same operations in the same
 * order, hence the same bits, which `tests/physics/test_spring_memory.c` compares. Equations are cited there. */
#ifndef SCREE_CONVEX_LAW_SPRING_MEMORY4_H
#define SCREE_CONVEX_LAW_SPRING_MEMORY4_H

#include "base/lanes.h"
#include "convex/law_spring_memory.h"

struct spring_memory4 {
    struct x3 slip, torque, normal;
};
struct spring_motion4 {
    v4 overlap;
    struct x3 normal, velocity, spin;
};
struct spring_result4 {
    struct x3 force, torque;
    v4 normal;
    m4 slides, rolls;
};

SIMD_INLINE struct x3 across4(struct x3 v, struct x3 normal)
{
    return x3_sub(v, x3_scale(normal, x3_dot(v, normal)));
}

SIMD_INLINE struct x3 turned4(struct x3 v, struct x3 n, struct x3 m, v4 over)
{
    return across4(x3_sub(v, x3_scale(x3_add(n, m), x3_dot(v, m) * over)), m);
}

SIMD_INLINE void spring_memory_turn4(struct spring_memory4 *memory, struct x3 normal)
{
    const struct x3 n = memory->normal, none = {v4_all(0), v4_all(0), v4_all(0)};
    v4 half = v4_all(1) + x3_dot(n, normal), over = v4_all(1) / half;
    m4 another = (half < v4_all(1e-6)) | (x3_dot(n, n) == v4_all(0));
    memory->slip = x3_select(another, none, turned4(memory->slip, n, normal, over));
    memory->torque = x3_select(another, none, turned4(memory->torque, n, normal, over));
    memory->normal = normal;
}

SIMD_INLINE struct x3 friction4(const struct spring_pair *p, struct x3 velocity, v4 normal, v4 step_s, struct x3 *slip, m4 *slides)
{
    *slip = x3_add(*slip, x3_scale(velocity, step_s));
    struct x3 viscous = x3_scale(velocity, v4_all(p->damping_t));
    struct x3 force = x3_scale(x3_add(x3_scale(*slip, v4_all(p->stiffness_t)), viscous), v4_all(-1));
    *slides = x3_cap(&force, v4_all(p->friction) * v4_abs(normal));
    if (p->stiffness_t > 0)
        *slip = x3_select(*slides, x3_scale(x3_add(force, viscous), v4_all(-1 / p->stiffness_t)), *slip);
    return force;
}

SIMD_INLINE struct x3 rolling4(const struct spring_pair *p, struct x3 spin, v4 normal, v4 step_s, struct x3 *spring, m4 *rolls)
{
    *rolls = (m4){0};
    if (!(p->rolling_friction > 0))
        return (struct x3){v4_all(0), v4_all(0), v4_all(0)};
    *spring = x3_sub(*spring, x3_scale(spin, v4_all(p->stiffness_r) * step_s));
    struct x3 damped = x3_sub(*spring, x3_scale(spin, v4_all(p->damping_r)));
    *rolls = x3_cap(spring, v4_all(p->rolling_friction * p->radius) * v4_abs(normal));
    return x3_select(*rolls, *spring, damped);
}

SIMD_INLINE struct spring_result4 spring_memory_step4(const struct spring_pair *pair, const struct spring_motion4 *motion,
                                                      double step_s, struct spring_memory4 *memory)
{
    struct spring_result4 out;
    v4 approach = x3_dot(motion->velocity, motion->normal);
    out.normal = v4_all(pair->stiffness) * motion->overlap + v4_all(pair->damping) * approach;
    if (pair->clamp)
        out.normal = v4_select(out.normal < v4_all(0), v4_all(0), out.normal);
    spring_memory_turn4(memory, motion->normal);
    struct x3 push = x3_scale(motion->normal, -out.normal);
    out.force = x3_add(
        push, friction4(pair, across4(motion->velocity, motion->normal), out.normal, v4_all(step_s), &memory->slip, &out.slides));
    out.torque = rolling4(pair, across4(motion->spin, motion->normal), out.normal, v4_all(step_s), &memory->torque, &out.rolls);
    return out;
}

#endif
