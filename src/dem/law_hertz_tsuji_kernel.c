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

struct rows { // of one of the two grains, by lane
    const double *x[4], *v[4], *w[4], *arm[4];
};

SIMD_INLINE void group(const struct law_coefs *c, const struct pair_batch *b, const uint32_t p[4], struct contact_out *const out[4],
                       struct contact_loss *const loss[4], int ledger)
{
    struct rows g1, g2;
    const double *shift[4];
    double *row[4];
    for (int l = 0; l < 4; l++) {
        uint32_t i = b->first[p[l]], second = b->second[p[l]], j = second & IMAGE_ROW;
        g1.x[l] = b->position[i], g2.x[l] = b->position[j];
        g1.v[l] = b->velocity[i], g2.v[l] = b->velocity[j];
        g1.w[l] = b->spin[i], g2.w[l] = b->spin[j];
        g1.arm[l] = b->arm[i], g2.arm[l] = b->arm[j];
        shift[l] = b->shift[second >> IMAGE_SHIFT];
        row[l] = b->contact[p[l]];
    }
    const v4 zero = {0}, one = v4_all(1.0), dt = v4_all(c->step);
    struct x3 x;
    v4 unused, light1, light2, turn1, turn2;
    v4_transpose((v4_load(g2.x[0]) - v4_load(g1.x[0])) + v4_load(shift[0]),
                 (v4_load(g2.x[1]) - v4_load(g1.x[1])) + v4_load(shift[1]),
                 (v4_load(g2.x[2]) - v4_load(g1.x[2])) + v4_load(shift[2]),
                 (v4_load(g2.x[3]) - v4_load(g1.x[3])) + v4_load(shift[3]), &x.x, &x.y, &x.z, &unused);
    struct x3 v1 = rows_load(g1.v[0], g1.v[1], g1.v[2], g1.v[3], &light1),
              v2 = rows_load(g2.v[0], g2.v[1], g2.v[2], g2.v[3], &light2);
    struct x3 spin1 = rows_load(g1.w[0], g1.w[1], g1.w[2], g1.w[3], &turn1);
    struct x3 spin2 = rows_load(g2.w[0], g2.w[1], g2.w[2], g2.w[3], &turn2);
    struct x3 arm1 = rows_load(g1.arm[0], g1.arm[1], g1.arm[2], g1.arm[3], &unused);
    struct x3 arm2 = rows_load(g2.arm[0], g2.arm[1], g2.arm[2], g2.arm[3], &unused);
    v4 mn_was, fn_old, a_old, r, r1, r2;
    struct x3 slid_was = rows_load(row[0], row[1], row[2], row[3], &mn_was);
    rows_load(row[0] + 4, row[1] + 4, row[2] + 4, row[3] + 4, &fn_old);
    v4_transpose(v4_load(row[0] + 8), v4_load(row[1] + 8), v4_load(row[2] + 8), v4_load(row[3] + 8), &a_old, &r, &r1, &r2);

    struct x3 velocity = x3_sub(v1, v2);
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
    v4 ft_size = lanes_size(ft);
    ft = x3_select((m4)(ft_size > ft_cap), x3_scale(ft, ft_cap / ft_size), ft);

    v4 far1 = lanes_size(x3_add(arm1, x3_scale(n, reach1))), far2 = lanes_size(x3_sub(arm2, x3_scale(n, reach2)));
    v4 roll1 = lanes_rolling(v4_all(c->mu_r) * press * far1, lanes_size(spin1), turn1);
    v4 roll2 = lanes_rolling(v4_all(c->mu_r) * press * far2, lanes_size(spin2), turn2);

    struct x3 twist = x3_cross(ft, n);
    rows_store(out[0]->force, out[1]->force, out[2]->force, out[3]->force, x3_add(x3_scale(n, fn), ft), zero);
    rows_store(out[0]->torque1, out[1]->torque1, out[2]->torque1, out[3]->torque1,
               x3_sub(x3_scale(twist, reach1), x3_scale(spin1, roll1)), zero);
    rows_store(out[0]->torque2, out[1]->torque2, out[2]->torque2, out[3]->torque2,
               x3_sub(x3_scale(twist, reach2), x3_scale(spin2, roll2)), zero);

    if (ledger) {
        v4 kt_old = v4_all(c->tangential) * a_old, h = v4_all(0.5);
        struct x3 was = x3_scale(slid_was, kt_old), now = x3_scale(slid, kt);
        v4 stored = h * kt_old * x3_dot(slid_was, slid_was), stores = h * kt * x3_dot(slid, slid);
        v4 lost_n = (fn - normal * a * overlap) * approach * dt;
        v4 lost_t = (h * x3_dot(x3_add(was, now), slide) + x3_dot(x3_sub(ft, now), slide)) * dt - (stores - stored);
        v4 lost_r = (roll1 * x3_dot(spin1, spin1) + roll2 * x3_dot(spin2, spin2)) * dt;
        rows_store(&loss[0]->normal, &loss[1]->normal, &loss[2]->normal, &loss[3]->normal, (struct x3){lost_n, lost_t, zero},
                   lost_r);
    }
    rows_store(row[0], row[1], row[2], row[3], slid, mn_was);
    v4 fn_size = v4_abs(fn);
    for (int l = 0; l < 4; l++) {
        row[l][CONTACT_FN] = fn_size[l];
        row[l][CONTACT_A] = a[l];
    }
}

void PER_ISA(hertz_tsuji_pairs)(const struct law_coefs *coefs, const struct pair_batch *batch)
{
    if (batch->loss)
        lanes_batch(coefs, batch, group, 1);
    else
        lanes_batch(coefs, batch, group, 0);
}
