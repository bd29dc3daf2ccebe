/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Velocity Verlet, four bodies side by side; compiled once per instruction set. */
#include <math.h>

#include "base/spinning4.h"
#include "convex/state.h"

SIMD_INLINE struct x3 rows_of(const double *const row[4], v4 *fourth)
{
    return rows_load(row[0], row[1], row[2], row[3], fourth);
}
SIMD_INLINE void rows_to(double *const row[4], struct x3 v, v4 fourth)
{
    rows_store(row[0], row[1], row[2], row[3], v, fourth);
}
#define ROWS(body, member) ((double *const[4]){(body)[0].member, (body)[1].member, (body)[2].member, (body)[3].member})
#define READ(body, member) ((const double *const[4]){(body)[0].member, (body)[1].member, (body)[2].member, (body)[3].member})

SIMD_INLINE struct x3 own_spin(struct x3 momentum, struct x3 inverse)
{
    return (struct x3){momentum.x * inverse.x, momentum.y * inverse.y, momentum.z * inverse.z};
}
SIMD_INLINE struct x3 into_space(const struct turn4 *t, struct x3 own)
{
    return x3_add(x3_add(x3_scale(t->x, own.x), x3_scale(t->y, own.y)), x3_scale(t->z, own.z));
}
SIMD_INLINE struct turn4 turn_load(const struct body *b)
{
    v4 unused;
    return (struct turn4){rows_of(READ(b, axis[0]), &unused), rows_of(READ(b, axis[1]), &unused),
                          rows_of(READ(b, axis[2]), &unused)};
}

/* Half a kick by forces and torques, for which the axes are still those of the last drift. */
SIMD_INLINE void half_kick(const struct body *b, const struct turn4 *turn, v4 half, v4 light, struct x3 *velocity,
                           struct x3 *momentum)
{
    v4 unused;
    struct x3 force = rows_of(READ(b, force), &unused), torque = rows_of(READ(b, torque), &unused);
    *velocity = x3_add(*velocity, x3_scale(force, half * light));
    struct x3 own = {x3_dot(turn->x, torque), x3_dot(turn->y, torque), x3_dot(turn->z, torque)};
    *momentum = x3_add(*momentum, x3_scale(own, half));
}

/* The free rotation of quat.h over a step; keeps the orientation a unit. */
SIMD_INLINE void rotate(struct spinning4 *s, struct x3 inverse, v4 half)
{
    turn_x(s, s->momentum.x * inverse.x * half);
    turn_y(s, s->momentum.y * inverse.y * half);
    turn_z(s, s->momentum.z * inverse.z * half);
    turn_z(s, s->momentum.z * inverse.z * half);
    turn_y(s, s->momentum.y * inverse.y * half);
    turn_x(s, s->momentum.x * inverse.x * half);
    v4 tidy = v4_all(1.5) - v4_all(0.5) * (s->w * s->w + s->x * s->x + s->y * s->y + s->z * s->z);
    s->w *= tidy, s->x *= tidy, s->y *= tidy, s->z *= tidy;
}

/* No point of a body moves farther in a step than (v + w (1 + 2 w dt) reach) dt: in free rotation |dw/dt| <= w^2. */
SIMD_INLINE v4 farthest(struct x3 velocity, v4 spin2, v4 reach, v4 dt)
{
    v4 spin = v4_sqrt(spin2);
    return dt * (v4_sqrt(x3_dot(velocity, velocity)) + spin * (v4_all(1) + v4_all(2) * spin * dt) * reach);
}

/* Returns by how much the squares of the ways from where the four centres were listed are beyond their margins'; adds what gravity
 * does to *work. */
