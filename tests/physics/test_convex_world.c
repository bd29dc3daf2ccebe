/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds of convex bodies: what is conserved, what rests, and that slices do not show. */
#include "unit.h"

#include <math.h>

#include "base/cpu.h"
#include "base/rng.h"
#include "convex/image.h"
#include "geom/gjk.h"

static struct scree_error error;

enum { BODIES_MAX = 64 };
static struct composite shape;
static struct convex_body bodies[BODIES_MAX];
static const struct convex_wall box[] = {{{0, 0, 0}, {0, 0, 1}, 0},
                                         {{0, 0, 0}, {1, 0, 0}, 0},
                                         {{0, 0, 0}, {0, 1, 0}, 0},
                                         {{0.08, 0, 0}, {-1, 0, 0}, 0},
                                         {{0, 0.08, 0}, {0, -1, 0}, 0}};

static struct convex_setup plain(size_t count, double step)
{
    for (size_t k = 0; k < count; k++)
        bodies[k] = (struct convex_body){.orientation = {1, 0, 0, 0}};
    return (struct convex_setup){.step_s = step, .shapes = &shape, .shape_count = 1, .bodies = bodies, .body_count = count};
}

static struct convex *world(const struct convex_setup *setup)
{
    struct convex *c = NULL;
    if (convex_create(setup, &c, &error))
        fail_msg("%s", error.message);
    return c;
}

static void run(struct convex *c, uint64_t steps)
{
    if (convex_advance(c, steps, &error))
        fail_msg("%s", error.message);
}

static void cross(void)
{
    assert_int_equal(composite_cross(27e-3, 2e-3, 3e-3, 770, 1e-4, &shape, &error), SCREE_OK);
}

static void block(void)
{
    struct polyhedron p;
    assert_int_equal(polyhedron_box((const double[3]){10e-3, 8e-3, 6e-3}, &p, &error), SCREE_OK);
    assert_int_equal(composite_create(&p, 1, 1000, 1e-4, &shape, NULL, &error), SCREE_OK);
}

static double change(const double after[3], const double before[3])
{
    double sum = 0, size = 0;
    for (int i = 0; i < 3; i++) {
        sum += (after[i] - before[i]) * (after[i] - before[i]);
        size += before[i] * before[i];
    }
    return sqrt(sum / size);
}

/* Nothing acts: momentum in space is kept to rounding, energy without a trend. */
static void free_cross_keeps_energy_and_momentum(void **state)
{
    (void)state;
    cross();
    struct convex_setup setup = plain(1, 1e-5);
    memcpy(bodies[0].spin, (const double[3]){30, 50, 80}, sizeof bodies[0].spin);
    struct convex *c = world(&setup);
    struct convex_sums before = convex_sums(c);
    for (int k = 0; k < 20; k++) {
        run(c, 5000);
        struct convex_sums now = convex_sums(c);
        assert_true(fabs(now.kinetic / before.kinetic - 1) < 1e-6);
        assert_true(change(now.angular, before.angular) < 1e-11);
    }
    convex_free(c);
}

/* Two crosses hit each other: momentum and angular momentum are kept with friction and damping, energy without. */
static void colliding_crosses_keep_what_they_must(void **state)
{
    (void)state;
    cross();
    for (int rough = 0; rough < 2; rough++) {
        struct convex_setup setup = plain(2, 2e-7);
        setup.between =
            rough ? (struct spring_pair){4.5e5, 0.5, 300, 0.2, 0.46, 0, 0, 0, 0, false} : (struct spring_pair){.stiffness = 4.5e5};
        memcpy(bodies[0].velocity, (const double[3]){1, 0.2, 0}, sizeof bodies[0].velocity);
        memcpy(bodies[1].position, (const double[3]){0.028, 0.004, 0.001}, sizeof bodies[1].position);
        memcpy(bodies[1].spin, (const double[3]){20, -10, 5}, sizeof bodies[1].spin);
        struct convex *c = world(&setup);
        struct convex_sums before = convex_sums(c), after;
        double elastic = 0, worst = 0;
        for (int k = 0; k < 3000; k++) {
            run(c, 50);
            after = convex_sums(c);
            elastic = fmax(elastic, after.elastic);
            assert_true(change(after.momentum, before.momentum) < 1e-12);
            worst = fmax(worst, change(after.angular, before.angular));
        }
        assert_true(worst < 1e-10 && elastic > 0);
        struct convex_body hit;
        convex_look(c, 1, &hit);
        assert_true(hit.velocity[0] > 0.01); // they did meet
        assert_int_equal(after.contacts, 0);
        if (rough)
            assert_true(after.kinetic < 0.999 * before.kinetic);
        else
            assert_true(fabs(after.kinetic / before.kinetic - 1) < 1e-4);
        convex_free(c);
    }
}

