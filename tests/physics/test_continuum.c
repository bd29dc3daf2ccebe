/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The continuum against closed forms: free motion, rest, sliding, pushing, frames. */
#include "continuum.h"

static const double g = 9.81;

/* Nothing touches the block: each point flies on the parabola of the scheme, v = v0 - g t, and stays itself. */
static void free_fall_is_exact(void **state)
{
    (void)state;
    const struct mpm_region region = {{0.02, 0.02, 0.05}, {0.05, 0.04, 0.08}};
    struct mpm_setup s = continuum_box(12, 6, 10, &region);
    s.velocity[0] = 0.2;
    s.velocity[1] = -0.05;
    struct mpm *mpm = continuum_start(&s);
    struct continuum_view first = continuum_view(mpm);
    double(*x0)[4] = malloc(first.points * sizeof *x0);
    for (size_t p = 0; p < first.points; p++)
        memcpy(x0[first.id[p]], first.position[p], sizeof *x0);
    enum { STEPS = 60 };
    continuum_run(mpm, STEPS);
    struct continuum_view view = continuum_view(mpm);
    double t = STEPS * s.step_s, drop = g * s.step_s * s.step_s * STEPS * (STEPS + 1) / 2; // sum of g k dt^2
    double mean[3];
    continuum_mean(&view, mean);
    for (size_t p = 0; p < view.points; p++) {
        const double *from = x0[view.id[p]];
        assert_true(fabs(view.position[p][0] - from[0] - 0.2 * t) < 1e-11);
        assert_true(fabs(view.position[p][1] - from[1] + 0.05 * t) < 1e-11);
        assert_true(fabs(view.position[p][2] - from[2] + drop) < 1e-11);
    }
    assert_true(fabs(mean[0] - 0.2) < 1e-12 && fabs(mean[1] + 0.05) < 1e-12 && fabs(mean[2] + g * t) < 1e-12);
    free(x0);
    mpm_free(mpm);
}

/* Stresses move momentum about and never make any: a squeezed block in free space. */
static void stresses_conserve_momentum(void **state)
{
    (void)state;
    const struct mpm_region region = {{0.03, 0.02, 0.03}, {0.06, 0.05, 0.06}};
    struct mpm_setup s = continuum_box(9, 7, 9, &region);
    s.jitter = 1;
    s.solver.tolerance = 1e-12;
    for (int a = 0; a < 3; a++) {
        s.gradient[a][a] = -2; // would close on itself
        s.velocity[a] = 0.1 * a;
        s.gravity[a] = 0;
    }
    s.gradient[0][2] = 3;
    struct mpm *mpm = continuum_start(&s);
    struct continuum_view view = continuum_view(mpm);
    double before[3], after[3], pressed = 0;
    continuum_mean(&view, before);
    for (int k = 0; k < 20; k++) {
        continuum_run(mpm, 1);
        view = continuum_view(mpm);
        for (size_t n = 0; n < view.nodes; n++)
            pressed += view.stress[n][0] > 0;
    }
    continuum_mean(&view, after);
    assert_true(pressed > 10); // the stresses did something
    for (int a = 0; a < 3; a++)
        assert_true(fabs(after[a] - before[a]) < 1e-9);
    mpm_free(mpm);
}

/* Mean of the vertical stress over a layer of nodes, weighted by their shares of the section. */
static double mean_stress(const struct continuum_view *view, int z)
{
    double sum = 0, weight = 0;
    for (int x = 0; x <= view->cells[0]; x++)
        for (int y = 0; y <= (view->plane ? 0 : view->cells[1]); y++) {
            double w = x == 0 || x == view->cells[0] ? 0.5 : 1;
            w *= !view->plane && (y == 0 || y == view->cells[1]) ? 0.5 : 1;
            sum += w * view->stress[continuum_node(view, x, y, z)][2];
            weight += w;
        }
    return sum / weight;
}

/* A column between slippery walls: the section bears rho g (H - z) at every height (how it is spread over the
 * section is for the law to choose), the floor bears the weight, and nothing creeps. */
