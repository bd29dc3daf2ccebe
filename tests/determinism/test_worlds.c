/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds as the service runs them: the same chunks and numbers however they are sliced, threaded, forked or restarted. */
#include "unit.h"

#include <stdio.h>
#include <unistd.h>

#include "scree.h"
#include "spec/scenarios.h"

/* Everything that was put, stream by stream in the order of the chunks. */
struct heard {
    uint64_t hash, chunks;
};

static enum scree_status put(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct heard *heard = context;
    (void)err;
    const uint64_t *words = (const uint64_t *)(const void *)chunk->values;
    uint64_t sum = chunk->seq * 31 + chunk->rows;
    for (size_t k = 0; k < chunk->rows * chunk->stream->column_count; k++)
        sum = (sum ^ words[k]) * 0x100000001b3u;
    for (const char *name = chunk->stream->name; *name; name++)
        sum = (sum ^ (uint64_t)*name) * 0x100000001b3u;
    heard->hash += sum; // streams may take turns differently; chunks may not differ
    heard->chunks++;
    return SCREE_OK;
}

typedef void set_up(struct job_spec *job);

struct job_of {
    set_up *of;
    uint64_t middle; // a step at which much goes on
};

static void collapse(struct job_spec *job)
{
    job_defaults(job, &scenario_collapse_fields);
    struct collapse_params *p = (struct collapse_params *)(void *)job->params;
    p->cell_m = 0.03;
    p->cell_height_m = 0.0149;
    p->gate_wait_s = 0.01;
    p->slope_deg = 10;
    p->continuum.points = 2;
    p->continuum.law = LAW_MU_I;
    p->continuum.mu = 0.38;
    job->time.end_s = 0.1;
    job->record.snapshots.on = true;
    job->record.snapshots.every_s = 0.05;
    job->record.bulk.every_s = 0.01;
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

/* An endless layer that begins to flow, with frames of its surface. */
static void layer(struct job_spec *job)
{
    job_defaults(job, &scenario_layer_fields);
    job->time.end_s = 0.2;
    job->record.surface.every_s = 0.02;
    job->record.bulk.every_s = 0.01;
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

/* Crosses in the air, then in contact with each other and the walls, and a gate that rubs while it goes. */
static void dam_break(struct job_spec *job)
{
    job_defaults(job, &scenario_dam_break_fields);
    struct dam_break_params *p = (struct dam_break_params *)(void *)job->params;
    p->count = 8;
    p->length_m = 0.12;
    p->width_m = p->column_m = 0.04;
    p->settle_s = 0.12;
    p->gate_m_s2 = 43;
    job->time.step_s = 4e-6;
    job->time.end_s = 0.16;
    job->record.snapshots.on = true;
    job->record.snapshots.every_s = 0.02;
    job->record.views.on = true;
    job->record.views.every_s = 0.01;
    job->record.forces.on = true;
    job->record.forces.every_s = 0.01;
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

/* Beads leave a hopper, past the rim of its hole, and fall to the floor. */
static void hopper(struct job_spec *job)
{
    job_defaults(job, &scenario_hopper_fields);
    struct hopper_params *p = (struct hopper_params *)(void *)job->params;
    p->count = 40;
    p->floor_m = 0.03;
    p->side_m = 0.012;
    p->hole_m = 0.008;
    p->height_m = 0.01;
    p->settle_s = 0.05;
    job->rigid.stiffness /= 1000;
    job->rigid.stiffness_t /= 1000;
    job->rigid.rate_t /= 32;
    job->time.step_s = 1.5e-5;
    job->time.end_s = 0.12;
    job->record.basal_force.every_s = 3e-3;
    job->record.bulk.every_s = 3e-3;
    job->record.heap.every_s = 3e-3;
    job->record.views = (struct record_views){true, 6e-3, 3};
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

/* A sphere that rocks long enough to be fitted. */
static void rolling(struct job_spec *job)
{
    job_defaults(job, &scenario_rolling_fields);
    job->material.young_Pa /= 1e5;
    job->time.step_s = 2.5e-5;
    job->time.end_s = 0.2;
    job->record.rolling.every_s = 2e-4;
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

static void impact(struct job_spec *job)
{
    job_defaults(job, &scenario_collision_fields);
    job->time.step_s = 1e-9;
    job->record.snapshots.on = true;
    job->record.snapshots.every_s = 1e-6;
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

static void yield(struct job_spec *job)
{
    job_defaults(job, &scenario_plastic_yield_fields);
}

static void damping(struct job_spec *job)
{
    job_defaults(job, &scenario_damping_fields);
}

/* Grains that lean on a wall and on a plane of symmetry, half of them measured by everything there is. */
static void channel(struct job_spec *job)
{
    job_defaults(job, &scenario_channel_fields);
    struct incline_params *p = (struct incline_params *)(void *)job->params;
    p->nx = p->ny = 5;
    p->nz = 4;
    p->slope_deg = 27;
    job->time.end_s = 0.06;
    job->record.profiles = (struct record_profiles){true, 1e-3, 2e-2};
    job->record.collisions.on = job->record.connectivity.on = job->record.forces.on = job->record.energy.on = true;
    job->record.spectrum.on = true;
    job->record.spectrum.window_s = 0.02;
    assert_int_equal(job_check(job, 0, NULL), SCREE_OK);
}

static struct scree_world *start(set_up *of, const struct scree_sink *sink, int threads)
{
    struct job_spec job;
    struct scree_world *world;
    struct scree_error err;
    struct scree_options options = {.threads = threads};
    of(&job);
    if (scree_world_create(&job, &options, sink, &world, &err) != SCREE_OK)
        fail_msg("%s", err.message);
    return world;
}

static void go(struct scree_world *world, uint64_t slice)
{
    while (!scree_world_progress(world).finished)
        assert_int_equal(scree_world_advance(world, slice, NULL), SCREE_OK);
}

static uint64_t end(struct scree_world *world)
{
    assert_int_equal(scree_world_close(world, NULL), SCREE_OK);
    uint64_t hash = scree_world_hash(world);
    scree_world_free(world);
    return hash;
}

static uint64_t whole(set_up *of, struct heard *heard, int threads, uint64_t slice)
{
    const struct scree_sink sink = {put, heard};
    struct scree_world *world = start(of, &sink, threads);
    go(world, slice);
    return end(world);
}

static void slices_and_threads_do_not_show(void **state)
{
    set_up *of = ((struct job_of *)*state)->of;
    struct heard one = {0}, two = {0};
    uint64_t hash = whole(of, &one, 1, 100000);
    assert_true(one.chunks > 4);
    assert_int_equal(whole(of, &two, 2, 7), hash);
    assert_int_equal(one.hash, two.hash);
    assert_int_equal(one.chunks, two.chunks);
}

static void a_fork_goes_on_alike(void **state)
{
    set_up *of = ((struct job_of *)*state)->of;
    struct heard first = {0}, second = {0}, reference = {0};
    const struct scree_sink a = {put, &first}, b = {put, &second};
    uint64_t hash = whole(of, &reference, 1, 100000);
    struct scree_world *world = start(of, &a, 1), *fork;
    assert_int_equal(scree_world_advance(world, ((struct job_of *)*state)->middle, NULL), SCREE_OK);
    second = first;
    assert_int_equal(scree_world_fork(world, NULL, &b, &fork, NULL), SCREE_OK);
    go(world, 100000);
    go(fork, 11);
    struct scree_number x[SCREE_SUMMARY_MAX], y[SCREE_SUMMARY_MAX];
    size_t n = scree_world_summary(world, x);
    assert_int_equal(scree_world_summary(fork, y), n);
    assert_true(n > 5);
    for (size_t k = 0; k < n; k++)
        assert_memory_equal(&x[k].value, &y[k].value, sizeof x[k].value);
    assert_int_equal(end(world), hash);
    assert_int_equal(end(fork), hash);
    assert_int_equal(first.hash, reference.hash);
    assert_int_equal(second.hash, reference.hash);
}

static void a_restart_does_not_show(void **state)
{
    set_up *of = ((struct job_of *)*state)->of;
    struct heard heard = {0}, reference = {0};
    const struct scree_sink sink = {put, &heard};
    uint64_t hash = whole(of, &reference, 1, 100000);
    char path[64];
    struct scree_error err;
    struct job_spec job;
    snprintf(path, sizeof path, "world-%d.h5", (int)getpid());
    of(&job);
    struct scree_world *world = start(of, &sink, 1);
    assert_int_equal(scree_world_advance(world, ((struct job_of *)*state)->middle + 8, NULL), SCREE_OK);
    assert_int_equal(scree_checkpoint_write(world, path, &err), SCREE_OK);
    scree_world_free(world);
    if (scree_checkpoint_read(path, &job, &(struct scree_options){.threads = 3}, &sink, &world, &err) != SCREE_OK)
        fail_msg("%s", err.message);
    remove(path);
    go(world, 100000);
    assert_int_equal(end(world), hash);
    assert_int_equal(heard.hash, reference.hash);
}

/* A calculation has one step and no chunks; its image makes it anew. */
static void calculations_are_worlds(void **state)
{
    (void)state;
    set_up *const all[] = {yield, damping};
    for (size_t k = 0; k < COUNT(all); k++) {
        struct heard heard = {0};
        const struct scree_sink sink = {put, &heard};
        struct scree_world *world = start(all[k], &sink, 1), *fork;
        struct scree_number x[SCREE_SUMMARY_MAX], y[SCREE_SUMMARY_MAX];
        go(world, 1);
        assert_int_equal(scree_world_fork(world, NULL, &sink, &fork, NULL), SCREE_OK);
        assert_true(scree_world_progress(fork).finished && scree_world_progress(fork).time_s == scree_world_progress(world).time_s);
        size_t n = scree_world_summary(world, x);
        assert_int_equal(scree_world_summary(fork, y), n);
        assert_true(n > 5);
        for (size_t i = 0; i < n; i++)
            assert_memory_equal(&x[i].value, &y[i].value, sizeof x[i].value);
        assert_int_equal(end(world), end(fork));
        assert_int_equal(heard.chunks, 0);
    }
}

/* The bits of today; a change that moves them on purpose writes them anew: SCREE_GOLDEN=print prints them. */
static void bits_are_those_of_the_golden_hashes(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        set_up *of;
        uint64_t hash, chunks;
    } golden[] = {{"rolling", rolling, 0x39209552bfaaf16du, 0xba2019a6bc222f4au},
                  {"dam_break", dam_break, 0x53a99754882664cbu, 0x579c16c774015b1au},
                  {"hopper", hopper, 0xccbacadcdf75e43au, 0xa9d66032a0cc0768u},
                  {"impact", impact, 0xcde37eb0813dc4dbu, 0x9d9547db8f88ebd2u},
                  {"yield", yield, 0x76a975b585d14314u, 0},
                  {"damping", damping, 0xd150a2fb2924a82cu, 0}};
    for (size_t k = 0; k < COUNT(golden); k++) {
        struct heard heard = {0};
        uint64_t hash = whole(golden[k].of, &heard, 1, 100000);
        if (getenv("SCREE_GOLDEN"))
            print_message("%s: 0x%016llxu, 0x%016llxu\n", golden[k].name, (unsigned long long)hash, (unsigned long long)heard.hash);
        else if (hash != golden[k].hash || heard.hash != golden[k].chunks)
            fail_msg("%s: 0x%016llx, 0x%016llx", golden[k].name, (unsigned long long)hash, (unsigned long long)heard.hash);
    }
}

int main(void)
{
    static struct job_of a_collapse = {collapse, 53}, a_layer = {layer, 170}, a_dam_break = {dam_break, 33000},
                         a_hopper = {hopper, 5003}, a_channel = {channel, 200123}, a_sphere = {rolling, 5000},
                         an_impact = {impact, 5000};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &a_collapse),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &a_collapse),
        cmocka_unit_test_prestate(a_restart_does_not_show, &a_collapse),
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &a_layer),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &a_layer),
        cmocka_unit_test_prestate(a_restart_does_not_show, &a_layer),
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &a_dam_break),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &a_dam_break),
        cmocka_unit_test_prestate(a_restart_does_not_show, &a_dam_break),
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &a_hopper),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &a_hopper),
        cmocka_unit_test_prestate(a_restart_does_not_show, &a_hopper),
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &a_sphere),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &a_sphere),
        cmocka_unit_test_prestate(a_restart_does_not_show, &a_sphere),
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &an_impact),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &an_impact),
        cmocka_unit_test_prestate(a_restart_does_not_show, &an_impact),
        cmocka_unit_test_prestate(slices_and_threads_do_not_show, &a_channel),
        cmocka_unit_test_prestate(a_fork_goes_on_alike, &a_channel),
        cmocka_unit_test_prestate(a_restart_does_not_show, &a_channel),
        cmocka_unit_test(calculations_are_worlds),
        cmocka_unit_test(bits_are_those_of_the_golden_hashes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
