/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Records of single grains and contacts, on states made by hand: frames of
 * `snapshots` and `forces`, and the log `collisions` with its window, its region
 * and its percentiles. */
#include "unit.h"

#include <math.h>

#include "measure/measure.h"

extern const struct measurement measure_snapshots, measure_forces, measure_collisions;

enum { VALUES_MAX = 1 << 16 };

/* What a measurement wrote: the rows of its last chunk, and how many chunks and rows there were. */
struct told {
    size_t chunks, rows, last, columns;
    double t0_s, values[VALUES_MAX];
};

static enum scree_status keep(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct told *told = context;
    (void)err;
    told->chunks++;
    told->rows += chunk->rows;
    told->last = chunk->rows;
    told->columns = chunk->stream->column_count;
    told->t0_s = chunk->t0_s;
    assert_true(told->last * told->columns <= VALUES_MAX);
    memcpy(told->values, chunk->values, told->last * told->columns * sizeof(double));
    return SCREE_OK;
}

/* A measurement outside of a world. */
struct taken {
    const struct measurement *what;
    struct job_spec job;
    struct measure_context context;
    struct scree_sink sink;
    struct told told;
    void *state;
};

static void start(struct taken *t, const struct measurement *what)
{
    struct scree_error err = {0};
    memset(t, 0, sizeof *t);
    job_defaults(&t->job, scenario_find("incline"));
    t->what = what;
    t->sink = (struct scree_sink){.put = keep, .context = &t->told};
    t->context = (struct measure_context){.job = &t->job, .sink = &t->sink};
    t->context.site.region[0] = -INFINITY;
    t->context.site.region[1] = INFINITY;
    t->context.verdict.t0_s = -1;
    t->state = calloc(1, what->size);
    assert_non_null(t->state);
    size_t capacity = what->chunk ? what->chunk(&t->context) : 0;
    assert_int_equal(series_start(measure_series(what, t->state), what->streams[0], capacity, 0, &err), SCREE_OK);
    if (what->start)
        assert_int_equal(what->start(t->state, &t->context, &err), SCREE_OK);
}

static void sample(struct taken *t, const struct view *view)
{
    struct scree_error err = {0};
    const struct measure_now now = {.grains = view, .every = 1};
    t->context.time_s = view->time_s;
    assert_int_equal(t->what->sample(t->state, &t->context, &now, &err), SCREE_OK);
}

static double number(const struct taken *t, const char *name)
{
    struct scree_number numbers[16];
    const struct measure_now now = {0};
    size_t count = t->what->numbers(t->state, &t->context, &now, numbers, COUNT(numbers));
    for (size_t k = 0; k < count; k++)
        if (strcmp(numbers[k].name, name) == 0)
            return numbers[k].value;
    fail_msg("no number %s", name);
    return 0;
}

static void end(struct taken *t)
{
    series_end(measure_series(t->what, t->state));
    for (size_t k = 0; k < t->what->buffer_count; k++)
        free(measure_buffers(t->what, t->state)[k].values);
    free(t->state);
}

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.12g is not within %.3g of %.12g", value, tolerance, expected);
}

static void assert_row(const struct told *told, size_t k, const double *expected)
{
    for (size_t c = 0; c < told->columns; c++)
        assert_near(told->values[k * told->columns + c], expected[c], 1e-15);
}

/* Three grains, of which memory holds the last first and one of the base behind. */
static const uint32_t id[] = {1, 0, 2};
static const double position[][4] = {{0.5, 0.2, 0.3, 1e-3}, {0.0005, 0.1, 0.1, 2e-3}, {0.3, 0.3, 0, 1.5e-3}};
static const double velocity[][4] = {{1, 2, 3, 4e-6}, {-1, -2, -3, 5e-6}, {0, 0, 0, 6e-6}};
static const double spin[][4] = {{7, 8, 9, 1}, {10, 11, 12, 1}, {0, 0, 0, 1}};
static const struct view three = {.time_s = 0.25,
                                  .length = {1, 1, 0},
                                  .periodic = {1, 1, 0},
                                  .gravity = {0, 6, -8},
                                  .moving = 2,
                                  .fixed = 1,
                                  .id = id,
                                  .position = position,
                                  .velocity = velocity,
                                  .spin = spin};

static void a_snapshot_is_every_grain_by_its_id(void **state)
{
    (void)state;
    struct taken t;
    start(&t, &measure_snapshots);
    sample(&t, &three);
    assert_int_equal(t.told.chunks, 1);
    assert_int_equal(t.told.last, 3);
    assert_near(t.told.t0_s, 0.25, 0);
    const double expected[3][13] = {{0, 0.0005, 0.1, 0.1, 2e-3, -1, -2, -3, 10, 11, 12, 5e-6, 0},
                                    {1, 0.5, 0.2, 0.3, 1e-3, 1, 2, 3, 7, 8, 9, 4e-6, 0},
                                    {2, 0.3, 0.3, 0, 1.5e-3, 0, 0, 0, 0, 0, 0, 6e-6, 1}};
    for (size_t k = 0; k < 3; k++)
        assert_row(&t.told, k, expected[k]);
    end(&t);
}

/* A contact through a periodic face, one with the base, one each with walls of the base and others: names, places, the two
 * parts of a force; and the force above which frames are counted, 400 rho g d^3 (S0-28), which is 0.08 N here. */
