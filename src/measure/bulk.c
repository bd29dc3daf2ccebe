/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See bulk.h. Sums run over rows in memory order, which is part of a world's
 * state, so they are the same in every run. */
#include "measure/bulk.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/vec3.h"
#include "measure/measure.h"
#include "measure/window.h"

static const struct scree_column bulk_columns[BULK_COLUMNS] = {
    {"time", "s"}, {"kinetic", "J"}, {"elastic", "J"}, {"speed_rms", "m/s"}, {"centre_z", "m"}, {"vx", "m/s"},     {"vy", "m/s"},
    {"vz", "m/s"}, {"px", "kg m/s"}, {"py", "kg m/s"}, {"pz", "kg m/s"},     {"force_z", "N"},  {"contacts", "1"},
};
static const struct scree_stream bulk_stream = {
    "bulk", "energies, centre of mass and momentum of the moving grains that are measured", bulk_columns, BULK_COLUMNS, false};

void bulk_measure(const struct view *view, struct bulk *out)
{
    static const double everywhere[2] = {-INFINITY, INFINITY};
    bulk_measure_within(view, everywhere, out);
}

static bool inside(const struct view *view, const double region[2], size_t row)
{
    return view->position[row][1] >= region[0] && view->position[row][1] < region[1];
}

void bulk_measure_within(const struct view *view, const double region[2], struct bulk *out)
{
    double translation = 0;
    *out = (struct bulk){.time_s = view->time_s};
    for (size_t i = 0; i < view->moving; i++) {
        if (!inside(view, region, i))
            continue;
        out->grains++;
        const double *v = view->velocity[i], *w = view->spin[i], r = view->position[i][3];
        if (!view->bodies) {
            translation += 0.5 * v[3] * vec3_square(v);
            out->rotation += 0.5 * w[3] * vec3_square(w);
        }
        for (int a = 0; a < 3; a++)
            out->momentum[a] += v[3] * v[a];
        out->centre_z += v[3] * view->position[i][2];
        out->mass += v[3];
        out->volume += 4.0 / 3.0 * M_PI * r * r * r;
    }
    if (view->bodies)
        out->volume = 0;
    for (size_t k = 0; k < view->bodies; k++) {
        const struct view_body *b = &view->body[k];
        translation += 0.5 * b->mass * vec3_square(b->velocity);
        out->rotation += 0.5 * (b->spin[0] * b->momentum[0] + b->spin[1] * b->momentum[1] + b->spin[2] * b->momentum[2]);
        out->volume += b->volume;
    }
    double sides = 0;
    for (size_t k = 0; k < view->contacts; k++) {
        const struct view_contact *c = &view->contact[k];
        bool a = inside(view, region, c->a), b = c->b < view->moving && inside(view, region, c->b);
        out->elastic += a ? c->elastic : 0;
        sides += a + b;
    }
    out->kinetic = translation + out->rotation;
    double mass = out->mass > 0 ? out->mass : 1; // there need not be a grain inside
    out->centre_z /= mass;
    out->speed_rms = sqrt(2 * translation / mass);
    out->contacts = out->grains > 0 ? sides / out->grains : 0;
    for (int a = 0; a < 3; a++) {
        out->velocity[a] = out->momentum[a] / mass;
        out->force[a] = view->base_force[a];
    }
}

void bulk_row(const struct bulk *b, double row[BULK_COLUMNS])
{
    const double values[BULK_COLUMNS] = {b->time_s,      b->kinetic,     b->elastic,     b->speed_rms,   b->centre_z,
                                         b->velocity[0], b->velocity[1], b->velocity[2], b->momentum[0], b->momentum[1],
                                         b->momentum[2], b->force[2],    b->contacts};
    for (int k = 0; k < BULK_COLUMNS; k++)
        row[k] = values[k];
}

/* ---- the measurement ---- */

static const struct scree_stream *const streams[] = {&bulk_stream};

struct state {
    struct window window; // of what samples say, each of weight 1
    struct series series;
};
enum { MEAN_HEIGHT, MEAN_VX, MEAN_SPEED, MEAN_CONTACTS, MEAN_KINETIC, MEAN_VOLUME }; // in the window

/* The summary speaks of it even where nobody records it. */
static bool wanted(const struct measure_context *context)
{
    return context->site.area > 0;
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    (void)context;
    (void)err;
    window_start(&((struct state *)state)->window);
    return SCREE_OK;
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    const struct bulk *b = &context->here;
    double values[WINDOW_VALUES] = {b->centre_z, b->velocity[0], b->speed_rms, b->contacts, b->kinetic, b->volume};
    (void)now;
    window_add(&s->window, b->time_s, 1, values);
    if (!s->series.values)
        return SCREE_OK;
    double row[BULK_COLUMNS];
    bulk_row(b, row);
    return series_add(&s->series, context->sink, b->time_s, row, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    (void)now;
    const struct measure_site *site = &context->site;
    double mean[WINDOW_VALUES];
    if (site->area_z <= 0)
        return 0;
    double from = window_means(&((const struct state *)state)->window, measure_window_from(context), mean);
    double d = site->diameter, g = hypot(context->gravity[0], context->gravity[2]);
    double height = 2 * (mean[MEAN_HEIGHT] - site->base_z), fraction = mean[MEAN_VOLUME] / (site->area_z * height);
    /* Bagnold's profile: local inertial number from the mean velocity (protocols 1.11). */
    double inertial = 2.5 * mean[MEAN_VX] * d / (height * sqrt(fraction * -context->gravity[2] * height));
    const struct scree_number all[] = {
        {"window_start", "s", "means below are from here to the end: t_0 if steady, else the last half", from},
        {"flow_height", "m", "twice the height of the centre of mass over the base", height},
        {"solid_fraction", "1", "volume of grains over area times flow height", fraction},
        {"mean_velocity", "m/s", "of the flow downslope", mean[MEAN_VX]},
        {"mean_velocity_sqrt_gd", "1", "the same over sqrt(g d)", mean[MEAN_VX] / sqrt(g * d)},
        {"inertial_number", "1", "bulk, from a Bagnold profile", inertial},
        {"speed_rms", "m/s", "root mean square speed of the grains", mean[MEAN_SPEED]},
        {"contacts_per_grain", "1", "coordination number", mean[MEAN_CONTACTS]},
        {"kinetic_energy", "J", "", mean[MEAN_KINETIC]},
        {"steady_since", "s", "t_0, -1 if the flow was not found steady", context->verdict.t0_s},
        {"fixed_per_d2", "1", "grains of the base over its area in grain diameters squared",
         (double)context->fixed * d * d / site->area},
    };
    /* The force on the base, where it is recorded, has said from when. */
    size_t skip = context->job->record.basal_force.on;
    return measure_numbers(out, room, all + skip, sizeof all / sizeof *all - skip);
}

static size_t used(const void *state)
{
    return window_bytes(&((const struct state *)state)->window);
}

static bool sound(const void *state, const struct measure_context *context)
{
    (void)context;
    return window_sound(&((const struct state *)state)->window);
}

const struct measurement measure_bulk = {
    .name = "bulk",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .wanted = wanted,
    .start = start,
    .sample = sample,
    .numbers = numbers,
    .used = used,
    .sound = sound,
};
