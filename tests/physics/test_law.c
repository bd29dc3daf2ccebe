/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The contact law one contact at a time: signs, frames, caps, conservation
 * (targets S0-23, S0-24), and the vector kernels against the plain law. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/rng.h"
#include "base/vec3.h"
#include "dem/law.h"

static const struct law *const law = &law_hertz_rolling;

static struct material_spec glass(void)
{
    return material_preset_find("glass-beads-2mm")->values;
}

/* Two grains and the one pair between them, moved by hand. */
struct pair {
    _Alignas(32) double position[2][4], velocity[2][4], spin[2][4], shift[IMAGE_CODES][4];
    _Alignas(32) double contact[1][CONTACT_SLOTS];
    _Alignas(32) struct contact_out out;
    _Alignas(32) struct contact_loss loss;
    struct law_coefs coefs;
};

static const double step = 2.5e-7;

static void pair_start(struct pair *p, const struct material_spec *m, double r1, double r2, double overlap)
{
    memset(p, 0, sizeof *p);
    p->position[0][3] = r1;
    p->position[1][3] = r2;
    p->position[1][0] = r1 + r2 - overlap;
    p->contact[0][CONTACT_R] = r1 * r2 / (r1 + r2);
    p->contact[0][CONTACT_R1] = r1;
    p->contact[0][CONTACT_R2] = r2;
    law->coefs(m, 0, step, &p->coefs);
}

static void pair_force(struct pair *p)
{
    const uint32_t first = 0, second = 1 | (uint32_t)IMAGE_NONE << IMAGE_SHIFT, active = 0;
    struct pair_batch batch = {.position = (const double(*)[4])p->position,
                               .velocity = (const double(*)[4])p->velocity,
                               .spin = (const double(*)[4])p->spin,
                               .shift = (const double(*)[4])p->shift,
                               .first = &first,
                               .second = &second,
                               .contact = p->contact,
                               .active = &active,
                               .active_count = 1,
                               .out = &p->out,
                               .loss = &p->loss};
    law->pairs[cpu_best()](&p->coefs, &batch);
}

static struct vec3 pair_normal(const struct pair *p)
{
    struct vec3 x = vec3_sub(vec3_load(p->position[1]), vec3_load(p->position[0]));
    return vec3_scale(x, 1 / sqrt(vec3_dot(x, x)));
}

/* Eqs 3, 5: Hertz's force at rest, F = 2E / 3(1 - nu^2) sqrt(r) d^(3/2). */
static void static_force_is_hertz(void **state)
{
    (void)state;
    struct material_spec m = glass();
    struct pair p;
    pair_start(&p, &m, 1e-3, 1.5e-3, 2e-6);
    pair_force(&p);
    double r = 1e-3 * 1.5e-3 / 2.5e-3;
    double expect = 2 * m.young_Pa / (3 * (1 - m.poisson * m.poisson)) * sqrt(r) * pow(2e-6, 1.5);
    assert_true(fabs(p.out.force[0] / expect - 1) < 1e-9); // overlap itself is known to 1e-10
    assert_true(p.out.force[1] == 0 && p.out.force[2] == 0);
}

/* Eq. 8 corrected and eq. 9: a first sliding step builds k_t dt against the motion of 1 over 2. */
static void first_slide_has_stiffness_and_sign_of_eq_9(void **state)
{
    (void)state;
    struct material_spec m = glass();
    struct pair p;
    pair_start(&p, &m, 1e-3, 1e-3, 2e-6);
    p.velocity[0][1] = 1e-6; // 1 slides along +y over 2: drags it along +y
    pair_force(&p);
    double kt = 4 * material_shear_modulus(&m) / (2 - m.poisson) * sqrt(5e-4 * 2e-6);
    double expect = kt * 1e-6 * (step + m.beta_s);
    assert_true(fabs(p.out.force[1] / expect - 1) < 1e-6);
    assert_true(fabs(p.contact[0][CONTACT_FT_Y] / (kt * 1e-6 * step) - 1) < 1e-6);
    /* Eq. 13: (r - d/2) F_t x n on both, the same sign. F_t along y, n along x: -z. */
    assert_true(fabs(p.out.torque2[2] / (-(1e-3 - 1e-6) * expect) - 1) < 1e-6);
    assert_true(p.out.torque1[2] == p.out.torque2[2]);
}

