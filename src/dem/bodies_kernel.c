/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Row loops of rigid bodies; compiled once per instruction set. Four bodies turn
 * side by side, for a turn is one long chain of dependent operations; members
 * are rows and take a vector each. What a body gets does not depend on which
 * bodies stand beside it. The method is that of base/quat.h, lane by lane. */
#include "base/spinning4.h"
#include "dem/lanes.h"
#include "dem/kernels.h"

/* A body's step as rows, for its members: places are centre + x p.x + y p.y + z p.z
 * of the offset, velocities velocity + x u.x + ... with u the axes' own velocities. */
struct body_step {
    _Alignas(32) double centre[4], velocity[4], spin[4], place[3][4], speed[3][4];
};

SIMD_INLINE void step_store(struct body_step step[4], size_t which, struct x3 v)
{
    const v4 zero = {0};
    double *rows[4];
    for (int l = 0; l < 4; l++) {
        double *const all[9] = {step[l].centre,   step[l].velocity, step[l].spin,     step[l].place[0], step[l].place[1],
                                step[l].place[2], step[l].speed[0], step[l].speed[1], step[l].speed[2]};
        rows[l] = all[which];
    }
    rows_store(rows[0], rows[1], rows[2], rows[3], v, zero);
}

/* Bodies k[0..3], of which the first `count` are wanted: kick, drift and free turn. */
SIMD_INLINE void four_bodies(const struct body_batch *b, const size_t k[4], size_t count, struct body_step step[4])
{
    const v4 dt = v4_all(b->step), half = v4_all(0.5 * b->step);
    v4 mass, light, unused, volume;
    struct x3 centre = rows_load(b->centre[k[0]], b->centre[k[1]], b->centre[k[2]], b->centre[k[3]], &mass);
    struct x3 velocity = rows_load(b->velocity[k[0]], b->velocity[k[1]], b->velocity[k[2]], b->velocity[k[3]], &light);
    struct x3 momentum = rows_load(b->momentum[k[0]], b->momentum[k[1]], b->momentum[k[2]], b->momentum[k[3]], &unused);
    struct x3 inverse = rows_load(b->inverse[k[0]], b->inverse[k[1]], b->inverse[k[2]], b->inverse[k[3]], &volume);
    struct spinning4 body;
    v4_transpose(v4_load(b->orientation[k[0]]), v4_load(b->orientation[k[1]]), v4_load(b->orientation[k[2]]),
                 v4_load(b->orientation[k[3]]), &body.w, &body.x, &body.y, &body.z);
    velocity = x3_add(velocity, (struct x3){v4_all(b->kick[0]), v4_all(b->kick[1]), v4_all(b->kick[2])});
    centre = x3_add(centre, x3_scale(velocity, dt));

    struct turn4 turn = turn_of(&body);
    body.momentum = (struct x3){x3_dot(turn.x, momentum), x3_dot(turn.y, momentum), x3_dot(turn.z, momentum)};
    turn_x(&body, body.momentum.x * inverse.x * half);
    turn_y(&body, body.momentum.y * inverse.y * half);
    turn_z(&body, body.momentum.z * inverse.z * half);
    struct turn4 middle = turn_of(&body);
    struct x3 spin =
        x3_add(x3_add(x3_scale(middle.x, body.momentum.x * inverse.x), x3_scale(middle.y, body.momentum.y * inverse.y)),
               x3_scale(middle.z, body.momentum.z * inverse.z));
    turn_z(&body, body.momentum.z * inverse.z * half);
    turn_y(&body, body.momentum.y * inverse.y * half);
    turn_x(&body, body.momentum.x * inverse.x * half);
    v4 norm2 = body.w * body.w + body.x * body.x + body.y * body.y + body.z * body.z;
    v4 tidy = v4_all(1.5) - v4_all(0.5) * norm2;
    body.w *= tidy, body.x *= tidy, body.y *= tidy, body.z *= tidy;
    turn = turn_of(&body);

    _Alignas(32) double q[4][4], v[4][4], c[4][4];
    rows_store(q[0], q[1], q[2], q[3], (struct x3){body.w, body.x, body.y}, body.z);
    rows_store(v[0], v[1], v[2], v[3], velocity, light);
    rows_store(c[0], c[1], c[2], c[3], centre, mass);
    for (size_t l = 0; l < count; l++) {
        v4_store(b->orientation[k[l]], v4_load(q[l]));
        v4_store(b->velocity[k[l]], v4_load(v[l]));
        v4_store(b->centre[k[l]], v4_load(c[l]));
    }
    const struct x3 rows[9] = {centre,
                               velocity,
                               spin,
                               turn.x,
                               turn.y,
                               turn.z,
                               x3_cross(spin, middle.x),
                               x3_cross(spin, middle.y),
                               x3_cross(spin, middle.z)};
    for (size_t r = 0; r < 9; r++)
        step_store(step, r, rows[r]);
}

