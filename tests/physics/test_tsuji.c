/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The law of seed 003 against closed forms, through the engine (targets S3-09,
 * S3-10, S3-11, S3-15, B-01, B-02, B-03, B-06, B-08), and its kernels against
 * the plain law. */
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
#include "dem/dem.h"
#include "dem/law.h"

static const struct law *const law = &law_hertz_tsuji;

static void near_to(double value, double expect, double relative)
{
    if (!(fabs(value - expect) <= relative * fabs(expect)))
        fail_msg("%.17g is not %.17g", value, expect);
}

/* One matter for everything, without friction. */
static struct fragment_spec matter(double young_Pa, double poisson, double restitution)
{
    struct fragment_matter one = {.shear_Pa = young_Pa / (2 * (1 + poisson)), .poisson = poisson};
    struct fragment_pair pair = {.restitution = restitution};
    return (struct fragment_spec){.clast = one, .chute = one, .clast_clast = pair, .clast_chute = pair, .softening = 1};
}

/* E = 2 G (1 + nu), to the figures of the targets. */
static void moduli_follow_from_table_1(void **state)
{
    (void)state;
    const struct fragment_spec *m = &fragment_igneous;
    assert_true(fabs(fragment_young_modulus(&m->clast) / 1e9 - 56.644) < 1e-9);
    assert_true(fabs(fragment_young_modulus(&m->chute) / 1e9 - 18.495) < 1e-9);
    assert_true(fabs(fragment_young_modulus(&m->gate) / 1e9 - 68.0) < 1e-9);
}

/* S3-15: for the inscribed spheres of 1, 1.5... here radii .125 to .75 mm. */
static void rayleigh_times_are_those_of_the_targets(void **state)
{
    (void)state;
    const double radius[] = {0.125e-3, 0.25e-3, 0.5e-3, 0.75e-3}, expect[] = {1.46e-7, 2.92e-7, 5.83e-7, 8.75e-7};
    for (int k = 0; k < 4; k++)
        near_to(fragment_rayleigh_time(&fragment_igneous, radius[k]), expect[k], 2e-3);
    struct fragment_spec soft = fragment_igneous;
    soft.softening = 1000;
    near_to(fragment_rayleigh_time(&soft, 0.25e-3), sqrt(1000) * fragment_rayleigh_time(&fragment_igneous, 0.25e-3), 1e-14);
}

/* S3-11: S_t / S_n = 2 (1 - nu) / (2 - nu) for like bodies; S_n = 3/2 dF/d... = 2 E* sqrt(R x). */
static void stiffness_ratio_is_mindlins(void **state)
{
    (void)state;
    struct law_coefs c;
    law->coefs(&fragment_igneous, FRAGMENT_CLAST, 1e-8, &c);
    near_to(c.tangential / (1.5 * c.normal), 2 * (1 - 0.19) / (2 - 0.19), 1e-12);
    near_to(c.tangential / (1.5 * c.normal), 0.8950, 1e-4);
}

/* ---- impacts ---- */

struct impact {
    double deepest, force, time, restitution;
};

/* A sphere of radius r falls at `speed` upon a like one that comes at the same speed, or upon a plane. */
static struct impact impact(const struct fragment_spec *m, double r, double density, double speed, bool plane, double step_s)
{
    struct dem_grain grains[2] = {{.position = {0, 0, r}, .velocity = {0, 0, -speed}, .radius = r, .density = density},
                                  {.position = {0, 0, -r}, .velocity = {0, 0, speed}, .radius = r, .density = density}};
    const struct dem_wall floor = {.normal = {0, 0, 1}, .partner = FRAGMENT_CHUTE};
    const struct dem_setup setup = {.law = law,
                                    .matter = m,
                                    .step_s = step_s,
                                    .grains = grains,
                                    .grain_count = plane ? 1 : 2,
                                    .walls = &floor,
                                    .wall_count = plane,
                                    .floor_z = -INFINITY,
                                    .threads = 1,
                                    .overlaps = true};
    struct dem *dem = NULL;
    struct scree_error error = {0};
    struct view view;
    struct impact out = {0};
    double approach = plane ? speed : 2 * speed, was = 0;
    if (dem_create(&setup, &dem, &error))
        fail_msg("%s", error.message);
    for (int k = 0; k < 1000000; k++) {
        if (dem_advance(dem, 1, &error) || dem_view(dem, &view, &error))
            fail_msg("%s", error.message);
        double overlap = view.contacts ? view.contact[0].overlap : 0;
        if (k > 2 && view.contacts == 0) { // the overlap went through zero between this step and the last
            double v = view.velocity[0][2] - (plane ? 0 : view.velocity[1][2]);
            out.restitution = fabs(v) / approach;
            out.time = ((double)k + was / (fabs(v) * step_s)) * step_s;
            break;
        }
        was = overlap;
        out.deepest = fmax(out.deepest, overlap);
        if (view.contacts)
            out.force = fmax(out.force, view.contact[0].force_normal);
    }
    dem_free(dem);
    return out;
}

