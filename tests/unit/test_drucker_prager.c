/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rheology at one node: the root function of eqs A1-A9, projections on its
 * cones, and the row solver against definitions and against brute force. */
#include "unit.h"

#include <math.h>

#include "base/rng.h"
#include "mpm/drucker_prager.h"

static double draw(struct rng *rng)
{
    return rng_uniform(rng, -1, 1);
}

static void draw_tensor(struct rng *rng, bool plane, double size, double t[TENSOR])
{
    for (int k = 0; k < TENSOR; k++)
        t[k] = plane && (k == 1 || k == 3 || k == 5) ? 0 : size * draw(rng);
}

static void add_identity(double t[TENSOR], double a, bool plane)
{
    t[0] += a;
    t[1] += plane ? 0 : a;
    t[2] += a;
}

static double dimension(bool plane)
{
    return plane ? 2 : 3;
}

/* A pair on eq. 2.7 in the wanted state, made from the definition alone. */
static void draw_state(struct rng *rng, enum phase phase, bool plane, double mu, double gamma[TENSOR], double lambda[TENSOR])
{
    double d = dimension(plane), p = rng_uniform(rng, 0.01, 3), dev[TENSOR];
    memset(gamma, 0, TENSOR * sizeof *gamma);
    memset(lambda, 0, TENSOR * sizeof *lambda);
    draw_tensor(rng, plane, 2, dev);
    tensor_deviator(dev, plane, dev);
    double norm = tensor_norm(dev);
    if (phase == PHASE_GAS) {
        memcpy(gamma, dev, sizeof dev);
        add_identity(gamma, rng_uniform(rng, 0, 2) / d, plane);
        return;
    }
    add_identity(lambda, p, plane);
    double share = phase == PHASE_STATIC ? rng_uniform(rng, 0, 0.999) : 1;
    for (int k = 0; k < TENSOR; k++) {
        lambda[k] -= share * mu * p * dev[k] / norm;
        gamma[k] = phase == PHASE_STATIC ? 0 : dev[k];
    }
}

/* S2-12: f_MFB vanishes on every state of DP(mu), in two and three dimensions. */
static void root_function_vanishes_on_the_law(void **state)
{
    (void)state;
    struct rng rng = rng_start(1, 1);
    double worst = 0, f[TENSOR], g[TENSOR], l[TENSOR];
    for (int k = 0; k < 30000; k++) {
        bool plane = k & 1;
        double mu = rng_uniform(&rng, 0.05, 1.2);
        draw_state(&rng, (enum phase)(k % 3), plane, mu, g, l);
        drucker_prager_root(g, l, mu, plane, f);
        worst = fmax(worst, tensor_norm(f));
    }
    /* Static states with a tiny difference of large squares lose half the digits: the function has a root there. */
    assert_true(worst < 1e-10);
}

/* ... and nowhere else: a pair moved off the law by h has |f| of the order of h. */
static void root_function_sees_every_departure(void **state)
{
    (void)state;
    struct rng rng = rng_start(2, 1);
    double f[TENSOR], g[TENSOR], l[TENSOR];
    for (int k = 0; k < 3000; k++) {
        bool plane = k & 1;
        double mu = rng_uniform(&rng, 0.1, 1.0);
        draw_state(&rng, PHASE_FLOWING, plane, mu, g, l);
        switch (k % 3) {
        case 0: // compression without limit
            add_identity(g, -0.01, plane);
            break;
        case 1: // stress outside the cone
            add_identity(l, -0.01, plane);
            break;
        default: // expansion under pressure
            add_identity(g, 0.01, plane);
        }
        drucker_prager_root(g, l, mu, plane, f);
        assert_true(tensor_norm(f) > 1e-5);
    }
}