/* Members keep the fourth element of their rows; what they stray from the
 * straight path of the refresh is their way over the step against its velocity. */
SIMD_INLINE v4 members(const struct body_batch *b, size_t k, const struct body_step *s, v4 strayed2)
{
    const m4 vector = {-1, -1, -1, 0};
    const v4 rate = v4_all(1.0 / b->step);
    for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
        v4 x = v4_all(b->offset[i][0]), y = v4_all(b->offset[i][1]), z = v4_all(b->offset[i][2]);
        v4 arm = v4_load(s->place[0]) * x + v4_load(s->place[1]) * y + v4_load(s->place[2]) * z;
        v4 speed = v4_load(s->velocity) + (v4_load(s->speed[0]) * x + v4_load(s->speed[1]) * y + v4_load(s->speed[2]) * z);
        v4 place = v4_load(s->centre) + arm, old = v4_load(b->place[i]);
        v4 change = (place - old) * rate - v4_load(b->speed0[i]);
        strayed2 = v4_max(strayed2, change * change);
        v4_store(b->arm[i], arm);
        v4_store(b->place[i], v4_select(vector, place, old));
        v4_store(b->speed[i], v4_select(vector, speed, v4_load(b->speed[i])));
        v4_store(b->spin[i], v4_select(vector, v4_load(s->spin), v4_load(b->spin[i])));
    }
    return strayed2;
}

void PER_ISA(bodies_drift)(const struct body_batch *b)
{
    v4 strayed2 = v4_load(b->strayed2);
    struct body_step step[4];
    for (size_t from = b->from; from < b->to; from += 4) {
        size_t count = b->to - from < 4 ? b->to - from : 4, k[4];
        for (size_t l = 0; l < 4; l++)
            k[l] = from + (l < count ? l : count - 1);
        four_bodies(b, k, count, step);
        for (size_t l = 0; l < count; l++)
            strayed2 = members(b, k[l], &step[l], strayed2);
    }
    v4_store(b->strayed2, strayed2);
}

SIMD_INLINE v4 cross(v4 a, v4 b)
{
    v4 a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    v4 a2 = __builtin_shufflevector(a, a, 2, 0, 1, 3), b2 = __builtin_shufflevector(b, b, 2, 0, 1, 3);
    return a1 * b2 - a2 * b1;
}

void PER_ISA(bodies_gather)(const struct body_batch *b)
{
    const m4 vector = {-1, -1, -1, 0};
    const v4 zero = {0};
    for (size_t k = b->from; k < b->to; k++) {
        v4 force = zero, torque = zero;
        for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
            v4 load = v4_select(vector, v4_load(b->load[i]), zero);
            force += load;
            torque += v4_select(vector, v4_load(b->twist[i]), zero) + cross(v4_load(b->arm[i]), load);
        }
        v4_store(b->force[k], force);
        v4_store(b->torque[k], torque);
        v4_store(b->velocity[k], v4_load(b->velocity[k]) + force * v4_all(b->velocity[k][3]));
        v4_store(b->momentum[k], v4_load(b->momentum[k]) + torque * v4_all(b->step));
    }
}
