/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Flows of seed 003 as whole worlds: 27 g of 3 mm, softened a thousandfold, on
 * either accelerator. Targets S3-04, S3-05, S3-07 and S3-08 as far as the coarsest
 * grains carry them; tests/results/fragments.md has the table. */
#include "summary.h"

#include <math.h>
#include <stdlib.h>

#include "measure/frames.h"

enum { LAYERS = 64 };

struct frame {
    double row[FRAME_COLUMNS];
};

struct outcome {
    struct summary summary;
    double still_rear_first, still_rear_last;                              // the first that is seen to lie still at all
    double rear_over_middle[2];                                            // speeds along x, at 0.6 s and at 0.9 s
    double layer_speed[LAYERS], layer_bodies[LAYERS], layer_cubes[LAYERS]; // of the layers at half a second
    size_t layers;
};

static int by_place(const void *a, const void *b)
{
    double x = ((const double *)a)[FRAME_X], y = ((const double *)b)[FRAME_X];
    return (x > y) - (x < y);
}

/* Mean speed of the spheres that are at [from, to) of the flow, by number from its rear. */
static double speed_between(const struct frame *sorted, size_t rows, double from, double to)
{
    double sum = 0, count = 0;
    for (size_t k = (size_t)(from * (double)rows); k < (size_t)(to * (double)rows); k++, count++)
        sum += sorted[k].row[FRAME_VX];
    return sum / count;
}

static double rear_over_middle(const struct scree_chunk *chunk)
{
    struct frame *sorted = malloc(chunk->rows * sizeof *sorted);
    assert_non_null(sorted);
    memcpy(sorted, chunk->values, chunk->rows * sizeof *sorted);
    qsort(sorted, chunk->rows, sizeof *sorted, by_place);
    double ratio = speed_between(sorted, chunk->rows, 0, 0.1) / speed_between(sorted, chunk->rows, 0.3, 0.7);
    free(sorted);
    return ratio;
}

static enum scree_status keep(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct outcome *o = context;
    size_t columns = chunk->stream->column_count;
    (void)err;
    for (size_t r = 0; strcmp(chunk->stream->name, "flow") == 0 && r < chunk->rows; r++) {
        o->still_rear_last = chunk->values[r * columns + columns - 2];
        if (o->still_rear_first == 0)
            o->still_rear_first = o->still_rear_last;
    }
    for (int k = 0; k < 2; k++)
        if (strcmp(chunk->stream->name, "snapshots") == 0 && fabs(chunk->t0_s - (k == 0 ? 0.6 : 0.9)) < 0.05)
            o->rear_over_middle[k] = rear_over_middle(chunk);
    if (strcmp(chunk->stream->name, "layers") == 0 && fabs(chunk->t0_s - 0.5) < 0.05)
        for (o->layers = 0; o->layers < chunk->rows && o->layers < LAYERS; o->layers++) {
            const double *row = chunk->values + o->layers * columns;
            o->layer_bodies[o->layers] = row[1];
            o->layer_speed[o->layers] = row[2];
            o->layer_cubes[o->layers] = row[4];
        }
    return SCREE_OK;
}

static void flow(int accelerator, struct outcome *o)
{
    struct job_spec job;
    const struct scree_sink sink = {.put = keep, .context = o};
    memset(o, 0, sizeof *o);
    job_defaults(&job, scenario_find("chute"));
    struct chute_params *p = (struct chute_params *)(void *)job.params;
    p->size_m = 3e-3;
    p->accelerator = accelerator;
    job.fragments.softening = 1000;
    job.time.step_s = 8.4e-6; // 0.3 of the Rayleigh time
    job.time.end_s = 1.5;
    job.stop.when = 0;
    job.record.flow.every_s = 0.1;
    job.record.snapshots = (struct record_every){true, 0.1};
    job.record.energy = (struct record_every){true, 0.05};
    o->summary = run(&job, &sink);
}

/* S3-04: mu_A within 0.05 of the lines of Figs 8 and 10 at the flow's own beta; S3-05: the smoother accelerator lets it go
 * farther; S3-07: the budget closes; overlaps stay small. */
static void mobility_is_near_the_published_lines(void **state)
{
    (void)state;
    static struct outcome o[2];
    const double a[2] = {0.029, 0.0348}, b[2] = {0.8154, 0.7119};
    for (int k = 0; k < 2; k++) {
        flow(k == 0 ? ACCELERATOR_CHUTE : ACCELERATOR_GATE, &o[k]);
        double mobility = number(&o[k].summary, "mobility"), line = a[k] * number(&o[k].summary, "beta") + b[k];
        if (!(fabs(mobility - line) < (k == 0 ? 0.05 : 0.08))) // few touch one another where they run fast
            fail_msg("mobility %g, published %g", mobility, line);
        assert_true(number(&o[k].summary, "mobility_lower") < mobility && mobility < number(&o[k].summary, "mobility_upper"));
        assert_true(fabs(number(&o[k].summary, "energy_residual")) < 0.015);
        assert_true(number(&o[k].summary, "overlap_reached") < 0.02);
    }
    assert_true(number(&o[1].summary, "mobility") < number(&o[0].summary, "mobility") - 0.02);
    assert_true(number(&o[1].summary, "mobility_lower") < number(&o[0].summary, "mobility_lower") - 0.02);

    /* S3-08: cubes at the top and at the front; speed falls towards the floor, where cubes are rare; backward accretion. */
    assert_true(number(&o[0].summary, "cube_height_rank") > 0.6 && number(&o[0].summary, "cube_front_rank") > 0.6);
    assert_true(o[0].layers >= 3 && o[0].layer_bodies[2] > 5);
    for (size_t k = 1; k < 3; k++) {
        assert_true(o[0].layer_speed[k] > o[0].layer_speed[k - 1]);
        assert_true(o[0].layer_cubes[k] > o[0].layer_cubes[0]);
    }
    assert_true(o[0].still_rear_last > 0 && o[0].still_rear_last < o[0].still_rear_first);
    /* The rear first follows the middle, then runs into what slows down before it: it accumulates at the back. */
    if (!(o[0].rear_over_middle[0] < 0.9 && o[0].rear_over_middle[1] > 1.3))
        fail_msg("rear over middle %g, then %g", o[0].rear_over_middle[0], o[0].rear_over_middle[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mobility_is_near_the_published_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
