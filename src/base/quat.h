/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Orientations as unit quaternions, and the free rotation of a rigid body.
 *
 * q turns body coordinates into space: x_space = q x_body q*. Nothing here calls
 * libm's sine and cosine, whose last bits differ between processors: only
 * arithmetic and square roots, which do not. */
#ifndef SCREE_BASE_QUAT_H
#define SCREE_BASE_QUAT_H

#include <math.h>

#include "base/vec3.h"

struct quat {
    double w, x, y, z;
};

/* Columns are the body's axes in space: space = column[0] x + column[1] y + column[2] z. */
struct turn {
    struct vec3 column[3];
};

static inline struct quat quat_one(void)
{
    return (struct quat){1, 0, 0, 0};
}
static inline struct quat quat_load(const double *a) // w, x, y, z
{
    return (struct quat){a[0], a[1], a[2], a[3]};
}
static inline void quat_store(double *a, struct quat q)
{
    a[0] = q.w;
    a[1] = q.x;
    a[2] = q.y;
    a[3] = q.z;
}
static inline struct quat quat_inverse(struct quat q) // of a unit quaternion
{
    return (struct quat){q.w, -q.x, -q.y, -q.z};
}
/* First b, then a. */
static inline struct quat quat_product(struct quat a, struct quat b)
{
    return (struct quat){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                         a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
static inline double quat_norm2(struct quat q)
{
    return q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
}
static inline struct quat quat_scale(struct quat q, double s)
{
    return (struct quat){q.w * s, q.x * s, q.y * s, q.z * s};
}
static inline struct quat quat_unit(struct quat q) // of any but zero
{
    return quat_scale(q, 1.0 / sqrt(quat_norm2(q)));
}
/* Takes off what rounding has added to a unit quaternion: Newton's step for 1 / |q|. */
static inline struct quat quat_tidy(struct quat q)
{
    return quat_scale(q, 1.5 - 0.5 * quat_norm2(q));
}

static inline struct turn quat_turn(struct quat q)
{
    double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (struct turn){.column = {{1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (xz - wy)},
                                    {2 * (xy - wz), 1 - 2 * (xx + zz), 2 * (yz + wx)},
                                    {2 * (xz + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)}}};
}
static inline struct vec3 turn_out(const struct turn *t, struct vec3 body) // body to space
{
    return vec3_add(vec3_add(vec3_scale(t->column[0], body.x), vec3_scale(t->column[1], body.y)), vec3_scale(t->column[2], body.z));
}
static inline struct vec3 turn_in(const struct turn *t, struct vec3 space) // space to body
{
    return (struct vec3){vec3_dot(t->column[0], space), vec3_dot(t->column[1], space), vec3_dot(t->column[2], space)};
}
static inline struct vec3 quat_rotate(struct quat q, struct vec3 body)
{
    struct turn t = quat_turn(q);
    return turn_out(&t, body);
}

/* sin(x) to the last bits for |x| < 0.3; beyond that a smooth odd function
 * that stays within [-1, 1] up to |x| = pi / 2: rotations by it remain rotations. */
static inline double quat_small_sine(double x)
{
    double y = x * x;
    double s = x * (1 + y * (-1.0 / 6 + y * (1.0 / 120 + y * (-1.0 / 5040 + y * (1.0 / 362880 - y * (1.0 / 39916800))))));
    return s > 1 ? 1 : s < -1 ? -1 : s;
}

/* A body in free rotation: orientation, and angular momentum in its own principal axes, N m s. */
struct spinning {
    struct quat orientation;
    struct vec3 momentum;
};

/* Turns the body by `angle` about its own x axis; the momentum, fixed in space, turns back in body axes. */
static inline void spinning_turn_x(struct spinning *b, double angle)
{
    double s = quat_small_sine(0.5 * angle), c = sqrt(1 - s * s), sine = 2 * s * c, cosine = 1 - 2 * s * s;
    struct quat q = b->orientation;
    b->orientation = (struct quat){q.w * c - q.x * s, q.x * c + q.w * s, q.y * c + q.z * s, q.z * c - q.y * s};
    struct vec3 m = b->momentum;
    b->momentum = (struct vec3){m.x, cosine * m.y + sine * m.z, cosine * m.z - sine * m.y};
}
static inline void spinning_turn_y(struct spinning *b, double angle)
{
    double s = quat_small_sine(0.5 * angle), c = sqrt(1 - s * s), sine = 2 * s * c, cosine = 1 - 2 * s * s;
    struct quat q = b->orientation;
    b->orientation = (struct quat){q.w * c - q.y * s, q.x * c - q.z * s, q.y * c + q.w * s, q.z * c + q.x * s};
    struct vec3 m = b->momentum;
    b->momentum = (struct vec3){cosine * m.x - sine * m.z, m.y, cosine * m.z + sine * m.x};
}
static inline void spinning_turn_z(struct spinning *b, double angle)
{
    double s = quat_small_sine(0.5 * angle), c = sqrt(1 - s * s), sine = 2 * s * c, cosine = 1 - 2 * s * s;
    struct quat q = b->orientation;
    b->orientation = (struct quat){q.w * c - q.z * s, q.x * c + q.y * s, q.y * c - q.x * s, q.z * c + q.w * s};
    struct vec3 m = b->momentum;
    b->momentum = (struct vec3){cosine * m.x + sine * m.y, cosine * m.y - sine * m.x, m.z};
}

/* Free rotation by splitting (Dullweber, Leimkuhler and McLachlan 1997): the
 * kinetic energy is a sum over the principal axes, and each term alone turns
 * the body about its axis by L_k t / I_k, exactly. In the symmetric order
 * x y z | z y x over one step the map is second order, reversible and
 * symplectic, so energy errs by O((w dt)^2) without a trend, and every part
 * leaves the momentum in space alone. These are its halves: between them the
 * body is where it is at half the step, to the same order.
 * `inverse` holds 1 / I along the principal axes, 1/(kg m2); half the step, s. */
static inline void spinning_first_half(struct spinning *b, struct vec3 inverse, double half)
{
    spinning_turn_x(b, b->momentum.x * inverse.x * half);
    spinning_turn_y(b, b->momentum.y * inverse.y * half);
    spinning_turn_z(b, b->momentum.z * inverse.z * half);
}
static inline void spinning_second_half(struct spinning *b, struct vec3 inverse, double half)
{
    spinning_turn_z(b, b->momentum.z * inverse.z * half);
    spinning_turn_y(b, b->momentum.y * inverse.y * half);
    spinning_turn_x(b, b->momentum.x * inverse.x * half);
}

#endif