static void check_column(bool plane)
{
    const struct mpm_region region = {{0, 0, 0}, {0.04, 0.03, 0.12}};
    struct mpm_setup s = continuum_box(4, plane ? 0 : 3, 15, &region);
    s.walls[MPM_Z_LOW].kind = MPM_STICK;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 50);
    double force[3], weight = s.density * g * 0.04 * 0.12 * (plane ? 1 : 0.03);
    mpm_take_base_force(mpm, force);
    assert_true(fabs(force[2] + weight) < 1e-6 * weight);
    struct continuum_view view = continuum_view(mpm);
    for (int z = 1; z < 12; z++) {
        double expect = s.density * g * (0.12 - 0.01 * z);
        assert_true(fabs(mean_stress(&view, z) - expect) < 1e-5 * expect);
    }
    double fastest = 0;
    for (size_t p = 0; p < view.points; p++)
        for (int a = 0; a < 3; a++)
            fastest = fmax(fastest, fabs(view.velocity[p][a]));
    assert_true(fastest < 1e-6);
    mpm_free(mpm);
}

static void column_rests(void **state)
{
    (void)state;
    check_column(false);
}

static void column_rests_in_a_plane(void **state)
{
    (void)state;
    check_column(true);
}

struct slide {
    double velocity, force[3], weight, time; // along the floor, m/s; on the floor in the last step, N; N; s
};

/* A stiff block (its own mu is 3) on a floor of friction mu, gravity turned by an angle. */
static struct slide slide(double angle, double mu, bool plane, uint64_t steps)
{
    const struct mpm_region region = {{0.03, 0, 0}, {0.15, 0.04, 0.03}};
    struct mpm_setup s = continuum_box(22, plane ? 0 : 4, 5, &region);
    s.walls[MPM_Z_LOW] = (struct mpm_wall){MPM_FRICTION, .mu = mu};
    s.coefs.mu = 3;
    s.gravity[0] = g * sin(angle);
    s.gravity[2] = -g * cos(angle);
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, steps - 1);
    struct continuum_view view = continuum_view(mpm);
    double before[3], after[3];
    continuum_mean(&view, before);
    continuum_run(mpm, 1);
    view = continuum_view(mpm);
    continuum_mean(&view, after);
    double mass = s.density * view.volume;
    struct slide out = {.velocity = after[0], .weight = mass * g, .time = (double)steps * s.step_s};
    memcpy(out.force, view.base_force, sizeof out.force);
    /* Newton: the step's change of momentum is gravity's and the floor's, along and across (but for the trifle of
     * inertia that nearly empty nodes are lent). */
    assert_true(fabs(mass * (after[0] - before[0]) / s.step_s - mass * s.gravity[0] + out.force[0]) < 1e-6 * out.weight);
    assert_true(fabs(mass * (after[2] - before[2]) / s.step_s - mass * s.gravity[2] + out.force[2]) < 1e-6 * out.weight);
    mpm_free(mpm);
    return out;
}

/* Sliding: the floor takes exactly mu times the push, and a = g (sin - mu cos) but for crumbling edges. */
static void block_slides_as_coulomb_says(void **state)
{
    (void)state;
    for (int plane = 0; plane < 2; plane++) {
        double angle = 0.5, mu = 0.3, expect = g * (sin(angle) - mu * cos(angle));
        struct slide s = slide(angle, mu, plane, 12);
        assert_true(fabs(s.force[0] + mu * s.force[2]) < (plane ? 1e-6 : 5e-4) * s.weight); // in space some slip goes sideways
        assert_true(fabs(s.velocity / s.time - expect) < 0.025 * expect);
        s = slide(angle, 0, plane, 12);
        assert_true(fabs(s.velocity / s.time - g * sin(angle)) < 1e-9);
        assert_true(s.force[0] == 0);
    }
}

/* Below the angle of friction it stays; what still moves are its edges. */
static void block_rests_as_coulomb_says(void **state)
{
    (void)state;
    struct slide s = slide(0.2, 0.5, true, 100);
    assert_true(fabs(s.velocity) < 0.04 * g * s.time * sin(0.2));
    assert_true(fabs(s.force[0]) < 0.5 * fabs(s.force[2]));
}

/* Integral of U(t) = v (1 - exp(-t/tau)), by hand. */
static double rigid_way_of(const struct mpm_body *body, double t)
{
    return body->velocity[0] * (t - body->tau_s * (1 - exp(-t / body->tau_s)));
}

