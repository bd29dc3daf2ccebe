/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The law of law_hertz_tsuji.c on four contacts at once; compiled per instruction
 * set. Every operation and its order are those of hertz_tsuji_contact. */
#include "dem/lanes.h"
#include "dem/law_hertz_tsuji.h"

SIMD_INLINE v4 lanes_size(struct x3 v)
{
    return v4_sqrt(x3_dot(v, v));
}

/* Eq. 13 as a factor of the spin. */
SIMD_INLINE v4 lanes_rolling(v4 torque, v4 spin, v4 turn)
{
    v4 printed = torque / (spin + v4_all(TSUJI_NOTHING)), stop = v4_all(1.0) / (v4_all(TSUJI_STOP) * turn + v4_all(TSUJI_NOTHING));
    return v4_select((m4)(printed < stop), printed, stop);
}

/* Both grains of four pairs. Rows are numbered in scalars, not arrays: of arrays of addresses compilers make vectors that
 * go through memory before they can be used. */
struct grains {
    struct x3 x, velocity, spin1, spin2, arm1, arm2; // x and velocity: from 1 to 2, of 1 against 2
    v4 light1, light2, turn1, turn2;
};

SIMD_INLINE struct grains grains_load(const struct pair_batch *b, const uint32_t p[4])
{
    const uint32_t i0 = b->first[p[0]], i1 = b->first[p[1]], i2 = b->first[p[2]], i3 = b->first[p[3]];
    const uint32_t s0 = b->second[p[0]], s1 = b->second[p[1]], s2 = b->second[p[2]], s3 = b->second[p[3]];
    const uint32_t j0 = s0 & IMAGE_ROW, j1 = s1 & IMAGE_ROW, j2 = s2 & IMAGE_ROW, j3 = s3 & IMAGE_ROW;
    struct grains g;
    v4 unused;
    v4_transpose((v4_load(b->position[j0]) - v4_load(b->position[i0])) + v4_load(b->shift[s0 >> IMAGE_SHIFT]),
                 (v4_load(b->position[j1]) - v4_load(b->position[i1])) + v4_load(b->shift[s1 >> IMAGE_SHIFT]),
                 (v4_load(b->position[j2]) - v4_load(b->position[i2])) + v4_load(b->shift[s2 >> IMAGE_SHIFT]),
                 (v4_load(b->position[j3]) - v4_load(b->position[i3])) + v4_load(b->shift[s3 >> IMAGE_SHIFT]), &g.x.x, &g.x.y,
                 &g.x.z, &unused);
    struct x3 v1 = rows_load(b->velocity[i0], b->velocity[i1], b->velocity[i2], b->velocity[i3], &g.light1);
    struct x3 v2 = rows_load(b->velocity[j0], b->velocity[j1], b->velocity[j2], b->velocity[j3], &g.light2);
    g.velocity = x3_sub(v1, v2);
    g.spin1 = rows_load(b->spin[i0], b->spin[i1], b->spin[i2], b->spin[i3], &g.turn1);
    g.spin2 = rows_load(b->spin[j0], b->spin[j1], b->spin[j2], b->spin[j3], &g.turn2);
    g.arm1 = rows_load(b->arm[i0], b->arm[i1], b->arm[i2], b->arm[i3], &unused);
    g.arm2 = rows_load(b->arm[j0], b->arm[j1], b->arm[j2], b->arm[j3], &unused);
    return g;
}

SIMD_INLINE void group(const struct law_coefs *c, const struct pair_batch *b, const uint32_t p[4], struct contact_out *const out[4],
                       struct contact_loss *const loss[4], int ledger)
{
    double *const row0 = b->contact[p[0]], *const row1 = b->contact[p[1]], *const row2 = b->contact[p[2]],
                  *const row3 = b->contact[p[3]];
    const v4 zero = {0}, one = v4_all(1.0), dt = v4_all(c->step);
    const struct grains g = grains_load(b, p);
    const struct x3 x = g.x, velocity = g.velocity, spin1 = g.spin1, spin2 = g.spin2;
    const v4 light1 = g.light1, light2 = g.light2, turn1 = g.turn1, turn2 = g.turn2;
    v4 mn_was, a_old, r, r1, r2;
    struct x3 slid_was = rows_load(row0, row1, row2, row3, &mn_was);
    v4_transpose(v4_load(row0 + 8), v4_load(row1 + 8), v4_load(row2 + 8), v4_load(row3 + 8), &a_old, &r, &r1, &r2);

    v4 distance = v4_sqrt(x3_dot(x, x)), inverse = one / distance;
    v4 overlap = (r1 + r2) - distance;
    overlap = v4_select((m4)(overlap > zero), overlap, zero);
    struct x3 n = x3_scale(x, inverse);
    v4 half = v4_all(0.5) * overlap, reach1 = r1 - half, reach2 = r2 - half;

