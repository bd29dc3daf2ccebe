/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Balances of whole worlds: momentum against the force on the base, angular
 * momentum, energy, images of a periodic box, lists against brute force. */
#include "engine.h"

#include "base/rng.h"
#include "measure/bulk.h"
#include "scenario/scenario.h"

static struct job_spec flow(int64_t n, int64_t nz, double slope_deg, double step_s)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = n;
    p->nz = nz;
    p->slope_deg = slope_deg;
    job.time.step_s = step_s;
    return job;
}

static struct dem *build(const struct job_spec *job)
{
    struct scree_error error = {0};
    struct dem *dem = NULL;
    must(job_check(job, 0, &error), &error);
    must(scenario_implementation("incline")->build(job, &(struct scenario_means){.threads = 1}, &dem, &error), &error);
    return dem;
}

/* F_base + weight = dP/dt at every step, to rounding: velocities at whole steps
 * change by half the forces of both ends. */
static void base_force_balances_momentum_at_every_step(void **state)
{
    (void)state;
    struct job_spec job = flow(5, 4, 24, 2.5e-7);
    struct dem *dem = build(&job);
    advance(dem, 60000); // the filling has landed on the base
    double force[3], momentum[3], gravity[3], worst = 0, largest = 0, taken[3], sum[3] = {0};
    scenario_implementation("incline")->gravity(&job, gravity);
    dem_take_base_force(dem, taken);
    struct bulk bulk;
    struct view view = look(dem);
    bulk_measure(&view, &bulk);
    memcpy(force, view.base_force, sizeof force);
    memcpy(momentum, bulk.momentum, sizeof momentum);
    for (int step = 0; step < 2000; step++) {
        advance(dem, 1);
        view = look(dem);
        bulk_measure(&view, &bulk);
        for (int a = 0; a < 3; a++) {
            double expect = job.time.step_s * (bulk.mass * gravity[a] - 0.5 * (force[a] + view.base_force[a]));
            worst = fmax(worst, fabs(bulk.momentum[a] - momentum[a] - expect));
            largest = fmax(largest, fabs(bulk.momentum[a]));
            sum[a] += view.base_force[a];
            force[a] = view.base_force[a];
            momentum[a] = bulk.momentum[a];
        }
    }
    assert_true(fabs(sum[2]) > 0 && largest > 0);
    assert_true(worst < 1e-13 * largest); // 1,000 terms of rounding at most
    dem_take_base_force(dem, taken);      // what is recorded is the mean over the same steps
    for (int a = 0; a < 3; a++)
        assert_true(fabs(taken[a] - sum[a] / 2000) < 1e-12 * fabs(sum[2] / 2000));
    dem_free(dem);
}

/* Linear and angular momentum of two colliding, spinning grains of different size. */
static void colliding_pair_keeps_momentum_and_angular_momentum(void **state)
{
    (void)state;
    struct dem_grain grains[2] = {
        {.position = {0, 0, 1e-3}, .velocity = {0.2, -0.1, -0.3}, .spin = {120, -300, 55}, .radius = 1e-3},
        {.position = {0, 0, -1.3e-3}, .velocity = {0.01, 0.02, 0.05}, .spin = {-40, 10, 90}, .radius = 1.3e-3}};
    grains[0].density = grains[1].density = 2530;
    struct dem_setup setup = {.step_s = 2.5e-7,
                              .grains = grains,
                              .grain_count = 2,
                              .material = material_preset_find("glass-beads-2mm")->values,
                              .floor_z = -INFINITY,
                              .threads = 1};
    struct dem *dem = NULL;
    struct scree_error error = {0};
    must(dem_create(&setup, &dem, &error), &error);
    double start[6] = {0}, size = 0;
    int touched = 0;
    for (int step = 0; step < 60; step++) {
        struct view view = look(dem);
        double now[6] = {0};
        touched |= view.contacts > 0;
        for (size_t i = 0; i < 2; i++) {
            const double *x = view.position[i], *v = view.velocity[i], *w = view.spin[i], m = v[3], inertia = w[3];
            const double cross[3] = {x[1] * v[2] - x[2] * v[1], x[2] * v[0] - x[0] * v[2], x[0] * v[1] - x[1] * v[0]};
            for (int a = 0; a < 3; a++) {
                now[a] += m * v[a];
                now[3 + a] += m * cross[a] + inertia * w[a];
                if (step == 0)
                    size += fabs(inertia * w[a]);
            }
        }
        if (step == 0)
            memcpy(start, now, sizeof start);
        for (int a = 0; a < 3; a++) {
            assert_true(fabs(now[a] - start[a]) < 1e-14 * 1e-5);
            assert_true(fabs(now[3 + a] - start[3 + a]) < 1e-12 * size);
        }
        advance(dem, 1);
    }
    assert_true(touched && look(dem).contacts == 0);
    dem_free(dem);
}

