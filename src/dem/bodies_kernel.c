/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Row loops of rigid bodies; compiled once per instruction set. Four bodies turn
 * side by side in lanes, and two such fours in turns, for a turn is one long
 * chain of dependent operations; members are rows and take a vector each. What a
 * body gets does not depend on which bodies stand beside it. The method is that
 * of base/quat.h, lane by lane. */
#include "base/spinning4.h"
#include "dem/lanes.h"
#include "dem/kernels.h"

/* A body's step as rows, for its members: places are centre + x p.x + y p.y + z p.z
 * of the offset, velocities velocity + x u.x + ... with u the axes' own velocities. */
enum step_row { STEP_CENTRE, STEP_VELOCITY, STEP_SPIN, STEP_PLACE, STEP_SPEED = STEP_PLACE + 3, STEP_ROWS = STEP_SPEED + 3 };
struct body_step {
    _Alignas(32) double row[STEP_ROWS][4];
};

enum { FOURS = 2, ABREAST = 4 * FOURS }; // bodies that move side by side
#define EACH_FOUR(f) _Pragma("GCC unroll 2") for (size_t f = 0; f < FOURS; f++)

struct moving4 {
    struct x3 centre, velocity, inverse, spin;
    v4 mass, light; // fourth elements of centre and velocity
    struct spinning4 body;
    struct turn4 middle; // as they stand at half the step
};

/* Bodies k[0..3]: kicked and drifted, angular momentum in own axes. */
SIMD_INLINE void moving_load(const struct body_batch *b, const size_t k[4], struct moving4 *m)
{
    v4 unused;
    m->centre = rows_load(b->centre[k[0]], b->centre[k[1]], b->centre[k[2]], b->centre[k[3]], &m->mass);
    m->velocity = rows_load(b->velocity[k[0]], b->velocity[k[1]], b->velocity[k[2]], b->velocity[k[3]], &m->light);
    m->inverse = rows_load(b->inverse[k[0]], b->inverse[k[1]], b->inverse[k[2]], b->inverse[k[3]], &unused);
    struct x3 momentum = rows_load(b->momentum[k[0]], b->momentum[k[1]], b->momentum[k[2]], b->momentum[k[3]], &unused);
    v4_transpose(v4_load(b->orientation[k[0]]), v4_load(b->orientation[k[1]]), v4_load(b->orientation[k[2]]),
                 v4_load(b->orientation[k[3]]), &m->body.w, &m->body.x, &m->body.y, &m->body.z);
    m->velocity = x3_add(m->velocity, (struct x3){v4_all(b->kick[0]), v4_all(b->kick[1]), v4_all(b->kick[2])});
    m->centre = x3_add(m->centre, x3_scale(m->velocity, v4_all(b->step)));
    struct turn4 turn = turn_of(&m->body);
    m->body.momentum = (struct x3){x3_dot(turn.x, momentum), x3_dot(turn.y, momentum), x3_dot(turn.z, momentum)};
}

SIMD_INLINE void moving_look(struct moving4 *m)
{
    const struct x3 own = m->body.momentum;
    m->middle = turn_of(&m->body);
    m->spin = x3_add(x3_add(x3_scale(m->middle.x, own.x * m->inverse.x), x3_scale(m->middle.y, own.y * m->inverse.y)),
                     x3_scale(m->middle.z, own.z * m->inverse.z));
}

/* The first `count` of bodies k[0..3] back, and all four's rows for their members. */
SIMD_INLINE void moving_store(const struct body_batch *b, const size_t k[4], size_t count, struct moving4 *m,
                              struct body_step step[4])
{
    struct spinning4 *body = &m->body;
    v4 norm2 = body->w * body->w + body->x * body->x + body->y * body->y + body->z * body->z;
    v4 tidy = v4_all(1.5) - v4_all(0.5) * norm2;
    body->w *= tidy, body->x *= tidy, body->y *= tidy, body->z *= tidy;
    struct turn4 turn = turn_of(body);
    _Alignas(32) double q[4][4], v[4][4], c[4][4];
    rows_store(q[0], q[1], q[2], q[3], (struct x3){body->w, body->x, body->y}, body->z);
    rows_store(v[0], v[1], v[2], v[3], m->velocity, m->light);
    rows_store(c[0], c[1], c[2], c[3], m->centre, m->mass);
    for (size_t l = 0; l < count; l++) {
        v4_store(b->orientation[k[l]], v4_load(q[l]));
        v4_store(b->velocity[k[l]], v4_load(v[l]));
        v4_store(b->centre[k[l]], v4_load(c[l]));
    }
    const struct x3 rows[STEP_ROWS] = {m->centre,
                                       m->velocity,
                                       m->spin,
                                       turn.x,
                                       turn.y,
                                       turn.z,
                                       x3_cross(m->spin, m->middle.x),
                                       x3_cross(m->spin, m->middle.y),
                                       x3_cross(m->spin, m->middle.z)};
    const v4 zero = {0};
    for (size_t r = 0; r < STEP_ROWS; r++)
        rows_store(step[0].row[r], step[1].row[r], step[2].row[r], step[3].row[r], rows[r], zero);
}

