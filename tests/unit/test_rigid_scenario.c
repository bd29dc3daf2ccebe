/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shapes from a job's params, what of them is refused, how they are poured; the same bits on every instruction set and
 * from an image, for composites; the network of contacts on made-up views. */
#include "unit.h"

#include <math.h>
#include <stdio.h>

#include "base/cpu.h"
#include "convex/image.h"
#include "measure/packing.h"
#include "scenario/rigid.h"
#include "spec/scenarios.h"

static struct scree_error error;
static struct job_spec job;
static struct rigid_plan plan;

static struct settle_params *settle(int shape, const char *points)
{
    job_defaults(&job, &scenario_settle_fields);
    struct settle_params *p = (struct settle_params *)(void *)job.params;
    p->count = 30;
    p->length_m = p->width_m = 0.06;
    p->body.shape = shape;
    snprintf(p->body.points_m, sizeof p->body.points_m, "%s", points);
    return p;
}

static enum scree_status make(void)
{
    rigid_plan_free(&plan);
    error = (struct scree_error){.message = ""};
    return rigid_scenario_find("settle")->plan(&job, &plan, &error);
}

#define CUBE "0 0 0, 0.02 0 0, 0 0.02 0, 0.02 0.02 0, 0 0 0.02, 0.02 0 0.02, 0 0.02 0.02, 0.02 0.02 0.02"

static void shapes_weigh_what_they_must(void **state)
{
    (void)state;
    settle(BODY_HULLS, CUBE);
    assert_int_equal(make(), SCREE_OK);
    assert_true(fabs(plan.shape.volume / 8e-6 - 1) < 1e-12);
    /* The same cube twice, half a side apart: one and a half of it. */
    settle(BODY_HULLS, CUBE ";0.01 0 0, 0.03 0 0, 0.01 0.02 0, 0.03 0.02 0, 0.01 0 0.02, 0.03 0 0.02, 0.01 0.02 0.02, "
                            "0.03 0.02 0.02");
    assert_int_equal(make(), SCREE_OK);
    assert_true(fabs(plan.shape.volume / 12e-6 - 1) < 1e-12 && plan.shape.parts == 2);
    struct settle_params *p = settle(BODY_CYLINDER, "");
    p->body.length_m = 0.003;
    p->body.radius_m = 0.0135;
    assert_int_equal(make(), SCREE_OK);
    assert_true(fabs(plan.shape.volume / (M_PI * 0.0135 * 0.0135 * 0.003) - 1) < 1e-9);
    /* A disc's moment about its axis is m R^2 / 2; 24 sides of its area have 0.2 % more. */
    double most = fmax(plan.shape.inertia[0], fmax(plan.shape.inertia[1], plan.shape.inertia[2]));
    assert_true(fabs(most / (0.5 * plan.shape.mass * 0.0135 * 0.0135) - 1) < 1e-3);
    p = settle(BODY_PRISM, "");
    p->body.sides = 6;
    p->body.radius_m = p->body.length_m = 0.01;
    assert_int_equal(make(), SCREE_OK);
    assert_true(fabs(plan.shape.volume / (1.5 * sqrt(3) * 1e-6) - 1) < 1e-9);
}

/* Two unit spheres a radius apart share a lens of 5 pi / 12 r^3. */
static void glued_spheres_share_a_lens(void **state)
{
    (void)state;
    settle(BODY_SPHERES, "0 0 0 0.01, 0.01 0 0 0.01");
    assert_int_equal(make(), SCREE_OK);
    assert_true(fabs(plan.shape.volume / ((8.0 / 3 - 5.0 / 12) * M_PI * 1e-6) - 1) < 1e-4);
    assert_true(fabs(plan.shape.reach - 0.015) < 1e-6);
    settle(BODY_SPHERES, "0 0 0 0.004, 0.01 0 0 0.004");
    assert_int_equal(make(), SCREE_INVALID);
    assert_non_null(strstr(error.message, "sphere 1 of the body meets none of the others"));
}