static void a_frame_of_forces_is_the_network(void **state)
{
    (void)state;
    const struct view_contact contacts[] = {
        {.a = 1, .b = 0, .overlap = 1e-3, .normal = {-1, 0, 0}, .force = {-3, 0.3, 0.4}, .force_normal = 3},
        {.a = 0, .b = 2, .on_base = 1, .overlap = 2e-4, .normal = {0, 0, -1}, .force = {0, 0, -0.07}, .force_normal = 0.07},
        {.a = 0, .b = VIEW_WALL, .on_base = 1, .normal = {0, 0, -1}, .force = {0.6, 0.8, 1}, .force_normal = -1},
        {.a = 0, .b = VIEW_WALL + 2, .normal = {0, 1, 0}, .force = {0, 1, 0}, .force_normal = 1},
    };
    struct view view = three, quiet = three;
    view.contact = contacts;
    view.contacts = COUNT(contacts);
    quiet.contact = &contacts[1];
    quiet.contacts = 1;
    struct taken t;
    start(&t, &measure_forces);
    t.context.site.density = 2500;
    t.context.site.diameter = 2e-3;
    sample(&t, &view);
    assert_int_equal(t.told.last, COUNT(contacts));
    /* The first is midway between the surfaces, 1.5 mm to the left of a grain at 0.5 mm: at the right end of the box. */
    const double expected[COUNT(contacts)][12] = {
        {0, 1, 0.999, 0.1, 0.1, -1, 0, 0, 3, 0.5, 1e-3, 0},
        {1, 2, 0.5, 0.2, 0.3 - 0.9e-3, 0, 0, -1, 0.07, 0, 2e-4, 1},
        {1, 0, 0.5, 0.2, 0.299, 0, 0, -1, -1, 1, 0, 2},
        {1, 2, 0.5, 0.201, 0.3, 0, 1, 0, 1, 0, 0, 3},
    };
    for (size_t k = 0; k < COUNT(contacts); k++)
        assert_row(&t.told, k, expected[k]);
    sample(&t, &quiet);
    assert_int_equal(t.told.last, 1);
    view.contacts = 0;
    sample(&t, &view);
    assert_int_equal(t.told.chunks, 2); // nothing touched: no frame, though it counts
    assert_near(number(&t, "largest_force"), 3, 0);
    assert_near(number(&t, "frames_above_400"), 1.0 / 3, 1e-15);
    end(&t);
}

/* Ten thousand impacts with speeds 2e-4, 4e-4 .. 1 m/s, each twice, one every 0.1 ms: all are counted in the window, which is the
 * last half of a run that is not steady; those before from_s are not in the stream, those outside the region or with other walls
 * not in the numbers. */
static void collisions_are_counted_and_ranked(void **state)
{
    (void)state;
    enum { MANY = 10000 };
    struct taken t;
    struct scree_error err = {0};
    start(&t, &measure_collisions);
    t.job.record.collisions.from_s = 0.95;
    t.context.site.region[0] = 0.5;
    t.context.here.grains = 20;
    for (int k = 0; k < MANY; k++) {
        struct view_formation f = {.time_s = 1e-4 * k + 5e-5,
                                   .a = 3,
                                   .b = 4,
                                   .place = {0.1, 0.6, 0.2},
                                   .approach = 2e-4 * ((k * 7 + 1) % (MANY / 2) + 1), // in no order, each once in each half
                                   .tangential = {0, 0.3, 0.4}};
        struct view_formation others[3] = {f, f, f};
        others[0].place[1] = 0.49; // not of the region
        others[1].b = VIEW_WALL + 1;
        others[2].b = VIEW_WALL;
        others[2].fixed = 1; // of the base: one more that counts
        t.context.time_s = f.time_s;
        assert_int_equal(t.what->formed(t.state, &t.context, &f, 1, &err), SCREE_OK);
        assert_int_equal(t.what->formed(t.state, &t.context, others, COUNT(others), &err), SCREE_OK);
    }
    t.context.time_s = 1;
    assert_near(number(&t, "collisions"), MANY, 0);
    assert_near(number(&t, "collisions_per_s"), 2 * MANY, 1e-9);
    assert_near(number(&t, "collisions_per_grain_s"), MANY / 10.0, 1e-9);
    assert_near(number(&t, "impact_tangential2"), 0.25, 1e-12);
    assert_near(number(&t, "impact_normal2"), 1.0 / 3, 1e-3);
    assert_near(number(&t, "impact_median"), 0.5, 0.005);
    assert_near(number(&t, "impact_p999"), 0.999, 0.01);
    assert_int_equal(series_flush(measure_series(t.what, t.state), &t.sink, &err), SCREE_OK);
    assert_int_equal(t.told.rows, 4 * MANY / 20);
    const double last[] = {0.99995, 0.1, 0.6, 0.2, 2e-4 * (((MANY - 1) * 7 + 1) % (MANY / 2) + 1), 0.5, 3, 0, 2};
    assert_row(&t.told, t.told.last - 1, last);
    end(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_snapshot_is_every_grain_by_its_id),
        cmocka_unit_test(a_frame_of_forces_is_the_network),
        cmocka_unit_test(collisions_are_counted_and_ranked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
