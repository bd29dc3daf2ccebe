/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The free rotation of base/quat.h for four bodies side by side, for a turn is one
 * long chain of dependent operations. What a body gets does not depend on which
 * bodies stand beside it. */
#ifndef SCREE_BASE_SPINNING4_H
#define SCREE_BASE_SPINNING4_H

#include "base/lanes.h"

struct spinning4 {
    v4 w, x, y, z;      // orientation
    struct x3 momentum; // in own axes
};
struct turn4 { // columns: own axes in space
    struct x3 x, y, z;
};

/* x - x^3/6 + x^5/120 - x^7/5040, within [-1, 1]: exact to rounding below 0.05. */
SIMD_INLINE v4 small_sine(v4 x)
{
    v4 y = x * x, one = v4_all(1.0);
    v4 s = x * (one + y * (v4_all(-1.0 / 6) + y * (v4_all(1.0 / 120) + y * v4_all(-1.0 / 5040))));
    return v4_min(v4_max(s, -one), one);
}

struct half_angle {
    v4 s, c, sine, cosine; // of half the angle, and of the angle
};
SIMD_INLINE struct half_angle half_angle(v4 angle)
{
    v4 s = small_sine(v4_all(0.5) * angle), c = v4_sqrt(v4_all(1.0) - s * s), two = v4_all(2.0);
    return (struct half_angle){s, c, two * s * c, v4_all(1.0) - two * s * s};
}

SIMD_INLINE void turn_x(struct spinning4 *b, v4 angle)
{
    struct half_angle h = half_angle(angle);
    v4 w = b->w, x = b->x, y = b->y, z = b->z, my = b->momentum.y, mz = b->momentum.z;
    b->w = w * h.c - x * h.s, b->x = x * h.c + w * h.s, b->y = y * h.c + z * h.s, b->z = z * h.c - y * h.s;
    b->momentum.y = h.cosine * my + h.sine * mz, b->momentum.z = h.cosine * mz - h.sine * my;
}
SIMD_INLINE void turn_y(struct spinning4 *b, v4 angle)
{
    struct half_angle h = half_angle(angle);
    v4 w = b->w, x = b->x, y = b->y, z = b->z, mx = b->momentum.x, mz = b->momentum.z;
    b->w = w * h.c - y * h.s, b->x = x * h.c - z * h.s, b->y = y * h.c + w * h.s, b->z = z * h.c + x * h.s;
    b->momentum.x = h.cosine * mx - h.sine * mz, b->momentum.z = h.cosine * mz + h.sine * mx;
}
SIMD_INLINE void turn_z(struct spinning4 *b, v4 angle)
{
    struct half_angle h = half_angle(angle);
    v4 w = b->w, x = b->x, y = b->y, z = b->z, mx = b->momentum.x, my = b->momentum.y;
    b->w = w * h.c - z * h.s, b->x = x * h.c + y * h.s, b->y = y * h.c - x * h.s, b->z = z * h.c + w * h.s;
    b->momentum.x = h.cosine * mx + h.sine * my, b->momentum.y = h.cosine * my - h.sine * mx;
}

SIMD_INLINE struct turn4 turn_of(const struct spinning4 *b)
{
    v4 xx = b->x * b->x, yy = b->y * b->y, zz = b->z * b->z, xy = b->x * b->y, xz = b->x * b->z, yz = b->y * b->z;
    v4 wx = b->w * b->x, wy = b->w * b->y, wz = b->w * b->z, one = v4_all(1.0), two = v4_all(2.0);
    return (struct turn4){.x = {one - two * (yy + zz), two * (xy + wz), two * (xz - wy)},
                          .y = {two * (xy - wz), one - two * (xx + zz), two * (yz + wx)},
                          .z = {two * (xz + wy), two * (yz - wx), one - two * (xx + yy)}};
}

#endif
