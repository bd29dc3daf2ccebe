/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A deposit's numbers on fields made by hand, where they are known. */
#include "unit.h"

#include <math.h>

#include "measure/deposit.h"

enum { NX = 20, NZ = 10, NODES = (NX + 1) * (NZ + 1) };
static const double spacing = 0.01;

struct made {
    double fraction[NODES], velocity[NODES][4], stress[NODES][8];
    double position[2][4], point_velocity[2][4];
    struct continuum_view view;
};

/* A plane wedge whose surface falls from `top` at x = 0 with a slope of one half to 1 cm. */
static double wedge(double x, double top)
{
    return fmax(0.01, top - 0.5 * x);
}

static void make(struct made *m, double top)
{
    memset(m, 0, sizeof *m);
    m->view = (struct continuum_view){.spacing = {spacing, 1, spacing},
                                      .length = {NX * spacing, 1, NZ * spacing},
                                      .cells = {NX, 1, NZ},
                                      .plane = true,
                                      .nodes = NODES,
                                      .fraction = m->fraction,
                                      .node_velocity = (const double(*)[4])m->velocity,
                                      .stress = (const double(*)[8])m->stress,
                                      .points = 2,
                                      .position = (const double(*)[4])m->position,
                                      .velocity = (const double(*)[4])m->point_velocity,
                                      .volume = 2,
                                      .time_s = 1.25};
    for (int x = 0; x <= NX; x++)
        for (int z = 0; z <= NZ; z++) {
            size_t n = continuum_node(&m->view, x, 0, z);
            /* Linear through 0.5 at the surface, so that the contour is exact. */
            m->fraction[n] = fmin(1, fmax(0, 0.5 + (wedge(x * spacing, top) - z * spacing) / (2 * spacing)));
            m->velocity[n][0] = z * spacing; // 0.01 m/s at z = 1 cm
        }
}

static const struct deposit_site site = {.bed = 0.02, .gate = 0.05, .start = 0.2};

/* The contour phi = 0.5 and the line |u| = 0.01 m/s, between nodes. */
static void lines_are_found_between_nodes(void **state)
{
    (void)state;
    static struct made m;
    struct deposit_lines lines;
    make(&m, 0.083);
    assert_int_equal(deposit_lines_start(&lines, &m.view, NULL), SCREE_OK);
    deposit_trace(&m.view, 0, &lines);
    for (int x = 0; x <= NX; x++) {
        assert_true(fabs(lines.surface[x] - wedge(x * spacing, 0.083)) < 1e-12);
        assert_true(fabs(lines.still[x] - 0.01) < 1e-12);
    }
    deposit_lines_free(&lines);
}

/* Run-out ends where the deposit is 2 mm over the bed, counted from the gate. */
static void run_out_follows_the_rule(void **state)
{
    (void)state;
    static struct made m;
    struct deposit_lines lines;
    struct deposit d;
    make(&m, 0.083);
    assert_int_equal(deposit_lines_start(&lines, &m.view, NULL), SCREE_OK);
    deposit_measure(&m.view, &site, &lines, &d);
    double end = (0.083 - 0.022) / 0.5; // 0.122: where the wedge is 2 mm deep
    assert_true(fabs(d.run_out - (end - 0.05)) < 1e-12);
    assert_true(fabs(d.height_back - 0.063) < 1e-12);
    assert_true(fabs(d.time_s - 1.05) < 1e-12);
    /* A lump beyond a gap does not count. */
    for (int z = 0; z <= NZ; z++)
        m.fraction[continuum_node(&m.view, 17, 0, z)] = z < 6;
    deposit_measure(&m.view, &site, &lines, &d);
    assert_true(fabs(d.run_out - (end - 0.05)) < 1e-12);
    deposit_lines_free(&lines);
}

/* A frame holds both lines; the slope of the middle of the box is the wedge's, against the horizontal. */
static void surface_is_framed_and_its_slope_found(void **state)
{
    (void)state;
    static struct made m;
    struct deposit_lines lines;
    struct deposit d;
    double rows[NX + 1][SURFACE_COLUMNS];
    make(&m, 0.15); // so high that the wedge reaches over the middle
    const double tilt = 10 * M_PI / 180;
    m.view.gravity[0] = 9.81 * sin(tilt);
    m.view.gravity[2] = -9.81 * cos(tilt);
    m.view.residual_mean = 1e-12;
    m.view.residual_largest = 3e-10;
    assert_int_equal(deposit_lines_start(&lines, &m.view, NULL), SCREE_OK);
    deposit_measure(&m.view, &site, &lines, &d);
    /* Cut off by the top of the box at 0.1 m up to x = 0.1: measured right of there, the line is fitted to what is seen. */
    deposit_surface(&m.view, &lines, rows);
    for (int x = 11; x <= NX; x++) {
        assert_true(rows[x][0] == x * spacing && fabs(rows[x][1] - wedge(x * spacing, 0.15)) < 1e-12);
        assert_true(fabs(rows[x][2] - 0.01) < 1e-12 && fabs(rows[x][3] - floor(rows[x][1] / spacing + 1e-9) * spacing) < 0.011);
    }
    assert_true(fabs(d.inclination - 10) < 1e-12);
    assert_true(d.residual_mean == 1e-12 && d.residual_largest == 3e-10);
    make(&m, 0.09);
    m.view.gravity[2] = -9.81;
    deposit_measure(&m.view, &site, &lines, &d);
    assert_true(fabs(d.surface_angle - atan(0.5) * 180 / M_PI) < 1e-9); // falls all along the middle
    deposit_lines_free(&lines);
}

static void points_and_quantiles(void **state)
{
    (void)state;
    static struct made m;
    struct deposit_lines lines;
    struct deposit d;
    make(&m, 0.083);
    memcpy(m.position, (double[2][4]){{0.11, 0, 0.03, 0.5}, {0.19, 0, 0.01, 1.5}}, sizeof m.position); // the second lies in the bed
    m.point_velocity[0][2] = -0.3;
    /* Eleven flowing nodes inside, I = 0.001 k; one below the limit. */
    for (int k = 0; k <= 11; k++) {
        double *l = m.stress[continuum_node(&m.view, k % 6, 0, k / 6)];
        l[0] = l[2] = 100;
        l[6] = k == 0 ? 1e-4 : 1e-3 * k;
    }
    assert_int_equal(deposit_lines_start(&lines, &m.view, NULL), SCREE_OK);
    deposit_measure(&m.view, &site, &lines, &d);
    assert_true(fabs(d.furthest - 0.11) < 1e-15);
    assert_true(fabs(d.fastest - 0.3) < 1e-15);
    assert_true(fabs(d.flowing - 0.25) < 1e-15);
    assert_true(fabs(d.inertial[0] - 0.004) < 1e-15 && fabs(d.inertial[1] - 0.006) < 1e-15 && fabs(d.inertial[2] - 0.008) < 1e-15);
    deposit_lines_free(&lines);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_are_found_between_nodes),
        cmocka_unit_test(run_out_follows_the_rule),
        cmocka_unit_test(surface_is_framed_and_its_slope_found),
        cmocka_unit_test(points_and_quantiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