/* A box let down on a plane comes to rest for good, and the plane carries its weight. */
static void box_on_plane_rests(void **state)
{
    (void)state;
    block();
    struct convex_setup setup = plain(1, 1e-5);
    setup.walls = box;
    setup.wall_count = 1;
    setup.gravity[2] = -9.81;
    setup.at_wall = (struct spring_pair){1e4, 0.5, 1e3, 0.3, 0.5, 0, 0, 0, 0, false};
    double q[4] = {1, 0.01, 0.02, 0.05}, size = sqrt(1.003);
    for (int i = 0; i < 4; i++)
        bodies[0].orientation[i] = q[i] / size;
    bodies[0].orientation[0] = sqrt(1 - (q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) / (size * size));
    bodies[0].position[2] = 8e-3;
    struct convex *c = world(&setup);
    run(c, 100000);
    struct convex_sums s = convex_sums(c);
    assert_true(s.speed_max < 1e-9);
    assert_true(fabs(s.wall_force[2] / (-9.81 * shape.mass) - 1) < 1e-9);
    convex_free(c);
}

/* A box on a slope below the angle of friction stays where it is while another flies by, for whose sake lists are made
 * anew all the time: contacts keep their memory from list to list. */
static void memory_outlives_lists(void **state)
{
    (void)state;
    block();
    struct convex_setup setup = plain(2, 1e-5);
    setup.walls = box;
    setup.wall_count = 1;
    setup.gravity[0] = 0.4 * 9.81;
    setup.gravity[2] = -9.81;
    setup.at_wall = (struct spring_pair){1e4, 0.5, 1e3, 0.3, 0.5, 0, 0, 0, 0, false};
    bodies[0].position[2] = 3e-3;
    bodies[1].position[0] = 1;
    bodies[1].velocity[2] = 8;
    struct convex *c = world(&setup);
    struct convex_body early, late;
    run(c, 50000);
    convex_look(c, 0, &early);
    uint64_t lists = convex_counts(c).rebuilds;
    run(c, 50000);
    convex_look(c, 0, &late);
    assert_true(convex_counts(c).rebuilds > lists + 1000);
    assert_true(fabs(late.position[0] - early.position[0]) < 1e-10);
    convex_free(c);
}

/* Boxes stacked askew on a plane come to rest for good, as one does: faces that lie on each other press at the corners of
 * what they have in common. Crusts carry the weight above them as one corner's spring would, whatever the faces share. */
static void stacked_boxes_rest(void **state)
{
    (void)state;
    for (int average = 0; average < 2; average++) {
        block();
        struct convex_setup setup = plain(3, 1e-5);
        setup.walls = box;
        setup.wall_count = 1;
        setup.gravity[2] = -9.81;
        setup.average = average;
        setup.at_wall = setup.between = (struct spring_pair){1e4, 0.5, 1e3, 0.3, 0.5, 0, 0, 0, 0, false};
        for (int k = 0; k < 3; k++) {
            double half = 0.05 * k * k;
            quat_store(bodies[k].orientation, (struct quat){cos(half), 0, 0, sin(half)});
            bodies[k].position[0] = 3e-4 * k;
            bodies[k].position[2] = 3e-3 + 6e-3 * k;
        }
        struct convex *c = world(&setup);
        run(c, 150000);
        struct convex_sums s = convex_sums(c);
        struct convex_body below, top;
        convex_look(c, 1, &below);
        convex_look(c, 2, &top);
        double overlap = 6e-3 - (top.position[2] - below.position[2]);
        assert_int_equal(s.contacts, 16);
        assert_true(fabs(s.wall_force[2] / (-9.81 * shape.mass) - 3) < 1e-9);
        assert_true(fabs(overlap / (9.81 * shape.mass / setup.between.stiffness) - 1) < 0.05);
        assert_true(s.speed_max < 1e-9);
        convex_free(c);
    }
}

