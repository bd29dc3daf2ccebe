/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shear in an endless channel, where walls and law have closed forms: what a wall takes
 * off a flow, and mu(I) under one rate of shear at every pressure. */
#include "continuum.h"

static const double g = 9.81, width = 0.02, depth = 0.06;
enum { UP = 12, OVER = 3 }; // cells of the material's depth, and over it

static struct mpm_setup channel(int across, const struct mpm_region *region)
{
    struct mpm_setup s = continuum_box(1, across, UP + OVER, region);
    s.endless = true;
    s.length[1] = width;
    s.length[2] = depth * (UP + OVER) / UP;
    s.solver.tolerance = 1e-14;
    return s;
}

/* Mean over the section of the velocity along the channel. */
static double speed_at(const struct continuum_view *view, int z)
{
    double volume = 0, flow = 0;
    for (int y = 0; y < continuum_layers(view, 1); y++) {
        const double *u = view->node_velocity[continuum_node(view, 0, y, z)];
        volume += u[3];
        flow += u[3] * u[0];
    }
    return flow / volume;
}

/* A layer that lets go between walls. In shear all normal stresses are p = rho g cos(theta) h, so that the walls take
 * 2 mu_w p / W of each volume and
 *     du/dt = g cos(theta) (tan(theta) - mu - 2 mu_w h / W)
 * down to the depth where that is nothing; below, it rests. (Shear across, of the order of (mu_w / mu)^2, is left out.) */
static void walls_take_what_coulomb_says(void **state)
{
    (void)state;
    const double slope = atan(0.64), mu = 0.44, mu_wall = 0.05;
    const struct mpm_region region = {{0, 0, 0}, {1, width, depth}};
    for (int across = 3; across <= 6; across += 3) {
        struct mpm_setup s = channel(across, &region);
        s.walls[MPM_Z_LOW].kind = MPM_STICK;
        s.walls[MPM_Y_LOW] = s.walls[MPM_Y_HIGH] = (struct mpm_wall){MPM_FRICTION, .mu = mu_wall};
        s.coefs.mu = mu;
        s.gravity[0] = g * sin(slope);
        s.gravity[2] = -g * cos(slope);
        struct mpm *mpm = continuum_start(&s);
        continuum_run(mpm, 40);
        struct continuum_view view = continuum_view(mpm);
        const double cell = depth / UP, surface = g * cos(slope) * (tan(slope) - mu) * mpm_time(mpm);
        for (int z = 1; z < UP; z++) {
            double h = depth - z * cell, p = s.density * g * cos(slope) * h;
            double expect = surface - g * cos(slope) * 2 * mu_wall * h / width * mpm_time(mpm);
            assert_true(fabs(speed_at(&view, z) - fmax(expect, 0)) < 0.015 * surface);
            for (int side = 0; side <= across && expect > 0.1 * surface; side += across)
                assert_true(fabs(view.stress[continuum_node(&view, 0, side, z)][1] - p) < 5e-3 * p);
        }
        mpm_free(mpm);
    }
}

/* Walls that stick and slide past each other shear what lies between them at one rate everywhere, whatever its
 * pressure rho g h: the shear stress is mu(I) p with I = d (rate / 2) sqrt(rho_I / p), which falls with depth. */
static void uniform_shear_obeys_mu_of_i(void **state)
{
    (void)state;
    const double rate = 60, d = 0.005;
    const struct mpm_region region = {{0, 0, 0}, {1, width, depth}};
    struct mpm_setup s = channel(4, &region);
    s.law = &mpm_law_mu_i;
    s.coefs = (struct mpm_law_coefs){.mu = 0.38, .mu_2 = 0.64, .inertial0 = 0.279};
    s.grain_diameter = d;
    s.inertial_density = s.density / 0.6;
    s.walls[MPM_Y_LOW] = (struct mpm_wall){.kind = MPM_STICK};
    s.walls[MPM_Y_HIGH] = (struct mpm_wall){.kind = MPM_STICK, .velocity = {rate * width, 0, 0}};
    s.gradient[0][1] = rate;
    struct mpm *mpm = continuum_start(&s);
    continuum_run(mpm, 50);
    struct continuum_view view = continuum_view(mpm);
    double mu_seen[2] = {1, 0};
    for (int z = 1; z < UP; z++) {
        double h = depth - z * depth / UP, weight = s.density * g * h, pressure = 0, shear = 0;
        for (int y = 1; y < 4; y++) { // of the nodes that walls do not hold
            const double *l = view.stress[continuum_node(&view, 0, y, z)];
            double p = (l[0] + l[1] + l[2]) / 3, inertial = 0.5 * rate * d * sqrt(s.inertial_density / p);
            double mu = 0.38 + (0.64 - 0.38) * inertial / (inertial + 0.279);
            assert_true(fabs(view.node_velocity[continuum_node(&view, 0, y, z)][0] - rate * y * width / 4) < 1e-4 * rate * width);
            assert_true(fabs(-l[5] - mu * p) < 1e-4 * mu * p);
            pressure += p / 3;
            shear -= l[5] / 3;
        }
        assert_true(fabs(pressure - weight) < 2e-3 * weight);
        mu_seen[0] = fmin(mu_seen[0], shear / pressure);
        mu_seen[1] = fmax(mu_seen[1], shear / pressure);
    }
    assert_true(mu_seen[1] - mu_seen[0] > 0.05); // a range of I, not one
    mpm_free(mpm);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_take_what_coulomb_says),
        cmocka_unit_test(uniform_shear_obeys_mu_of_i),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