/* A body that moves at U into a block on a slippery floor takes it along at U. */
static void body_pushes(void **state)
{
    (void)state;
    const struct mpm_region region = {{0.03, 0, 0}, {0.06, 0.02, 0.02}};
    struct mpm_body body = {.low = {0.005, -1, -1}, .high = {0.03, 1, 1}, .velocity = {0.2, 0, 0}, .tau_s = 0.01};
    struct mpm_setup s = continuum_box(12, 2, 4, &region);
    s.bodies = &body;
    s.body_count = 1;
    s.coefs.mu = 3;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 80);
    struct continuum_view view = continuum_view(mpm);
    double mean[3];
    continuum_mean(&view, mean);
    assert_true(mean[0] > 0.99 * 0.2 && mean[0] < 1.06 * 0.2); // the free side crumbles ahead
    double face = 0.03 + rigid_way_of(&body, mpm_time(mpm));
    for (size_t p = 0; p < view.points; p++)
        assert_true(view.position[p][0] > face - 0.005);
    mpm_free(mpm);
}

/* U(t) = v (1 - exp(-(t - ts)/tau)): what a body has moved is its integral. */
static void column_falls_when_the_gate_lifts(void **state)
{
    (void)state;
    const struct mpm_region region = {{0, 0, 0}, {0.06, 0.02, 0.06}};
    struct mpm_body gate = {
        .low = {0.06, -1, -1}, .high = {0.08, 1, 1}, .velocity = {0, 0, 50}, .start_s = 0.03, .tau_s = 1e-3, .mu = 0.2};
    struct mpm_setup s = continuum_box(20, 2, 8, &region);
    s.walls[MPM_Z_LOW].kind = MPM_STICK;
    s.bodies = &gate;
    s.body_count = 1;
    s.solver.tolerance = 1e-11;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 29);
    struct continuum_view view = continuum_view(mpm);
    double held = view.kinetic;
    continuum_run(mpm, 60);
    view = continuum_view(mpm);
    assert_true(held < 1e-6 * s.density * view.volume * g * 0.06);
    assert_true(view.kinetic > 100 * held);
    mpm_free(mpm);
}

/* The same collapse along y instead of x ends the same: nothing in the solver knows an axis but the order of sums. */
static void frame_does_not_matter(void **state)
{
    (void)state;
    double front[2] = {0, 0};
    for (int turn = 0; turn < 2; turn++) {
        struct mpm_region region = {{0, 0, 0}, {0.04, 0.02, 0.04}};
        struct mpm_setup s = continuum_box(12, 2, 6, &region);
        if (turn) {
            region = (struct mpm_region){{0, 0, 0}, {0.02, 0.04, 0.04}};
            s = continuum_box(2, 12, 6, &region);
        }
        s.walls[MPM_Z_LOW].kind = MPM_STICK;
        s.solver.tolerance = 1e-15;
        struct mpm *mpm = continuum_start(&s);
        continuum_run(mpm, 60);
        struct continuum_view view = continuum_view(mpm);
        for (size_t p = 0; p < view.points; p++)
            front[turn] += view.position[p][turn] / (double)view.points;
        mpm_free(mpm);
    }
    assert_true(front[0] > 0.0215);
    assert_true(fabs(front[0] - front[1]) < 1e-8);
}

/* The friction coefficients of the laws at the ends of their ranges. */
static void laws_have_their_limits(void **state)
{
    (void)state;
    const struct mpm_law_coefs c = {.mu = 0.38, .mu_2 = 0.64, .inertial0 = 0.279, .delta_mu = 0.16, .inertial_star = 0.04};
    assert_true(fabs(mpm_law_mu_i.friction(&c, 0) - 0.38) < 1e-15);
    assert_true(fabs(mpm_law_mu_i.friction(&c, 0.279) - 0.51) < 1e-12);
    assert_true(fabs(mpm_law_mu_i.friction(&c, 1e9) - 0.64) < 1e-9);
    assert_true(fabs(mpm_law_hysteretic_ramp.friction(&c, 0) - 0.54) < 1e-15);
    assert_true(fabs(mpm_law_hysteretic_ramp.friction(&c, 0.02) - 0.46) < 1e-12);
    assert_true(fabs(mpm_law_hysteretic_ramp.friction(&c, 0.04) - 0.38) < 1e-15);
    assert_true(fabs(mpm_law_hysteretic_step.friction(&c, 0.0399) - 0.54) < 1e-15);
    assert_true(fabs(mpm_law_hysteretic_step.friction(&c, 0.04) - 0.38) < 1e-15);
    assert_ptr_equal(mpm_law_find("mu(I)"), &mpm_law_mu_i);
    assert_null(mpm_law_find("none"));
}

