/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `chute`, with rigid bodies and walls of triangles, as a whole world:
 * the same bits on any threads, instruction set and slice, across a checkpoint and
 * a fork, and those of today. SCREE_GOLDEN=print prints today's. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/cpu.h"
#include "scree.h"

static const uint64_t golden = 0x0b32276b3c05b8e8ull, golden_own = 0x3b017373b6232eadull;

static enum scree_status mix(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    uint64_t *hash = context, word;
    (void)err;
    for (size_t k = 0; k < chunk->rows * chunk->stream->column_count; k++) {
        memcpy(&word, &chunk->values[k], sizeof word);
        *hash = (*hash ^ word ^ chunk->seq) * 0x9e3779b97f4a7c15u;
        *hash ^= *hash >> 31;
    }
    return SCREE_OK;
}

/* 1 g of 3 mm behind a gate that lifts, for 0.16 s. */
static struct job_spec spec(void)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("chute"));
    struct chute_params *p = (struct chute_params *)(void *)job.params;
    p->mass_g = 1;
    p->space_mass_g = 3;
    p->size_m = 3e-3;
    p->gate_m_s = 2;
    job.fragments.softening = 1e4;
    job.time.step_s = 1.6e-5;
    job.time.end_s = 0.16;
    job.stop.when = 0;
    job.record.energy = (struct record_every){true, 0.01};
    job.record.flow.every_s = 0.02;
    return job;
}

/* The same of clasts of the user's own, three spheres of three sizes, for 0.05 s. */
static struct job_spec spec_own(void)
{
    static const double spheres[3][4] = {{0, 0, 0, 8e-4}, {1e-3, 0, 0, 6e-4}, {0, 1.2e-3, 3e-4, 5e-4}};
    struct job_spec job = spec();
    struct clast_spec *c = &((struct chute_params *)(void *)job.params)->clast;
    c->on = true;
    c->spheres.count = 3;
    memcpy(c->spheres.row, spheres, sizeof spheres);
    c->mass_kg = 1e-5;
    c->centre_m[0] = c->centre_m[1] = 3e-4;
    c->moments_kg_m2[0] = 9e-12, c->moments_kg_m2[1] = 7e-12, c->moments_kg_m2[2] = 1e-11;
    c->products_kg_m2[0] = 2e-12;
    job.time.step_s = 1e-5;
    job.time.end_s = 0.05;
    return job;
}

struct outcome {
    uint64_t state, streams;
};

static struct scree_world *make(const struct job_spec *job, const struct scree_options *options, uint64_t *streams)
{
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    const struct scree_sink sink = {.put = mix, .context = streams};
    if (scree_world_create(job, options, &sink, &world, &error))
        fail_msg("%s", error.message);
    return world;
}

static void run(struct scree_world *world, uint64_t steps)
{
    struct scree_error error = {0};
    if (scree_world_advance(world, steps, &error))
        fail_msg("%s", error.message);
}

static void finish(struct scree_world *world, struct outcome *out)
{
    struct scree_error error = {0};
    run(world, UINT64_MAX);
    out->state = scree_world_hash(world);
    assert_int_equal(scree_world_close(world, &error), SCREE_OK);
    scree_world_free(world);
}

static struct outcome whole_of(const struct job_spec *job, int threads, const char *isa, uint64_t slice)
{
    struct outcome out = {0, 1};
    const struct scree_options options = {.threads = threads, .isa = isa};
    struct scree_world *world = make(job, &options, &out.streams);
    while (!scree_world_progress(world).finished)
        run(world, slice);
    finish(world, &out);
    return out;
}

static struct outcome whole(int threads, const char *isa, uint64_t slice)
{
    struct job_spec job = spec();
    return whole_of(&job, threads, isa, slice);
}

static void same(struct outcome a, struct outcome b)
{
    assert_true(a.state == b.state && a.streams == b.streams);
}

static void threads_instruction_sets_and_slices_do_not_show(void **state)
{
    (void)state;
    struct outcome one = whole(1, NULL, 1000000);
    same(one, whole(3, NULL, 1000000));
    same(one, whole(1, NULL, 491));
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++)
        if (cpu_has(isa))
            same(one, whole(2, cpu_isa_name(isa), 1000000));
    if (getenv("SCREE_GOLDEN"))
        print_message("0x%016llx\n", (unsigned long long)one.state);
    else
        assert_true(one.state == golden);
}

static void nor_do_they_with_clasts_of_ones_own(void **state)
{
    (void)state;
    struct job_spec job = spec_own();
    struct outcome one = whole_of(&job, 1, NULL, 1000000);
    same(one, whole_of(&job, 3, NULL, 77));
    for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++)
        if (cpu_has(isa))
            same(one, whole_of(&job, 2, cpu_isa_name(isa), 1000000));
    if (getenv("SCREE_GOLDEN"))
        print_message("0x%016llx\n", (unsigned long long)one.state);
    else
        assert_true(one.state == golden_own);
}

/* Cut while the gate still lifts, and again when bodies lie on the chute. */
static void checkpoints_and_forks_do_not_show(void **state)
{
    (void)state;
    struct job_spec job = spec();
    struct scree_error error = {0};
    struct outcome one = whole(1, NULL, 1000000), restarted = {0, 1}, forked = {0, 0}, first = {0, 1};
    char folder[] = "/tmp/scree-fragments-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/c.h5", folder);
    struct scree_world *world = make(&job, NULL, &restarted.streams), *other = NULL;
    for (int cut = 0; cut < 2; cut++) {
        run(world, cut ? 6000 : 300);
        assert_int_equal(scree_checkpoint_write(world, path, &error), SCREE_OK);
        scree_world_free(world);
        world = NULL;
        const struct scree_sink sink = {.put = mix, .context = &restarted.streams};
        const struct scree_options options = {.threads = 2};
        if (scree_checkpoint_read(path, &job, &options, &sink, &world, &error))
            fail_msg("%s", error.message);
    }
    finish(world, &restarted);
    same(one, restarted);
    world = make(&job, NULL, &first.streams);
    run(world, 5555);
    forked.streams = first.streams;
    const struct scree_sink sink = {.put = mix, .context = &forked.streams};
    assert_int_equal(scree_world_fork(world, NULL, &sink, &other, &error), SCREE_OK);
    finish(other, &forked);
    finish(world, &first);
    same(one, forked);
    same(one, first);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_instruction_sets_and_slices_do_not_show),
        cmocka_unit_test(nor_do_they_with_clasts_of_ones_own),
        cmocka_unit_test(checkpoints_and_forks_do_not_show),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