/* Eq. A9 is x + y - sqrt(x^2 + y^2) of the cone's Jordan algebra. */
static void root_function_is_the_jordan_one(void **state)
{
    (void)state;
    struct rng rng = rng_start(3, 1);
    for (int k = 0; k < 2000; k++) {
        bool plane = k & 1;
        double d = dimension(plane), g[TENSOR], l[TENSOR], f[TENSOR], dev_g[TENSOR], dev_l[TENSOR], dev_f[TENSOR];
        draw_tensor(&rng, plane, 1, g);
        draw_tensor(&rng, plane, 1, l);
        /* mu~ = 1 and an undone A4 leave f_FB itself. */
        double mu = sqrt(d / 2);
        tensor_deviator(g, plane, dev_g);
        tensor_deviator(l, plane, dev_l);
        double shifted[TENSOR];
        memcpy(shifted, g, sizeof g);
        add_identity(shifted, -sqrt(2 / d) * tensor_norm(dev_g), plane);
        drucker_prager_root(shifted, l, mu, plane, f);
        /* z = x o x + y o y = (z0, z1); sqrt has eigenvalues sqrt(z0 +- |z1|) on (1, +-z1/|z1|)/2. */
        double x0 = tensor_trace(g) / sqrt(2 * d), y0 = tensor_trace(l) / sqrt(2 * d), z1[TENSOR];
        for (int i = 0; i < TENSOR; i++)
            z1[i] = 2 * (x0 * dev_g[i] + y0 * dev_l[i]);
        double z0 = x0 * x0 + y0 * y0 + pow(tensor_norm(dev_g), 2) + pow(tensor_norm(dev_l), 2), n = tensor_norm(z1);
        double up = sqrt(z0 + n), down = sqrt(fmax(0, z0 - n));
        double f0 = x0 + y0 - 0.5 * (up + down);
        assert_true(fabs(tensor_trace(f) / sqrt(2 * d) - f0) < 1e-12);
        tensor_deviator(f, plane, dev_f);
        for (int i = 0; i < TENSOR; i++)
            assert_true(fabs(dev_f[i] - (dev_g[i] + dev_l[i] - 0.5 * (up - down) * z1[i] / n)) < 1e-11);
    }
}

/* The projection is in the cone and no point of the cone is nearer (its normal
 * is in the polar cone and at right angles). */
static void projection_is_nearest(void **state)
{
    (void)state;
    struct rng rng = rng_start(4, 1);
    for (int k = 0; k < 5000; k++) {
        bool plane = k & 1;
        double d = dimension(plane), c = rng_uniform(&rng, 0.05, 3), t[TENSOR], p[TENSOR], dev[TENSOR], off[TENSOR];
        draw_tensor(&rng, plane, 1, t);
        cone_project(t, c, plane, p);
        tensor_deviator(p, plane, dev);
        assert_true(tensor_norm(dev) <= c * tensor_trace(p) / sqrt(2 * d) + 1e-12);
        double dot = 0;
        for (int i = 0; i < TENSOR; i++) {
            off[i] = p[i] - t[i];
            dot += (i < 3 ? 0.5 : 1) * off[i] * p[i];
        }
        assert_true(fabs(dot) < 1e-12);
        tensor_deviator(off, plane, dev); // p - t lies in the dual cone K_{1/c}
        assert_true(tensor_norm(dev) <= tensor_trace(off) / sqrt(2 * d) / c + 1e-12);
    }
}

/* A positive definite K with eigenvalues that differ up to `spread`, turned at random. */
static void draw_block(struct rng *rng, bool plane, double spread, double k[TENSOR])
{
    double t[TENSOR], q[3][3], e[3];
    draw_tensor(rng, plane, 1, t);
    tensor_eigen(t, q, e);
    for (int a = 0; a < 3; a++)
        e[a] = exp(rng_uniform(rng, 0, log(spread)));
    double r[TENSOR] = {e[0], e[1], e[2], 0, 0, 0};
    tensor_rotate_back(r, (const double(*)[3])q, k);
    if (plane)
        k[1] = k[3] = k[5] = 0;
}

/* gamma = W lambda + b with W lambda = (lambda K + K lambda)/2, by plain matrices. */
static void strain(const double k[TENSOR], const double b[TENSOR], const double lambda[TENSOR], double gamma[TENSOR])
{
    double m[3][3] = {{k[0], k[5], k[4]}, {k[5], k[1], k[3]}, {k[4], k[3], k[2]}};
    double l[3][3] = {{lambda[0], lambda[5], lambda[4]}, {lambda[5], lambda[1], lambda[3]}, {lambda[4], lambda[3], lambda[2]}};
    double w[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            w[i][j] = 0;
            for (int n = 0; n < 3; n++)
                w[i][j] += 0.5 * (l[i][n] * m[n][j] + m[i][n] * l[n][j]);
        }
    const double parts[TENSOR] = {w[0][0], w[1][1], w[2][2], w[1][2], w[0][2], w[0][1]};
    for (int i = 0; i < TENSOR; i++)
        gamma[i] = parts[i] + b[i];
}

