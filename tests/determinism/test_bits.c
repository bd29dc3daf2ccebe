/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The same spec gives the same bits: on any number of threads, any instruction
 * set, any slicing, with or without records; and the bits of today are those of
 * the golden hashes below. A change that moves them on purpose writes them anew:
 * SCREE_GOLDEN=print tests/determinism/... prints the lines. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu.h"
#include "scree.h"

static const struct { // world hash after the run
    const char *name, *scenario;
    int64_t n, nz; // square
    double slope_deg, end_s;
    uint64_t hash;
} golden[] = {
    {"flow", "incline", 6, 5, 24, 0.03, 0xb8f1ed94ba8e5c04u},
    {"rest", "incline", 4, 3, 5, 0.12, 0x7a85935341bd1f72u},
    {"wide", "incline", 12, 2, 30, 0.016, 0x12184f083cff3ecfu},
    {"channel", "channel", 6, 4, 26, 0.03, 0x2e354d91f00c01deu},
};
enum { GOLDEN = sizeof golden / sizeof *golden };

/* What a run put into its streams, as one hash, and the state it ended in. */
struct bits {
    uint64_t state, force, all; // world, stream basal_force, every stream
};

static void mix(uint64_t *hash, const struct scree_chunk *chunk)
{
    for (size_t k = 0; k < chunk->rows * chunk->stream->column_count; k++) {
        uint64_t word;
        memcpy(&word, &chunk->values[k], sizeof word);
        *hash = (*hash ^ word) * 0x9e3779b97f4a7c15u;
        *hash ^= *hash >> 31;
    }
    *hash += chunk->seq;
}

static enum scree_status mix_chunk(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct bits *bits = context;
    (void)err;
    mix(&bits->all, chunk);
    if (strcmp(chunk->stream->name, "basal_force") == 0)
        mix(&bits->force, chunk);
    return SCREE_OK;
}

struct how {
    int threads;
    const char *isa;
    uint64_t slice;
    bool records; // everything on, rather than nothing but the force
};

static struct bits run_world(int which, struct how how)
{
    struct bits bits = {0, 1, 1};
    struct job_spec job;
    struct scree_error error = {0};
    struct scree_world *world = NULL;
    job_defaults(&job, scenario_find(golden[which].scenario));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = golden[which].n;
    p->nz = golden[which].nz;
    p->slope_deg = golden[which].slope_deg;
    job.time.end_s = golden[which].end_s;
    job.stop.when = 0;
    job.record.bulk.on = job.record.energy.on = job.record.snapshots.on = how.records;
    job.record.profiles = (struct record_profiles){how.records, 1e-3, 4e-3};
    job.record.spectrum.on = how.records;
    job.record.spectrum.window_s = 3e-3;
    job.record.connectivity.on = job.record.forces.on = job.record.collisions.on = how.records;
    const struct scree_sink sink = {.put = mix_chunk, .context = &bits};
    const struct scree_options options = {.isa = how.isa, .threads = how.threads};
    if (scree_world_create(&job, &options, &sink, &world, &error))
        fail_msg("%s", error.message);
    while (!scree_world_progress(world).finished)
        if (scree_world_advance(world, how.slice, &error))
            fail_msg("%s", error.message);
    bits.state = scree_world_hash(world);
    assert_int_equal(scree_world_close(world, &error), SCREE_OK);
    scree_world_free(world);
    return bits;
}

static const struct how plain = {.threads = 1, .slice = 1000000, .records = true};

static void same(struct bits a, struct bits b)
{
    assert_true(a.state == b.state);
    assert_true(a.force == b.force);
    assert_true(a.all == b.all);
}

static void threads_do_not_show(void **state)
{
    (void)state;
    const int threads[] = {2, 3, 4, 8};
    struct bits one = run_world(2, plain);
    for (int k = 0; k < 4; k++) {
        struct how how = plain;
        how.threads = threads[k];
        same(one, run_world(2, how));
    }
}

static void instruction_sets_do_not_show(void **state)
{
    (void)state;
    for (int w = 0; w < GOLDEN; w++) {
        struct bits best = run_world(w, plain);
        for (enum cpu_isa isa = CPU_V2; isa < CPU_ISA_COUNT; isa++) {
            struct how how = plain;
            how.isa = cpu_isa_name(isa);
            if (cpu_has(isa))
                same(best, run_world(w, how));
            else
                print_message("%s: not on this machine, left out\n", how.isa);
        }
    }
}

static void slices_do_not_show(void **state)
{
    (void)state;
    const uint64_t slices[] = {1, 7, 1000};
    struct bits whole = run_world(0, plain);
    for (int k = 0; k < 3; k++) {
        struct how how = plain;
        how.slice = slices[k];
        same(whole, run_world(0, how));
    }
}

static void records_do_not_show(void **state)
{
    (void)state;
    struct how how = plain;
    how.records = false;
    for (int w = 0; w < GOLDEN; w++) {
        struct bits with = run_world(w, plain), without = run_world(w, how);
        assert_true(with.state == without.state && with.force == without.force);
    }
}

static void bits_are_those_of_the_golden_hashes(void **state)
{
    (void)state;
    bool print = getenv("SCREE_GOLDEN") != NULL;
    for (int w = 0; w < GOLDEN; w++) {
        uint64_t hash = run_world(w, plain).state;
        if (print)
            print_message("%s: 0x%016llx\n", golden[w].name, (unsigned long long)hash);
        else
            assert_true(hash == golden[w].hash);
    }
}

/* The hash sees the last bit of one grain's place: two seeds differ, and so do two neighbouring slopes. */
static void the_hash_tells_worlds_apart(void **state)
{
    (void)state;
    struct bits a = run_world(0, plain), b = run_world(1, plain), c = run_world(2, plain);
    assert_true(a.state != b.state && b.state != c.state && a.force != b.force);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_show),         cmocka_unit_test(instruction_sets_do_not_show),
        cmocka_unit_test(slices_do_not_show),          cmocka_unit_test(records_do_not_show),
        cmocka_unit_test(the_hash_tells_worlds_apart), cmocka_unit_test(bits_are_those_of_the_golden_hashes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