/* B-01: Chung and Ooi 2011, table 1: two spheres of 10 mm at 10 m/s each. */
static void elastic_spheres_meet_as_hertz_says(void **state)
{
    (void)state;
    struct fragment_spec glass = matter(48e9, 0.20, 1), limestone = matter(20e9, 0.25, 1);
    struct impact g = impact(&glass, 10e-3, 2800, 10, false, 1e-8), l = impact(&limestone, 10e-3, 2500, 10, false, 1e-8);
    near_to(g.deepest, 274.11e-6, 1e-3);
    near_to(g.force, 10.697e3, 1e-3);
    near_to(g.time, 40.34e-6, 1e-3);
    near_to(l.deepest, 368.3e-6, 1e-3);
    near_to(l.force, 7.108e3, 1e-3);
    near_to(l.time, 54.2e-6, 1e-3);
    near_to(g.restitution, 1, 1e-6);
}

/* B-02: table 2: a sphere of 100 mm at 0.2 m/s upon a rigid plane. */
static void a_sphere_meets_a_rigid_plane_as_hertz_says(void **state)
{
    (void)state;
    struct fragment_spec al = matter(70e9, 0.30, 1), mg = matter(40e9, 0.35, 1);
    al.chute.shear_Pa = mg.chute.shear_Pa = 1e30;
    struct impact a = impact(&al, 0.1, 2699, 0.2, true, 2e-7), b = impact(&mg, 0.1, 1800, 0.2, true, 2e-7);
    near_to(a.deepest, 49.72e-6, 1e-3);
    near_to(a.force, 11.37e3, 1e-3);
    near_to(a.time, 731.6e-6, 1e-3);
    near_to(b.deepest, 52.12e-6, 1e-3);
    near_to(b.force, 7.233e3, 1e-3);
    near_to(b.time, 767.0e-6, 1e-3);
}

/* S3-10: e of Table 2 exactly, at any speed; clamped at zero it is larger, by as much as the targets say. */
static void restitution_is_exact_at_any_speed(void **state)
{
    (void)state;
    const double e[] = {0.49, 0.30, 0.53}, clamped[] = {0.5423, 0.3971, 0.5745}, speed[] = {0.01, 0.3, 10};
    for (int k = 0; k < 3; k++)
        for (int s = 0; s < 3; s++) {
            struct fragment_spec m = matter(56.64e9, 0.19, e[k]);
            double step = 4e-10 * pow(speed[s], -0.2);
            assert_true(fabs(impact(&m, 0.25e-3, 2700, speed[s], false, step).restitution - e[k]) < 1e-4);
            m.clamp = true;
            assert_true(fabs(impact(&m, 0.25e-3, 2700, speed[s], false, step).restitution - clamped[k]) < 1e-3);
        }
}

/* What an oblique impact of spinning spheres takes from their motion is what the ledger says was lost, at the steps that flows
 * are computed with: the work of a dashpot goes by the mean of the velocities before and after its own kick. */
