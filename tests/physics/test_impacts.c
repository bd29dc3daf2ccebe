/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the engine reports of contacts: each is logged once, with the relative
 * velocity of closed forms, the same on any number of threads; the network's
 * forces on a grain are what accelerates it. */
#include "engine.h"

#include "scenario/scenario.h"

static struct dem *two(struct dem_grain grains[2], const struct material_spec *material, double length)
{
    struct scree_error error = {0};
    struct dem *dem = NULL;
    grains[0].density = grains[1].density = 2530;
    struct dem_setup setup = {
        .step_s = 2.5e-7, .grains = grains, .grain_count = 2, .material = *material, .floor_z = -INFINITY, .threads = 1};
    setup.length[0] = setup.length[1] = length; // 0: unbounded
    must(dem_create(&setup, &dem, &error), &error);
    dem_log_formations(dem, true);
    return dem;
}

/* Two spinning spheres that meet: one record, at the first step with overlap, with the closed form's velocities
 * (eqs 4 and 8 with the minus of the errata), ids and place; nothing while they stay in touch, nothing after. */
static void a_meeting_is_logged_once_with_its_velocities(void **state)
{
    (void)state;
    struct material_spec m = material_preset_find("glass-beads-2mm")->values;
    double gap = 3e-6, closing = 0.37;
    struct dem_grain grains[2] = {
        {.position = {0, 0, 1e-3 + gap}, .velocity = {0.2, 0, -0.3}, .spin = {120, 0, 55}, .radius = 1e-3},
        {.position = {0, 0, -1.2e-3}, .velocity = {0, -0.1, 0.07}, .spin = {-40, 10, 90}, .radius = 1.2e-3}};
    struct dem *dem = two(grains, &m, 0);
    size_t seen = 0;
    for (int step = 0; step < 400; step++) {
        const struct view_formation *f = NULL;
        advance(dem, 1);
        size_t count = dem_take_formations(dem, &f);
        if (count == 0)
            continue;
        assert_int_equal(count, 1);
        assert_int_equal(seen++, 0);
        double sign = f->a == 0 ? 1 : -1; // of velocities relative to the one named first
        assert_int_equal(f->a + f->b, 1);
        assert_int_equal(f->fixed, 0);
        near(f->time_s, ceil(gap / closing / 2.5e-7) * 2.5e-7, 1e-12);
        near(f->approach, closing, 5e-4);
        /* Point of 0 that touches: v + w x (-r z); of 1: v + w x (r z). They move by 0.2 % of a radius before. */
        double across[3] = {0.2 - 0 * 1e-3 - 10 * 1.2e-3, 120e-3 + 0.1 - 40 * 1.2e-3, 0};
        for (int a = 0; a < 3; a++)
            near(sign * f->tangential[a], across[a], 1e-3);
        near(sign * f->normal[2], -1, 1e-4);
        near(f->place[2], 0.07 * f->time_s, 2e-7);
    }
    assert_int_equal(seen, 1);
    dem_free(dem);
}

/* A contact that forms again is a new one; and one through a periodic face is one contact, placed inside the box. */
static void a_second_meeting_is_a_new_one(void **state)
{
    (void)state;
    struct material_spec m = material_preset_find("glass-beads-2mm")->values;
    m.beta_s = 0; // they part at the speed at which they met, and meet again at the other face
    double length = 5e-3;
    struct dem_grain grains[2] = {{.position = {1e-3, 1e-3, 0}, .velocity = {-1, 0, 0}, .radius = 1e-3},
                                  {.position = {4e-3, 1e-3, 0}, .velocity = {1, 0, 0}, .radius = 1e-3}};
    struct dem *dem = two(grains, &m, length);
    double at[4];
    int seen = 0;
    for (int step = 0; step < 8000 && seen < 4; step++) {
        const struct view_formation *f = NULL;
        advance(dem, 1);
        if (dem_take_formations(dem, &f) == 0)
            continue;
        at[seen++] = f->time_s;
        near(f->approach, 2, 1e-3);
        assert_true(f->place[0] >= 0 && f->place[0] < length);
        double place = seen % 2 ? fmin(f->place[0], length - f->place[0]) : fabs(f->place[0] - 0.5 * length);
        near(place, 0, 1e-5); // across the face first, then in the middle
    }
    assert_int_equal(seen, 4);
    near(at[1] - at[0], 0.5e-3, 2e-5); // 1 mm of free way at 2 m/s, and the contact's 5 us
    near(at[3] - at[1], 1e-3, 4e-5);
    dem_free(dem);
}

static struct dem *flow(int threads, double slope_deg)
{
    struct scree_error error = {0};
    struct job_spec job;
    struct dem *dem = NULL;
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = 6;
    p->nz = 4;
    p->slope_deg = slope_deg;
    must(job_check(&job, 0, &error), &error);
    must(scenario_implementation("incline")->build(&job, &(struct scenario_means){.threads = threads}, &dem, &error), &error);
    dem_log_formations(dem, true);
    return dem;
}

enum { KEPT = 200000 };
static struct view_formation logs[2][KEPT];

