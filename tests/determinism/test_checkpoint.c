/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world that was checkpointed and restarted, or forked, ends in the bits of one
 * that was never stopped; writing a checkpoint changes nothing; a damaged file is
 * refused by name. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/rng.h"
#include "scree.h"

static char folder[] = "/tmp/scree-checkpoint-XXXXXX";
static char path[64];

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof path, "%s/c.h5", folder);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(folder);
}

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

static struct job_spec spec(int64_t n, int64_t nz, double end_s)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = n;
    p->nz = nz;
    p->slope_deg = 26;
    job.time.end_s = end_s;
    job.stop.when = 0;
    job.record.energy = (struct record_every){true, 1e-3};
    job.record.profiles = (struct record_profiles){true, 1e-3, 4e-3};
    job.record.spectrum.on = true;
    job.record.spectrum.window_s = 3e-3;
    job.record.connectivity.on = job.record.forces.on = job.record.collisions.on = true;
    return job;
}

static struct scree_world *make(const struct job_spec *job, uint64_t *streams)
{
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    const struct scree_sink sink = {.put = mix, .context = streams};
    if (scree_world_create(job, NULL, &sink, &world, &error))
        fail_msg("%s", error.message);
    return world;
}

static void run(struct scree_world *world, uint64_t steps)
{
    struct scree_error error = {0};
    if (scree_world_advance(world, steps, &error))
        fail_msg("%s", error.message);
}

static uint64_t end(struct scree_world *world)
{
    struct scree_error error = {0};
    run(world, UINT64_MAX);
    assert_int_equal(scree_world_close(world, &error), SCREE_OK);
    uint64_t hash = scree_world_hash(world);
    scree_world_free(world);
    return hash;
}

static struct scree_world *read_back(const struct job_spec *job, uint64_t *streams, int threads)
{
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    const struct scree_sink sink = {.put = mix, .context = streams};
    const struct scree_options options = {.threads = threads};
    if (scree_checkpoint_read(path, job, &options, &sink, &world, &error))
        fail_msg("%s", error.message);
    return world;
}

/* At odd steps, in flight and in the flow, several times in one run, on other threads. */
static void restarts_do_not_show(void **state)
{
    (void)state;
    struct job_spec job = spec(6, 4, 0.05);
    const uint64_t stops[] = {1, 12345, 77777, 131071};
    uint64_t whole = 1, parts = 1;
    struct scree_error error = {0};
    uint64_t expect = end(make(&job, &whole));
    struct scree_world *world = make(&job, &parts);
    for (size_t k = 0; k < 4; k++) {
        run(world, stops[k] - scree_world_progress(world).step);
        uint64_t hash = scree_world_hash(world);
        assert_int_equal(scree_checkpoint_write(world, path, &error), SCREE_OK);
        assert_true(scree_world_hash(world) == hash);
        scree_world_free(world);
        world = read_back(&job, &parts, (int)k % 2 + 1);
        assert_true(scree_world_hash(world) == hash);
        assert_int_equal(scree_world_progress(world).step, stops[k]);
    }
    assert_true(end(world) == expect);
    assert_true(parts == whole); // every chunk too, and under the same numbers
}

static void writing_changes_nothing(void **state)
{
    (void)state;
    struct job_spec job = spec(4, 3, 0.02);
    uint64_t quiet = 1, written = 1;
    struct scree_error error = {0};
    uint64_t expect = end(make(&job, &quiet));
    struct scree_world *world = make(&job, &written);
    while (!scree_world_progress(world).finished) {
        run(world, 7919);
        assert_int_equal(scree_checkpoint_write(world, path, &error), SCREE_OK);
    }
    assert_true(end(world) == expect);
    assert_true(written == quiet);
}

static void an_unchanged_fork_equals_its_parent(void **state)
{
    (void)state;
    struct job_spec job = spec(5, 4, 0.04);
    uint64_t parent_streams = 1, child_streams = 1;
    struct scree_error error = {0};
    struct scree_world *parent = make(&job, &parent_streams), *child = NULL;
    run(parent, 80001);
    child_streams = parent_streams;
    const struct scree_sink sink = {.put = mix, .context = &child_streams};
    assert_int_equal(scree_world_fork(parent, NULL, &sink, &child, &error), SCREE_OK);
    run(child, 1000); // turn by turn: neither disturbs the other
    run(parent, 3000);
    uint64_t a = end(parent), b = end(child);
    assert_true(a == b);
    assert_true(parent_streams == child_streams);
}