static void the_ledger_of_an_impact_closes(void **state)
{
    (void)state;
    const double r = 0.75e-3, step_s = 0.3 * fragment_rayleigh_time(&fragment_igneous, r),
                 mass = 4.0 / 3.0 * M_PI * r * r * r * 2700;
    for (int plane = 0; plane < 2; plane++) {
        struct dem_grain grains[2] = {
            {.position = {0, 0, r}, .velocity = {0.2, 0, -0.3}, .spin = {100, 300, 50}, .radius = r, .density = 2700},
            {.position = {0, 0, -r}, .velocity = {0, 0.1, 0.3}, .spin = {-200, 0, 30}, .radius = r, .density = 2700}};
        const struct dem_wall floor = {.normal = {0, 0, 1}, .partner = FRAGMENT_CHUTE};
        const struct dem_setup setup = {.law = law,
                                        .matter = &fragment_igneous,
                                        .step_s = step_s,
                                        .grains = grains,
                                        .grain_count = plane ? 1 : 2,
                                        .walls = &floor,
                                        .wall_count = (size_t)plane,
                                        .floor_z = -INFINITY,
                                        .threads = 1,
                                        .overlaps = true,
                                        .ledger = true};
        struct dem *dem = NULL;
        struct scree_error error = {0};
        struct view view;
        double before = 0, after = 0;
        if (dem_create(&setup, &dem, &error) || dem_advance(dem, 2000, &error) || dem_view(dem, &view, &error))
            fail_msg("%s", error.message);
        assert_int_equal(view.contacts, 0);
        for (int k = 0; k < 2 - plane; k++)
            for (int a = 0; a < 3; a++) {
                double v0 = grains[k].velocity[a], w0 = grains[k].spin[a], v = view.velocity[k][a], w = view.spin[k][a];
                before += 0.5 * mass * (v0 * v0 + 0.4 * r * r * w0 * w0);
                after += 0.5 * mass * (v * v + 0.4 * r * r * w * w);
            }
        double lost = view.dissipated_normal + view.dissipated_tangential + view.dissipated_rolling;
        near_to(lost, before - after, 5e-3);
        dem_free(dem);
    }
}

/* B-03: a sphere of 2.5 mm at 3.9 m/s: out comes what went in, or with the clamp the targets' values. */
static void restitution_of_chung_and_ooi(void **state)
{
    (void)state;
    const double e[] = {0.2, 0.3, 0.4, 0.6, 0.8, 0.98}, clamped[] = {0.3249, 0.3971, 0.472, 0.6323, 0.8081, 0.9801};
    for (int k = 0; k < 6; k++) {
        struct fragment_spec m = matter(380e9, 0.23, e[k]);
        assert_true(fabs(impact(&m, 2.5e-3, 4000, 3.9, true, 5e-9).restitution - e[k]) < 1e-3);
        m.clamp = true;
        assert_true(fabs(impact(&m, 2.5e-3, 4000, 3.9, true, 5e-9).restitution - clamped[k]) < 1e-3);
    }
}

/* ---- rolling and sliding on a plane ---- */

/* A sphere that rests in its own overlap on the plane z = 0. */
static struct dem *on_plane(const struct fragment_spec *m, double r, const double gravity[3], double speed, double step_s)
{
    struct law_coefs c;
    double mass = 4.0 / 3.0 * M_PI * r * r * r * m->density_kg_m3;
    law->coefs(m, FRAGMENT_CHUTE, step_s, &c);
    double overlap = pow(-mass * gravity[2] / (c.normal * sqrt(r)), 2.0 / 3.0);
    struct dem_grain grain = {.position = {0, 0, r - overlap}, .velocity = {speed, 0, 0}, .radius = r, .density = m->density_kg_m3};
    const struct dem_wall floor = {.normal = {0, 0, 1}, .partner = FRAGMENT_CHUTE};
    struct dem_setup setup = {.law = law,
                              .matter = m,
                              .step_s = step_s,
                              .grains = &grain,
                              .grain_count = 1,
                              .walls = &floor,
                              .wall_count = 1,
                              .floor_z = -INFINITY,
                              .threads = 1};
    memcpy(setup.gravity, gravity, sizeof setup.gravity);
    struct dem *dem = NULL;
    struct scree_error error = {0};
    if (dem_create(&setup, &dem, &error))
        fail_msg("%s", error.message);
    return dem;
}

static struct view after(struct dem *dem, double seconds, double step_s)
{
    struct scree_error error = {0};
    struct view view = {0};
    if (dem_advance(dem, (uint64_t)round(seconds / step_s), &error) || dem_view(dem, &view, &error))
        fail_msg("%s", error.message);
    return view;
}

/* B-06: sliding turns into rolling after t = 2 u0 / (7 mu g), at 5/7 of the speed. */
static void sliding_turns_into_rolling(void **state)
{
    (void)state;
    const double r = 5e-3, mu = 0.3, g = 9.81, u0 = 0.5, step = 1e-6, gravity[3] = {0, 0, -g};
    struct fragment_spec m = matter(1e8, 0.3, 0.5);
    m.density_kg_m3 = 2700;
    m.clast_chute.friction = mu;
    struct dem *dem = on_plane(&m, r, gravity, u0, step);
    double expect = 2 * u0 / (7 * mu * g), turned = 0;
    for (int k = 0; k < 100000 && turned == 0; k++) {
        struct view view = after(dem, step, step);
        double f = hypot(view.contact[0].force[0], view.contact[0].force[1]);
        if (f < 0.9 * mu * fabs(view.contact[0].force_normal) && k > 100)
            turned = view.time_s;
    }
    struct view view = after(dem, 0.05, step);
    near_to(turned, expect, 6e-3);
    near_to(view.velocity[0][0], 5.0 / 7 * u0, 1e-3);
    near_to(view.spin[0][1] * r, 5.0 / 7 * u0, 1e-3);
    dem_free(dem);
}

