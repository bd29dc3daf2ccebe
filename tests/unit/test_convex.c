/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Convex bodies, composites and their distances: closed forms, brute force, sizes
 * from 0.1 mm to 1 m, and the refusals of what is no such body. */
#include "unit.h"

#include <math.h>

#include "base/rng.h"
#include "geom/composite.h"
#include "geom/gjk.h"

static struct scree_error error;

static void near_to(double value, double expect, double relative)
{
    if (!(fabs(value - expect) <= relative * fabs(expect)))
        fail_msg("%.17g is not %.17g", value, expect);
}

/* S1-09: the overlap of the two arms counts once, and inertia is exact. */
static void cross_has_the_published_volume_and_exact_inertia(void **state)
{
    (void)state;
    struct composite c;
    assert_int_equal(composite_cross(27e-3, 2e-3, 3e-3, 770, 1e-4, &c, &error), SCREE_OK);
    near_to(c.volume, 312e-9, 1e-12);
    near_to(c.mass, 2.4024e-4, 1e-12);
    near_to(cbrt(3 * c.volume / (4 * M_PI)), 4.207e-3, 2e-4);
    double least = fmin(c.inertia[0], fmin(c.inertia[1], c.inertia[2])),
           most = fmax(c.inertia[0], fmax(c.inertia[1], c.inertia[2]));
    near_to(most, 770 * 19783e-15, 1e-10);
    near_to(least, 770 * 10125.5e-15, 1e-10);
    near_to(c.reach, sqrt(13.4 * 13.4 + 0.9 * 0.9 + 1.4 * 1.4) * 1e-3 + 1e-4, 1e-9);
}

/* Four legs at tetrahedral angles have nearly the same inertia about every axis (their six sides break the
 * symmetry a little): a check of inclusion and exclusion to depth 4. */
static void tetrapod_is_nearly_isotropic_and_lighter_than_its_legs(void **state)
{
    (void)state;
    struct composite c;
    assert_int_equal(composite_tetrapod(10e-3, 1.5e-3, 1000, 1e-4, &c, &error), SCREE_OK);
    double legs = 4 * (1.5 * sqrt(3) * 1.5e-3 * 1.5e-3) * 10e-3;
    assert_true(c.volume < legs && c.volume > 0.8 * legs);
    near_to(c.inertia[0], c.inertia[1], 0.03);
    near_to(c.inertia[1], c.inertia[2], 0.03);
}

static void prism_has_closed_forms(void **state)
{
    (void)state;
    struct polyhedron p;
    struct moments m;
    assert_int_equal(polyhedron_prism(6, 2, 3, &p, &error), SCREE_OK);
    polyhedron_moments(&p, &m);
    assert_int_equal(p.faces, 8);
    near_to(m.volume, 1.5 * sqrt(3) * 4 * 3, 1e-12);
    near_to(m.second[0], 5 * sqrt(3) / 16 * 16 * 3, 1e-12);
    near_to(m.second[2], m.volume * 9 / 12, 1e-12);
}

static void bad_bodies_are_refused_by_name(void **state)
{
    (void)state;
    struct polyhedron p, q[2];
    struct composite c;
    double cube[9][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0.5, 0.5, 0.9}};
    assert_int_equal(polyhedron_create((const double(*)[3])cube, 9, &p, &error), SCREE_INVALID);
    assert_error(&error, SCREE_INVALID, "", "vertex 8 is no corner of the hull of all: the list is not convex");
    cube[8][2] = 1; // within a face
    assert_int_equal(polyhedron_create((const double(*)[3])cube, 9, &p, &error), SCREE_INVALID);
    assert_int_equal(polyhedron_create((const double(*)[3])cube, 4, &p, &error), SCREE_INVALID);
    assert_error(&error, SCREE_INVALID, "", "a convex body of 4 vertices has no volume");
    assert_int_equal(polyhedron_box((const double[3]){1, 1, 1}, &q[0], &error), SCREE_OK);
    polyhedron_place(&q[0], quat_one(), (struct vec3){1.5, 0, 0}, &q[1]);
    assert_int_equal(composite_create(q, 2, 1, 0.1, &c, NULL, &error), SCREE_INVALID);
    assert_error(&error, SCREE_INVALID, "", "part 1 of the body shares no volume with the others");
    assert_int_equal(composite_create(q, 1, 1, 0.5, &c, NULL, &error), SCREE_INVALID);
}

/* ---- distances ---- */

static struct quat any_turn(struct rng *rng)
{
    for (;;) {
        struct quat q = {rng_uniform(rng, -1, 1), rng_uniform(rng, -1, 1), rng_uniform(rng, -1, 1), rng_uniform(rng, -1, 1)};
        if (quat_norm2(q) > 0.01 && quat_norm2(q) < 1)
            return quat_unit(q);
    }
}

/* Largest separation along any normal of a face and any cross product of edges of two boxes: the exact answer to
 * whether they are apart, by another method. */