/* How many of the four from `first` on are among the first `count`. */
SIMD_INLINE size_t within(size_t count, size_t first)
{
    return count <= first ? 0 : count - first < 4 ? count - first : 4;
}

/* Bodies k[0..7], of which the first `count` are wanted: kick, drift and free turn. */
SIMD_INLINE void move(const struct body_batch *b, const size_t k[ABREAST], size_t count, struct body_step step[ABREAST])
{
    const v4 half = v4_all(0.5 * b->step);
    struct moving4 m[FOURS];
    EACH_FOUR(f) moving_load(b, &k[4 * f], &m[f]);
    EACH_FOUR(f) turn_x(&m[f].body, m[f].body.momentum.x * m[f].inverse.x * half);
    EACH_FOUR(f) turn_y(&m[f].body, m[f].body.momentum.y * m[f].inverse.y * half);
    EACH_FOUR(f) turn_z(&m[f].body, m[f].body.momentum.z * m[f].inverse.z * half);
    EACH_FOUR(f) moving_look(&m[f]);
    EACH_FOUR(f) turn_z(&m[f].body, m[f].body.momentum.z * m[f].inverse.z * half);
    EACH_FOUR(f) turn_y(&m[f].body, m[f].body.momentum.y * m[f].inverse.y * half);
    EACH_FOUR(f) turn_x(&m[f].body, m[f].body.momentum.x * m[f].inverse.x * half);
    EACH_FOUR(f) moving_store(b, &k[4 * f], within(count, 4 * f), &m[f], &step[4 * f]);
}

/* Members keep the fourth element of their rows; what they stray from the
 * straight path of the refresh is their way over the step against its velocity. */
SIMD_INLINE v4 members(const struct body_batch *b, size_t k, const struct body_step *s, v4 strayed2)
{
    const m4 vector = {-1, -1, -1, 0};
    const v4 rate = v4_all(1.0 / b->step);
    for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
        v4 x = v4_all(b->offset[i][0]), y = v4_all(b->offset[i][1]), z = v4_all(b->offset[i][2]);
        v4 arm = v4_load(s->row[STEP_PLACE]) * x + v4_load(s->row[STEP_PLACE + 1]) * y + v4_load(s->row[STEP_PLACE + 2]) * z;
        v4 speed = v4_load(s->row[STEP_VELOCITY]) +
                   (v4_load(s->row[STEP_SPEED]) * x + v4_load(s->row[STEP_SPEED + 1]) * y + v4_load(s->row[STEP_SPEED + 2]) * z);
        v4 place = v4_load(s->row[STEP_CENTRE]) + arm, old = v4_load(b->place[i]);
        v4 change = (place - old) * rate - v4_load(b->speed0[i]);
        strayed2 = v4_max(strayed2, change * change);
        v4_store(b->arm[i], arm);
        v4_store(b->place[i], v4_select(vector, place, old));
        v4_store(b->speed[i], v4_select(vector, speed, v4_load(b->speed[i])));
        v4_store(b->spin[i], v4_select(vector, v4_load(s->row[STEP_SPIN]), v4_load(b->spin[i])));
    }
    return strayed2;
}

void PER_ISA(bodies_drift)(const struct body_batch *b)
{
    v4 strayed2 = v4_load(b->strayed2);
    struct body_step step[ABREAST];
    for (size_t from = b->from; from < b->to; from += ABREAST) {
        size_t count = b->to - from < ABREAST ? b->to - from : ABREAST, k[ABREAST];
        for (size_t l = 0; l < ABREAST; l++)
            k[l] = from + (l < count ? l : count - 1);
        move(b, k, count, step);
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
    const v4 zero = {0}, one = {0, 0, 0, 1};
    for (size_t k = b->from; k < b->to; k++) {
        v4 force = zero, torque = zero;
        for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
            v4 load = v4_select(vector, v4_load(b->load[i]), zero);
            force += load;
            torque += v4_select(vector, v4_load(b->twist[i]), zero) + cross(v4_load(b->arm[i]), load);
            v4_store(b->load[i], one);
            v4_store(b->twist[i], one);
        }
        v4_store(b->force[k], force);
        v4_store(b->torque[k], torque);
        v4_store(b->velocity[k], v4_load(b->velocity[k]) + force * v4_all(b->velocity[k][3]));
        v4_store(b->momentum[k], v4_load(b->momentum[k]) + torque * v4_all(b->step));
    }
}
