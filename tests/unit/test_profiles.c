/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Profiles, collisions, what they amount to and what models make of them, on
 * grains and impacts whose numbers are known (S0-08, 25, 26). */
#include "unit.h"

#include "base/rng.h"
#include "measure/connect.h"
#include "measure/models.h"
#include "measure/profiles.h"

/* Everything is in a box of AREA with grains of diameter D. */
#define D    2e-3
#define AREA (25 * D * D)
enum { ROWS = 40000, LAYERS = 6, HEIGHTS = 16 * LAYERS, SUMS = PROFILES_HEAD + PROFILES_SUMS * HEIGHTS };

static struct {
    double position[ROWS][4], velocity[ROWS][4];
    uint32_t id[ROWS], root[ROWS + 1];
    struct view view;
    double sums[SUMS];
    struct profile profile[HEIGHTS];
} w;
static const double everywhere[2] = {-INFINITY, INFINITY};

static void begin(void)
{
    memset(&w, 0, sizeof w);
    w.view = (struct view){.id = w.id, .position = (const double(*)[4])w.position, .velocity = (const double(*)[4])w.velocity};
}

static void add_grain(double z, double ux, double uy, double uz)
{
    size_t k = w.view.moving++;
    const double x[4] = {0, 0, z, 0.5 * D}, u[4] = {ux, uy, uz, 1};
    assert_true(k < ROWS);
    memcpy(w.position[k], x, sizeof x);
    memcpy(w.velocity[k], u, sizeof u);
}

static struct coarse_grid add_up(double base_z)
{
    struct coarse_grid grid = coarse_grid_of(base_z, D, AREA, LAYERS);
    connect_base(&w.view, CONNECT_OVERLAP, w.root);
    profiles_add_view(&grid, everywhere, &w.view, w.root, w.sums);
    profiles_of(&grid, w.sums, w.profile);
    return grid;
}

static double height_of(size_t k)
{
    return -7.0 / 8 * D + (double)k * D / 4;
}
static const double volume = M_PI / 6 * D * D * D;

/* S5: 16 n_z heights, d/4 apart, from -7d/8. Eq. 34 with the 1/d that the print lacks: a grain's weight integrates to
 * 1 / A, and with K = 3 it ends where the print says. */
static void one_grain_spreads_to_a_known_gaussian(void **state)
{
    (void)state;
    begin();
    double at = 4.3 * D, sum = 0;
    add_grain(at, 0.5, 0, 0);
    add_up(0);
    for (size_t k = 0; k < HEIGHTS; k++) {
        double x = (height_of(k) - at) / D;
        double expect = fabs(x) < 3 ? volume * sqrt(2 / M_PI) * exp(-2 * x * x) / (AREA * D * erf(3 * sqrt(2))) : 0;
        near(w.profile[k].z, height_of(k), 1e-15);
        near(w.profile[k].fraction, expect, 1e-14 * volume / (AREA * D));
        near(w.profile[k].velocity[0], fabs(x) < 3 ? 0.5 : 0, 1e-14);
        sum += w.profile[k].fraction * D / 4; // a Gaussian's sum at d/4 is its integral
    }
    near(sum / (volume / AREA), 1, 1e-7);
}

/* Mass and momentum of any grains: the integrals are theirs, however many samples there are. */
static void mass_and_momentum_are_kept(void **state)
{
    (void)state;
    begin();
    struct rng rng = rng_start(3, 1);
    double mass = 0, momentum = 0, all = 0, flow = 0;
    for (int k = 0; k < 500; k++) {
        double u = rng_uniform(&rng, -1, 2);
        add_grain(rng_uniform(&rng, 3 * D, 18 * D), u, 0, 0);
        all += volume / AREA;
        flow += volume * u / AREA;
    }
    add_up(0);
    add_up(0);
    add_up(0);
    for (size_t k = 0; k < HEIGHTS; k++) {
        mass += w.profile[k].fraction * D / 4;
        momentum += w.profile[k].fraction * w.profile[k].velocity[0] * D / 4;
    }
    near(mass / all, 1, 1e-6);
    near(momentum / flow, 1, 1e-6);
}

