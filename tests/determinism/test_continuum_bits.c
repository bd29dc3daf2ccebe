/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The continuum's bits: the same on any threads, instruction set, slice and across
 * an image; and the golden hash of one collapse. */
#include "continuum.h"

#include "base/cpu.h"
#include "base/memory.h"
#include "mpm/image.h"

enum { STEPS = 40, MIDDLE = 23 };

/* A column behind a gate that lifts, frictional walls, mu(I): every part of a step is used. */
static struct mpm_setup collapse(int threads, const char *isa, bool plane)
{
    static const struct mpm_region regions[2] = {{{0, 0, 0}, {0.16, 0.03, 0.01}}, {{0, 0, 0.01}, {0.05, 0.03, 0.05}}};
    static const struct mpm_body gate = {
        .low = {0.05, -1, 0.01}, .high = {0.07, 1, 1}, .velocity = {0, 0, 3}, .start_s = 0.005, .tau_s = 0.005, .mu = 0.2};
    struct mpm_setup s = continuum_box(16, plane ? 0 : 3, 7, regions);
    s.region_count = 2;
    s.points_per_cell = 3;
    s.jitter = 1;
    s.bodies = &gate;
    s.body_count = 1;
    s.walls[MPM_Z_LOW].kind = MPM_STICK;
    for (int face = MPM_X_LOW; face < MPM_Z_LOW; face++)
        s.walls[face] = (struct mpm_wall){MPM_FRICTION, .mu = 0.23};
    s.law = &mpm_law_mu_i;
    s.coefs = (struct mpm_law_coefs){.mu = 0.38, .mu_2 = 0.64, .inertial0 = 0.279};
    s.solver.tolerance = 1e-10;
    s.solver.sweeps = 100;
    s.threads = threads;
    s.isa = isa;
    return s;
}

static uint64_t run(int threads, const char *isa, bool plane, uint64_t slice)
{
    struct mpm_setup s = collapse(threads, isa, plane);
    struct mpm *mpm = continuum_start(&s);
    for (uint64_t done = 0; done < STEPS; done += slice)
        continuum_run(mpm, slice < STEPS - done ? slice : STEPS - done);
    uint64_t hash = mpm_hash(mpm);
    mpm_free(mpm);
    return hash;
}

/* Threads take slabs and cells as they like; sums keep their order. */
static void threads_do_not_show(void **state)
{
    (void)state;
    for (int plane = 0; plane < 2; plane++) {
        uint64_t one = run(1, NULL, plane, STEPS);
        for (int threads = 2; threads <= 5; threads++)
            assert_int_equal(run(threads, NULL, plane, STEPS), one);
    }
}

static void instruction_sets_do_not_show(void **state)
{
    (void)state;
    for (int plane = 0; plane < 2; plane++) {
        uint64_t v2 = run(1, "x86-64-v2", plane, STEPS);
        for (enum cpu_isa isa = CPU_V3; isa < CPU_ISA_COUNT; isa++)
            if (cpu_has(isa))
                assert_int_equal(run(1, cpu_isa_name(isa), plane, STEPS), v2);
    }
}

static void slices_do_not_show(void **state)
{
    (void)state;
    uint64_t whole = run(1, NULL, false, STEPS);
    assert_int_equal(run(1, NULL, false, 1), whole);
    assert_int_equal(run(2, NULL, false, 7), whole);
}

