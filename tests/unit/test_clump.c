/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Clumps and the free rotation of rigid bodies: layouts, inertia against closed
 * forms, refusals, and targets B-09. */
#include "unit.h"

#include <math.h>

#include "base/rng.h"
#include "geom/clump.h"

static void near_to(double value, double expect, double relative)
{
    if (!(fabs(value - expect) <= relative * fabs(expect)))
        fail_msg("%.17g is not %.17g", value, expect);
}

/* Seed 003 3.1: cube, half and quarter with the layouts of protocols 4; inner spheres are left out. */
static void blocks_have_the_layouts_and_inertia_of_the_fragments(void **state)
{
    (void)state;
    const double a = 1e-3, rho = 2700;
    const struct {
        double size[3];
        size_t coarse, fine;
    } shapes[] = {{{a, a, a}, 8, 56}, {{a, a, a / 2}, 4, 32}, {{a, a / 2, a / 2}, 2, 16}};
    for (size_t k = 0; k < COUNT(shapes); k++) {
        const double *s = shapes[k].size;
        struct clump coarse, fine;
        struct scree_error error;
        assert_int_equal(clump_block(s, a / 4, rho, &coarse, &error), SCREE_OK);
        assert_int_equal(clump_block(s, a / 8, rho, &fine, &error), SCREE_OK);
        assert_int_equal(coarse.spheres, shapes[k].coarse);
        assert_int_equal(fine.spheres, shapes[k].fine);
        near_to(coarse.mass, rho * s[0] * s[1] * s[2], 1e-14);
        for (int i = 0; i < 3; i++) {
            double b = s[(i + 1) % 3], c = s[(i + 2) % 3];
            near_to(coarse.inertia[i], coarse.mass / 12 * (b * b + c * c), 1e-14);
            near_to(fine.inertia[i], coarse.inertia[i], 1e-14);
        }
        for (size_t n = 0; n < fine.spheres; n++)
            for (int i = 0; i < 3; i++)
                assert_true(fabs(fine.sphere[n][i]) + fine.sphere[n][3] <= 0.5 * s[i] * (1 + 1e-12));
    }
}

/* With spheres in its corners a block reaches all of its faces there, and keeps mass and inertia. */
static void corners_reach_the_faces_of_their_block(void **state)
{
    (void)state;
    const double a = 1e-3, rho = 2700, radius = a / 20;
    const double size[3][3] = {{a, a, a}, {a, a, a / 2}, {a, a / 2, a / 2}};
    const size_t spheres[3] = {9, 12, 10};
    struct scree_error error;
    for (size_t k = 0; k < 3; k++) {
        const double *s = size[k];
        struct clump clump;
        assert_int_equal(clump_block(s, s[2] / 2, rho, &clump, &error), SCREE_OK);
        const struct clump block = clump;
        assert_int_equal(clump_add_corners(s, radius, &clump, &error), SCREE_OK);
        assert_int_equal(clump.spheres, spheres[k]);
        near_to(clump.mass, rho * s[0] * s[1] * s[2], 1e-14);
        assert_memory_equal(clump.inertia, block.inertia, sizeof clump.inertia);
        const double x = s[0] / 2 - radius, y = s[1] / 2 - radius, z = s[2] / 2 - radius;
        near_to(clump.reach, sqrt(x * x + y * y + z * z) + radius, 1e-12);
        for (size_t n = block.spheres; n < clump.spheres; n++)
            for (int i = 0; i < 3; i++)
                near_to(fabs(clump.sphere[n][i]) + radius, 0.5 * s[i], 1e-12);
    }
    struct clump clump;
    assert_int_equal(clump_block(size[0], a / 8, rho, &clump, &error), SCREE_OK);
    assert_int_equal(clump_add_corners(size[0], radius, &clump, &error), SCREE_OK); // 56 and 8 are as many as there may be
    assert_int_equal(clump_add_corners(size[0], radius, &clump, &error), SCREE_INVALID);
    assert_int_equal(clump_block(size[1], a / 4, rho, &clump, &error), SCREE_OK);
    assert_int_equal(clump_add_corners(size[1], 0.3 * a, &clump, &error), SCREE_INVALID);
}