/* Work of gravity = kinetic + elastic + dissipated to 1e-3 over 0.05 s. The ledger's
 * viscous part is summed at one end of each step, so this holds at a step well
 * below the contact time; the error falls with the step. */
static void energy_ledger_closes(void **state)
{
    (void)state;
    double residual[2];
    for (int k = 0; k < 2; k++) {
        struct job_spec job = flow(4, 4, 24, k ? 5e-8 : 1e-7);
        job.record.energy.on = true;
        struct dem *dem = build(&job);
        advance(dem, (uint64_t)round(0.05 / job.time.step_s));
        struct view view = look(dem);
        struct bulk bulk;
        double row[ENERGY_COLUMNS];
        bulk_measure(&view, &bulk);
        energy_row(&view, &bulk, 0, row);
        residual[k] = fabs(row[9] / view.gravity_work);
        print_message("step %.2g s: work %.4g J, kinetic %.4g, elastic %.4g, residual %.2g of the work\n", job.time.step_s,
                      view.gravity_work, bulk.kinetic, bulk.elastic, row[9] / view.gravity_work);
        assert_true(view.dissipated_normal > 0 && view.dissipated_tangential > 0);
        assert_true(view.dissipated_tangential > 0.05 * view.gravity_work);
        dem_free(dem);
    }
    assert_true(residual[0] < 1e-3 && residual[1] < 1e-3);
}

/* Contacts by a search over all pairs and images; at a floor at floor_z, too. */
static size_t contacts_of_all(const struct view *v, double floor_z)
{
    size_t count = 0, all = v->moving + v->fixed;
    const int images_x = v->length[0] > 0 ? 2 : 0, images_y = v->length[1] > 0 ? 2 : 0;
    for (size_t i = 0; i < v->moving; i++) {
        for (size_t j = i + 1; j < all; j++)
            for (int sx = -images_x; sx <= images_x; sx++)
                for (int sy = -images_y; sy <= images_y; sy++) {
                    double x = v->position[j][0] - v->position[i][0] + sx * v->length[0];
                    double y = v->position[j][1] - v->position[i][1] + sy * v->length[1];
                    double z = v->position[j][2] - v->position[i][2], r = v->position[i][3] + v->position[j][3];
                    count += x * x + y * y + z * z <= r * r;
                }
        count += v->position[i][2] - v->position[i][3] <= floor_z;
    }
    return count;
}

/* Contacts found by the lists are those of a search over all pairs and images. */
static void lists_find_every_contact(void **state)
{
    (void)state;
    const int64_t sizes[][2] = {{6, 4}, {3, 3}, {2, 4}}; // the small boxes are met through several images
    for (int c = 0; c < 3; c++) {
        struct job_spec job = flow(sizes[c][0], sizes[c][1], 24, 2.5e-7);
        struct dem *dem = build(&job);
        size_t seen = 0;
        for (int look_at = 0; look_at < 600; look_at++) {
            advance(dem, 397);
            struct view v = look(dem);
            size_t count = contacts_of_all(&v, -2e-3);
            assert_int_equal(count, v.contacts);
            seen += count;
        }
        print_message("%zu contacts seen\n", seen);
        assert_true(seen > 50);
        dem_free(dem);
    }
}

