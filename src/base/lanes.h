/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Four vectors side by side, and names of functions per instruction set: for
 * sources that are compiled once per instruction set, named by ISA. */
#ifndef SCREE_BASE_LANES_H
#define SCREE_BASE_LANES_H

#include "base/simd.h"

#define PER_ISA_PASTE(name, isa) name##_##isa
#define PER_ISA_NAME(name, isa)  PER_ISA_PASTE(name, isa)
#define PER_ISA(name)            PER_ISA_NAME(name, ISA)

struct x3 { // a vector a lane
    v4 x, y, z;
};

SIMD_INLINE struct x3 x3_add(struct x3 a, struct x3 b)
{
    return (struct x3){a.x + b.x, a.y + b.y, a.z + b.z};
}
SIMD_INLINE struct x3 x3_sub(struct x3 a, struct x3 b)
{
    return (struct x3){a.x - b.x, a.y - b.y, a.z - b.z};
}
SIMD_INLINE struct x3 x3_scale(struct x3 a, v4 s)
{
    return (struct x3){a.x * s, a.y * s, a.z * s};
}
SIMD_INLINE v4 x3_dot(struct x3 a, struct x3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
SIMD_INLINE struct x3 x3_cross(struct x3 a, struct x3 b)
{
    return (struct x3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SIMD_INLINE struct x3 x3_select(m4 mask, struct x3 yes, struct x3 no)
{
    return (struct x3){v4_select(mask, yes.x, no.x), v4_select(mask, yes.y, no.y), v4_select(mask, yes.z, no.z)};
}

/* Shortens to `cap` what is longer, and says where that was. Roots and quotients
 * are a large part of what contact laws take: where all four are shorter, by more
 * than rounding can be, neither is taken. */
SIMD_INLINE m4 x3_cap(struct x3 *v, v4 cap)
{
    v4 squared = x3_dot(*v, *v);
    m4 longer = (m4)(squared > cap * cap * v4_all(1 - 1e-12));
    if (!m4_bits(longer))
        return longer;
    v4 size = v4_sqrt(squared);
    longer = (m4)(size > cap);
    *v = x3_select(longer, x3_scale(*v, cap / size), *v);
    return longer;
}

/* Elements 0..2 of four rows as a vector a lane, element 3 apart. */
SIMD_INLINE struct x3 rows_load(const double *r0, const double *r1, const double *r2, const double *r3, v4 *fourth)
{
    struct x3 v;
    v4_transpose(v4_load(r0), v4_load(r1), v4_load(r2), v4_load(r3), &v.x, &v.y, &v.z, fourth);
    return v;
}
SIMD_INLINE void rows_store(double *r0, double *r1, double *r2, double *r3, struct x3 v, v4 fourth)
{
    v4 a, b, c, d;
    v4_transpose(v.x, v.y, v.z, fourth, &a, &b, &c, &d);
    v4_store(r0, a);
    v4_store(r1, b);
    v4_store(r2, c);
    v4_store(r3, d);
}

#endif