/* Rolling without sliding leaves the contact point at rest: spins of opposite sign do not slide. */
static void counter_rotation_does_not_slide(void **state)
{
    (void)state;
    struct material_spec m = glass();
    struct pair p;
    pair_start(&p, &m, 1e-3, 2e-3, 2e-6);
    p.spin[0][2] = 2.0;
    p.spin[1][2] = -1.0; // r1 w1 + r2 w2 = 0
    pair_force(&p);
    assert_true(fabs(p.out.force[1]) < 1e-15);
    assert_true(p.out.torque2[2] > 0); // rolling resistance drives 2 after 1
}

/* Eq. 11: pure sliding transmits mu |F_n|, along the sliding direction. */
static void sliding_is_capped_by_coulomb(void **state)
{
    (void)state;
    struct material_spec m = glass();
    struct pair p;
    pair_start(&p, &m, 1e-3, 1e-3, 2e-6);
    p.velocity[0][1] = 0.3;
    p.velocity[0][2] = -0.4;
    for (int k = 0; k < 5; k++)
        pair_force(&p);
    double t = hypot(p.out.force[1], p.out.force[2]);
    assert_true(fabs(t / (m.mu_t * fabs(p.out.force[0])) - 1) < 1e-12);
    assert_true(fabs(p.out.force[1] / t - 0.6) < 1e-12 && fabs(p.out.force[2] / t + 0.8) < 1e-12);
}

/* Eq. 14: stiffness factor * G * a^3 of the first torsion step, with either factor; eq. 18: its cap. */
static void torsion_has_stiffness_and_cap_as_printed(void **state)
{
    (void)state;
    const double factors[] = {16.0 / 3.0, 8.0 / 3.0};
    for (int k = 0; k < 2; k++) {
        struct material_spec m = glass();
        m.torsion_factor = factors[k];
        struct pair p;
        pair_start(&p, &m, 1e-3, 1e-3, 2e-6);
        p.spin[0][0] = 1e-3;
        pair_force(&p);
        double a = sqrt(5e-4 * 2e-6), expect = factors[k] * material_shear_modulus(&m) * a * a * a * 1e-3 * (step + m.beta_s);
        assert_true(fabs(p.out.torque2[0] / expect - 1) < 1e-6);
        assert_true(p.out.torque1[0] == -p.out.torque2[0]);
        p.spin[0][0] = 1e6;
        pair_force(&p);
        assert_true(fabs(p.out.torque2[0] / (3 * M_PI / 16 * m.mu_t * fabs(p.out.force[0]) * a) - 1) < 1e-9);
    }
}

/* Eq. 9 on unloading rescales the spring by k_t / k_t_old, on loading it does not. */
static void spring_is_rescaled_on_unloading_only(void **state)
{
    (void)state;
    struct material_spec m = glass();
    struct pair p;
    pair_start(&p, &m, 1e-3, 1e-3, 2e-6);
    p.velocity[0][1] = 1e-6;
    pair_force(&p);
    p.velocity[0][1] = 0;
    double before = p.contact[0][CONTACT_FT_Y];
    p.position[1][0] = 2e-3 - 3e-6;
    pair_force(&p);
    assert_true(p.contact[0][CONTACT_FT_Y] == before);
    p.position[1][0] = 2e-3 - 1e-6;
    pair_force(&p);
    assert_true(fabs(p.contact[0][CONTACT_FT_Y] / (before * sqrt(1.0 / 3.0)) - 1) < 1e-9);
}

/* S0-23 (i) and (ii): carried around by rigid rotation the spring stays in the
 * plane to rounding, and each step changes its length at second order only. */
