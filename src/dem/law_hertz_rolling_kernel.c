/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The law of law_hertz_rolling.c on four contacts at once.
 *
 * This one source is compiled per instruction set (ISA names it).
 * Rows of four doubles are loaded whole and transposed: gathers are slower on
 * most processors. Branches become selects; every operation and its order are
 * those of hertz_rolling_contact, to which a test holds it bit by bit. Equation
 * numbers stand there. */
#include "dem/lanes.h"
#include "dem/law_hertz_rolling.h"

/* Energy of a spring; an unloaded contact stores nothing. */
SIMD_INLINE v4 lanes_spring(v4 force_squared, v4 stiffness)
{
    v4 zero = {0};
    return v4_select((m4)(stiffness > zero), force_squared / (v4_all(2.0) * stiffness), zero);
}

/* From the first grain to the second, and how the first moves against it; spins of both. */
struct pair_motion {
    struct x3 x, velocity, spin1, spin2;
};

SIMD_INLINE struct pair_motion load_motion(const struct pair_batch *b, const uint32_t p[4])
{
    const double *x1[4], *x2[4], *u1[4], *u2[4], *s1[4], *s2[4], *shift[4];
    for (int l = 0; l < 4; l++) {
        uint32_t i = b->first[p[l]], second = b->second[p[l]], j = second & IMAGE_ROW;
        x1[l] = b->position[i], x2[l] = b->position[j];
        u1[l] = b->velocity[i], u2[l] = b->velocity[j];
        s1[l] = b->spin[i], s2[l] = b->spin[j];
        shift[l] = b->shift[second >> IMAGE_SHIFT];
    }
    struct pair_motion m;
    v4 unused;
    v4_transpose((v4_load(x2[0]) - v4_load(x1[0])) + v4_load(shift[0]), (v4_load(x2[1]) - v4_load(x1[1])) + v4_load(shift[1]),
                 (v4_load(x2[2]) - v4_load(x1[2])) + v4_load(shift[2]), (v4_load(x2[3]) - v4_load(x1[3])) + v4_load(shift[3]),
                 &m.x.x, &m.x.y, &m.x.z, &unused);
    v4_transpose(v4_load(u1[0]) - v4_load(u2[0]), v4_load(u1[1]) - v4_load(u2[1]), v4_load(u1[2]) - v4_load(u2[2]),
                 v4_load(u1[3]) - v4_load(u2[3]), &m.velocity.x, &m.velocity.y, &m.velocity.z, &unused);
    m.spin1 = rows_load(s1[0], s1[1], s1[2], s1[3], &unused);
    m.spin2 = rows_load(s2[0], s2[1], s2[2], s2[3], &unused);
    return m;
}

/* One group: contacts p[0..3], results to out[0..3], losses to loss[0..3] when
 * `ledger`. Lanes may repeat a contact: they then write the same values. */
SIMD_INLINE void group(const struct law_coefs *c, const struct pair_batch *b, const uint32_t p[4], struct contact_out *const out[4],
                       struct contact_loss *const loss[4], int ledger)
{
    const v4 zero = {0}, one = v4_all(1.0), dt = v4_all(c->step);
    double *row[4];
    for (int l = 0; l < 4; l++)
        row[l] = b->contact[p[l]];
    const struct pair_motion m = load_motion(b, p);
    const struct x3 x = m.x, velocity = m.velocity, spin1 = m.spin1, spin2 = m.spin2;
    v4 mn_was, fn_old, a_old, r, r1, r2;
    struct x3 ft_was = rows_load(row[0], row[1], row[2], row[3], &mn_was);
    struct x3 mr_was = rows_load(row[0] + 4, row[1] + 4, row[2] + 4, row[3] + 4, &fn_old);
    v4_transpose(v4_load(row[0] + 8), v4_load(row[1] + 8), v4_load(row[2] + 8), v4_load(row[3] + 8), &a_old, &r, &r1, &r2);

    v4 distance = v4_sqrt(x3_dot(x, x)), inverse = one / distance;
    v4 overlap = (r1 + r2) - distance;
    overlap = v4_select((m4)(overlap > zero), overlap, zero);
    struct x3 n = x3_scale(x, inverse);

    v4 approach = x3_dot(velocity, n);
    v4 a = v4_sqrt(r * overlap);
    v4 fn = v4_all(c->normal) * a * (overlap + v4_all(c->beta) * approach);
    v4 fn_size = v4_abs(fn);
    m4 loading = (m4)(fn_size >= fn_old);
    v4 ratio = v4_select(loading, one, a / a_old);

