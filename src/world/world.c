/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The narrow waist: everything that the service sees of the physics.
 *
 * A world runs its body from one instant at which a measurement is due to the
 * next. All intervals are whole numbers of steps from t = 0, so that slices never
 * show. Which bodies there are is kind.h's affair, which measurements that of
 * measure/registry.c. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "world/state.h"

const char *scree_verdict_word(enum scree_verdict verdict)
{
    static const char *const words[] = {"undecided", "rest", "steady", "accelerating"};
    return words[verdict];
}

const char *scree_build(void)
{
    return SCREE_VERSION " (" SCREE_COMPILER ", " SCREE_BUILD ")";
}

/* ---- making ---- */

uint64_t world_every(const struct measurement *what, const struct job_spec *job)
{
    if (!what->sample)
        return 0;
    double every_s = what->interval_s;
    if (every_s <= 0)
        every_s = record_find(job, what->every_of ? what->every_of : what->name).every_s;
    return (uint64_t)fmax(1, round(every_s / job->time.step_s));
}

static enum scree_status start_series(struct scree_world *w, const struct measured *m, struct scree_error *err)
{
    const struct measurement *what = m->what;
    size_t capacity = what->chunk ? what->chunk(&w->context) : MEASURE_CHUNK;
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < what->stream_count && !status; k++) {
        w->streams[w->stream_count++] = what->streams[k];
        status = series_start(&measure_series(what, m->state)[k], what->streams[k], what->streams[k]->frames ? 0 : capacity,
                              (double)m->every * w->job.time.step_s, err);
    }
    return status;
}

static enum scree_status start_measurements(struct scree_world *w, struct scree_error *err)
{
    for (size_t k = 0; k < measurement_count; k++) {
        const struct measurement *what = measurement_list[k];
        bool wanted = what->wanted ? what->wanted(&w->context) : !what->name;
        bool recorded = what->name ? record_find(&w->job, what->name).on : wanted;
        if (what->kind != w->kind->kind || (!recorded && !wanted))
            continue;
        struct measured *m = &w->measured[w->measured_count];
        *m = (struct measured){.what = what, .recorded = recorded, .every = world_every(what, &w->job)};
        m->state = memory_rows(1, what->size);
        if (!m->state)
            return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a measurement");
        w->measured_count++;
        w->making.needs |= what->needs;
        enum scree_status status;
        if ((recorded && (status = start_series(w, m, err))) || (what->start && (status = what->start(m->state, &w->context, err))))
            return status;
    }
    return SCREE_OK;
}

void world_look(struct scree_world *w)
{
    w->context.step = w->step;
    if (!w->body)
        return;
    struct world_counts counts = w->kind->counts(w->body);
    w->context.time_s = counts.time_s;
    w->context.moving = counts.moving;
    w->context.fixed = counts.fixed;
}

static void bulk_sums(struct scree_world *w, const struct view *view)
{
    const double *region = w->context.site.region;
    bulk_measure(view, &w->context.last);
    w->context.here = w->context.last;
    if (isfinite(region[0]) || isfinite(region[1]))
        bulk_measure_within(view, region, &w->context.here);
}

static enum scree_status take_view(struct scree_world *w, struct measure_now *now, struct scree_error *err)
{
    enum scree_status status = w->kind->view(w->body, now, err);
    if (!status && now->grains)
        bulk_sums(w, now->grains);
    if (!status && now->points)
        w->context.here = w->context.last = (struct bulk){.mass = now->points->density * now->points->volume};
    return status;
}

/* The state at t = 0: energies, and what measurements want of it. */
static enum scree_status look_first(struct scree_world *w, struct scree_error *err)
{
    struct measure_now now = {0};
    enum scree_status status = take_view(w, &now, err);
    w->context.start_energy = w->context.last.kinetic + w->context.last.elastic;
    for (size_t k = 0; k < w->measured_count && !status; k++)
        if (w->measured[k].what->first)
            status = w->measured[k].what->first(w->measured[k].state, &w->context, &now, err);
    return status;
}