static double drift_of_tumbling_spring(double angle_per_step, int steps, double *out_of_plane)
{
    struct material_spec m = glass();
    m.mu_t = 10;
    m.beta_s = 0;
    struct pair p;
    pair_start(&p, &m, 1e-3, 1e-3, 2e-6);
    p.velocity[0][1] = 1;
    pair_force(&p);
    double start = p.contact[0][CONTACT_FT_Y], d = 2e-3 - 2e-6, worst = 0;
    struct vec3 axis = {0.3, -0.5, 0.81240384046359608}; // unit
    struct vec3 x = {d, 0, 0};
    for (int k = 0; k < steps; k++) {
        double c = cos(angle_per_step), s = sin(angle_per_step);
        struct vec3 turned =
            vec3_add(vec3_add(vec3_scale(x, c), vec3_scale(vec3_cross(axis, x), s)), vec3_scale(axis, vec3_dot(axis, x) * (1 - c)));
        struct vec3 v = vec3_scale(vec3_sub(turned, x), 1 / step);
        x = turned;
        vec3_store(p.velocity[1], v);
        vec3_store3(p.position[1], x);
        vec3_store3(p.velocity[0], (struct vec3){0, 0, 0});
        /* Both spin with the pair so that nothing slides: eq. 8 takes the arms r1 + r2, a little more than d. */
        vec3_store(p.spin[0], vec3_scale(axis, angle_per_step / step * d / 2e-3));
        vec3_store(p.spin[1], vec3_scale(axis, angle_per_step / step * d / 2e-3));
        pair_force(&p);
        struct vec3 f = vec3_load(&p.contact[0][CONTACT_FT_X]);
        worst = fmax(worst, fabs(vec3_dot(f, pair_normal(&p))) / sqrt(vec3_dot(f, f)));
    }
    struct vec3 f = vec3_load(&p.contact[0][CONTACT_FT_X]);
    *out_of_plane = worst;
    return fabs(sqrt(vec3_dot(f, f)) / start - 1) / steps;
}

static void spring_turns_with_the_pair(void **state)
{
    (void)state;
    double plane;
    double coarse = drift_of_tumbling_spring(2e-4, 2000, &plane);
    assert_true(plane < 1e-12);
    double fine = drift_of_tumbling_spring(1e-4, 4000, &plane);
    assert_true(plane < 1e-12);
    assert_true(coarse < 1e-4); // the tip moves along a chord: angle^2 d / 2 against a spring of 1e-4 d
    assert_true(fabs(coarse / fine - 4) < 0.2);
}

/* S0-23 (iii), (v): what 1 does to 2 and 2 to 1 conserves momentum and, with
 * lever arms r - d/2 from each centre, angular momentum. */
static void torques_balance_about_any_point(void **state)
{
    (void)state;
    struct rng rng = rng_start(7, 1);
    struct material_spec m = glass();
    for (int k = 0; k < 200; k++) {
        struct pair p;
        double r1 = rng_uniform(&rng, 0.5e-3, 2e-3), r2 = rng_uniform(&rng, 0.5e-3, 2e-3);
        pair_start(&p, &m, r1, r2, rng_uniform(&rng, 1e-9, 5e-6));
        for (int a = 0; a < 3; a++) {
            p.velocity[0][a] = rng_uniform(&rng, -1, 1);
            p.velocity[1][a] = rng_uniform(&rng, -1, 1);
            p.spin[0][a] = rng_uniform(&rng, -500, 500);
            p.spin[1][a] = rng_uniform(&rng, -500, 500);
        }
        for (int s = 0; s < 3; s++)
            pair_force(&p);
        struct vec3 f = vec3_load(p.out.force);
        /* 2 gets F at x2, 1 gets -F at x1: total torque about x1 must vanish. */
        struct vec3 apart = vec3_sub(vec3_load(p.position[1]), vec3_load(p.position[0]));
        struct vec3 total = vec3_add(vec3_add(vec3_load(p.out.torque1), vec3_load(p.out.torque2)), vec3_cross(apart, f));
        double size = sqrt(vec3_dot(apart, apart) * vec3_dot(f, f));
        assert_true(sqrt(vec3_dot(total, total)) < 1e-12 * size);
    }
}