/* A box that spins on another is stopped by friction at the corners of their faces, which one point could not do, at the rate
 * of mu N r / I. What turned faces have in common has corners near theirs and where their edges cross in the middle; sides
 * that meet there say that each kind carries half: r is half of either's distance from the axis. */
static void a_face_stops_a_spin(void **state)
{
    (void)state;
    block();
    struct convex_setup setup = plain(2, 1e-5);
    setup.walls = box;
    setup.wall_count = 1;
    setup.gravity[2] = -9.81;
    setup.at_wall = (struct spring_pair){1e4, 0.5, 1e3, 0.3, 5, 0, 0, 0, 0, false};
    setup.between = (struct spring_pair){1e4, 0.5, 1e4, 0.3, 0.2, 0, 0, 0, 0, false};
    const double press = 9.81 * shape.mass / 1e4;
    bodies[0].position[2] = 3e-3 - press / 2; // on four springs
    bodies[1].position[2] = 9e-3 - 1.5 * press;
    bodies[1].spin[2] = 3;
    struct convex *c = world(&setup);
    struct convex_body top;
    const double x = 4.9e-3, y = 3.9e-3, arm = 0.5 * hypot(x, y) + x * y / (x + y), inertia = shape.mass * (1e-4 + 6.4e-5) / 12;
    run(c, 200);
    convex_look(c, 1, &top);
    double slowed = (3 - top.spin[2]) / (0.2 * 9.81 * shape.mass * arm / inertia * 2e-3);
    assert_true(fabs(slowed - 1) < 0.02);
    run(c, 50000);
    assert_true(convex_sums(c).speed_max < 1e-9);
    convex_look(c, 1, &top);
    assert_true(fabs(top.spin[2]) < 1e-6);
    convex_free(c);
}

/* The same bits on every instruction set and on from an image, while faces lie on each other, slide and turn. */
static void flat_contacts_keep_their_bits(void **state)
{
    (void)state;
    uint64_t hash[CPU_ISA_COUNT] = {0};
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT && cpu_has(isa); isa++) {
        block();
        struct convex_setup setup = plain(3, 1e-5);
        setup.isa = cpu_isa_name(isa);
        setup.walls = box;
        setup.wall_count = 1;
        setup.gravity[2] = -9.81;
        setup.at_wall = setup.between = (struct spring_pair){1e4, 0.5, 1e3, 0.3, 0.3, 0, 0, 0, 0, false};
        for (int k = 0; k < 3; k++) {
            bodies[k].position[2] = 3e-3 + 6e-3 * k;
            bodies[k].velocity[0] = 0.05 * k;
            bodies[k].spin[2] = k;
        }
        struct convex *c = world(&setup), *again = NULL;
        run(c, 3000);
        assert_true(convex_sums(c).contacts > 8);
        struct convex_image image;
        assert_int_equal(convex_save(c, &image, &error), SCREE_OK);
        assert_int_equal(convex_load(&image, &setup, &again, &error), SCREE_OK);
        convex_image_free(&image);
        run(c, 3000);
        run(again, 3000);
        hash[isa] = convex_hash(c);
        assert_true(hash[isa] == convex_hash(again) && hash[isa] == hash[CPU_V2]);
        convex_free(c);
        convex_free(again);
    }
}

/* A bead let go over the hole of a level wall falls through; over its rim, it rolls in about the rim or out, without a kick: energy
 * is kept to the step's accuracy; and where the wall is whole it carries. */