enum scree_status world_prepare(const struct job_spec *job, const struct scree_options *options, const struct scree_sink *sink,
                                struct scree_world **out, struct scree_error *err)
{
    const struct world_kind *kind = world_kind_find(job);
    if (!kind)
        return scree_fail(err, SCREE_INTERNAL, "scenario", "scenario %s has no implementation", job->scenario->name);
    struct scree_world *w = memory_rows(1, sizeof *w);
    if (!w)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    w->job = *job;
    w->sink = *sink;
    w->kind = kind;
    w->making = world_making_of(job, options);
    w->end_step = (uint64_t)fmax(1, round(job->time.end_s / job->time.step_s));
    w->context.job = &w->job;
    w->context.sink = &w->sink;
    kind->gravity(job, w->context.gravity);
    enum scree_status status = kind->site(job, &w->context.site, err);
    if (!status)
        status = start_measurements(w, err);
    if (status)
        scree_world_free(w);
    else
        *out = w;
    return status;
}

enum scree_status scree_world_create(const struct job_spec *job, const struct scree_options *options, const struct scree_sink *sink,
                                     struct scree_world **out, struct scree_error *err)
{
    struct scree_world *w = NULL;
    enum scree_status status = world_prepare(job, options, sink, &w, err);
    if (status)
        return status;
    if ((status = w->kind->build(job, &w->making, &w->body, err))) {
        scree_world_free(w);
        return status;
    }
    world_look(w);
    const struct measure_site *site = &w->context.site;
    const double *gravity = w->context.gravity, d = site->diameter;
    double g = sqrt(gravity[0] * gravity[0] + gravity[1] * gravity[1] + gravity[2] * gravity[2]);
    double layers = site->area > 0 ? (double)w->context.moving * d * d / site->area : 0;
    verdict_start(&w->context.verdict, d, g > 0 ? g : 1, layers, site->calm > 0 ? site->calm : VERDICT_CALM);
    if ((status = look_first(w, err)))
        scree_world_free(w);
    else
        *out = w;
    return status;
}

void scree_world_free(struct scree_world *w)
{
    if (!w)
        return;
    w->kind->free(w->body);
    for (size_t k = 0; k < w->measured_count; k++) {
        const struct measurement *what = w->measured[k].what;
        void *state = w->measured[k].state;
        for (size_t s = 0; s < what->stream_count; s++)
            series_end(&measure_series(what, state)[s]);
        for (size_t b = 0; b < what->buffer_count; b++)
            free(measure_buffers(what, state)[b].values);
        free(state);
    }
    free((void *)(uintptr_t)w->context.site.fall.release);
    free(w);
}

/* ---- advancing ---- */

/* Divisions once a slice: a force recorded at every step would feel them. */
static void schedule(struct scree_world *w)
{
    for (size_t k = 0; k < w->measured_count; k++) {
        uint64_t every = w->measured[k].every;
        w->measured[k].due = every ? (w->step / every + 1) * every : UINT64_MAX;
    }
}

enum { FORMATION_STEPS = 1024 };

static uint64_t next_stop(const struct scree_world *w)
{
    uint64_t next = w->end_step;
    for (size_t k = 0; k < w->measured_count; k++)
        next = w->measured[k].due < next ? w->measured[k].due : next;
    if (w->making.needs & MEASURE_FORMATIONS && next - w->step > FORMATION_STEPS)
        next = w->step + FORMATION_STEPS; // the engine's log stays short
    return next;
}

enum scree_status world_hand_over(struct scree_world *w, struct scree_error *err)
{
    if (!(w->making.needs & MEASURE_FORMATIONS) || !w->kind->take_formations)
        return SCREE_OK;
    const struct view_formation *formations = NULL;
    size_t count = w->kind->take_formations(w->body, &formations);
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < w->measured_count && count > 0 && !status; k++)
        if (w->measured[k].what->formed)
            status = w->measured[k].what->formed(w->measured[k].state, &w->context, formations, count, err);
    return status;
}