/* ---- vector kernels against the plain law ---- */

enum { PAIRS = 1003, GRAINS = 400 };

struct crowd {
    double (*position)[4], (*velocity)[4], (*spin)[4], (*contact)[CONTACT_SLOTS], (*shift)[4];
    uint32_t *first, *second, *active;
    struct contact_out *out;
    struct contact_loss *loss;
    struct pair_batch batch;
};

static struct crowd crowd_make(uint64_t seed)
{
    struct crowd c = {.position = memory_rows(GRAINS, 32),
                      .velocity = memory_rows(GRAINS, 32),
                      .spin = memory_rows(GRAINS, 32),
                      .contact = memory_rows(PAIRS, sizeof *c.contact),
                      .shift = memory_rows(IMAGE_CODES, 32),
                      .first = memory_rows(PAIRS, 4),
                      .second = memory_rows(PAIRS, 4),
                      .active = memory_rows(PAIRS, 4),
                      .out = memory_rows(PAIRS, sizeof *c.out),
                      .loss = memory_rows(PAIRS, sizeof *c.loss)};
    struct rng rng = rng_start(seed, 3);
    for (int code = 0; code < IMAGE_CODES; code++)
        for (int a = 0, rest = code; a < 3; a++, rest /= IMAGE_BASE)
            c.shift[code][a] = (rest % IMAGE_BASE - IMAGE_REACH) * 0.02;
    for (size_t i = 0; i < GRAINS; i++) {
        for (int a = 0; a < 3; a++) {
            c.velocity[i][a] = rng_uniform(&rng, -1, 1) * pow(10, rng_uniform(&rng, -9, 1));
            c.spin[i][a] = rng_uniform(&rng, -1, 1) * pow(10, rng_uniform(&rng, -6, 6));
        }
        c.position[i][3] = rng_uniform(&rng, 0.95e-3, 1.05e-3);
    }
    for (size_t p = 0; p < PAIRS; p++) {
        /* Grain 2 is put at the wanted overlap from grain 1, in a random direction and
         * image; later pairs may move it again, so pairs are evaluated one by one. */
        size_t i = rng_next(&rng) % (GRAINS / 2), j = GRAINS / 2 + rng_next(&rng) % (GRAINS / 2);
        c.first[p] = (uint32_t)i;
        c.second[p] = (uint32_t)j | (uint32_t)(rng_next(&rng) % IMAGE_CODES) << IMAGE_SHIFT;
        c.active[p] = (uint32_t)p;
        double r1 = c.position[i][3], r2 = c.position[j][3], *k = c.contact[p];
        k[CONTACT_R] = r1 * r2 / (r1 + r2);
        k[CONTACT_R1] = r1;
        k[CONTACT_R2] = r2;
        switch (p % 4) { // fresh, or with a history of any size: loading, unloading, sliding
        case 0:
            break;
        default:
            for (int s = 0; s < CONTACT_HISTORY; s++)
                k[s] = rng_uniform(&rng, s < CONTACT_FN ? -1 : 0, 1) * pow(10, rng_uniform(&rng, -12, p % 4 == 1 ? 3 : -6));
        }
    }
    c.batch = (struct pair_batch){.position = (const double(*)[4])c.position,
                                  .velocity = (const double(*)[4])c.velocity,
                                  .spin = (const double(*)[4])c.spin,
                                  .shift = (const double(*)[4])c.shift,
                                  .first = c.first,
                                  .second = c.second,
                                  .contact = c.contact,
                                  .active = c.active,
                                  .out = c.out,
                                  .loss = c.loss};
    return c;
}