static void a_hole_opens_in_a_wall(void **state)
{
    (void)state;
    static const struct convex_wall bottom[] = {{{0, 0, 0.1}, {0, 0, 1}, 0}};
    assert_int_equal(composite_sphere(1e-3, 2500, &shape, &error), SCREE_OK);
    const double from[] = {0, 4.2e-3, 5.2e-3, 8e-3}; // the middle, within the rim and without it, the whole wall
    for (size_t k = 0; k < COUNT(from); k++) {
        struct convex_setup setup = plain(1, 1e-6);
        setup.walls = bottom;
        setup.wall_count = 1;
        setup.gate = (struct convex_gate){.present = true, .start_s = 0.01, .hole = {{-5e-3, 5e-3}, {-5e-3, 5e-3}}};
        setup.gravity[2] = -9.81;
        setup.at_wall = (struct spring_pair){.stiffness = 1e3};
        bodies[0].position[0] = from[k];
        bodies[0].position[2] = 0.101;
        struct convex *c = world(&setup);
        struct convex_body bead;
        run(c, 10000);
        convex_look(c, 0, &bead);
        assert_true(fabs(bead.position[2] - 0.101) < 1e-5);
        run(c, 100000);
        convex_look(c, 0, &bead);
        struct convex_sums s = convex_sums(c);
        double energy = s.kinetic + s.elastic + 9.81 * shape.mass * (bead.position[2] - 0.101);
        assert_true(fabs(energy) < 1e-3 * 9.81 * shape.mass * 1e-3);
        assert_true(from[k] < 5e-3 ? bead.position[2] < 0.09 : fabs(bead.position[2] - 0.101) < 1e-5);
        convex_free(c);
    }
}

static struct convex_setup heap(size_t count)
{
    cross();
    struct convex_setup setup = plain(count, 5e-6);
    struct rng rng = rng_start(11, 2);
    setup.walls = box;
    setup.wall_count = COUNT(box);
    setup.gravity[2] = -9.81;
    setup.between = (struct spring_pair){4.5e5, 3, 300, 0.24, 0.46, 0, 0, 0, 0, false};
    setup.at_wall = (struct spring_pair){4.5e5, 3, 300, 0.24, 0.62, 0, 0, 0, 0, false};
    for (size_t k = 0; k < count; k++) {
        struct quat q;
        do
            q = (struct quat){rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1),
                              rng_uniform(&rng, -1, 1)};
        while (!(quat_norm2(q) > 0.01));
        quat_store(bodies[k].orientation, quat_unit(q));
        double at[3] = {0.021 + 0.038 * (double)(k % 2), 0.021 + 0.038 * (double)(k / 2 % 2), 0.03 + 0.04 * (double)(k / 4)};
        memcpy(bodies[k].position, at, sizeof at);
    }
    return setup;
}

/* The same bits in one run and in slices, with composites that entangle, for forces summed and averaged; none is lost. */
static void slices_do_not_show(void **state)
{
    (void)state;
    for (int average = 0; average < 2; average++) {
        struct convex_setup setup = heap(32);
        setup.average = average;
        struct convex *whole = world(&setup), *cut = world(&setup);
        size_t met = 0;
        run(whole, 60000);
        for (uint64_t done = 0, slice; done < 60000; done += slice) {
            slice = done % 997 + 1 < 60000 - done ? done % 997 + 1 : 60000 - done;
            run(cut, slice);
            met += convex_sums(cut).contacts;
        }
        assert_true(convex_hash(whole) == convex_hash(cut));
        assert_true(met > 100);
        for (size_t k = 0; k < 32; k++) {
            struct convex_body b;
            convex_look(whole, k, &b);
            assert_true(b.position[2] > 0 && b.position[0] > 0 && b.position[0] < 0.08);
        }
        convex_free(whole);
        convex_free(cut);
    }
}