static void image_does_not_show(void **state)
{
    (void)state;
    struct mpm_setup s = collapse(1, NULL, false), other = collapse(3, NULL, false);
    struct mpm *first = continuum_start(&s), *second;
    continuum_run(first, MIDDLE);
    struct mpm_image image;
    assert_int_equal(mpm_save(first, &image, NULL), SCREE_OK);
    assert_int_equal(mpm_load(&image, &other, &second, NULL), SCREE_OK);
    mpm_image_free(&image);
    assert_int_equal(mpm_hash(second), mpm_hash(first));
    continuum_run(first, STEPS - MIDDLE);
    continuum_run(second, STEPS - MIDDLE);
    assert_int_equal(mpm_hash(second), mpm_hash(first));
    struct continuum_view a = continuum_view(first), b = continuum_view(second);
    assert_true(a.kinetic == b.kinetic && a.potential == b.potential && a.volume == b.volume);
    assert_memory_equal(&(double[1]){mpm_report(first).residual.mean}, &(double[1]){mpm_report(second).residual.mean},
                        sizeof(double));
    mpm_free(first);
    mpm_free(second);
}

/* An image that was tampered with is refused, whatever was changed. */
static void unsound_images_are_refused(void **state)
{
    (void)state;
    struct mpm_setup s = collapse(1, NULL, false);
    struct mpm *mpm = continuum_start(&s), *out;
    struct scree_error err;
    continuum_run(mpm, 3);
    struct mpm_image image;
    assert_int_equal(mpm_save(mpm, &image, NULL), SCREE_OK);
    double x = image.position[5][0];
    image.position[5][0] += 0.05;
    assert_int_equal(mpm_load(&image, &s, &out, &err), SCREE_CORRUPT);
    assert_string_equal(err.message, "the image's points are not in its cells");
    image.position[5][0] = NAN;
    assert_int_equal(mpm_load(&image, &s, &out, &err), SCREE_CORRUPT);
    image.position[5][0] = x;
    image.id[0] = image.id[1];
    assert_int_equal(mpm_load(&image, &s, &out, &err), SCREE_CORRUPT);
    image.id[0] = 0;
    image.contact[1].node = 1u << 30;
    assert_int_equal(mpm_load(&image, &s, &out, &err), SCREE_CORRUPT);
    image.scalars.cells++;
    assert_int_equal(mpm_load(&image, &s, &out, &err), SCREE_CORRUPT);
    mpm_image_free(&image);
    mpm_free(mpm);
}

/* Steps take no memory once the movers' room has grown. */
static void warm_steps_take_no_memory(void **state)
{
    (void)state;
    struct mpm_setup s = collapse(1, NULL, false);
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, STEPS);
    unsigned long before = memory_requests();
    continuum_run(mpm, 10);
    assert_int_equal(memory_requests() - before, 0);
    mpm_free(mpm);
}

/* An endless layer on a slope, on any threads; returns its hash. */
static uint64_t run_layer(int threads)
{
    static const struct mpm_region region = {{0, 0, 0}, {1, 1, 0.05}};
    struct mpm_setup s = continuum_box(1, 0, 7, &region);
    s.endless = true;
    s.gravity[0] = 4.2;
    s.walls[MPM_Z_LOW].kind = MPM_STICK;
    s.law = &mpm_law_mu_i;
    s.coefs = (struct mpm_law_coefs){.mu = 0.38, .mu_2 = 0.64, .inertial0 = 0.279};
    s.threads = threads;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, STEPS);
    uint64_t hash = mpm_hash(mpm);
    mpm_free(mpm);
    return hash;
}

/* Changes only with a change of the physics or of the order of sums: say so in the commit that changes it. */
static void golden_hash(void **state)
{
    (void)state;
    assert_int_equal(run(1, NULL, false, STEPS), 0x916ec4744e907d8eu);
    assert_int_equal(run(1, NULL, true, STEPS), 0x209622e73ba56f6u);
    assert_int_equal(run_layer(1), 0x305827862388556au);
    assert_int_equal(run_layer(3), 0x305827862388556au);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_show),
        cmocka_unit_test(instruction_sets_do_not_show),
        cmocka_unit_test(slices_do_not_show),
        cmocka_unit_test(image_does_not_show),
        cmocka_unit_test(unsound_images_are_refused),
        cmocka_unit_test(warm_steps_take_no_memory),
        cmocka_unit_test(golden_hash),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