SIMD_INLINE v4 four_move(struct body *b, double *travelled, v4 dt, struct x3 gravity, v4 *work)
{
    v4 travel = v4_load(travelled), light, mass, reach, margin, unused, half = v4_all(0.5) * dt;
    struct x3 position = rows_of(READ(b, position), &unused), velocity = rows_of(READ(b, velocity), &light);
    struct x3 inverse = rows_of(READ(b, inverse), &reach);
    struct turn4 turn = turn_load(b);
    struct spinning4 s;
    s.momentum = rows_of(READ(b, momentum), &mass);
    struct x3 q = rows_of(READ(b, orientation), &s.z);
    s.w = q.x, s.x = q.y, s.y = q.z;
    half_kick(b, &turn, half, light, &velocity, &s.momentum);
    *work = *work + mass * dt * x3_dot(gravity, velocity);
    position = x3_add(position, x3_scale(velocity, dt));
    struct x3 spin = own_spin(s.momentum, inverse);
    v4 spin2 = x3_dot(spin, spin);
    rotate(&s, inverse, half);
    spin = own_spin(s.momentum, inverse);
    travel = travel + farthest(velocity, v4_max(spin2, x3_dot(spin, spin)), reach, dt);
    turn = turn_of(&s);
    v4_store(travelled, travel);
    rows_to(ROWS(b, position), position, v4_all(0));
    rows_to(ROWS(b, velocity), velocity, light);
    rows_to(ROWS(b, orientation), (struct x3){s.w, s.x, s.y}, s.z);
    rows_to(ROWS(b, momentum), s.momentum, mass);
    rows_to(ROWS(b, omega), into_space(&turn, spin), v4_all(0));
    rows_to(ROWS(b, axis[0]), turn.x, v4_all(0));
    rows_to(ROWS(b, axis[1]), turn.y, v4_all(0));
    rows_to(ROWS(b, axis[2]), turn.z, v4_all(0));
    struct x3 way = x3_sub(position, rows_of(READ(b, listed), &margin));
    return x3_dot(way, way) - margin * margin + (travel - travel); // NaN where the travel is no number
}

static double move(struct convex *c)
{
    const struct x3 gravity = {v4_all(c->setup.gravity[0]), v4_all(c->setup.gravity[1]), v4_all(c->setup.gravity[2])};
    v4 far2 = v4_all(-INFINITY), sound = {0}, work = {0};
    for (size_t k = 0; k < c->bodies; k += 4) {
        v4 over2 = four_move(&c->body[k], &c->travel[k], v4_all(c->setup.step_s), gravity, &work);
        far2 = v4_max(far2, over2);
        sound = sound + (over2 - over2);
    }
    c->gravity_work += (work[0] + work[1]) + (work[2] + work[3]);
    double most = far2[0];
    for (int l = 1; l < 4; l++)
        most = far2[l] > most ? far2[l] : most;
    return most + ((sound[0] + sound[1]) + (sound[2] + sound[3]));
}

static void kick(struct convex *c)
{
    const v4 half = v4_all(0.5 * c->setup.step_s);
    for (size_t k = 0; k < c->bodies; k += 4) {
        struct body *b = &c->body[k];
        v4 light, mass, unused;
        struct x3 velocity = rows_of(READ(b, velocity), &light), momentum = rows_of(READ(b, momentum), &mass);
        struct turn4 turn = turn_load(b);
        half_kick(b, &turn, half, light, &velocity, &momentum);
        rows_to(ROWS(b, velocity), velocity, light);
        rows_to(ROWS(b, momentum), momentum, mass);
        rows_to(ROWS(b, omega), into_space(&turn, own_spin(momentum, rows_of(READ(b, inverse), &unused))), v4_all(0));
    }
}

enum scree_status PER_ISA(convex_meet)(struct convex *c, struct scree_error *err);
enum scree_status PER_ISA(convex_meet_walls)(struct convex *c, struct scree_error *err);

const struct convex_kernels PER_ISA(convex_kernels) = {
    .move = move, .kick = kick, .meet = PER_ISA(convex_meet), .meet_walls = PER_ISA(convex_meet_walls)};