/* Puts grain 2 of pair p at an overlap between grazing (1e-18 m) and deep. */
static void crowd_place(struct crowd *c, size_t p)
{
    struct rng rng = rng_start(p, 4);
    uint32_t i = c->first[p], j = c->second[p] & IMAGE_ROW;
    double overlap = pow(10, rng_uniform(&rng, -18, -5)), n[3], norm = 0;
    for (int a = 0; a < 3; a++) {
        n[a] = rng_uniform(&rng, -1, 1);
        norm += n[a] * n[a];
    }
    for (int a = 0; a < 3; a++) {
        c->position[i][a] = rng_uniform(&rng, 0, 0.02);
        c->position[j][a] = c->position[i][a] + n[a] / sqrt(norm) * (c->position[i][3] + c->position[j][3] - overlap) -
                            c->shift[c->second[p] >> IMAGE_SHIFT][a];
    }
}

static void crowd_free(struct crowd *c)
{
    free(c->position), free(c->velocity), free(c->spin), free(c->contact), free(c->shift);
    free(c->first), free(c->second), free(c->active), free(c->out), free(c->loss);
}

/* Every kernel gives the bits of the plain law: forces, torques, histories, losses;
 * fresh, sliding, unloading and grazing contacts, huge spins, any tail length. */
static void kernels_have_the_bits_of_the_plain_law(void **state)
{
    (void)state;
    struct material_spec m = glass();
    struct law_coefs coefs;
    law->coefs(&m, 0, step, &coefs);
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++) {
        if (!cpu_has(isa)) {
            print_message("%s: not on this machine, left out\n", cpu_isa_name(isa));
            continue;
        }
        for (int ledger = 0; ledger < 2; ledger++) {
            struct crowd plain = crowd_make(11), fast = crowd_make(11);
            if (!ledger)
                plain.batch.loss = fast.batch.loss = NULL;
            size_t k = 0;
            for (size_t count = 1; k < PAIRS; k += count, count = count % 9 + 1) {
                /* Groups of 1 to 9 contacts at a time, none of which shares a moved grain. */
                size_t n = k + count <= PAIRS ? count : PAIRS - k, used = 0;
                for (; used < n; used++) {
                    int clash = 0;
                    for (size_t q = 0; q < used; q++)
                        clash |= plain.second[k + q] % (1u << IMAGE_SHIFT) == plain.second[k + used] % (1u << IMAGE_SHIFT) ||
                                 plain.first[k + q] == plain.first[k + used];
                    if (clash)
                        break;
                    crowd_place(&plain, k + used);
                    crowd_place(&fast, k + used);
                }
                count = used;
                plain.batch.active = plain.active + k, fast.batch.active = fast.active + k;
                plain.batch.out = plain.out + k, fast.batch.out = fast.out + k;
                if (ledger)
                    plain.batch.loss = plain.loss + k, fast.batch.loss = fast.loss + k;
                plain.batch.active_count = fast.batch.active_count = used;
                law->pairs_reference(&coefs, &plain.batch);
                law->pairs[isa](&coefs, &fast.batch);
            }
            assert_memory_equal(plain.out, fast.out, PAIRS * sizeof *plain.out);
            assert_memory_equal(plain.contact, fast.contact, PAIRS * sizeof *plain.contact);
            if (ledger)
                assert_memory_equal(plain.loss, fast.loss, PAIRS * sizeof *plain.loss);
            crowd_free(&plain);
            crowd_free(&fast);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(static_force_is_hertz),
        cmocka_unit_test(first_slide_has_stiffness_and_sign_of_eq_9),
        cmocka_unit_test(counter_rotation_does_not_slide),
        cmocka_unit_test(sliding_is_capped_by_coulomb),
        cmocka_unit_test(torsion_has_stiffness_and_cap_as_printed),
        cmocka_unit_test(spring_is_rescaled_on_unloading_only),
        cmocka_unit_test(spring_turns_with_the_pair),
        cmocka_unit_test(torques_balance_about_any_point),
        cmocka_unit_test(kernels_have_the_bits_of_the_plain_law),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
