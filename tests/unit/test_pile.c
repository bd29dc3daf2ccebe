/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Image rules of a heap (targets S1-12), on heaps whose pictures are known. */
#include "unit.h"

#include <math.h>

#include "measure/measure.h"
#include "measure/pile.h"
#include "measure/raster.h"
#include "measure/repose.h"

/* Boxes with edges along the axes, one part each, and crusts of radius r. */
enum { BOXES_MAX = 40 };
static struct heap {
    struct view view;
    struct view_body body[BOXES_MAX];
    uint32_t start[BOXES_MAX + 1];
    double corner[8 * BOXES_MAX][4];
} heap;

static void add_box(double x0, double x1, double y0, double y1, double z0, double z1, double r)
{
    size_t k = heap.view.bodies++;
    heap.body[k] = (struct view_body){.id = (uint32_t)k,
                                      .mass = 1,
                                      .part_first = (uint32_t)k,
                                      .parts = 1,
                                      .position = {0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (z0 + z1)}};
    for (int c = 0; c < 8; c++) {
        double *at = heap.corner[8 * k + (size_t)c];
        at[0] = c & 1 ? x1 - r : x0 + r;
        at[1] = c & 2 ? y1 - r : y0 + r;
        at[2] = c & 4 ? z1 - r : z0 + r;
        at[3] = r;
    }
    heap.start[k + 1] = (uint32_t)(8 * (k + 1));
    heap.view.body = heap.body;
    heap.view.part_start = heap.start;
    heap.view.corner = (const double(*)[4])heap.corner;
}

static int empty(void **state)
{
    (void)state;
    heap = (struct heap){0};
    return 0;
}

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.12g is not within %.3g of %.12g", value, tolerance, expected);
}

static struct pile measured(double length, double width, double from, double pixel)
{
    struct pile p;
    assert_int_equal(pile_measure(&heap.view, length, width, from, pixel, &p, NULL), SCREE_OK);
    return p;
}

static void runout_is_where_the_cover_thins(void **state)
{
    (void)state;
    add_box(0, 0.2, 0, 0.1, 0, 0.05, 1e-4);      // whole width
    add_box(0.2, 0.25, 0, 0.015, 0, 0.01, 1e-4); // 15 % of it
    add_box(0.25, 0.3, 0, 0.005, 0, 0.01, 1e-4); // 5 %
    struct pile p = measured(0.4, 0.1, 0, 1e-3);
    assert_near(p.runout, 0.25, 1.01e-3);
    assert_near(p.runout_least, 0.2, 1.01e-3);
    assert_near(p.runout_most, 0.3, 1.01e-3);
}

/* A gap beside the back wall is not where the heap ends. */
static void what_lies_before_the_heap_does_not_count(void **state)
{
    (void)state;
    add_box(0.05, 0.2, 0, 0.1, 0, 0.05, 1e-4);
    assert_near(measured(0.4, 0.1, 0, 1e-3).runout, 0, 1e-12);
    assert_near(measured(0.4, 0.1, 0.1, 1e-3).runout, 0.2, 1.01e-3);
}

static void height_is_that_of_the_highest_body_across(void **state)
{
    (void)state;
    add_box(0, 0.1, 0, 0.05, 0, 0.02, 1e-4);
    add_box(0.1, 0.2, 0, 0.05, 0, 0.01, 1e-4); // lower, behind it
    add_box(0, 0.1, 0.05, 0.1, 0, 0.06, 1e-4);
    struct pile p = measured(0.3, 0.1, 0, 1e-3);
    assert_near(p.height, 0.04, 1e-9);
    assert_near(p.height_low, 0.02, 1e-9);
    assert_near(p.height_high, 0.06, 1e-9);
}

static void a_sphere_covers_its_disc(void **state)
{
    (void)state;
    heap.view.bodies = 1;
    heap.body[0] = (struct view_body){.mass = 2, .parts = 1, .position = {0.5, 0.5, 0.3}};
    heap.start[1] = 1;
    heap.corner[0][0] = heap.corner[0][1] = 0.5;
    heap.corner[0][2] = 0.3;
    heap.corner[0][3] = 0.3;
    heap.view.body = heap.body;
    heap.view.part_start = heap.start;
    heap.view.corner = (const double(*)[4])heap.corner;
    struct pile p = measured(1, 1, 0.5, 1e-3);
    assert_near(p.runout_most, 0.8, 2e-3);
    /* 10 % of the width is covered where the chord is 0.1. */
    assert_near(p.runout, 0.5 + sqrt(0.09 - 0.0025), 2e-3);
    assert_near(p.centre[2], 0.3, 1e-15);
    assert_near(p.height_high, 0.3 + sqrt(0.09 - 0.125 * 0.125), 2e-3); // a quarter of all lines is within 0.125 of the middle
}