static double separating_axis(const double a[3], const struct gjk_core *ca, const double b[3], const struct gjk_core *cb)
{
    struct vec3 axes[15], d = vec3_sub(cb->centre, ca->centre);
    int count = 0;
    double most = -INFINITY;
    for (int i = 0; i < 3; i++) {
        axes[count++] = ca->turn.column[i];
        axes[count++] = cb->turn.column[i];
        for (int j = 0; j < 3; j++)
            axes[count++] = vec3_cross(ca->turn.column[i], cb->turn.column[j]);
    }
    for (int k = 0; k < 15; k++) {
        double length = sqrt(vec3_dot(axes[k], axes[k])), gap = fabs(vec3_dot(axes[k], d));
        if (length < 1e-6)
            continue;
        for (int i = 0; i < 3; i++)
            gap -= 0.5 * (a[i] * fabs(vec3_dot(axes[k], ca->turn.column[i])) + b[i] * fabs(vec3_dot(axes[k], cb->turn.column[i])));
        most = fmax(most, gap / length);
    }
    return most;
}

/* What optimality says: no vertex of either body lies beyond the planes through the nearest points. */
static void nearest_points_are_optimal(const struct gjk_core *a, const struct gjk_core *b, const struct gjk_result *r, double size)
{
    for (size_t k = 0; k < a->vertices; k++) {
        struct vec3 x = vec3_add(a->centre, turn_out(&a->turn, vec3_load(a->vertex[k])));
        assert_true(vec3_dot(r->normal, vec3_sub(x, r->on_a)) < 1e-6 * size);
    }
    for (size_t k = 0; k < b->vertices; k++) {
        struct vec3 x = vec3_add(b->centre, turn_out(&b->turn, vec3_load(b->vertex[k])));
        assert_true(vec3_dot(r->normal, vec3_sub(x, r->on_b)) > -1e-6 * size);
    }
}

static void box_vertices(const double size[3], double vertex[8][3])
{
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++)
            vertex[k][i] = (k >> i & 1 ? 0.5 : -0.5) * size[i];
}

/* Random, parallel, flat and nested boxes at three scales; simplices are warm from an unrelated pair. */
static void distance_agrees_with_separating_axes(void **state)
{
    (void)state;
    struct rng rng = rng_start(7, 1);
    struct gjk_cache cache = {0};
    size_t unsure = 0, apart = 0, inside = 0;
    for (int trial = 0; trial < 300000; trial++) {
        double scale = (const double[]){1e-4, 1e-2, 1}[trial % 3], sa[3], sb[3], va[8][3], vb[8][3];
        for (int i = 0; i < 3; i++) {
            sa[i] = scale * rng_uniform(&rng, 0.05, 1);
            sb[i] = scale * rng_uniform(&rng, 0.05, 1) * (trial % 7 == 0 ? 0.01 : 1);
        }
        box_vertices(sa, va);
        box_vertices(sb, vb);
        double far = scale * (trial % 5 == 0 ? 0.2 : 1.2);
        struct quat qa = any_turn(&rng), qb = trial % 2 ? any_turn(&rng) : qa;
        struct gjk_core a = {(const double(*)[3])va, 8, quat_turn(qa), {0, 0, 0}};
        struct gjk_core b = {(const double(*)[3])vb,
                             8,
                             quat_turn(qb),
                             {rng_uniform(&rng, -far, far), rng_uniform(&rng, -far, far), rng_uniform(&rng, -far, far)}};
        struct gjk_result r;
        enum gjk_state s = gjk_distance(&a, &b, &cache, &r);
        double sat = separating_axis(sa, &a, sb, &b);
        if (s == GJK_UNSURE)
            unsure++;
        else if (s == GJK_APART) {
            apart++;
            assert_true(r.distance > sat - 1e-9 * scale);
            assert_true(sat > -1e-9 * scale);
            nearest_points_are_optimal(&a, &b, &r, scale);
        } else {
            inside++;
            if (sat > 1e-9 * scale)
                fail_msg("trial %d: a false contact, the gap is %g of %g", trial, sat, scale);
        }
    }
    assert_int_equal(unsure, 0);
    assert_true(apart > 50000 && inside > 50000);
}

/* A warm simplex of four points in one plane, which the origin's projection is within, is no overlap. */
static void flat_warm_simplex_is_no_contact(void **state)
{
    (void)state;
    double va[8][3], vb[8][3];
    const double size[3] = {1e-3, 1e-3, 1e-3};
    box_vertices(size, va);
    box_vertices(size, vb);
    struct gjk_core a = {(const double(*)[3])va, 8, quat_turn(quat_one()), {0, 0, 0}}, b = a;
    b.vertex = (const double(*)[3])vb;
    b.centre.z = 1.0000001e-3;
    struct gjk_cache cache = {.count = 4, .a = {4, 5, 6, 7}, .b = {3, 2, 1, 0}};
    struct gjk_result r;
    assert_int_equal(gjk_distance(&a, &b, &cache, &r), GJK_APART);
    near_to(r.distance, 1e-10, 1e-5);
    near_to(r.normal.z, 1, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cross_has_the_published_volume_and_exact_inertia),
        cmocka_unit_test(tetrapod_is_nearly_isotropic_and_lighter_than_its_legs),
        cmocka_unit_test(prism_has_closed_forms),
        cmocka_unit_test(bad_bodies_are_refused_by_name),
        cmocka_unit_test(distance_agrees_with_separating_axes),
        cmocka_unit_test(flat_warm_simplex_is_no_contact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