/* Layers d/8 apart of known number: uniform phi in the middle, u as given, T none. */
static void a_lattice_has_its_fraction_and_velocity(void **state)
{
    (void)state;
    begin();
    for (int layer = 0; layer < 160; layer++)
        for (int k = 0; k < 3; k++)
            add_grain(layer * D / 8, 0.3, -0.1, 0.02);
    add_up(0);
    double phi = 3 * volume / (AREA * D / 8);
    for (size_t k = 20; k < 70; k++) {
        near(w.profile[k].fraction / phi, 1, 1e-6);
        near(w.profile[k].velocity[0], 0.3, 1e-12);
        near(w.profile[k].velocity[1], -0.1, 1e-12);
        near(w.profile[k].velocity[2], 0.02, 1e-12);
        near(w.profile[k].temperature, 0, 1e-12);
    }
}

/* Eq. 37 counts shear within the kernel: u' = g makes T too large by g^2 d^2 / 12 (S0-25). */
static void shear_biases_temperature_as_documented(void **state)
{
    (void)state;
    begin();
    double rate = 40, bias = rate * rate * D * D / 12;
    for (int layer = 0; layer < 320; layer++)
        add_grain(layer * D / 16, rate * layer * D / 16, 0, 0);
    add_up(0);
    for (size_t k = 20; k < 70; k++) {
        near(w.profile[k].velocity[0], rate * height_of(k), 1e-6 * rate * D);
        near(w.profile[k].temperature / bias, 1, 2e-6); // K = 3 takes a little off the variance
    }
}

/* A gas of known T, moving as a whole. */
static void a_gas_has_its_temperature(void **state)
{
    (void)state;
    begin();
    struct rng rng = rng_start(11, 1);
    double temperature = 0.01, width = sqrt(12 * temperature); // each component uniform: variance T
    for (int k = 0; k < ROWS; k++)
        add_grain(rng_uniform(&rng, 0, 20 * D), 0.7 + rng_uniform(&rng, -0.5, 0.5) * width, rng_uniform(&rng, -0.5, 0.5) * width,
                  rng_uniform(&rng, -0.5, 0.5) * width);
    add_up(0);
    double phi = ROWS * volume / (AREA * 20 * D);
    for (size_t k = 20; k < 70; k++) {
        near(w.profile[k].temperature / temperature, 1, 0.05);
        near(w.profile[k].velocity[0], 0.7, 0.02);
        near(w.profile[k].fraction / phi, 1, 0.15);
    }
}

/* Grains of the base count in P_C alone; what lies outside the region counts in nothing. */
static void base_and_region_count_as_published(void **state)
{
    (void)state;
    begin();
    for (int k = 0; k < 8; k++)
        add_grain(5 * D, 1, 0, 0);
    for (size_t k = 4; k < 8; k++)
        w.position[k][1] = -1; // not in the half that is measured
    w.view.moving = 7;
    w.view.fixed = 1; // the eighth is of the base
    w.position[7][1] = 0;
    w.position[7][2] = 5 * D;
    const double half[2] = {-0.5, 0.5};
    struct coarse_grid grid = coarse_grid_of(0, D, AREA, LAYERS);
    connect_base(&w.view, CONNECT_OVERLAP, w.root);
    profiles_add_view(&grid, half, &w.view, w.root, w.sums);
    profiles_of(&grid, w.sums, w.profile);
    double sum = 0;
    for (size_t k = 0; k < HEIGHTS; k++)
        sum += w.profile[k].fraction * D / 4;
    near(sum / (4 * volume / AREA), 1, 1e-6); // four of seven moving ones, not the base's
    near(w.profile[23].joined, 0.2, 1e-12);   // one of five grains is of the base
}

