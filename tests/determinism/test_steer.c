/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world that is steered: what changes is what was asked for, from the next step
 * on; and neither slices nor checkpoints around the change show in a single bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scree.h"

/* What the streams said: a hash over everything, and the last frame. */
struct heard {
    uint64_t hash;
    double mean[3]; // velocity of the moving grains at the end, m/s
    double last_t0_s;
    size_t force_rows;
    double force_dt_s;
};

enum { X_VELOCITY = 5, FIXED = 12, FRAME = 13 }; // columns of the frame at the end

static enum scree_status hear(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct heard *h = context;
    uint64_t word;
    (void)err;
    for (size_t k = 0; k < chunk->rows * chunk->stream->column_count; k++) {
        memcpy(&word, &chunk->values[k], sizeof word);
        h->hash = (h->hash ^ word ^ chunk->seq) * 0x9e3779b97f4a7c15u;
        h->hash ^= h->hash >> 31;
    }
    h->last_t0_s = chunk->t0_s;
    if (strcmp(chunk->stream->name, "basal_force") == 0) {
        h->force_rows += chunk->rows;
        h->force_dt_s = chunk->dt_s;
    }
    if (strcmp(chunk->stream->name, "grains") == 0) {
        size_t moving = 0;
        for (size_t r = 0; r < chunk->rows; r++)
            for (int a = 0; a < 3 && chunk->values[r * FRAME + FIXED] == 0; a++) {
                h->mean[a] += chunk->values[r * FRAME + X_VELOCITY + (size_t)a];
                moving += a == 0;
            }
        for (int a = 0; a < 3; a++)
            h->mean[a] /= (double)moving;
    }
    return SCREE_OK;
}

static struct incline_params *incline(struct job_spec *job)
{
    return (struct incline_params *)(void *)job->params;
}

static struct job_spec spec(double end_s)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    struct incline_params *p = incline(&job);
    p->nx = p->ny = 4;
    p->nz = 3;
    p->slope_deg = 26;
    job.time.end_s = end_s;
    job.stop.when = 0;
    return job;
}

static struct scree_world *make(const struct job_spec *job, struct heard *heard)
{
    struct scree_world *world = NULL;
    struct scree_error error = {0};
    const struct scree_sink sink = {.put = hear, .context = heard};
    if (scree_world_create(job, NULL, &sink, &world, &error))
        fail_msg("%s", error.message);
    return world;
}

static void run_to(struct scree_world *world, uint64_t step, uint64_t slice)
{
    struct scree_error error = {0};
    while (scree_world_progress(world).step < step && !scree_world_progress(world).finished) {
        uint64_t left = step - scree_world_progress(world).step;
        if (scree_world_advance(world, left < slice ? left : slice, &error))
            fail_msg("%s", error.message);
    }
}

static void steer(struct scree_world *world, const struct job_spec *job)
{
    struct scree_error error = {0};
    if (scree_world_steer(world, job, &error))
        fail_msg("%s", error.message);
}

static uint64_t end(struct scree_world *world)
{
    struct scree_error error = {0};
    run_to(world, UINT64_MAX, UINT64_MAX);
    uint64_t hash = scree_world_hash(world);
    assert_int_equal(scree_world_close(world, &error), SCREE_OK);
    scree_world_free(world);
    return hash;
}

/* Through the air, before anything touches: v = g1 t1 + g2 t2, exactly that of a parabola. */
static void gravity_turns_at_the_step(void **state)
{
    (void)state;
    struct heard heard = {.hash = 1};
    struct job_spec job = spec(4e-4), to = job; // 1,600 steps; falls 1e-6 m
    const double degree = M_PI / 180, t1 = 700 * job.time.step_s, t2 = 900 * job.time.step_s;
    incline(&to)->slope_deg = 10;
    incline(&to)->gravity_m_s2 = 5;
    struct scree_world *world = make(&job, &heard);
    run_to(world, 700, 64);
    steer(world, &to);
    end(world);
    double vx = 9.81 * sin(26 * degree) * t1 + 5 * sin(10 * degree) * t2;
    double vz = -9.81 * cos(26 * degree) * t1 - 5 * cos(10 * degree) * t2;
    assert_true(fabs(heard.mean[0] - vx) < 1e-12 && fabs(heard.mean[1]) < 1e-12 && fabs(heard.mean[2] - vz) < 1e-12);
}

/* Friction that is changed before the first contact is the friction of the contact. */
static void friction_changes_before_a_contact(void **state)
{
    (void)state;
    struct job_spec job, to;
    job_defaults(&job, scenario_find("collision"));
    struct collision_params *p = (struct collision_params *)(void *)job.params;
    p->gap_m = 1e-6;
    p->tangential_m_s[0] = 0.3;
    to = job;
    to.material.mu_t = 0.05;
    struct heard plain = {.hash = 1}, expected = {.hash = 1}, steered = {.hash = 1};
    uint64_t as_it_was = end(make(&job, &plain)), as_it_should_be = end(make(&to, &expected));
    struct scree_world *world = make(&job, &steered);
    run_to(world, 3, 1);
    steer(world, &to);
    assert_true(end(world) == as_it_should_be);
    assert_true(as_it_was != as_it_should_be);
}