/* How deep two bodies are in each other by GJK from nowhere, over all their parts, m; below 0 apart. */
static double depth_of(const struct convex_body *a, const struct convex_body *b)
{
    double depth = -INFINITY;
    for (size_t p = 0; p < shape.parts; p++)
        for (size_t q = 0; q < shape.parts; q++) {
            const struct composite_part *of_a = &shape.part[p], *of_b = &shape.part[q];
            struct gjk_core x = {of_a->vertex, of_a->vertices, quat_turn(quat_load(a->orientation)), vec3_load(a->position)};
            struct gjk_core y = {of_b->vertex, of_b->vertices, quat_turn(quat_load(b->orientation)), vec3_load(b->position)};
            struct gjk_cache none = {0};
            struct gjk_result r;
            assert_int_equal(gjk_distance(&x, &y, &none, &r), GJK_APART);
            depth = fmax(depth, of_a->radius + of_b->radius - r.distance);
        }
    return depth;
}

/* All pairs of bodies against what the world says: lists, budgets, spheres around bodies and corners that are tried first
 * leave out nothing that touches, and measure it as GJK does. Returns how many touch. */
static size_t compare_with_all_pairs(struct convex *c, size_t count)
{
    double deepest[BODIES_MAX][BODIES_MAX] = {{0}};
    int points[BODIES_MAX][BODIES_MAX] = {{0}};
    struct view view;
    size_t touching = 0;
    assert_int_equal(convex_view(c, &view, &error), SCREE_OK);
    for (size_t k = 0; k < view.contacts; k++) {
        const struct view_contact *v = &view.contact[k];
        if (v->b >= VIEW_WALL)
            continue;
        deepest[v->a][v->b] = fmax(deepest[v->a][v->b], v->overlap);
        points[v->a][v->b]++;
    }
    for (size_t a = 0; a < count; a++)
        for (size_t b = a + 1; b < count; b++) {
            struct convex_body x, y;
            convex_look(c, a, &x);
            convex_look(c, b, &y);
            double depth = depth_of(&x, &y);
            touching += depth > 0;
            /* Faces that lie flat press along a face's normal, from which the shortest way may differ. */
            if (fabs(fmax(depth, 0) - deepest[a][b]) > 1e-12 + (points[a][b] > 1 ? 1e-2 * depth : 0))
                fail_msg("bodies %zu and %zu are %.12g m deep in each other, not %.12g", a, b, depth, deepest[a][b]);
        }
    return touching;
}

static void nothing_that_touches_is_missed(void **state)
{
    (void)state;
    for (int round = 0; round < 2; round++) {
        size_t touching = 0;
        struct convex_setup setup = heap(32);
        if (round)
            assert_int_equal(composite_sphere(6e-3, 770, &shape, &error), SCREE_OK);
        struct convex *c = world(&setup);
        for (int k = 0; k < 120; k++) {
            run(c, 501);
            touching += compare_with_all_pairs(c, 32);
        }
        if (touching < (round ? 50 : 100))
            fail_msg("%zu touched", touching);
        convex_free(c);
    }
}

/* What is deeper than its crusts is said, with both bodies' numbers, and never a force. */
static void too_deep_is_reported(void **state)
{
    (void)state;
    cross();
    struct convex_setup setup = plain(2, 1e-6);
    struct convex *c = NULL;
    bodies[1].position[2] = 1e-3;
    assert_int_equal(convex_create(&setup, &c, &error), SCREE_BLOWUP);
    assert_non_null(strstr(error.message, "bodies 0 and 1 are deeper in each other"));
    bodies[1].orientation[0] = 0.5;
    assert_int_equal(convex_create(&setup, &c, &error), SCREE_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(free_cross_keeps_energy_and_momentum),
        cmocka_unit_test(colliding_crosses_keep_what_they_must),
        cmocka_unit_test(box_on_plane_rests),
        cmocka_unit_test(memory_outlives_lists),
        cmocka_unit_test(stacked_boxes_rest),
        cmocka_unit_test(a_face_stops_a_spin),
        cmocka_unit_test(flat_contacts_keep_their_bits),
        cmocka_unit_test(a_hole_opens_in_a_wall),
        cmocka_unit_test(slices_do_not_show),
        cmocka_unit_test(nothing_that_touches_is_missed),
        cmocka_unit_test(too_deep_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