/* Where the material flows, ||Dev lambda|| = mu(I) p with the I of the step before, as a user reads both. */
static void flowing_nodes_are_on_the_cone(void **state)
{
    (void)state;
    const struct mpm_region region = {{0, 0, 0}, {0.06, 0, 0.06}};
    struct mpm_setup s = continuum_box(20, 0, 8, &region);
    s.walls[MPM_Z_LOW].kind = MPM_STICK;
    s.law = &mpm_law_mu_i;
    s.coefs = (struct mpm_law_coefs){.mu = 0.38, .mu_2 = 0.64, .inertial0 = 0.279};
    s.points_per_cell = 3;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 60);
    struct continuum_view view = continuum_view(mpm);
    int flowing = 0;
    for (size_t n = 0; n < view.nodes; n++) {
        const double *l = view.stress[n], p = 0.5 * (l[0] + l[2]), half = 0.5 * (l[0] - l[2]);
        double dev = sqrt(half * half + l[4] * l[4]);
        assert_true(dev <= l[7] * p * (1 + 1e-9) + 1e-12);
        assert_true(p == 0 || (l[7] >= 0.38 && l[7] <= 0.64));
        flowing += p > 50 && dev > l[7] * p * (1 - 1e-9);
    }
    assert_true(flowing > 10);
    mpm_free(mpm);
}

/* An endless layer on a rough slope under mu(I): tan(theta) = mu(I) at every depth, so that the shear rate is
 * 2 I/d sqrt(p/rho_I) (||e|| is half of it) and
 *     u(z) = 4 I/(3 d) sqrt(rho g cos(theta) / rho_I) (h^(3/2) - (h - z)^(3/2)). */
static void endless_layer_flows_as_bagnold_says(void **state)
{
    (void)state;
    const double h = 0.05, angle = atan(0.46), d = 0.005;
    const struct mpm_region region = {{0, 0, 0}, {1, 0, h}};
    struct mpm_setup s = continuum_box(1, 0, 22, &region);
    s.endless = true;
    s.length[2] = 0.055;
    s.walls[MPM_Z_LOW].kind = MPM_STICK;
    s.law = &mpm_law_mu_i;
    s.coefs = (struct mpm_law_coefs){.mu = 0.38, .mu_2 = 0.64, .inertial0 = 0.279};
    s.grain_diameter = d;
    s.inertial_density = s.density / 0.6;
    s.gravity[0] = g * sin(angle);
    s.gravity[2] = -g * cos(angle);
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 6000);
    struct continuum_view view = continuum_view(mpm);
    double inertial = 0.279 * (0.46 - 0.38) / (0.64 - 0.46), scale = 4 * inertial / (3 * d) * sqrt(0.6 * g * cos(angle));
    for (int z = 2; z <= 18; z++) {
        size_t n = continuum_node(&view, 0, 0, z);
        double depth = h - 0.0025 * z, expect = scale * (pow(h, 1.5) - pow(depth, 1.5));
        assert_true(fabs(view.node_velocity[n][0] - expect) < 0.02 * scale * pow(h, 1.5));
        assert_true(fabs(view.stress[n][2] - s.density * g * cos(angle) * depth) < 0.01 * s.density * g * h);
        assert_true(fabs(view.stress[n][6] - inertial) < 0.05 * inertial);
    }
    double force[3];
    mpm_take_base_force(mpm, force);
    assert_true(fabs(-view.base_force[0] / view.base_force[2] - 0.46) < 0.01);
    mpm_free(mpm);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(free_fall_is_exact),
        cmocka_unit_test(stresses_conserve_momentum),
        cmocka_unit_test(column_rests),
        cmocka_unit_test(column_rests_in_a_plane),
        cmocka_unit_test(block_slides_as_coulomb_says),
        cmocka_unit_test(block_rests_as_coulomb_says),
        cmocka_unit_test(body_pushes),
        cmocka_unit_test(column_falls_when_the_gate_lifts),
        cmocka_unit_test(frame_does_not_matter),
        cmocka_unit_test(laws_have_their_limits),
        cmocka_unit_test(flowing_nodes_are_on_the_cone),
        cmocka_unit_test(endless_layer_flows_as_bagnold_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