static enum scree_status take_samples(struct scree_world *w, struct scree_error *err)
{
    struct measure_now now = {0};
    unsigned needs = 0;
    for (size_t k = 0; k < w->measured_count; k++)
        needs |= w->measured[k].due == w->step ? w->measured[k].what->needs : 0;
    if (needs & MEASURE_BASE_FORCE)
        w->kind->take_base_force(w->body, now.base_force);
    enum scree_status status = needs & MEASURE_VIEW ? take_view(w, &now, err) : SCREE_OK;
    for (size_t k = 0; k < w->measured_count && !status; k++) {
        struct measured *m = &w->measured[k];
        if (m->due != w->step)
            continue;
        m->due += m->every;
        now.every = m->every;
        status = m->what->sample(m->state, &w->context, &now, err);
    }
    return status;
}

static bool finished(const struct scree_world *w)
{
    return w->context.stop || w->step >= w->end_step;
}

enum scree_status scree_world_advance(struct scree_world *w, uint64_t steps, struct scree_error *err)
{
    schedule(w);
    while (steps > 0 && !finished(w)) {
        uint64_t next = next_stop(w), count = next - w->step < steps ? next - w->step : steps;
        enum scree_status status = w->kind->advance(w->body, count, err);
        if (status)
            return status;
        w->step += count;
        steps -= count;
        world_look(w);
        if ((status = world_hand_over(w, err)) || (status = take_samples(w, err)))
            return status;
    }
    return SCREE_OK;
}

enum scree_status scree_world_close(struct scree_world *w, struct scree_error *err)
{
    struct measure_now now = {0};
    if (w->closed)
        return SCREE_OK;
    w->closed = true;
    enum scree_status status = w->kind->view(w->body, &now, err);
    for (size_t k = 0; k < w->measured_count && !status; k++) {
        const struct measured *m = &w->measured[k];
        if (!m->recorded)
            continue;
        if (m->what->close)
            status = m->what->close(m->state, &w->context, &now, err);
        for (size_t s = 0; s < m->what->stream_count && !status; s++)
            status = series_flush(&measure_series(m->what, m->state)[s], &w->sink, err);
    }
    return status;
}

/* ---- looking ---- */

struct scree_progress scree_world_progress(const struct scree_world *w)
{
    struct world_counts counts = w->kind->counts(w->body);
    return (struct scree_progress){.step = w->step,
                                   .end_step = w->end_step,
                                   .time_s = counts.time_s,
                                   .end_s = w->job.time.end_s,
                                   .moving = counts.moving,
                                   .fixed = counts.fixed,
                                   .finished = finished(w),
                                   .verdict = w->context.verdict.current,
                                   .evidence =
                                       w->context.site.area > 0 || w->context.verdict.current ? w->context.verdict.evidence : "",
                                   .isa = counts.isa,
                                   .threads = w->making.threads};
}

size_t scree_world_summary(const struct scree_world *w, struct scree_number numbers[SCREE_SUMMARY_MAX])
{
    struct measure_now now = {0};
    size_t count = 0;
    if (w->step == 0 || (w->making.needs & MEASURE_END_VIEW && w->kind->view(w->body, &now, NULL)))
        return 0;
    if (w->kind->numbers)
        count = w->kind->numbers(w->body, numbers, SCREE_SUMMARY_MAX);
    for (size_t k = 0; k < w->measured_count; k++) {
        const struct measured *m = &w->measured[k];
        if (m->what->numbers)
            count += m->what->numbers(m->state, &w->context, &now, numbers + count, SCREE_SUMMARY_MAX - count);
    }
    return count;
}

uint64_t scree_world_hash(const struct scree_world *w)
{
    return w->kind->hash(w->body);
}

size_t scree_world_streams(const struct scree_world *w, const struct scree_stream *const **streams)
{
    *streams = w->streams;
    return w->stream_count;
}