    v4 mass = dt / (light1 + light2), normal = v4_all(c->normal), beta = v4_all(c->beta);
    v4 approach = x3_dot(velocity, n);
    v4 a = v4_sqrt(r * overlap);
    v4 damping = beta * v4_sqrt(v4_all(1.5) * normal * a * mass);
    v4 fn = normal * a * overlap + damping * approach, least = v4_all(c->least);
    fn = v4_select((m4)(fn > least), fn, least);
    v4 press = v4_select((m4)(fn > zero), fn, zero);

    v4 kt = v4_all(c->tangential) * a, drag = beta * v4_sqrt(kt * mass);
    struct x3 lever = x3_add(x3_scale(spin1, reach1), x3_scale(spin2, reach2));
    struct x3 slide = x3_add(x3_sub(velocity, x3_scale(n, approach)), x3_cross(lever, n));
    struct x3 slid = x3_sub(slid_was, x3_scale(n, x3_dot(slid_was, n)));
    slid = x3_add(slid, x3_scale(slide, dt));
    v4 spring = kt * lanes_size(slid), ft_cap = v4_all(c->mu_t) * press;
    slid = x3_select((m4)(spring > ft_cap), x3_scale(slid, ft_cap / spring), slid);
    struct x3 ft = x3_add(x3_scale(slid, kt), x3_scale(slide, drag));
    x3_cap(&ft, ft_cap);

    const struct x3 arm1 = x3_add(g.arm1, x3_scale(n, reach1)), arm2 = x3_sub(g.arm2, x3_scale(n, reach2));
    v4 roll1 = lanes_rolling(v4_all(c->mu_r) * press * lanes_size(arm1), lanes_size(spin1), turn1);
    v4 roll2 = lanes_rolling(v4_all(c->mu_r) * press * lanes_size(arm2), lanes_size(spin2), turn2);

    struct x3 twist = x3_cross(ft, n), force = x3_add(x3_scale(n, fn), ft);
    rows_store(out[0]->force, out[1]->force, out[2]->force, out[3]->force, force, zero);
    rows_store(out[0]->torque1, out[1]->torque1, out[2]->torque1, out[3]->torque1,
               x3_sub(x3_scale(twist, reach1), x3_scale(spin1, roll1)), zero);
    rows_store(out[0]->torque2, out[1]->torque2, out[2]->torque2, out[3]->torque2,
               x3_sub(x3_scale(twist, reach2), x3_scale(spin2, roll2)), zero);

    if (ledger) {
        v4 kt_old = v4_all(c->tangential) * a_old, h = v4_all(0.5);
        struct x3 spun1 = x3_scale(x3_add(x3_cross(arm1, force), x3_scale(spin1, roll1)), v4_all(-0.5) * turn1);
        struct x3 spun2 = x3_scale(x3_sub(x3_cross(arm2, force), x3_scale(spin2, roll2)), h * turn2);
        struct x3 kick = x3_sub(x3_cross(spun1, arm1), x3_cross(spun2, arm2));
        kick = x3_sub(kick, x3_scale(force, h * (light1 + light2)));
        v4 along = x3_dot(kick, n);
        struct x3 mean = x3_add(slide, x3_sub(kick, x3_scale(n, along)));
        struct x3 was = x3_scale(slid_was, kt_old), now = x3_scale(slid, kt);
        v4 stored = h * kt_old * x3_dot(slid_was, slid_was), stores = h * kt * x3_dot(slid, slid);
        v4 lost_n = (fn - normal * a * overlap) * (approach + along) * dt;
        v4 lost_t = (h * x3_dot(x3_add(was, now), slide) + x3_dot(x3_sub(ft, now), mean)) * dt - (stores - stored);
        v4 lost_r = (roll1 * x3_dot(spin1, x3_add(spin1, spun1)) + roll2 * x3_dot(spin2, x3_add(spin2, spun2))) * dt;
        rows_store(&loss[0]->normal, &loss[1]->normal, &loss[2]->normal, &loss[3]->normal, (struct x3){lost_n, lost_t, zero},
                   lost_r);
    }
    rows_store(row0, row1, row2, row3, slid, mn_was);
    double *const rows[4] = {row0, row1, row2, row3};
    v4 fn_size = v4_abs(fn);
    for (int l = 0; l < 4; l++) {
        rows[l][CONTACT_FN] = fn_size[l];
        rows[l][CONTACT_A] = a[l];
    }
}

void PER_ISA(hertz_tsuji_pairs)(const struct law_coefs *coefs, const struct pair_batch *batch)
{
    if (batch->loss)
        lanes_batch(coefs, batch, group, 1);
    else
        lanes_batch(coefs, batch, group, 0);
}
