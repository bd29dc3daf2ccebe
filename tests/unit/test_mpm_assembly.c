/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the grid is told by the points: coefficients, masses and rooms against
 * direct sums and integrals. */
#include "continuum.h"

#include "base/rng.h"
#include "mpm/state.h"

static double hat(double s)
{
    return fmax(0, 1 - fabs(s));
}

static double hat_slope(double s)
{
    return fabs(s) >= 1 ? 0 : s > 0 ? -1 : 1;
}

/* N and its gradient at a point, by node place. */
static double shape(const struct grid *g, const int place[3], const double x[3], double slope[3])
{
    double n[3], d[3];
    for (int a = 0; a < 3; a++) {
        double s = x[a] * g->inverse[a] - place[a];
        bool flat = g->flat[a];
        n[a] = flat ? 1 : hat(s);
        d[a] = flat ? 0 : hat_slope(s) * g->inverse[a];
    }
    slope[0] = d[0] * n[1] * n[2];
    slope[1] = n[0] * d[1] * n[2];
    slope[2] = n[0] * n[1] * d[2];
    return n[0] * n[1] * n[2];
}

/* C_ij = sum_p V N_j grad N_i, point by point, against what 27 moments a cell gave. */
static void check_coupling(bool plane)
{
    const struct mpm_region region = {{0.005, 0.012, 0.003}, {0.043, 0.031, 0.034}};
    struct mpm_setup s = continuum_box(5, plane ? 0 : 4, 4, &region);
    s.jitter = 1;
    s.points_per_cell = 3;
    struct mpm *mpm = continuum_start(&s);
    assemble(mpm, 0);
    const struct grid *g = &mpm->grid;
    double worst = 0, largest = 0;
    for (size_t r = 0; r < mpm->row_count; r++) {
        int j[3];
        grid_node_place(g, mpm->rows[r].node, j);
        const double *c = mpm->coupling + r * mpm->field.coupling_stride;
        for (int run = 0; run < mpm->field.runs; run++)
            for (int k = 0; k < 3; k++, c += 3) {
                size_t node = (size_t)((ptrdiff_t)mpm->rows[r].node + mpm->field.run[run] + k);
                int i[3];
                grid_node_place(g, node, i);
                double direct[3] = {0, 0, 0}, slope[3], other[3];
                for (size_t p = 0; p < mpm->points; p++) {
                    const double *x = mpm->position[p];
                    double weight = x[3] * shape(g, j, x, other);
                    shape(g, i, x, slope);
                    for (int a = 0; a < 3; a++)
                        direct[a] += weight * slope[a];
                }
                for (int a = 0; a < 3; a++) {
                    worst = fmax(worst, fabs(direct[a] * mpm->scale[node] - c[a]));
                    largest = fmax(largest, fabs(c[a]));
                }
            }
    }
    assert_true(mpm->row_count > 20);
    assert_true(worst < 1e-12 * largest);
    mpm_free(mpm);
}

static void coupling_is_the_sum_over_points(void **state)
{
    (void)state;
    check_coupling(false);
}

static void coupling_is_the_sum_over_points_in_a_plane(void **state)
{
    (void)state;
    check_coupling(true);
}

/* After points have moved and changed cells, their moments are still those of where they are. */
static void moments_follow_the_points(void **state)
{
    (void)state;
    const struct mpm_region region = {{0.01, 0.01, 0.02}, {0.04, 0.03, 0.05}};
    struct mpm_setup s = continuum_box(8, 5, 6, &region);
    s.jitter = 1;
    s.points_per_cell = 3;
    s.gradient[0][1] = 5;
    s.gradient[1][2] = -4;
    s.velocity[0] = 0.3;
    struct mpm *mpm = continuum_start(&s);
    uint64_t moved = 0;
    for (int k = 0; k < 40; k++) {
        continuum_run(mpm, 1);
        moved += mpm_report(mpm).moved;
    }
    assert_true(moved > 200);
    struct continuum_view view = continuum_view(mpm);
    double worst = 0;
    for (int x = 0; x <= 8; x++)
        for (int y = 0; y <= 5; y++)
            for (int z = 0; z <= 6; z++) {
                double sum = 0, slope[3];
                for (size_t p = 0; p < view.points; p++)
                    sum += view.position[p][3] * shape(&mpm->grid, (int[3]){x, y, z}, view.position[p], slope);
                worst = fmax(worst, fabs(sum - view.node_velocity[continuum_node(&view, x, y, z)][3]));
            }
    assert_true(worst < 1e-13 * view.volume);
    mpm_free(mpm);
}

/* Every point keeps its name and volume, and the nodes share out exactly the material there is. */
static void mass_is_conserved(void **state)
{
    (void)state;
    const struct mpm_region region = {{0, 0, 0}, {0.03, 0.02, 0.04}};
    struct mpm_setup s = continuum_box(8, 2, 5, &region);
    s.jitter = 1;
    s.solver.tolerance = 1e-10;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 100);
    struct continuum_view view = continuum_view(mpm);
    bool *seen = calloc(view.points, sizeof *seen);
    double points = 0, nodes = 0;
    for (size_t p = 0; p < view.points; p++) {
        assert_false(seen[view.id[p]]);
        seen[view.id[p]] = true;
        points += view.position[p][3];
    }
    for (size_t n = 0; n < view.nodes; n++)
        nodes += view.node_velocity[n][3];
    assert_true(fabs(points - 0.03 * 0.02 * 0.04) < 1e-15 * (double)view.points);
    assert_true(fabs(nodes - points) < 1e-13 * points);
    free(seen);
    mpm_free(mpm);
}

/* Rooms of all nodes fill the box less the bodies in it, wherever those are. */
static void rooms_fill_the_box(void **state)
{
    (void)state;
    const struct mpm_region region = {{0, 0, 0}, {0.01, 0.02, 0.01}};
    struct mpm_body body = {.low = {0.0231, -1, 0.0112}, .high = {0.0457, 1, 0.0389}};
    struct mpm_setup s = continuum_box(7, 2, 6, &region);
    s.bodies = &body;
    s.body_count = 1;
    struct mpm *mpm = continuum_start(&s);
    double room = 0;
    for (int x = 0; x <= 7; x++)
        for (int y = 0; y <= 2; y++)
            for (int z = 0; z <= 6; z++)
                room += rigid_room(mpm, (int[3]){x, y, z});
    double expect = 0.07 * 0.02 * 0.06 - 0.0226 * 0.02 * 0.0277;
    assert_true(fabs(room - expect) < 1e-12 * expect);
    mpm_free(mpm);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coupling_is_the_sum_over_points),
        cmocka_unit_test(coupling_is_the_sum_over_points_in_a_plane),
        cmocka_unit_test(moments_follow_the_points),
        cmocka_unit_test(mass_is_conserved),
        cmocka_unit_test(rooms_fill_the_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