/* The log as the world takes it, `slice` steps at a time. */
static size_t log_of(int threads, uint64_t slice, struct view_formation *log)
{
    struct dem *dem = flow(threads, 25);
    size_t count = 0;
    for (uint64_t step = 0; step < 80000; step += slice) {
        const struct view_formation *f = NULL;
        advance(dem, slice);
        size_t more = dem_take_formations(dem, &f);
        assert_true(count + more <= KEPT);
        if (more > 0)
            memcpy(log + count, f, more * sizeof *log);
        count += more;
    }
    dem_free(dem);
    return count;
}

static void threads_and_slices_do_not_show_in_the_log(void **state)
{
    (void)state;
    size_t one = log_of(1, 1000, logs[0]), other = log_of(3, 160, logs[1]);
    assert_true(one > 200);
    assert_int_equal(one, other);
    for (size_t k = 0; k < one; k++) {
        const struct view_formation *a = &logs[0][k], *b = &logs[1][k];
        assert_int_equal(a->a, b->a);
        assert_int_equal(a->b, b->b);
        assert_true(a->time_s == b->time_s && a->approach == b->approach);
        assert_memory_equal(a->place, b->place, sizeof a->place);
        assert_memory_equal(a->tangential, b->tangential, sizeof a->tangential);
    }
}

/* Step by step: a pair that touches now and did not before is in the log of that step, and nothing else is. */
static void the_log_is_what_views_show(void **state)
{
    (void)state;
    enum { GRAINS = 400, PAIRS = GRAINS * GRAINS };
    static uint8_t touched[2][PAIRS];
    struct dem *dem = flow(1, 25);
    size_t formed = 0;
    const struct view_formation *f = NULL;
    advance(dem, 60000);
    for (int step = 0; step < 3000; step++) {
        uint8_t *now = touched[step % 2], *before = touched[1 - step % 2];
        size_t fresh = 0, count;
        advance(dem, 1);
        struct view view = look(dem);
        assert_true(view.moving + view.fixed <= GRAINS);
        memset(now, 0, PAIRS);
        count = dem_take_formations(dem, &f);
        for (size_t k = 0; k < view.contacts; k++) {
            const struct view_contact *c = &view.contact[k];
            if (c->b >= VIEW_WALL)
                continue;
            uint32_t i = view.id[c->a], j = view.id[c->b];
            size_t pair = (i < j ? i : j) * GRAINS + (i < j ? j : i);
            now[pair] = 1;
            fresh += !before[pair];
        }
        for (size_t k = 0; k < count && step > 0; k++) {
            size_t pair = (f[k].a < f[k].b ? f[k].a : f[k].b) * GRAINS + (f[k].a < f[k].b ? f[k].b : f[k].a);
            if (f[k].b >= VIEW_WALL)
                continue;
            assert_true(now[pair] && !before[pair]);
            formed++;
            fresh--;
        }
        assert_true(step == 0 || fresh == 0);
    }
    assert_true(formed > 10);
    dem_free(dem);
}

/* Newton: the contacts' forces and gravity are each grain's mass times the change of its velocity over a step
 * (velocities of whole steps change by half the forces of both ends). */
static void the_networks_forces_accelerate_each_grain(void **state)
{
    (void)state;
    enum { GRAINS = 400 };
    static double force[2][GRAINS][3], velocity[GRAINS][3];
    struct dem *dem = flow(1, 25);
    double worst = 0, largest = 0;
    advance(dem, 60000);
    for (int step = 0; step < 200; step++) {
        advance(dem, 1);
        struct view view = look(dem);
        double(*now)[3] = force[step % 2], (*then)[3] = force[1 - step % 2];
        memset(now, 0, sizeof force[0]);
        for (size_t k = 0; k < view.contacts; k++) {
            const struct view_contact *c = &view.contact[k];
            double across = 0;
            for (int a = 0; a < 3; a++) {
                now[view.id[c->a]][a] -= c->force[a];
                if (c->b < VIEW_WALL)
                    now[view.id[c->b]][a] += c->force[a];
                across += c->force[a] * c->normal[a];
            }
            near(across, c->force_normal, 1e-12 + 1e-9 * fabs(across));
        }
        for (size_t i = 0; i < view.moving; i++) {
            uint32_t id = view.id[i];
            for (int a = 0; a < 3; a++) {
                double u = view.velocity[i][a], m = view.velocity[i][3];
                double expect = view.step_s * (view.gravity[a] + 0.5 * (now[id][a] + then[id][a]) / m);
                if (step > 0) {
                    worst = fmax(worst, fabs(u - velocity[id][a] - expect));
                    largest = fmax(largest, fabs(expect));
                }
                velocity[id][a] = u;
            }
        }
    }
    assert_true(largest > 1e-3);
    assert_true(worst < 1e-12);
    dem_free(dem);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_meeting_is_logged_once_with_its_velocities), cmocka_unit_test(a_second_meeting_is_a_new_one),
        cmocka_unit_test(threads_and_slices_do_not_show_in_the_log),    cmocka_unit_test(the_log_is_what_views_show),
        cmocka_unit_test(the_networks_forces_accelerate_each_grain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