/* ---- pictures ---- */

enum { WIDE = 8, HIGH = 4 };
struct painted {
    char pixel[2][HIGH][WIDE + 1]; // from above, from aside; top line first
    size_t frames[2];
};

/* Paints a frame with the letter of the body that each pixel shows, told by its speed. */
static enum scree_status paint(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct painted *painted = context;
    const bool above = strcmp(chunk->stream->name, "view_above") == 0;
    const struct scree_column *columns = chunk->stream->columns;
    (void)err;
    assert_string_equal(columns[0].name, "x");
    assert_string_equal(columns[1].name, above ? "y" : "z");
    assert_string_equal(columns[2].name, above ? "z" : "y");
    assert_int_equal(chunk->stream->column_count, 4);
    painted->frames[!above]++;
    for (size_t k = 0; k < chunk->rows; k++) {
        const double *row = chunk->values + 4 * k;
        double x = row[0] / 0.01 - 0.5, y = row[1] / 0.01 - 0.5; // whole numbers in the middle of a pixel
        size_t body = (size_t)round(row[3]) - 1;
        assert_true(x > -0.1 && x < WIDE && y > -0.1 && y < HIGH && body < heap.view.bodies);
        assert_near(x, round(x), 1e-9);
        assert_near(y, round(y), 1e-9);
        assert_near(row[2], heap.body[body].position[above ? 2 : 1], 1e-12);
        char *pixel = &painted->pixel[!above][HIGH - 1 - (size_t)round(y)][(size_t)round(x)];
        assert_int_equal(*pixel, '.'); // each pixel once
        *pixel = (char)('A' + body);
    }
    return SCREE_OK;
}

/* Three boxes on a floor of 8 by 4 pixels of 10 mm: A in front, B behind it and higher, C over B, partly out of the box. */
static void a_picture_shows_the_nearest_body_of_each_pixel(void **state)
{
    (void)state;
    static const char *const expected[2][HIGH] = {{".CC.....", ".CCBB...", "AA......", "AA......"},
                                                  {".CC.....", ".BBBB...", "AABBB...", "AABBB..."}};
    extern const struct measurement measure_views;
    add_box(0.00, 0.02, 0.00, 0.02, 0.00, 0.02, 1e-3);
    add_box(0.01, 0.05, 0.02, 0.03, 0.00, 0.03, 1e-3);
    add_box(0.01, 0.03, 0.02, 0.06, 0.03, 0.04, 1e-3);
    for (size_t k = 0; k < 3; k++)
        heap.body[k].velocity[k] = k == 1 ? -2.0 : 1.0 + (double)k;
    struct job_spec job = {.record.views.pixels = 8};
    struct painted painted = {0};
    const struct scree_sink sink = {paint, &painted};
    struct measure_context context = {
        .job = &job, .sink = &sink, .site = {.diameter = 0.08, .length_x = 0.08, .width_y = 0.04}, .time_s = 0.5};
    const struct measure_now now = {.grains = &heap.view};
    void *views = calloc(1, measure_views.size);
    assert_non_null(views);
    for (size_t k = 0; k < measure_views.stream_count; k++)
        assert_int_equal(series_start(&measure_series(&measure_views, views)[k], measure_views.streams[k], 0, 0, NULL), SCREE_OK);
    for (size_t frame = 1; frame <= 2; frame++) {
        memset(painted.pixel, '.', sizeof painted.pixel);
        assert_int_equal((frame == 1 ? measure_views.first : measure_views.sample)(views, &context, &now, NULL), SCREE_OK);
        for (size_t k = 0; k < 2; k++) {
            assert_int_equal(painted.frames[k], frame);
            for (size_t line = 0; line < HIGH; line++)
                assert_memory_equal(painted.pixel[k][line], expected[k][line], WIDE);
        }
    }
    assert_int_equal(measure_views.close(views, &context, &now, NULL), SCREE_OK);
    assert_int_equal(painted.frames[0], 2); // the end has been looked at
    memset(painted.pixel, '.', sizeof painted.pixel);
    context.time_s = 0.6;
    assert_int_equal(measure_views.close(views, &context, &now, NULL), SCREE_OK);
    assert_int_equal(painted.frames[0], 3);
    heap.view.bodies = 0;
    assert_int_equal(measure_views.sample(views, &context, &now, NULL), SCREE_OK);
    assert_int_equal(painted.frames[0], 3); // nothing to be seen: no frame
    for (size_t k = 0; k < measure_views.stream_count; k++)
        series_end(&measure_series(&measure_views, views)[k]);
    free(views);
}