static void bad_shapes_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *points, *message;
    } all[] = {
        {CUBE ", 0.01 0.01 0.01", "no corner"},                                  // a dent: not convex
        {"0 0 0, 0.02 0 0, 0 0.02 0, 0.02 0.02 0", "part 0"},                    // flat: no volume
        {CUBE ";0.1 0 0, 0.12 0 0, 0.1 0.02 0, 0.1 0 0.02", "shares no volume"}, // apart
    };
    for (size_t k = 0; k < COUNT(all); k++) {
        settle(BODY_HULLS, all[k].points);
        assert_int_equal(make(), SCREE_INVALID);
        if (!strstr(error.message, all[k].message))
            fail_msg("\"%s\" says nothing of \"%s\"", error.message, all[k].message);
    }
    static const char *const unreadable[] = {"",        "0 0",     "0 0 0 0",         "0 0 x",     "0 0 0,",
                                             "0 0 nan", "0x1 0 0", "0 0 0, 1 2 3; ;", "0 0 1e400", "0 0 11"};
    for (size_t k = 0; k < COUNT(unreadable); k++) {
        settle(BODY_HULLS, unreadable[k]);
        struct scree_error err = {0};
        assert_int_equal(job_check(&job, 0, &err), SCREE_INVALID);
        assert_string_equal(err.path, "params.body.points_m");
    }
}

/* Nothing touches to begin with, and everything is inside. */
static void poured_bodies_are_apart(void **state)
{
    (void)state;
    struct convex *world = NULL;
    struct settle_params *p = settle(BODY_CROSS, "");
    p->length_m = p->width_m = 0.035;
    assert_int_equal(make(), SCREE_OK);
    assert_int_equal(convex_create(&plan.setup, &world, &error), SCREE_OK);
    struct convex_sums sums = convex_sums(world);
    assert_int_equal(sums.contacts + sums.contacts_wall, 0);
    double top = 0;
    for (size_t k = 0; k < plan.setup.body_count; k++)
        top = fmax(top, plan.bodies[k].position[2]);
    assert_true(top < 0.35); // a lattice of balls is 0.8 m high
    convex_free(world);
}

/* A column no longer than its bodies: whatever they are, the gate and the walls meet none of them. */
static void poured_bodies_stand_behind_the_gate(void **state)
{
    (void)state;
    for (int shape = BODY_CROSS; shape <= BODY_SPHERES; shape++) {
        job_defaults(&job, &scenario_dam_break_fields);
        struct dam_break_params *p = (struct dam_break_params *)(void *)job.params;
        p->count = 12;
        p->body.shape = shape;
        p->body.radius_m = 0.004;
        snprintf(p->body.points_m, sizeof p->body.points_m, "%s", shape == BODY_HULLS ? CUBE : "0 0 0 0.006, 0.008 0 0 0.004");
        job.time.step_s = 1e-6;
        p->column_m = p->width_m = 2 * body_reach(&p->body) + 1e-6;
        if (job_check(&job, 0, &error))
            fail_msg("shape %d: %s", shape, error.message);
        rigid_plan_free(&plan);
        struct convex *world = NULL;
        assert_int_equal(rigid_scenario_find("dam_break")->plan(&job, &plan, &error), SCREE_OK);
        assert_int_equal(convex_create(&plan.setup, &world, &error), SCREE_OK);
        struct convex_sums sums = convex_sums(world);
        if (sums.contacts + sums.contacts_wall > 0)
            fail_msg("shape %d: %zu contacts, %zu with walls", shape, sums.contacts, sums.contacts_wall);
        convex_free(world);
    }
}