/* Eqs 39-41 with K infinite: density, and means of squares, of a list of impacts. */
static void impacts_have_their_density_and_speeds(void **state)
{
    (void)state;
    begin();
    enum { N = 32000 };
    static struct view_formation impacts[N + 3];
    struct coarse_grid grid = coarse_grid_of(0, D, AREA, LAYERS);
    double seconds = 0.25;
    for (int k = 0; k < N; k++) { // evenly over 0 .. 20 d, two speeds in turn
        impacts[k].place[2] = (k + 0.5) / N * 20 * D;
        impacts[k].approach = k % 2 ? 0.1 : 0.3;
        impacts[k].tangential[0] = 0.2;
        impacts[k].tangential[1] = k % 2 ? -0.1 : 0.1;
    }
    impacts[N] = (struct view_formation){.place = {0, 9, 10 * D}, .approach = 100};                     // not in the region
    impacts[N + 1] = (struct view_formation){.place = {0, 0, 10 * D}, .approach = 100, .b = VIEW_WALL}; // on a side wall
    impacts[N + 2] = (struct view_formation){.place = {0, 0, -0.5 * D}, .b = VIEW_WALL, .fixed = 1};    // on the floor: counts
    const double region[2] = {-1, 1};
    profiles_add_formations(&grid, region, impacts, N / 2, w.sums);
    profiles_add_formations(&grid, region, impacts + N / 2, N / 2 + 3, w.sums);
    w.sums[PROFILES_TIME] = seconds;
    profiles_of(&grid, w.sums, w.profile);
    double density = N / (AREA * 20 * D) / seconds, sum = 0;
    for (size_t k = 20; k < 70; k++) {
        near(w.profile[k].impacts / density, 1, 1e-6);
        near(w.profile[k].normal2, 0.5 * (0.01 + 0.09), 1e-6);
        near(w.profile[k].tangential2, 0.05, 1e-6);
    }
    static struct profile other[HEIGHTS];
    memcpy(other, w.profile, sizeof other);
    memset(w.sums, 0, sizeof w.sums);
    profiles_add_formations(&grid, region, impacts + N + 2, 1, w.sums);
    w.sums[PROFILES_TIME] = seconds;
    profiles_of(&grid, w.sums, w.profile);
    for (size_t k = 0; k < HEIGHTS; k++) { // K infinite: also where the kinematic profiles have ended
        double x = (height_of(k) + 0.5 * D) / D;
        near(w.profile[k].impacts, sqrt(2 / M_PI) * exp(-2 * x * x) / (AREA * D * seconds), 1e-9 / (AREA * D));
        sum += w.profile[k].impacts;
        assert_true(other[k].impacts >= w.profile[k].impacts * 0.999);
    }
    assert_true(w.profile[16].impacts > 0 && sum > 0);
}

static void nothing_at_all_is_nothing(void **state)
{
    (void)state;
    begin();
    struct coarse_grid grid = coarse_grid_of(0, D, AREA, LAYERS);
    struct profile_bulk bulk;
    struct model_power power;
    profiles_of(&grid, w.sums, w.profile);
    profiles_bulk(&grid, w.profile, 0, 2530, 9, &bulk);
    models_power(&grid, w.profile, &bulk, 0, 2530, &power);
    const double *numbers = (const double *)&bulk, *models = (const double *)&power;
    for (size_t k = 0; k < sizeof bulk / sizeof *numbers; k++)
        assert_true(numbers[k] == 0);
    for (size_t k = 0; k < sizeof power / sizeof *models; k++)
        assert_true(models[k] == 0);
}

/* ---- what profiles amount to ---- */

/* A slab of phi = 0.56 from the base to 12 d, put straight into the profile, sheared at a constant rate. */
static struct coarse_grid slab(double base_z, double rate)
{
    struct coarse_grid grid = coarse_grid_of(base_z, D, AREA, LAYERS);
    memset(w.profile, 0, sizeof w.profile);
    for (size_t k = 0; k < HEIGHTS; k++) {
        double z = coarse_height(&grid, k) - base_z;
        if (z > 0 && z < 12 * D)
            w.profile[k] = (struct profile){.z = 0, .fraction = 0.56, .temperature = 0.004};
        w.profile[k].z = z + base_z;
        w.profile[k].velocity[0] = z > 0 ? rate * z : 0;
    }
    return grid;
}

static void depth_means_and_inertial_numbers(void **state)
{
    (void)state;
    double rate = 30, g = 9, density = 2530, base = 0.01;
    struct coarse_grid grid = slab(base, rate);
    struct profile_bulk b;
    profiles_bulk(&grid, w.profile, base, density, g, &b);
    near(b.h1 / (12 * D), 1, 1e-9);
    near(b.h2 / (12 * D), 1, 1e-9); // phi falls from 0.56 to 0 between 11.875 and 12.125 d
    near(b.fraction, 0.56, 1e-12);
    near(b.velocity, rate * 6 * D, 1e-9);
    near(b.temperature, 0.004, 1e-12);
    near(b.pressure / (density * g * 0.56 * 12 * D), 1, 1e-9);
    near(b.inertial / (2.5 * rate * 6 * D * D / (12 * D * sqrt(0.56 * g * 12 * D))), 1, 1e-9);
    near(b.local / (rate * D * sqrt(1 / (g * 0.56 * 6 * D))), 1, 0.02); // the height next to the middle is d/8 off
    near(b.shear / (sqrt(0.004) / (rate * D)), 1, 0.03);                // the lowest height has half the slope
}