/* B-08: v = 5/7 g sin 15 deg t. */
static void a_sphere_rolls_down_fifteen_degrees(void **state)
{
    (void)state;
    const double slope = 15 * M_PI / 180, g = 9.8, step = 1e-6, gravity[3] = {g * sin(slope), 0, -g * cos(slope)};
    struct fragment_spec m = matter(2e9, 0.3, 0.5);
    m.density_kg_m3 = 2700;
    m.clast_chute.friction = 0.5;
    struct dem *dem = on_plane(&m, 5e-3, gravity, 0, step);
    struct view view = after(dem, 1, step);
    near_to(view.velocity[0][0], 1.81173, 1e-4);
    dem_free(dem);
}

/* Eq. 13: the torque mu_r F_n r works against the spin, friction keeps the sphere rolling: dv/dt = -5/7 mu_r g. */
static void rolling_torque_slows_at_a_constant_rate(void **state)
{
    (void)state;
    const double r = 5e-3, mu_r = 0.02, g = 9.81, step = 1e-6, gravity[3] = {0, 0, -g};
    struct fragment_spec m = matter(1e8, 0.3, 0.5);
    m.density_kg_m3 = 2700;
    m.clast_chute.friction = 0.8;
    m.clast_chute.rolling = mu_r;
    struct dem *dem = on_plane(&m, r, gravity, 0.1, step);
    struct view view = after(dem, 0.05, step); // rolls
    double before = view.velocity[0][0], t = view.time_s;
    view = after(dem, 0.2, step);
    near_to((before - view.velocity[0][0]) / (view.time_s - t), 5.0 / 7 * mu_r * g, 1e-3);
    view = after(dem, 1, step); // and comes to rest, without rocking
    assert_true(fabs(view.velocity[0][0]) < 1e-9 && fabs(view.spin[0][1]) * r < 1e-9);
    dem_free(dem);
}

/* ---- kernels against the plain law ---- */

enum { PAIRS = 403, GRAINS = 2 * PAIRS };

struct crowd {
    double (*position)[4], (*velocity)[4], (*spin)[4], (*arm)[4], (*contact)[CONTACT_SLOTS], (*shift)[4];
    uint32_t *first, *second, *active;
    struct contact_out *out;
    struct contact_loss *loss;
    struct pair_batch batch;
};