/* Composites step to the same bits on every instruction set, and on from an image; a cross takes less than 8 kB. */
static void no_instruction_set_shows(void **state)
{
    (void)state;
    static const struct {
        int shape;
        const char *points;
    } all[] = {{BODY_CROSS, ""}, {BODY_SPHERES, "0 0 0 0.006, 0.008 0 0 0.006, 0 0.008 0 0.005"}, {BODY_HULLS, CUBE}};
    for (size_t k = 0; k < COUNT(all); k++) {
        uint64_t hash[CPU_ISA_COUNT + 1] = {0};
        settle(all[k].shape, all[k].points);
        job.rigid.stiffness = all[k].shape == BODY_HULLS ? 4.5e6 : 4.5e4; // cubes weigh 25 times as much as crosses
        job.time.step_s = 8e-6;
        assert_int_equal(make(), SCREE_OK);
        for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT && cpu_has(isa); isa++) {
            struct convex *world = NULL;
            plan.setup.isa = cpu_isa_name(isa);
            assert_int_equal(convex_create(&plan.setup, &world, &error), SCREE_OK);
            size_t met = 0;
            for (int slice = 0; slice < 60; slice++) {
                assert_int_equal(convex_advance(world, 200, &error), SCREE_OK);
                met += convex_sums(world).contacts + convex_sums(world).contacts_wall;
            }
            if (met == 0)
                fail_msg("shape %zu has not met anything", k);
            struct convex_image image;
            struct convex *again = NULL;
            assert_int_equal(convex_save(world, &image, &error), SCREE_OK);
            assert_int_equal(convex_load(&image, &plan.setup, &again, &error), SCREE_OK);
            convex_image_free(&image);
            assert_int_equal(convex_advance(world, 3000, &error), SCREE_OK);
            assert_int_equal(convex_advance(again, 3000, &error), SCREE_OK);
            hash[isa] = convex_hash(world);
            assert_true(hash[isa] == convex_hash(again) && hash[isa] == hash[0]);
            if (all[k].shape == BODY_CROSS && convex_counts(world).bytes >= 8000 * plan.setup.body_count)
                fail_msg("%zu bytes", convex_counts(world).bytes);
            convex_free(world);
            convex_free(again);
        }
    }
}

/* Three bodies in a column 1 long and 1 high: a level branch and an upright one, forces 3 and 1. */
static void network_on_a_made_up_view(void **state)
{
    (void)state;
    struct view_body body[3] = {
        {.mass = 1, .position = {0.2, 0, 0.2}}, {.mass = 1, .position = {0.8, 0, 0.2}}, {.mass = 2, .position = {0.8, 0, 0.8}}};
    struct view_contact contact[] = {
        {.a = 0, .b = 1, .point = {0.5, 0, 0.2}, .force = {3, 0, 0}},
        {.a = 1, .b = 2, .point = {0.8, 0, 0.6}, .force = {0, 0, 1}},
        {.a = 0, .b = VIEW_WALL, .on_base = 1, .normal = {0, 0, -1}, .force = {0, 0, -36}},
        {.a = 2, .b = VIEW_WALL + 5, .normal = {1, 0, 0}, .point = {1, 0, 0.8}, .force = {2, 0, -4}},
        {.a = 2, .b = VIEW_WALL + 3, .normal = {0, -1, 0}, .point = {0.8, 0, 0.8}},
    };
    const struct view view = {.gravity = {0, 0, -10}, .bodies = 3, .body = body, .contacts = COUNT(contact), .contact = contact};
    struct packing p;
    packing_measure(&view, 1, 1, &p);
    assert_true(fabs(p.force_mean - 2) < 1e-12 && fabs(p.force_most - 1.5) < 1e-12);
    assert_true(fabs(p.force_pdf[1] - 1) < 1e-12 && fabs(p.force_pdf[3] - 1) < 1e-12);
    assert_true(fabs(p.anisotropy) < 1e-12 && p.fabric[0] == 0.5 && p.fabric[9] == 0.5);
    assert_true(fabs(p.janssen - 0.1) < 1e-12);
    const struct packing_region whole = {3, 2, 1, 1, 1}, half = {2, 1, 0, 1, 1}, quarter = {1, 1, 0, 1, 1};
    assert_memory_equal(&p.region[0], &whole, sizeof whole);
    assert_memory_equal(&p.region[1], &half, sizeof half);
    assert_memory_equal(&p.region[2], &quarter, sizeof quarter);
}

static int clean_up(void **state)
{
    (void)state;
    rigid_plan_free(&plan);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_weigh_what_they_must),
        cmocka_unit_test(glued_spheres_share_a_lens),
        cmocka_unit_test(bad_shapes_are_refused),
        cmocka_unit_test(poured_bodies_are_apart),
        cmocka_unit_test(poured_bodies_stand_behind_the_gate),
        cmocka_unit_test(no_instruction_set_shows),
        cmocka_unit_test(network_on_a_made_up_view),
    };
    return cmocka_run_group_tests(tests, NULL, clean_up);
}
