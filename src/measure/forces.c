/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The network of contacts as frames: for pictures of force chains (seed 000,
 * movies S2 and S3) and their statistics. Movie S3's colours end at F_n = 400 rho g d^3,
 * which flows at 24.5 degrees exceed often (S0-28): the summary counts frames that do. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/measure.h"

static const struct scree_column columns[] = {
    {"a", "1"},  {"b", "1"},  {"x", "m"},  {"y", "m"},  {"z", "m"},       {"nx", "1"},
    {"ny", "1"}, {"nz", "1"}, {"fn", "N"}, {"ft", "N"}, {"overlap", "m"}, {"partner", "1"},
};
enum { COLUMNS = sizeof columns / sizeof *columns };
static const struct scree_stream stream = {"forces",
                                           "contacts of an instant: ids (b of a wall: its number), point of contact, normal from a "
                                           "to b, normal and tangential force, overlap; "
                                           "partner: 0 a moving grain, 1 a grain of the base, 2 a wall of the base, 3 another wall",
                                           columns, COLUMNS, true};
static const struct scree_stream *const streams[] = {&stream};

#define SATURATION 400.0 // rho g d^3

struct state {
    double largest;          // normal force of any frame, N
    double frames, exceeded; // frames; those with a force above the movies' scale
    struct series series;
};

static void row_of(const struct view *view, const struct view_contact *c, double row[COLUMNS])
{
    const double *x = view->position[c->a];
    bool wall = c->b >= VIEW_WALL;
    double across = 0;
    row[0] = view->id[c->a];
    row[1] = wall ? c->b - VIEW_WALL : view->id[c->b];
    for (int a = 0; a < 3; a++) {
        double at = x[a] + c->normal[a] * (x[3] - 0.5 * c->overlap), box = view->length[a];
        at = view->part_start ? c->point[a] : at; // bodies of parts have no radius
        row[2 + a] = box > 0 ? at - floor(at / box) * box : at;
        row[5 + a] = c->normal[a];
        double t = c->force[a] - c->force_normal * c->normal[a];
        across += t * t;
    }
    row[8] = c->force_normal;
    row[9] = sqrt(across);
    row[10] = c->overlap;
    row[11] = !wall ? c->on_base : c->on_base ? 2 : 3;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    const struct view *view = now->grains;
    s->frames += 1;
    if (view->contacts == 0)
        return SCREE_OK; // nothing touches: no frame
    double(*rows)[COLUMNS] = memory_rows(view->contacts, sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu contacts", view->contacts);
    double largest = 0, d = context->site.diameter;
    for (size_t k = 0; k < view->contacts; k++) {
        row_of(view, &view->contact[k], rows[k]);
        largest = fmax(largest, view->contact[k].force_normal);
    }
    double g =
        sqrt(view->gravity[0] * view->gravity[0] + view->gravity[1] * view->gravity[1] + view->gravity[2] * view->gravity[2]);
    s->largest = fmax(s->largest, largest);
    s->exceeded += largest > SATURATION * context->site.density * g * d * d * d;
    enum scree_status status = series_put_frame(&s->series, context->sink, context->time_s, rows[0], view->contacts, err);
    free(rows);
    return status;
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    (void)context;
    (void)now;
    const struct scree_number all[] = {
        {"largest_force", "N", "largest normal force of any contact in any frame", s->largest},
        {"frames_above_400", "1", "share of frames with a normal force above 400 rho g d^3",
         s->frames > 0 ? s->exceeded / s->frames : 0},
    };
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
}

const struct measurement measure_forces = {
    .name = "forces",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .sample = sample,
    .numbers = numbers,
};