/* What a world may ask for is no reason to run out of memory. */
static void pixels_grow_where_there_would_be_too_many(void **state)
{
    (void)state;
    struct raster r;
    add_box(0, 1, 0, 0.5, 0, 1, 1e-3);
    assert_int_equal(raster_draw(&heap.view, RASTER_ABOVE, 1, 1, 1e-9, &r, NULL), SCREE_OK);
    assert_near((double)(r.columns * r.lines) / RASTER_PIXELS_MAX, 1, 1e-3);
    assert_near(r.pixel * (double)r.columns, 1, 1e-3);
    const uint32_t *middle = &r.body[r.columns / 2 * r.lines];
    assert_int_equal(middle[r.lines / 4], 0);
    assert_true(middle[3 * r.lines / 4] == RASTER_NOTHING);
    raster_free(&r);
}

static void shares_below_a_threshold(void **state)
{
    (void)state;
    const double share[] = {0.05, 0.5, 0.1, 0.09, 0.5};
    assert_int_equal(pile_first_below(share, 5, 0, 0.1), 0);
    assert_int_equal(pile_first_below(share, 5, 1, 0.1), 3);
    assert_int_equal(pile_first_below(share, 5, 4, 0.1), 5);
}

/* A cone of bodies at 30 degrees, and one that is still in the hopper. */
static void slope_of_a_cone(void **state)
{
    (void)state;
    enum { SIDE = 80 };
    static struct view_body beads[SIDE * SIDE + 1];
    const double spacing = 2e-3, floor = 0.16, volume = 4 * M_PI / 3 * 1e-9, slope = tan(M_PI / 6);
    for (int k = 0; k < SIDE * SIDE; k++) {
        double x = (k % SIDE + 0.5) * spacing, y = (double)(k / SIDE) * spacing + 1e-3, z = 0.04;
        z -= slope * hypot(x - floor / 2, y - floor / 2);
        beads[k] = (struct view_body){.position = {x, y, fmax(0, z - 1e-3)}, .volume = volume};
    }
    beads[SIDE * SIDE] = (struct view_body){.position = {0.08, 0.08, 0.2}, .volume = volume};
    const struct view v = {.bodies = SIDE * SIDE + 1, .body = beads};
    struct repose r;
    assert_int_equal(repose_measure(&v, floor, 0.1, 4e-3, &r, NULL), SCREE_OK);
    assert_near(r.angle, 30, 1);
    assert_near(r.height, 0.038, 2e-3);
    assert_near(r.left * (double)v.bodies, 1, 1e-9);
    repose_free(&r);
    const struct view none = {.bodies = 1, .body = beads + SIDE * SIDE};
    assert_int_equal(repose_measure(&none, floor, 0.1, 4e-3, &r, NULL), SCREE_OK);
    assert_true(r.height == 0 && r.left == 1);
    repose_free(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(runout_is_where_the_cover_thins, empty),
        cmocka_unit_test_setup(what_lies_before_the_heap_does_not_count, empty),
        cmocka_unit_test_setup(height_is_that_of_the_highest_body_across, empty),
        cmocka_unit_test_setup(a_sphere_covers_its_disc, empty),
        cmocka_unit_test_setup(a_picture_shows_the_nearest_body_of_each_pixel, empty),
        cmocka_unit_test_setup(pixels_grow_where_there_would_be_too_many, empty),
        cmocka_unit_test(shares_below_a_threshold),
        cmocka_unit_test(slope_of_a_cone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