static void refuse(const struct job_spec *job, enum scree_status expect, const char *why)
{
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    uint64_t streams = 1;
    const struct scree_sink sink = {.put = mix, .context = &streams};
    assert_int_equal(scree_checkpoint_read(path, job, NULL, &sink, &world, &error), expect);
    assert_null(world);
    if (!strstr(error.message, path) || !strstr(error.message, why))
        fail_msg("\"%s\" does not name %s and say \"%s\"", error.message, path, why);
}

static unsigned char *read_whole(size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *whole = malloc(*size);
    assert_non_null(whole);
    assert_int_equal(fread(whole, 1, *size, file), *size);
    fclose(file);
    return whole;
}

static void put_byte(FILE *file, size_t place, unsigned char byte)
{
    fseek(file, (long)place, SEEK_SET);
    assert_int_equal(fwrite(&byte, 1, 1, file), 1);
    assert_int_equal(fflush(file), 0);
}

/* Every byte of a checkpoint changed in one bit, then the file cut short by every number of bytes. */
static void damage_is_refused_by_name(void **state)
{
    (void)state;
    struct job_spec job, other;
    job_defaults(&job, scenario_find("collision"));
    other = job;
    other.seed++;
    uint64_t streams = 1;
    struct scree_error error = {0};
    struct rng rng = rng_start(1, 1);
    struct scree_world *world = make(&job, &streams);
    run(world, 20);
    assert_int_equal(scree_checkpoint_write(world, path, &error), SCREE_OK);
    scree_world_free(world);
    refuse(&other, SCREE_CORRUPT, "another job");
    size_t size;
    unsigned char *whole = read_whole(&size);
    FILE *file = fopen(path, "r+b");
    for (size_t place = 0; place < size; place++) {
        put_byte(file, place, whole[place] ^ (unsigned char)(1u << rng_next(&rng) % 8));
        refuse(&job, SCREE_CORRUPT, "checksum");
        put_byte(file, place, whole[place]);
    }
    for (size_t length = size; length-- > 0;) {
        assert_int_equal(ftruncate(fileno(file), (off_t)length), 0);
        refuse(&job, SCREE_CORRUPT, "checksum");
    }
    fclose(file);
    free(whole);
    unlink(path);
    refuse(&job, SCREE_IO, "No such file");
}

/* At 1,000 grains: at most 1 MB; the time is printed, and measured in earnest by the benchmark. */
static void a_checkpoint_of_a_thousand_grains_is_small(void **state)
{
    (void)state;
    struct job_spec job = spec(10, 10, 1);
    /* The grains alone: histories of sums by height and frequency are as large again. */
    job.record.profiles.on = job.record.spectrum.on = job.record.collisions.on = job.record.connectivity.on = false;
    uint64_t streams = 1;
    struct scree_error error = {0};
    struct scree_world *world = make(&job, &streams);
    run(world, 400000);
    struct timespec before, after;
    clock_gettime(CLOCK_MONOTONIC, &before);
    assert_int_equal(scree_checkpoint_write(world, path, &error), SCREE_OK);
    clock_gettime(CLOCK_MONOTONIC, &after);
    scree_world_free(world);
    FILE *file = fopen(path, "rb");
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    fclose(file);
    print_message("%.1f ms, %ld kB\n",
                  1e3 * (double)(after.tv_sec - before.tv_sec) + 1e-6 * (double)(after.tv_nsec - before.tv_nsec), size / 1000);
    assert_true(size < 1000000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(restarts_do_not_show),
        cmocka_unit_test(writing_changes_nothing),
        cmocka_unit_test(an_unchanged_fork_equals_its_parent),
        cmocka_unit_test(damage_is_refused_by_name),
        cmocka_unit_test(a_checkpoint_of_a_thousand_grains_is_small),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