/* Swarms that fly as one, so that their lists last, and meet from afar: open, and round a periodic box. */
static void lists_find_contacts_of_swarms_that_meet(void **state)
{
    (void)state;
    enum { SIDE = 5, SWARMS = 3 };
    static struct dem_grain grains[SWARMS * SIDE * SIDE * SIDE];
    const double way[SWARMS][3] = {{2, 0.3, 0}, {-2, 0, 0.2}, {0, 0, -1.5}},
                 start[SWARMS][3] = {{0, 0, 0}, {0.05, 0.002, 0}, {0.02, 0.004, 0.045}};
    struct rng rng = rng_start(3, 1);
    size_t n = 0;
    for (int s = 0; s < SWARMS; s++)
        for (int k = 0; k < SIDE * SIDE * SIDE; k++, n++) {
            const int cell[3] = {k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE};
            grains[n] = (struct dem_grain){.radius = 1e-3, .density = 2500};
            for (int a = 0; a < 3; a++) {
                grains[n].position[a] = start[s][a] + 2.5e-3 * cell[a] + rng_uniform(&rng, 0, 4e-4);
                grains[n].velocity[a] = way[s][a] + rng_uniform(&rng, -0.05, 0.05);
            }
        }
    for (int periodic = 0; periodic < 2; periodic++) {
        struct material_spec soft = material_preset_find("glass-beads-2mm")->values;
        struct dem *dem = NULL;
        struct scree_error error = {0};
        soft.young_Pa /= 1000;
        struct dem_setup setup = {
            .step_s = 4e-6, .grains = grains, .grain_count = n, .material = soft, .floor_z = -INFINITY, .threads = 1};
        setup.length[0] = setup.length[1] = periodic ? 0.08 : 0;
        must(dem_create(&setup, &dem, &error), &error);
        size_t seen = 0;
        for (int look_at = 0; look_at < 700; look_at++) {
            advance(dem, 17);
            struct view v = look(dem);
            size_t count = contacts_of_all(&v, -INFINITY);
            assert_int_equal(count, v.contacts);
            seen += count;
        }
        const struct dem_counts counts = dem_counts(dem);
        print_message("%zu contacts seen, %llu rebuilds in %d steps\n", seen, (unsigned long long)counts.rebuilds, 700 * 17);
        assert_true(seen > 1000);
        dem_free(dem);
    }
}

/* Shifting every grain by a part of the box is another picture of the same world. */
static void periodic_images_do_not_matter(void **state)
{
    (void)state;
    enum { N = 60 };
    struct dem_grain grains[N], moved[N];
    struct rng rng = rng_start(5, 9);
    const double box = 0.012, step = 2.5e-7;
    for (int k = 0; k < N; k++) { // a loose lattice with random velocities: a gas that collides
        memset(&grains[k], 0, sizeof grains[k]);
        grains[k].radius = 1e-3 * rng_uniform(&rng, 0.95, 1.05);
        grains[k].density = 2530;
        grains[k].position[0] = 0.003 * (k % 4) + 0.0012;
        grains[k].position[1] = 0.003 * (k / 4 % 4) + 0.0012;
        grains[k].position[2] = 0.003 * (k / 16) + 0.0012;
        for (int a = 0; a < 3; a++)
            grains[k].velocity[a] = rng_uniform(&rng, -0.5, 0.5);
        moved[k] = grains[k];
        moved[k].position[0] += 0.0075; // leaves the box; exact enough in binary to compare below
        moved[k].position[1] += 0.25 * box;
        moved[k].position[2] -= 0.0031;
    }
    struct dem_setup setup = {.step_s = step,
                              .length = {box, box, box},
                              .grain_count = N,
                              .material = material_preset_find("glass-beads-2mm")->values,
                              .floor_z = -INFINITY,
                              .threads = 1};
    struct dem *one = NULL, *two = NULL;
    struct scree_error error = {0};
    setup.grains = grains;
    must(dem_create(&setup, &one, &error), &error);
    setup.grains = moved;
    must(dem_create(&setup, &two, &error), &error);
    /* Rounding differs, and a granular gas amplifies it: as long as that is small, states agree. */
    size_t changed = 0;
    for (int k = 0; k < 100; k++) {
        advance(one, 100);
        advance(two, 100);
        struct view a = look(one), b = look(two);
        double va[N][3], vb[N][3];
        for (size_t i = 0; i < N; i++) {
            memcpy(va[a.id[i]], a.velocity[i], sizeof va[0]);
            memcpy(vb[b.id[i]], b.velocity[i], sizeof vb[0]);
        }
        for (int i = 0; i < N; i++)
            for (int d = 0; d < 3; d++)
                assert_true(fabs(va[i][d] - vb[i][d]) < 1e-6);
        changed = 0;
        for (int i = 0; i < N; i++)
            changed += fabs(va[i][0] - grains[i].velocity[0]) > 1e-3;
    }
    assert_true(changed > N / 3); // they did meet, some across the edges
    dem_free(one);
    dem_free(two);
}

