/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The force of the flow on its base: summed at every step by the engine, mean over
 * each block of steps (protocols 1.6, 1.7). Blocks are averaged, never decimated,
 * so that nothing above the Nyquist frequency folds back unattenuated. */
#include <math.h>
#include <stddef.h>

#include "measure/measure.h"
#include "measure/window.h"

static const struct scree_column columns[] = {{"Fx", "N"}, {"Fy", "N"}, {"Fz", "N"}};
static const struct scree_stream stream = {"basal_force", "force of the flow on its base, mean over each block of steps", columns,
                                           3, false};
static const struct scree_stream *const streams[] = {&stream};

struct state {
    struct window window; // three components and the mass above, weighted by steps
    struct series series;
};
enum { MASS = 3 }; // in the window, after the force

static size_t chunk(const struct measure_context *context)
{
    return (size_t)context->job->record.basal_force.chunk;
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
    double values[WINDOW_VALUES] = {now->base_force[0], now->base_force[1], now->base_force[2], context->here.mass};
    window_add(&s->window, context->time_s, (double)now->every, values);
    return series_add(&s->series, context->sink, context->time_s, values, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    (void)now;
    const struct state *s = state;
    double force[WINDOW_VALUES];
    if (context->site.area_z <= 0)
        return 0;
    double window = window_means(&s->window, measure_window_from(context), force);
    double weight = force[MASS] * -context->gravity[2], pull = force[MASS] * context->gravity[0];
    const struct scree_number all[] = {
        {"window_start", "s", "means below are from here to the end: t_0 if steady, else the last half", window},
        {"mean_force_x", "N", "downslope force on the base", force[0]},
        {"mean_force_y", "N", "cross-slope", force[1]},
        {"mean_force_z", "N", "base-normal, negative into the base", force[2]},
        {"weight_normal", "N", "weight of the flow along the base's normal", weight},
        {"force_over_weight", "1", "mean normal force over weight: 1 when steady", -force[2] / weight},
        {"weight_tangential", "N", "weight of the flow downslope", pull},
        {"friction_ratio", "1", "mean downslope over normal force", -force[0] / force[2]},
    };
    return measure_numbers(out, room, all, sizeof all / sizeof *all);
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

const struct measurement measure_basal_force = {
    .name = "basal_force",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_BASE_FORCE,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .chunk = chunk,
    .start = start,
    .sample = sample,
    .numbers = numbers,
    .used = used,
    .sound = sound,
};

/* The same of a continuum. */
const struct measurement measure_basal_force_continuum = {
    .name = "basal_force",
    .kind = SCENARIO_MPM,
    .needs = MEASURE_BASE_FORCE,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .chunk = chunk,
    .start = start,
    .sample = sample,
    .numbers = numbers,
    .used = used,
    .sound = sound,
};