/* Bagnold's flow: u = (2/3) I sqrt(phi g) (h^1.5 - (h - z)^1.5) / d has that I everywhere; both definitions find it. */
static void both_inertial_numbers_are_bagnolds(void **state)
{
    (void)state;
    double inertial = 0.2, g = 9, h = 12 * D;
    struct coarse_grid grid = slab(0, 0);
    for (size_t k = 0; k < HEIGHTS; k++) {
        double z = w.profile[k].z;
        w.profile[k].velocity[0] = 2.0 / 3 * inertial * sqrt(0.56 * g) / D * (pow(h, 1.5) - pow(fmax(0, h - fmax(0, z)), 1.5));
    }
    struct profile_bulk b;
    profiles_bulk(&grid, w.profile, 0, 2530, g, &b);
    near(b.inertial / inertial, 1, 0.01);
    near(b.local / inertial, 1, 0.02);
}

/* ---- models ---- */

/* S0-08: shares and distances are integrals over a sphere. */
static void geometry_averages_are_the_constants(void **state)
{
    (void)state;
    double distance = 0, passed = 0;
    for (int k = 0; k < 100000; k++) {
        double angle = (k + 0.5) / 100000 * M_PI / 2, share = sin(angle) * M_PI / 2 / 100000;
        distance += cos(angle) * share;
        passed += cos(angle) * cos(angle) * share;
    }
    near(1 / distance, MODELS_CONTACTS, 1e-8);
    near(passed, MODELS_CONTACT_SHARE, 1e-8);
    near(pow(MODELS_CONTACT_SHARE, MODELS_CONTACTS), 1.0 / 9, 1e-15);
}

/* Uniform impacts, P_C = 1: A n J^2 / 3 times the integral of 9^(-z/d) above the base, four times that below. */
static void models_have_their_closed_forms(void **state)
{
    (void)state;
    double rate = 30, density = 2530, n = 1e12, speed2 = 0.02;
    struct coarse_grid grid = slab(0, rate);
    for (size_t k = 0; k < HEIGHTS; k++) {
        w.profile[k].impacts = n;
        w.profile[k].normal2 = speed2;
        w.profile[k].joined = 1;
        w.profile[k].temperature = 0.004;
        w.profile[k].fraction = 0.56;
        w.profile[k].velocity[0] = 1 + rate * w.profile[k].z;
    }
    struct profile_bulk bulk = {.pressure = 700, .fraction = 0.5, .velocity = 3, .temperature = 0.01};
    struct model_power p;
    models_power(&grid, w.profile, &bulk, 0, density, &p);
    double mass = density * volume, above = 0, attenuated = 0;
    for (size_t k = 0; k < HEIGHTS; k++) {
        double z = height_of(k) / D;
        above += (z < 0 ? 4 : pow(9, -z)) * D / 4;
        attenuated += exp(-fmax(0, z)) * D / 4;
    }
    near(above / (D * (4 * 1 + 1 / log(9))), 1, 0.01); // heights d/4 apart sum what the integral is
    near(p.minimal / (AREA * n * mass * mass * speed2 / 3 * above), 1, 1e-12);
    near(p.attenuated / (AREA * n * 4 * mass * mass * 0.004 / 3 * attenuated), 1, 1e-12);
    near(p.pressure / (AREA * 490000), 1, 1e-12);
    double u = 1 + rate * 0.5 * D, layer = AREA * M_PI / 6 * density * density * D * D * D;
    near(p.thin / (0.5 * layer * (27 + 9 * 0.01)), 1, 1e-9);
    near(p.thick / (0.56 * layer * (u * u * u + 3 * u * 0.004)), 1, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_grain_spreads_to_a_known_gaussian),
        cmocka_unit_test(mass_and_momentum_are_kept),
        cmocka_unit_test(a_lattice_has_its_fraction_and_velocity),
        cmocka_unit_test(shear_biases_temperature_as_documented),
        cmocka_unit_test(a_gas_has_its_temperature),
        cmocka_unit_test(base_and_region_count_as_published),
        cmocka_unit_test(impacts_have_their_density_and_speeds),
        cmocka_unit_test(nothing_at_all_is_nothing),
        cmocka_unit_test(depth_means_and_inertial_numbers),
        cmocka_unit_test(both_inertial_numbers_are_bagnolds),
        cmocka_unit_test(geometry_averages_are_the_constants),
        cmocka_unit_test(models_have_their_closed_forms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