/* One history of changes under many slicings, with a checkpoint before and after each. */
static void slices_and_checkpoints_do_not_show(void **state)
{
    (void)state;
    char folder[] = "/tmp/scree-steer-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/c.h5", folder);
    uint64_t hash[3], said[3];
    for (int way = 0; way < 3; way++) {
        static const uint64_t slices[] = {UINT64_MAX, 777, 4001};
        struct heard heard = {.hash = 1};
        struct scree_error error = {0};
        struct job_spec job = spec(0.03);
        const struct scree_sink sink = {.put = hear, .context = &heard};
        struct scree_world *world = make(&job, &heard);
        for (int change = 0; change < 4; change++) {
            run_to(world, (uint64_t[]){1, 20011, 50003, 90000}[change], slices[way]);
            incline(&job)->slope_deg = 20 + 3 * change;
            job.material.mu_t = 0.2 + 0.1 * change;
            job.record.basal_force.every_s = change == 2 ? 1e-5 : job.record.basal_force.every_s;
            job.record.bulk.every_s = change == 1 ? 3e-4 : job.record.bulk.every_s;
            job.time.end_s = change == 3 ? 0.04 : job.time.end_s;
            steer(world, &job);
            if (way == 0)
                continue;
            struct scree_image *image;
            assert_int_equal(scree_image_take(world, &image, &error), SCREE_OK);
            run_to(world, scree_world_progress(world).step + 9, 1); // the image does not follow
            assert_int_equal(scree_image_write(image, path, &error), SCREE_OK);
            scree_image_free(image);
            scree_world_free(world);
            if (scree_checkpoint_read(path, &job, NULL, &sink, &world, &error))
                fail_msg("%s", error.message);
        }
        hash[way] = end(world);
        said[way] = heard.hash;
    }
    assert_true(hash[1] == hash[0] && hash[2] == hash[0]);
    assert_true(said[1] == said[0] && said[2] == said[0]);
    unlink(path);
    rmdir(folder);
}

/* Blocks of force: twice as many rows a second after the interval is halved. */
static void record_rates_change(void **state)
{
    (void)state;
    struct heard heard = {.hash = 1};
    struct job_spec job = spec(0.02);
    job.record.basal_force.every_s = 1e-5;
    struct scree_world *world = make(&job, &heard);
    run_to(world, 40000, 1000); // 0.01 s: 1,000 rows
    job.record.basal_force.every_s = 5e-6;
    steer(world, &job);
    end(world);
    assert_int_equal(heard.force_rows, 1000 + 2000);
    assert_true(heard.force_dt_s == 20 * job.time.step_s);
}

/* What is not marked steerable is refused by name, and the world goes on as it was. */
static void the_rest_is_refused(void **state)
{
    (void)state;
    struct heard a = {.hash = 1}, b = {.hash = 1};
    struct scree_error error = {0};
    struct job_spec job = spec(0.005), wrong = job;
    uint64_t expected = end(make(&job, &a));
    struct scree_world *world = make(&job, &b);
    run_to(world, 5000, 5000);
    incline(&wrong)->nx = 5;
    assert_int_equal(scree_world_steer(world, &wrong, &error), SCREE_INVALID);
    assert_string_equal(error.path, "params.nx");
    wrong = job;
    wrong.material.young_Pa /= 2;
    assert_int_equal(scree_world_steer(world, &wrong, &error), SCREE_INVALID);
    assert_string_equal(error.path, "material.young_Pa");
    wrong = job;
    wrong.record.energy.on = true;
    assert_int_equal(scree_world_steer(world, &wrong, &error), SCREE_INVALID);
    assert_string_equal(error.path, "record.energy");
    assert_true(end(world) == expected);
}

/* Streams of a fork start at chunk 0 where it begins. */
static void a_branch_has_streams_of_its_own(void **state)
{
    (void)state;
    struct heard heard = {.hash = 1}, own = {.hash = 1};
    struct scree_error error = {0};
    struct job_spec job = spec(0.02);
    const struct scree_sink sink = {.put = hear, .context = &own};
    struct scree_world *world = make(&job, &heard), *child = NULL;
    run_to(world, 40000, 40000);
    assert_true(scree_world_next_chunk(world, 0) > 0);
    assert_int_equal(scree_world_fork(world, NULL, &sink, &child, &error), SCREE_OK);
    scree_world_branch(child);
    assert_int_equal(scree_world_next_chunk(child, 0), 0);
    assert_true(end(child) == end(world));
    assert_int_equal(own.force_rows, 4000); // the second half, in blocks of ten steps
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gravity_turns_at_the_step),
        cmocka_unit_test(friction_changes_before_a_contact),
        cmocka_unit_test(slices_and_checkpoints_do_not_show),
        cmocka_unit_test(record_rates_change),
        cmocka_unit_test(the_rest_is_refused),
        cmocka_unit_test(a_branch_has_streams_of_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