/* Over a time in which momentum hardly changes the flow's weight rests on its base. */
static void mean_normal_force_is_the_weight(void **state)
{
    (void)state;
    struct job_spec job = flow(6, 5, 22, 2.5e-7);
    struct dem *dem = build(&job);
    advance(dem, 800000); // 0.2 s: landed, flowing
    double mean[3], gravity[3];
    struct bulk bulk;
    dem_take_base_force(dem, mean);
    advance(dem, 1600000);
    dem_take_base_force(dem, mean);
    struct view view = look(dem);
    bulk_measure(&view, &bulk);
    scenario_implementation("incline")->gravity(&job, gravity);
    print_message("mean normal force over weight: %.4f\n", mean[2] / (bulk.mass * gravity[2]));
    assert_true(fabs(mean[2] / (bulk.mass * gravity[2]) - 1) < 0.01);
    dem_free(dem);
}

/* Fixed grains: 1.1 to 1.6 a diameter squared, no hole to the floor wider than 0.6 d. */
static void base_is_rough_and_closed(void **state)
{
    (void)state;
    for (int64_t seed = 1; seed <= 3; seed++) {
        struct job_spec job = flow(10, 1, 24, 2.5e-7);
        ((struct incline_params *)(void *)job.params)->base_seed = seed;
        struct dem *dem = build(&job);
        struct view v = look(dem);
        double density = (double)v.fixed / 100, widest = 0;
        for (int gx = 0; gx < 100; gx++)
            for (int gy = 0; gy < 100; gy++) {
                double nearest = INFINITY;
                for (size_t i = v.moving; i < v.moving + v.fixed; i++) {
                    double x = v.position[i][0] - gx * 2e-4, y = v.position[i][1] - gy * 2e-4, z = v.position[i][2];
                    x -= 0.02 * round(x / 0.02);
                    y -= 0.02 * round(y / 0.02);
                    nearest = fmin(nearest, sqrt(x * x + y * y + z * z) - v.position[i][3]);
                }
                widest = fmax(widest, nearest);
            }
        print_message("base %d: %.2f grains a d^2, widest hole %.2f d\n", (int)seed, density, widest / 2e-3);
        assert_true(density >= 1.1 && density <= 1.6);
        assert_true(widest < 0.6 * 2e-3);
        dem_free(dem);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(base_force_balances_momentum_at_every_step),
        cmocka_unit_test(colliding_pair_keeps_momentum_and_angular_momentum),
        cmocka_unit_test(energy_ledger_closes),
        cmocka_unit_test(lists_find_every_contact),
        cmocka_unit_test(lists_find_contacts_of_swarms_that_meet),
        cmocka_unit_test(periodic_images_do_not_matter),
        cmocka_unit_test(mean_normal_force_is_the_weight),
        cmocka_unit_test(base_is_rough_and_closed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