/* Pairs of spheres and of members of bodies, some against fixed ones, of any overlap, history and speed. */
static struct crowd crowd_make(void)
{
    struct crowd c = {.position = memory_rows(GRAINS, 32),
                      .velocity = memory_rows(GRAINS, 32),
                      .spin = memory_rows(GRAINS, 32),
                      .arm = memory_rows(GRAINS, 32),
                      .contact = memory_rows(PAIRS, sizeof *c.contact),
                      .shift = memory_rows(IMAGE_CODES, 32),
                      .first = memory_rows(PAIRS, 4),
                      .second = memory_rows(PAIRS, 4),
                      .active = memory_rows(PAIRS, 4),
                      .out = memory_rows(PAIRS, sizeof *c.out),
                      .loss = memory_rows(PAIRS, sizeof *c.loss)};
    struct rng rng = rng_start(3, 3);
    for (size_t p = 0; p < PAIRS; p++) {
        double n[3], norm = 0, overlap = pow(10, rng_uniform(&rng, -18, -5)), *k = c.contact[p];
        for (int a = 0; a < 3; a++) {
            n[a] = rng_uniform(&rng, -1, 1);
            norm += n[a] * n[a];
        }
        for (size_t i = 2 * p; i < 2 * p + 2; i++) {
            bool fixed = i % 2 == 1 && p % 5 == 0;
            for (int a = 0; a < 3; a++) {
                c.position[i][a] = i % 2 ? c.position[i - 1][a] : rng_uniform(&rng, 0, 0.02);
                c.velocity[i][a] = fixed ? 0 : rng_uniform(&rng, -1, 1) * pow(10, rng_uniform(&rng, -9, 1));
                c.spin[i][a] = fixed ? 0 : rng_uniform(&rng, -1, 1) * pow(10, rng_uniform(&rng, -12, 5));
                c.arm[i][a] = p % 3 == 0 ? 0 : rng_uniform(&rng, -1e-3, 1e-3);
            }
            c.position[i][3] = rng_uniform(&rng, 0.1e-3, 1e-3);
            c.velocity[i][3] = fixed ? 0 : 1e-8 / 2e-6;
            c.spin[i][3] = fixed ? 0 : 1e-8 / 4e-13;
        }
        double r1 = c.position[2 * p][3], r2 = c.position[2 * p + 1][3];
        for (int a = 0; a < 3; a++)
            c.position[2 * p + 1][a] += n[a] / sqrt(norm) * (r1 + r2 - overlap);
        c.first[p] = (uint32_t)(2 * p);
        c.second[p] = (uint32_t)(2 * p + 1) | (uint32_t)IMAGE_NONE << IMAGE_SHIFT;
        c.active[p] = (uint32_t)p;
        k[CONTACT_R] = r1 * r2 / (r1 + r2);
        k[CONTACT_R1] = r1;
        k[CONTACT_R2] = r2;
        if (p % 4) {
            for (int s = CONTACT_FT_X; s <= CONTACT_FT_Z; s++)
                k[s] = rng_uniform(&rng, -1, 1) * pow(10, rng_uniform(&rng, -14, -5));
            k[CONTACT_A] = pow(10, rng_uniform(&rng, -8, -4));
        }
    }
    c.batch = (struct pair_batch){.position = (const double(*)[4])c.position,
                                  .velocity = (const double(*)[4])c.velocity,
                                  .spin = (const double(*)[4])c.spin,
                                  .arm = (const double(*)[4])c.arm,
                                  .shift = (const double(*)[4])c.shift,
                                  .first = c.first,
                                  .second = c.second,
                                  .contact = c.contact,
                                  .active = c.active,
                                  .out = c.out,
                                  .loss = c.loss};
    return c;
}

static void crowd_free(struct crowd *c)
{
    free(c->position), free(c->velocity), free(c->spin), free(c->arm), free(c->contact), free(c->shift);
    free(c->first), free(c->second), free(c->active), free(c->out), free(c->loss);
}

static void kernels_have_the_bits_of_the_plain_law(void **state)
{
    (void)state;
    struct law_coefs coefs;
    for (int clamp = 0; clamp < 2; clamp++)
        for (int ledger = 0; ledger < 2; ledger++)
            for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++) {
                struct fragment_spec m = fragment_igneous;
                m.clamp = clamp;
                law->coefs(&m, FRAGMENT_CLAST, 1e-8, &coefs);
                if (!cpu_has(isa))
                    continue;
                struct crowd plain = crowd_make(), fast = crowd_make();
                if (!ledger)
                    plain.batch.loss = fast.batch.loss = NULL;
                plain.batch.active_count = fast.batch.active_count = PAIRS;
                law->pairs_reference(&coefs, &plain.batch);
                law->pairs[isa](&coefs, &fast.batch);
                assert_memory_equal(plain.out, fast.out, PAIRS * sizeof *plain.out);
                assert_memory_equal(plain.contact, fast.contact, PAIRS * sizeof *plain.contact);
                assert_memory_equal(plain.loss, fast.loss, PAIRS * sizeof *plain.loss);
                for (size_t k = 0; k < PAIRS; k++)
                    for (int a = 0; a < 3; a++)
                        assert_true(isfinite(fast.out[k].force[a] + fast.out[k].torque1[a] + fast.out[k].torque2[a]));
                crowd_free(&plain);
                crowd_free(&fast);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moduli_follow_from_table_1),
        cmocka_unit_test(rayleigh_times_are_those_of_the_targets),
        cmocka_unit_test(stiffness_ratio_is_mindlins),
        cmocka_unit_test(elastic_spheres_meet_as_hertz_says),
        cmocka_unit_test(a_sphere_meets_a_rigid_plane_as_hertz_says),
        cmocka_unit_test(restitution_is_exact_at_any_speed),
        cmocka_unit_test(the_ledger_of_an_impact_closes),
        cmocka_unit_test(restitution_of_chung_and_ooi),
        cmocka_unit_test(sliding_turns_into_rolling),
        cmocka_unit_test(a_sphere_rolls_down_fifteen_degrees),
        cmocka_unit_test(rolling_torque_slows_at_a_constant_rate),
        cmocka_unit_test(kernels_have_the_bits_of_the_plain_law),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
