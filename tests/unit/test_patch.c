/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Faces that lie on each other: closed forms, GJK's distance, and that nothing jumps. */
#include "unit.h"

#include <math.h>

#include "base/rng.h"
#include "geom/gjk.h"
#include "geom/patch.h"

#define CRUST 1e-4
static struct scree_error error;
static struct composite large, small, coin;

static void make(void)
{
    struct polyhedron p;
    assert_int_equal(polyhedron_box((const double[3]){20e-3, 20e-3, 5e-3}, &p, &error), SCREE_OK);
    assert_int_equal(composite_create(&p, 1, 1000, CRUST, &large, NULL, &error), SCREE_OK);
    assert_int_equal(polyhedron_box((const double[3]){4e-3, 6e-3, 5e-3}, &p, &error), SCREE_OK);
    assert_int_equal(composite_create(&p, 1, 1000, CRUST, &small, NULL, &error), SCREE_OK);
    assert_int_equal(polyhedron_prism(24, 10e-3, 5e-3, &p, &error), SCREE_OK);
    assert_int_equal(composite_create(&p, 1, 1000, CRUST, &coin, NULL, &error), SCREE_OK);
}

static struct patch_side at(const struct composite *shape, struct quat q, double x, double y, double z)
{
    return (struct patch_side){&shape->part[0], quat_turn(quat_unit(q)), {x, y, z}};
}

static struct patch measured(const struct patch_side *a, const struct patch_side *b)
{
    struct patch p;
    patch_measure(a, b, patch_find(a, b, (struct vec3){0, 0, 1}), &p);
    return p;
}

/* What all points press together, over k, and where. */
static double pressed(const struct patch *p, struct vec3 *centre)
{
    double sum = 0;
    *centre = (struct vec3){0, 0, 0};
    for (size_t k = 0; k < p->points; k++) {
        double force = p->point[k].share * p->point[k].overlap;
        *centre = vec3_add(*centre, vec3_scale(p->point[k].at, force));
        sum += force;
    }
    *centre = vec3_scale(*centre, 1 / sum);
    return sum;
}

static const struct quat flat = {1, 0, 0, 0};

/* Squares turned by 45 degrees have a regular octagon in common, which presses as deep as one corner would. */
static void crossed_squares_share_an_octagon(void **state)
{
    (void)state;
    make();
    const struct quat turned = {cos(M_PI / 8), 0, 0, sin(M_PI / 8)};
    struct patch_side a = at(&large, flat, 0, 0, 0), b = at(&large, turned, 0, 0, 5e-3 - 3e-5);
    struct patch p = measured(&a, &b);
    const double side = 10e-3 - CRUST, corner = side / cos(M_PI / 8);
    assert_int_equal(p.points, 8);
    for (size_t k = 0; k < 8; k++) {
        assert_true(fabs(hypot(p.point[k].at.x, p.point[k].at.y) / corner - 1) < 1e-9);
        assert_true(fabs(p.point[k].overlap / 3e-5 - 1) < 1e-9 && fabs(p.point[k].share - 0.125) < 1e-9);
        assert_true(fabs(p.point[k].at.z - (2.5e-3 - 1.5e-5)) < 1e-12);
    }
}

/* A tilted box on a large face: its deepest point is GJK's, no point is deeper, and the point of pressure lies between them;
 * seen from the other body the same. */