/* A box of triangles, turned and moved. */
static struct trimesh *box(const double size[3], struct quat q, struct vec3 at)
{
    static const uint32_t corner[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    double vertex[8][3];
    struct trimesh *mesh = NULL;
    struct scree_error error;
    for (int k = 0; k < 8; k++) {
        struct vec3 x = {(k & 1 ? 0.5 : -0.5) * size[0], (k & 2 ? 0.5 : -0.5) * size[1], (k & 4 ? 0.5 : -0.5) * size[2]};
        vec3_store3(vertex[k], vec3_add(at, quat_rotate(q, x)));
    }
    if (trimesh_create((const double(*)[3])vertex, 8, corner, 12, true, &mesh, &error))
        fail_msg("%s", error.message);
    return mesh;
}

/* Exact integrals of a turned, far away box give the block's mass and moments, and axes that turn spheres back. */
static void polyhedra_give_exact_mass_and_principal_axes(void **state)
{
    (void)state;
    const double size[3] = {3e-3, 2e-3, 1e-3};
    struct quat q = quat_unit((struct quat){0.9, -0.2, 0.3, 0.4});
    struct vec3 at = {0.7, -0.3, 0.2};
    struct trimesh *mesh = box(size, q, at);
    struct clump block, clump;
    struct scree_error error;
    struct quat axes;
    assert_int_equal(clump_block(size, 0.5e-3, 2700, &block, &error), SCREE_OK);
    assert_int_equal(block.spheres, 6);
    double sphere[6][4];
    for (int k = 0; k < 6; k++) {
        vec3_store3(sphere[k], vec3_add(at, quat_rotate(q, vec3_load(block.sphere[k]))));
        sphere[k][3] = 0.5e-3 * (1 - 1e-9);
    }
    if (clump_inscribe(mesh, (const double(*)[4])sphere, 6, 2700, &clump, &axes, &error))
        fail_msg("%s", error.message);
    near_to(clump.mass, block.mass, 1e-11); // vertices at 0.7 m are known to 1e-13 of a millimetre
    double want[3], have[3];
    for (int k = 0; k < 3; k++) {
        want[k] = block.inertia[k];
        have[k] = clump.inertia[k];
    }
    for (int i = 0; i < 3; i++) // principal axes come in any order
        for (int j = i + 1; j < 3; j++) {
            if (want[j] < want[i]) {
                double t = want[i];
                want[i] = want[j], want[j] = t;
            }
            if (have[j] < have[i]) {
                double t = have[i];
                have[i] = have[j], have[j] = t;
            }
        }
    for (int k = 0; k < 3; k++)
        near_to(have[k], want[k], 1e-10);
    for (int k = 0; k < 6; k++) { // own axes back into space
        struct vec3 x = vec3_add(at, quat_rotate(axes, vec3_load(clump.sphere[k])));
        for (int a = 0; a < 3; a++)
            assert_true(fabs((&x.x)[a] - sphere[k][a]) < 1e-14);
    }
    trimesh_free(mesh);
}

static void refusals_name_what_is_wrong(void **state)
{
    (void)state;
    const double size[3] = {1e-3, 1e-3, 1e-3}, inertia[6] = {1e-13, 1e-13, 1e-13};
    struct scree_error error;
    struct clump clump;
    struct trimesh *mesh = box(size, quat_one(), (struct vec3){0});
    double out[2][4] = {{0, 0, 0, 4e-4}, {1e-4, 0, 0, 4.5e-4}};
    assert_int_equal(clump_inscribe(mesh, (const double(*)[4])out, 2, 2700, &clump, NULL, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "sphere 1 leaves its polyhedron through triangle 10"));
    const double nothing[6] = {0}, flat[6] = {1, 1, 3}, centre[3] = {0};
    assert_int_equal(clump_create((const double(*)[4])out, 2, 1, centre, nothing, 1, &clump, NULL, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "moments of inertia must be positive"));
    assert_int_equal(clump_create((const double(*)[4])out, 2, 1, centre, flat, 1, &clump, NULL, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "no body has"));
    assert_int_equal(clump_create((const double(*)[4])out, 2, 0, centre, inertia, 1, &clump, NULL, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "mass must be positive"));
    assert_int_equal(clump_create((const double(*)[4])out, 0, 1, centre, inertia, 1, &clump, NULL, &error), SCREE_INVALID);
    assert_int_equal(clump_block(size, 0.3e-3, 2700, &clump, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "do not fill"));
    trimesh_free(mesh);
}

/* ---- B-09 ---- */

static double energy(const struct spinning *b, struct vec3 inverse)
{
    return 0.5 * (b->momentum.x * b->momentum.x * inverse.x + b->momentum.y * b->momentum.y * inverse.y +
                  b->momentum.z * b->momentum.z * inverse.z);
}

/* Steps an asymmetric top as the engine does: the momentum in space is kept, the
 * body's is derived from it at every step. Returns the largest relative change of energy. */
static double free_top(double angle_per_step, int steps, struct quat *end)
{
    const struct vec3 inverse = {1 / 1.0, 1 / 2.0, 1 / 2.7}, space = {0.3, 1.9, 0.4}; // mostly about the unstable axis
    struct quat q = quat_unit((struct quat){0.5, 0.1, -0.7, 0.2});
    double h = angle_per_step, start = 0, worst = 0;
    for (int k = 0; k < steps; k++) {
        struct turn t = quat_turn(q);
        struct spinning b = {q, turn_in(&t, space)};
        double e = energy(&b, inverse);
        start = k == 0 ? e : start;
        worst = fmax(worst, fabs(e / start - 1));
        spinning_first_half(&b, inverse, 0.5 * h);
        spinning_second_half(&b, inverse, 0.5 * h);
        q = quat_tidy(b.orientation);
        assert_true(fabs(quat_norm2(q) - 1) < 1e-15 * 4);
    }
    *end = q;
    return worst;
}

/* B-09: below 1e-8 in 1e5 steps of 1e-4 rad, which is far more than a contact's
 * time step turns a grain; the momentum in space is the state itself. */
static void a_free_asymmetric_top_keeps_its_energy(void **state)
{
    (void)state;
    struct quat end;
    double fine = free_top(1e-4, 100000, &end), coarse = free_top(1e-3, 100000, &end);
    assert_true(fine < 1e-8);
    assert_true(coarse < 1e-6);
    assert_true(coarse / fine > 80 && coarse / fine < 120); // second order, no trend
}

/* The path itself converges with the square of the step. */
static void free_rotation_is_second_order(void **state)
{
    (void)state;
    struct quat exact, end;
    double error[2];
    free_top(1e-4 / 8, 160000, &exact);
    for (int k = 0; k < 2; k++) {
        free_top(k ? 1e-3 / 2 : 1e-3, k ? 4000 : 2000, &end);
        struct quat d = quat_product(quat_inverse(exact), end);
        error[k] = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    }
    assert_true(error[0] / error[1] > 3.8 && error[0] / error[1] < 4.2);
}

/* About a principal axis the turn is exact: w t, whatever the step. */
static void rotation_about_a_principal_axis_is_exact(void **state)
{
    (void)state;
    const struct vec3 inverse = {1, 0.5, 0.25};
    struct spinning b = {quat_one(), {0, 0, 4 * 0.05}};
    for (int k = 0; k < 100; k++) {
        spinning_first_half(&b, inverse, 0.5);
        spinning_second_half(&b, inverse, 0.5);
    }
    assert_true(fabs(b.orientation.w - cos(2.5)) < 1e-13 && fabs(b.orientation.z - sin(2.5)) < 1e-13);
    struct vec3 x = quat_rotate(b.orientation, (struct vec3){1, 0, 0});
    assert_true(fabs(x.x - cos(5)) < 1e-13 && fabs(x.y - sin(5)) < 1e-13);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_have_the_layouts_and_inertia_of_the_fragments),
        cmocka_unit_test(corners_reach_the_faces_of_their_block),
        cmocka_unit_test(polyhedra_give_exact_mass_and_principal_axes),
        cmocka_unit_test(refusals_name_what_is_wrong),
        cmocka_unit_test(a_free_asymmetric_top_keeps_its_energy),
        cmocka_unit_test(free_rotation_is_second_order),
        cmocka_unit_test(rotation_about_a_principal_axis_is_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
