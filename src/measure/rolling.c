/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The sphere of scenario `rolling`: where it is, how fast, and what its motion says of the rolling resistance.
 *
 * A sphere that turns back, or is slower than flows at rest are, has come to a stop; one that reaches the bottom of the plane
 * flows: as in the experiment, which looks at nothing else. Once it has stopped it rocks without slipping in its rolling
 * resistance, and eq. 27 is fitted from there on. It gives K = w^2 + g^2 and beta_r = 2 g / K. K is the stiffness over the
 * inertia that takes part, which for a sphere that rolls on a plane without sliding is I + m r^2 = 7/5 m r^2:
 *     K = 2 kappa F r / (7/5 m r^2) = 10 kappa F / (7 m r).
 * The paper divides by the sphere's own I and takes half its radius (k_r / I = 5 kappa g / 2 r): the kappa of that relation is
 * 4/7 of what the law was given, and is put beside it. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "calibrate/oscillation.h"
#include "measure/measure.h"

enum { COLUMNS = 4 };
static const struct scree_column columns[COLUMNS] = {{"time", "s"}, {"distance", "m"}, {"velocity", "m/s"}, {"spin", "rad/s"}};
static const struct scree_stream stream = {"rolling", "way down the slope, velocity and spin of the sphere", columns, COLUMNS,
                                           false};
static const struct scree_stream *const streams[] = {&stream};

struct state {
    double speed, distance; // at the last sample, m/s, m
    double start;           // distance at t = 0
    double stop_s;          // when it first turned back; 0: not yet
    struct series series;
    struct measure_buffer rocking; // velocities from then on
};

static const struct rolling_params *params_of(const struct measure_context *context)
{
    return (const struct rolling_params *)(const void *)context->job->params;
}

static enum scree_status start(void *state, const struct measure_context *context, struct scree_error *err)
{
    (void)context;
    (void)err;
    ((struct state *)state)->rocking.most = ROLLING_SAMPLES_MAX + 1;
    return SCREE_OK;
}

static enum scree_status first(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    struct state *s = state;
    (void)context;
    (void)err;
    s->start = now->grains->position[0][0];
    s->speed = now->grains->velocity[0][0];
    return SCREE_OK;
}

static void judge(struct state *s, struct measure_context *context)
{
    struct verdict *v = &context->verdict;
    if (v->current != VERDICT_UNDECIDED)
        return;
    if (s->stop_s > 0) {
        v->current = VERDICT_REST;
        snprintf(v->evidence, sizeof v->evidence, "stopped after %.4g m at %.4g s", s->distance, s->stop_s);
    } else if (s->distance >= params_of(context)->length_m) {
        v->current = VERDICT_ACCELERATING;
        snprintf(v->evidence, sizeof v->evidence, "reached the bottom, %.4g m away, at %.4g s, at %.4g m/s",
                 params_of(context)->length_m, context->time_s, s->speed);
    }
    context->stop = context->stop || (v->current && context->job->stop.when >> (v->current - 1) & 1);
}

static enum scree_status sample(void *state, struct measure_context *context, const struct measure_now *now,
                                struct scree_error *err)
{
    struct state *s = state;
    const struct view *view = now->grains;
    double velocity = view->velocity[0][0];
    double calm = VERDICT_CALM * sqrt(fabs(context->gravity[2]) * context->site.diameter);
    if (s->stop_s == 0 && (velocity * s->speed < 0 || fabs(velocity) < calm))
        s->stop_s = context->time_s;
    s->speed = velocity;
    s->distance = view->position[0][0] - s->start;
    judge(s, context);
    enum scree_status status = SCREE_OK;
    if (s->stop_s > 0 && !(status = measure_buffer_resize(&s->rocking, s->rocking.count + 1, err)))
        s->rocking.values[s->rocking.count - 1] = velocity;
    const double row[COLUMNS] = {context->time_s, s->distance, velocity, view->spin[0][1]};
    return status ? status : series_add(&s->series, context->sink, context->time_s, row, err);
}

static size_t numbers(const void *state, const struct measure_context *context, const struct measure_now *now,
                      struct scree_number *out, size_t room)
{
    const struct state *s = state;
    const struct material_spec *m = &context->job->material;
    double interval = context->job->time.step_s * fmax(1, round(context->job->record.rolling.every_s / context->job->time.step_s));
    const struct scree_number way[] = {
        {"distance", "m", "down the slope", s->distance},
        {"velocity", "m/s", "down the slope, at the end", s->speed},
    };
    (void)now;
    size_t count = measure_numbers(out, room, way, sizeof way / sizeof *way);
    struct oscillation o;
    if (!oscillation_fit(s->rocking.values, s->rocking.count, interval, &o))
        return count;
    double stiffness = o.rate * o.rate + o.decay * o.decay, pull = fabs(context->gravity[2]); // F / m
    const struct scree_number fit[] = {
        {"rocking_rate", "rad/s", "omega of eq. 27 (with the minus sign), fitted from where it first turned back", o.rate},
        {"rocking_decay", "1/s", "beta_r k_r / 2 I of eq. 27", o.decay},
        {"natural_rate", "rad/s", "root of k_r over the inertia that takes part", sqrt(stiffness)},
        {"rocking_misfit", "1", "root mean square of the fit's residuals over that of the velocity", o.misfit},
        {"kappa", "1", "rolling stiffness modulus, of rolling without slip on a plane", 0.7 * stiffness * m->radius_m / pull},
        {"kappa_as_printed", "1", "by k_r / I = 5 kappa g / 2 r, as the paper has it", 0.4 * stiffness * m->radius_m / pull},
        {"beta_r", "s", "rolling damping", 2 * o.decay / stiffness},
    };
    return count + measure_numbers(out + count, room - count, fit, sizeof fit / sizeof *fit);
}

const struct measurement measure_rolling = {
    .name = "rolling",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct state),
    .plain = offsetof(struct state, series),
    .series = offsetof(struct state, series),
    .streams = streams,
    .stream_count = 1,
    .buffers = offsetof(struct state, rocking),
    .buffer_count = 1,
    .start = start,
    .first = first,
    .sample = sample,
    .numbers = numbers,
};
