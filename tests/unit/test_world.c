/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds as the service sees them: streams are cut by samples, never by slices;
 * a blow-up says step, grain and last good time; a warm step asks for no memory. */
#include "summary.h"

#include <math.h>

#include "base/memory.h"
#include "dem/dem.h"
#include "scenario/scenario.h"

struct counted {
    uint64_t chunks, rows, next;
    double last_t0;
    bool gap;
};

static enum scree_status count_force(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct counted *c = context;
    (void)err;
    if (strcmp(chunk->stream->name, "basal_force") != 0)
        return SCREE_OK;
    c->gap |= chunk->seq != c->next++;
    c->gap |= c->chunks > 0 && chunk->t0_s <= c->last_t0;
    c->last_t0 = chunk->t0_s;
    c->chunks++;
    c->rows += chunk->rows;
    return SCREE_OK;
}

static struct job_spec small(double end_s)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = (struct incline_params *)(void *)job.params;
    p->nx = p->ny = 4;
    p->nz = 3;
    job.time.end_s = end_s;
    job.stop.when = 0;
    return job;
}

static void chunks_are_numbered_without_gaps_and_whole(void **state)
{
    (void)state;
    struct job_spec job = small(0.01); // 40,000 steps: 4,000 samples, 3 chunks of 1,024 and one of 928
    struct counted counted = {0};
    const struct scree_sink sink = {.put = count_force, .context = &counted};
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    assert_int_equal(scree_world_create(&job, NULL, &sink, &world, &error), SCREE_OK);
    while (!scree_world_progress(world).finished)
        assert_int_equal(scree_world_advance(world, 777, &error), SCREE_OK);
    assert_int_equal(counted.chunks, 3);
    assert_int_equal(scree_world_close(world, &error), SCREE_OK);
    assert_int_equal(counted.chunks, 4);
    assert_int_equal(counted.rows, 4000);
    assert_false(counted.gap);
    assert_int_equal(scree_world_progress(world).step, 40000);
    scree_world_free(world);
}

static enum scree_status full(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    (void)context, (void)chunk;
    return scree_fail(err, SCREE_IO, "", "disk full");
}

static void a_failing_sink_stops_the_world(void **state)
{
    (void)state;
    struct job_spec job = small(0.01);
    const struct scree_sink sink = {.put = full};
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    assert_int_equal(scree_world_create(&job, NULL, &sink, &world, &error), SCREE_OK);
    assert_int_equal(scree_world_advance(world, 100000, &error), SCREE_IO);
    assert_string_equal(error.message, "disk full");
    scree_world_free(world);
}

/* A verdict rests on samples of its own: what is recorded, and how often, does not change it. */
static void verdicts_do_not_depend_on_what_is_recorded(void **state)
{
    (void)state;
    enum { CASES = 3 };
    static const double every_s[CASES] = {1e-3, 0.3, 0}; // 0: not recorded
    struct summary said[CASES];
    for (size_t k = 0; k < CASES; k++) {
        struct job_spec job = small(1);
        job.material.young_Pa /= 1000;
        job.material.beta_s *= 15.85;
        job.time.step_s *= 15.85;
        ((struct incline_params *)(void *)job.params)->slope_deg = 8;
        job.stop.when = STOP_REST;
        job.record.basal_force.on = false;
        job.record.bulk.on = every_s[k] > 0;
        if (every_s[k] > 0)
            job.record.bulk.every_s = every_s[k];
        said[k] = run(&job, &(struct scree_sink){.put = sink_nowhere});
        assert_int_equal(said[k].verdict, VERDICT_REST);
        assert_true(said[k].time_s == said[0].time_s);
        assert_string_equal(said[k].evidence, said[0].evidence);
    }
    print_message("at rest at %.4f s: %s\n", said[0].time_s, said[0].evidence);
}