/* The row solver's answer is on the law to rounding, for blocks as lopsided as
 * 1 : 1000, and reports the state it is in. */
static void row_is_solved_exactly(void **state)
{
    (void)state;
    struct rng rng = rng_start(5, 1);
    int seen[3] = {0};
    double worst = 0;
    for (int n = 0; n < 60000; n++) {
        bool plane = n & 1;
        double k[TENSOR], b[TENSOR], l[TENSOR], g[TENSOR], f[TENSOR];
        double mu = exp(rng_uniform(&rng, log(0.02), log(3.0)));
        draw_block(&rng, plane, n % 3 ? 4 : 1000, k);
        draw_tensor(&rng, plane, 1, b);
        add_identity(b, rng_uniform(&rng, -1, 0.3), plane);
        enum phase phase = drucker_prager_solve(k, b, mu, plane, l);
        seen[phase]++;
        strain(k, b, l, g);
        drucker_prager_root(g, l, mu, plane, f);
        /* Relative to the pair's size; a static state's exact zero costs half the digits of one of the two terms. */
        double size = tensor_norm(g) + tensor_norm(l) + tensor_norm(b);
        worst = fmax(worst, tensor_norm(f) / size);
        if (phase == PHASE_GAS)
            assert_true(tensor_norm(l) == 0 && tensor_trace(b) >= 0);
        if (phase == PHASE_STATIC)
            assert_true(tensor_norm(g) < 1e-12 * (1 + size));
    }
    for (int k = 0; k < 3; k++)
        assert_true(seen[k] > 1000);
    assert_true(worst < 1e-10);
}

static double departure(const double k[TENSOR], const double b[TENSOR], double mu, bool plane, const double l[TENSOR])
{
    double g[TENSOR], f[TENSOR];
    strain(k, b, l, g);
    drucker_prager_root(g, l, mu, plane, f);
    return pow(tensor_norm(f), 2);
}

/* Search by steps along axes and random directions, shrinking: knows nothing of the law but f. */
static void brute_force(struct rng *rng, const double k[TENSOR], const double b[TENSOR], double mu, bool plane, double l[TENSOR])
{
    memset(l, 0, TENSOR * sizeof *l);
    add_identity(l, 1, plane);
    double best = departure(k, b, mu, plane, l), size = 1;
    while (size > 1e-9) {
        bool better = false;
        for (int trial = 0; trial < 60; trial++) {
            double way[TENSOR], at[TENSOR];
            draw_tensor(rng, plane, 1, way);
            double norm = tensor_norm(way);
            for (int i = 0; i < TENSOR; i++)
                at[i] = l[i] + size * way[i] / norm;
            double value = departure(k, b, mu, plane, at);
            if (value < best) {
                best = value;
                memcpy(l, at, sizeof at);
                better = true;
            }
        }
        size *= better ? 1.3 : 0.7;
    }
}

/* Minimising |f_MFB|^2 (eq. 2.10) blindly ends at the row solver's answer. */
static void row_agrees_with_brute_force(void **state)
{
    (void)state;
    struct rng rng = rng_start(6, 1);
    int agreed = 0;
    enum { CASES = 60 };
    for (int n = 0; n < CASES; n++) {
        bool plane = n & 1;
        double k[TENSOR], b[TENSOR], l[TENSOR], found[TENSOR];
        draw_block(&rng, plane, 3, k);
        draw_tensor(&rng, plane, 1, b);
        add_identity(b, -0.4, plane);
        drucker_prager_solve(k, b, 0.5, plane, l);
        brute_force(&rng, k, b, 0.5, plane, found);
        double apart = 0;
        for (int i = 0; i < TENSOR; i++)
            apart = fmax(apart, fabs(found[i] - l[i]));
        agreed += apart < 1e-4;
    }
    assert_true(agreed >= CASES - 3); // a blind search may stop in a valley
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(root_function_vanishes_on_the_law),
        cmocka_unit_test(root_function_sees_every_departure),
        cmocka_unit_test(root_function_is_the_jordan_one),
        cmocka_unit_test(projection_is_nearest),
        cmocka_unit_test(row_is_solved_exactly),
        cmocka_unit_test(row_agrees_with_brute_force),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