static void deepest_point_is_that_of_gjk(void **state)
{
    (void)state;
    make();
    struct rng rng = rng_start(5, 1);
    for (int k = 0; k < 2000; k++) {
        double tilt = 0.02 * rng_uniform(&rng, 0, 1) * rng_uniform(&rng, 0, 1);
        struct quat q = {1, tilt * rng_uniform(&rng, -1, 1), tilt * rng_uniform(&rng, -1, 1), rng_uniform(&rng, -1, 1)};
        struct patch_side a = at(&large, flat, 0, 0, 0), b = at(&small, q, 1e-3, -2e-3, 5e-3 + rng_uniform(&rng, -4e-5, 0));
        struct gjk_core ca = {(const double(*)[3])large.part[0].vertex, large.part[0].vertices, a.turn, a.centre};
        struct gjk_core cb = {(const double(*)[3])small.part[0].vertex, small.part[0].vertices, b.turn, b.centre};
        struct gjk_cache cache = {0};
        struct gjk_result r;
        assert_int_equal(gjk_distance(&ca, &cb, &cache, &r), GJK_APART);
        struct patch p = measured(&a, &b), back;
        patch_measure(&b, &a, patch_find(&b, &a, (struct vec3){0, 0, -1}), &back);
        double deepest = 0;
        struct vec3 centre, other;
        for (size_t n = 0; n < p.points; n++)
            deepest = fmax(deepest, p.point[n].overlap);
        if (r.distance >= 2 * CRUST) {
            assert_int_equal(p.points, 0);
            continue;
        }
        assert_in_range(p.points, 1, 4);
        assert_true(fabs(deepest - (2 * CRUST - r.distance)) < 1e-12);
        double force = pressed(&p, &centre);
        assert_true(force > 0.25 * deepest && force < deepest * (1 + 1e-9));
        assert_true(fabs(pressed(&back, &other) / force - 1) < 1e-3);
        assert_true(fabs(other.x - centre.x) + fabs(other.y - centre.y) < 1e-5 && vec3_dot(back.normal, p.normal) < -0.999);
    }
}

/* Sliding through the place where corners coincide, where the common part gains and loses corners. */
static void nothing_jumps_as_corners_split(void **state)
{
    (void)state;
    make();
    struct vec3 before = {0, 0, 0}, centre;
    double was = 0;
    for (int k = -50; k <= 50; k++) {
        double x = 1e-9 * k;
        struct quat q = {1, 2e-7, 1e-7, 0};
        struct patch_side a = at(&large, flat, 0, 0, 0), b = at(&large, q, x, 0.3 * x, 5e-3 - 3e-5);
        struct patch p = measured(&a, &b);
        double force = pressed(&p, &centre);
        assert_in_range(p.points, 4, 8);
        if (k > -50)
            assert_true(fabs(force / was - 1) < 1e-6 && fabs(centre.x - before.x) + fabs(centre.y - before.y) < 2e-8);
        was = force;
        before = centre;
    }
}

/* More corners than are kept: coins press at their rims, about their middle, with the whole of the spring. */
static void coins_keep_eight_points(void **state)
{
    (void)state;
    make();
    struct patch_side a = at(&coin, flat, 0, 0, 0), b = at(&coin, flat, 1e-5, 0, 5e-3 - 3e-5);
    struct patch p = measured(&a, &b);
    struct vec3 centre;
    assert_int_equal(p.points, PATCH_POINTS_MAX);
    assert_true(fabs(pressed(&p, &centre) / 3e-5 - 1) < 1e-9);
    assert_true(hypot(centre.x, centre.y) < 1e-3);
}

/* Faces beside each other, and cores that overlap, press nowhere: it is for GJK to say what they do. */
static void nothing_in_common_is_no_patch(void **state)
{
    (void)state;
    make();
    struct patch_side a = at(&large, flat, 0, 0, 0), beside = at(&large, flat, 19.9e-3, 0, 5e-3 - 3e-5);
    struct patch_side deep = at(&large, flat, 0, 0, 4.7e-3), above = at(&large, flat, 0, 0, 5e-3 + 1e-6);
    assert_int_equal(measured(&a, &beside).points, 0);
    assert_int_equal(measured(&a, &deep).points, 0);
    assert_int_equal(measured(&a, &above).points, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crossed_squares_share_an_octagon), cmocka_unit_test(deepest_point_is_that_of_gjk),
        cmocka_unit_test(nothing_jumps_as_corners_split),   cmocka_unit_test(coins_keep_eight_points),
        cmocka_unit_test(nothing_in_common_is_no_patch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