/* A step ten times too long (job_check would refuse it) must fail the job, not run on. */
static void a_blow_up_fails_with_step_grain_and_time(void **state)
{
    (void)state;
    struct job_spec job = small(1);
    job.time.step_s = 8e-6;
    job.record.basal_force.on = false;
    job.material.beta_s = 0;
    struct counted counted = {0};
    const struct scree_sink sink = {.put = count_force, .context = &counted};
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    enum scree_status status = scree_world_create(&job, NULL, &sink, &world, &error);
    while (!status && !scree_world_progress(world).finished)
        status = scree_world_advance(world, 1000, &error);
    assert_int_equal(status, SCREE_BLOWUP);
    assert_non_null(strstr(error.message, "step "));
    assert_non_null(strstr(error.message, "grain "));
    scree_world_free(world);
}

/* A grain below the base is a blow-up, named. */
static void a_grain_through_the_base_is_named(void **state)
{
    (void)state;
    const struct dem_grain grain = {.position = {0, 0, 0.01}, .velocity = {0, 0, -1}, .radius = 1e-3, .density = 2530};
    const struct dem_setup setup = {.step_s = 1e-6,
                                    .grains = &grain,
                                    .grain_count = 1,
                                    .material = material_preset_find("glass-beads-2mm")->values,
                                    .floor_z = -0.002,
                                    .threads = 1};
    struct dem *dem = NULL;
    struct scree_error error = {0};
    assert_int_equal(dem_create(&setup, &dem, &error), SCREE_OK);
    assert_int_equal(dem_advance(dem, 20000, &error), SCREE_BLOWUP);
    assert_non_null(strstr(error.message, "grain 0 went through the base"));
    assert_non_null(strstr(error.message, "last good time 0.0"));
    dem_free(dem);
}

static void grains_that_overlap_at_the_start_are_refused(void **state)
{
    (void)state;
    struct dem_grain grains[2] = {{.position = {0, 0, 0}, .radius = 1e-3, .density = 2530},
                                  {.position = {0, 0, 1.9e-3}, .radius = 1e-3, .density = 2530}};
    const struct dem_setup setup = {.step_s = 1e-7,
                                    .grains = grains,
                                    .grain_count = 2,
                                    .material = material_preset_find("glass-beads-2mm")->values,
                                    .floor_z = -INFINITY,
                                    .threads = 1};
    struct dem *dem = NULL;
    struct scree_error error = {0};
    assert_int_equal(dem_create(&setup, &dem, &error), SCREE_INVALID);
    assert_string_equal(error.message, "grains 0 and 1 overlap by 0.0001 m at the start");
}

/* Lists grow to their size early on; after that a step allocates nothing. */
static void a_warm_step_asks_for_no_memory(void **state)
{
    (void)state;
    struct job_spec job = small(1);
    ((struct incline_params *)(void *)job.params)->slope_deg = 15;
    struct dem *dem = NULL;
    struct scree_error error = {0};
    assert_int_equal(scenario_implementation("incline")->build(&job, &(struct scenario_means){.threads = 1}, &dem, &error),
                     SCREE_OK);
    assert_int_equal(dem_advance(dem, 800000, &error), SCREE_OK);
    assert_int_equal(dem_advance(dem, DEM_REORDER_STEPS - 800000 % DEM_REORDER_STEPS + 1, &error), SCREE_OK);
    unsigned long before = memory_requests();
    assert_int_equal(dem_advance(dem, DEM_REORDER_STEPS - 2, &error), SCREE_OK); // refreshes and rebuilds among them
    assert_int_equal(memory_requests(), before);
    dem_free(dem);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chunks_are_numbered_without_gaps_and_whole),
        cmocka_unit_test(a_failing_sink_stops_the_world),
        cmocka_unit_test(verdicts_do_not_depend_on_what_is_recorded),
        cmocka_unit_test(a_blow_up_fails_with_step_grain_and_time),
        cmocka_unit_test(a_grain_through_the_base_is_named),
        cmocka_unit_test(grains_that_overlap_at_the_start_are_refused),
        cmocka_unit_test(a_warm_step_asks_for_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