    v4 kt = v4_all(c->tangential) * a;
    struct x3 lever = x3_add(x3_scale(spin1, r1), x3_scale(spin2, r2));
    struct x3 slide = x3_add(x3_sub(velocity, x3_scale(n, approach)), x3_cross(lever, n));
    struct x3 ft_e = x3_sub(ft_was, x3_scale(n, x3_dot(ft_was, n)));
    ft_e = x3_add(x3_scale(ft_e, ratio), x3_scale(slide, kt * dt));
    struct x3 viscous = x3_scale(slide, v4_all(c->beta) * kt);
    struct x3 ft = x3_add(ft_e, viscous);
    m4 slip = x3_cap(&ft, v4_all(c->mu_t) * fn_size);
    ft_e = x3_select(slip, x3_sub(ft, viscous), ft_e);

    struct x3 spin = x3_sub(spin1, spin2);
    v4 twist = x3_dot(spin, n);
    v4 kn = v4_all(c->torsion) * (a * a * a);
    v4 mn_e = mn_was * v4_select(loading, one, ratio * ratio * ratio) + twist * (kn * dt);
    v4 resist = twist * (v4_all(c->beta) * kn);
    v4 mn = mn_e + resist, mn_cap = v4_all(c->mu_n) * fn_size * a;
    m4 turn = (m4)(v4_abs(mn) > mn_cap);
    mn = v4_select(turn, v4_select((m4)(mn < zero), -mn_cap, mn_cap), mn);
    mn_e = v4_select(turn, mn - resist, mn_e);

    v4 kr = v4_all(c->rolling) * fn_size * r;
    struct x3 roll = x3_sub(spin, x3_scale(n, twist));
    struct x3 mr_e = x3_sub(mr_was, x3_scale(n, x3_dot(mr_was, n)));
    mr_e = x3_add(x3_scale(mr_e, v4_select(loading, one, fn_size / fn_old)), x3_scale(roll, kr * dt));
    struct x3 drag = x3_scale(roll, v4_all(c->beta_r) * kr);
    struct x3 mr = x3_add(mr_e, drag);
    m4 rolls = x3_cap(&mr, v4_all(c->mu_r) * fn_size * r);
    mr_e = x3_select(rolls, x3_sub(mr, drag), mr_e);

    struct x3 arm = x3_cross(ft, n);
    struct x3 couple = x3_add(x3_scale(n, mn), mr);
    v4 half = v4_all(0.5) * overlap;
    rows_store(out[0]->force, out[1]->force, out[2]->force, out[3]->force, x3_add(x3_scale(n, fn), ft), zero);
    rows_store(out[0]->torque1, out[1]->torque1, out[2]->torque1, out[3]->torque1, x3_sub(x3_scale(arm, r1 - half), couple), zero);
    rows_store(out[0]->torque2, out[1]->torque2, out[2]->torque2, out[3]->torque2, x3_add(x3_scale(arm, r2 - half), couple), zero);

    if (ledger) {
        v4 at = v4_all(c->tangential), an = v4_all(c->torsion), ar = v4_all(c->rolling), h = v4_all(0.5);
        v4 lost_n = v4_all(c->normal) * a * v4_all(c->beta) * (approach * approach) * dt;
        v4 lost_t = (h * x3_dot(x3_add(ft_was, ft_e), slide) + x3_dot(x3_sub(ft, ft_e), slide)) * dt -
                    (lanes_spring(x3_dot(ft_e, ft_e), at * a) - lanes_spring(x3_dot(ft_was, ft_was), at * a_old));
        v4 lost_m = (h * (mn_was + mn_e) * twist + (mn - mn_e) * twist) * dt -
                    (lanes_spring(mn_e * mn_e, an * (a * a * a)) - lanes_spring(mn_was * mn_was, an * (a_old * a_old * a_old)));
        v4 lost_r = (h * x3_dot(x3_add(mr_was, mr_e), roll) + x3_dot(x3_sub(mr, mr_e), roll)) * dt -
                    (lanes_spring(x3_dot(mr_e, mr_e), ar * fn_size * r) - lanes_spring(x3_dot(mr_was, mr_was), ar * fn_old * r));
        rows_store(&loss[0]->normal, &loss[1]->normal, &loss[2]->normal, &loss[3]->normal, (struct x3){lost_n, lost_t, lost_m},
                   lost_r);
    }
    rows_store(row[0], row[1], row[2], row[3], ft_e, mn_e);
    rows_store(row[0] + 4, row[1] + 4, row[2] + 4, row[3] + 4, mr_e, fn_size);
    for (int l = 0; l < 4; l++)
        row[l][CONTACT_A] = a[l];
}

void PER_ISA(hertz_rolling_pairs)(const struct law_coefs *coefs, const struct pair_batch *batch)
{
    if (batch->loss)
        lanes_batch(coefs, batch, group, 1);
    else
        lanes_batch(coefs, batch, group, 0);
}
