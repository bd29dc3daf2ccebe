/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The narrow waist: everything that the service sees of the physics.
 *
 * A world runs its grains from one instant at which something is due to the
 * next: a block of basal force, a bulk sample, a frame. All intervals are whole
 * numbers of steps from t = 0, so that slices never show. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/frames.h"
#include "world/state.h"

static const struct scree_column force_columns[] = {{"Fx", "N"}, {"Fy", "N"}, {"Fz", "N"}};
static const struct scree_stream force_stream = {"basal_force", "force of the flow on its base, mean over each block of steps",
                                                 force_columns, 3, false};

enum { BULK_CHUNK = 128, CONTACT_CHUNK = 256 };

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

static struct schedule schedule_of(bool on, double every_s, double step_s)
{
    uint64_t steps = (uint64_t)fmax(1, round(every_s / step_s));
    return (struct schedule){.on = on, .every = steps};
}

static enum scree_status start_series(struct scree_world *w, struct series *series, const struct schedule *schedule,
                                      const struct scree_stream *stream, size_t chunk, struct scree_error *err)
{
    if (!schedule->on)
        return SCREE_OK;
    w->streams[w->stream_count++] = stream;
    return series_start(series, stream, chunk, (double)schedule->every * w->job.time.step_s, err);
}

static enum scree_status start_records(struct scree_world *w, struct scree_error *err)
{
    const struct record_spec *r = &w->job.record;
    double step = w->job.time.step_s;
    w->force = schedule_of(r->basal_force.on, r->basal_force.every_s, step);
    w->bulk = schedule_of(r->bulk.on, r->bulk.every_s, step);
    w->energy = schedule_of(r->energy.on, r->energy.every_s, step);
    w->snapshots = schedule_of(r->snapshots.on, r->snapshots.every_s, step);
    w->contact = schedule_of(r->contact.on, step, step);
    w->flow = schedule_of(r->flow.on, r->flow.every_s, step);
    enum scree_status status;
    if ((status = start_series(w, &w->force_series, &w->force, &force_stream, (size_t)r->basal_force.chunk, err)) ||
        (status = start_series(w, &w->bulk_series, &w->bulk, &bulk_stream, BULK_CHUNK, err)) ||
        (status = start_series(w, &w->energy_series, &w->energy, &energy_stream, BULK_CHUNK, err)) ||
        (status = start_series(w, &w->contact_series, &w->contact, &contact_stream, CONTACT_CHUNK, err)))
        return status;
    if (w->snapshots.on)
        w->streams[w->stream_count++] = &snapshots_stream;
    w->streams[w->stream_count++] = &grains_stream;
    return flow_start(w, err);
}

/* The state at t = 0: energies, and the first frame. */
static enum scree_status look_first(struct scree_world *w, struct scree_error *err)
{
    struct view view;
    enum scree_status status = dem_view(w->dem, &view, err);
    if (status)
        return status;
    bulk_measure(&view, &w->last);
    w->start_energy = w->last.kinetic + w->last.elastic;
    if (w->contact.on) {
        double row[CONTACT_COLUMNS];
        contact_measure(&view, &w->trace, row);
    }
    return w->snapshots.on ? frame_put(&view, &snapshots_stream, w->snapshot_seq++, &w->sink, err) : SCREE_OK;
}

enum scree_status world_prepare(const struct job_spec *job, const struct scree_options *options, const struct scree_sink *sink,
                                struct scree_world **out, struct scree_error *err)
{
    const struct scenario *scenario = scenario_implementation(job->scenario->name);
    if (!scenario)
        return scree_fail(err, SCREE_INTERNAL, "scenario", "scenario %s has no implementation", job->scenario->name);
    struct scree_world *w = memory_rows(1, sizeof *w);
    if (!w)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    w->job = *job;
    w->sink = *sink;
    w->scenario = scenario;
    w->threads = options && options->threads > 0 ? options->threads : (int)job->threads;
    w->end_step = (uint64_t)fmax(1, round(job->time.end_s / job->time.step_s));
    scenario->base(job, &w->base_z, &w->area);
    enum scree_status status = start_records(w, err);
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
    double gravity[3];
    w->scenario->gravity(job, gravity);
    double g = sqrt(gravity[0] * gravity[0] + gravity[1] * gravity[1] + gravity[2] * gravity[2]);
    window_start(&w->force_window);
    window_start(&w->bulk_window);
    if ((status = w->scenario->build(job, options ? options->isa : NULL, w->threads, &w->dem, err)) ||
        (status = look_first(w, err))) {
        scree_world_free(w);
        return status;
    }
    double d = w->scenario->grain ? w->scenario->grain(job) : 2 * job->material.radius_m,
           layers = w->area > 0 ? (double)dem_moving(w->dem) * d * d / w->area : 0;
    verdict_start(&w->verdict, d, g > 0 ? g : 1, layers);
    *out = w;
    return SCREE_OK;
}

void scree_world_free(struct scree_world *w)
{
    if (!w)
        return;
    dem_free(w->dem);
    series_end(&w->force_series);
    series_end(&w->bulk_series);
    series_end(&w->energy_series);
    series_end(&w->contact_series);
    flow_end(w);
    free(w);
}

/* ---- advancing ---- */

static bool due(const struct scree_world *w, const struct schedule *schedule)
{
    return schedule->on && w->step % schedule->every == 0;
}

/* The verdict needs bulk samples even where nobody records them. */
static bool bulk_due(const struct scree_world *w)
{
    return (w->bulk.on || w->area > 0) && w->step % w->bulk.every == 0;
}

static void soonest(const struct scree_world *w, bool on, uint64_t every, uint64_t *next)
{
    uint64_t then = (w->step / every + 1) * every;
    if (on && then < *next)
        *next = then;
}

static uint64_t next_stop(const struct scree_world *w)
{
    uint64_t next = w->end_step;
    soonest(w, w->force.on, w->force.every, &next);
    soonest(w, w->bulk.on || w->area > 0, w->bulk.every, &next);
    soonest(w, w->energy.on, w->energy.every, &next);
    soonest(w, w->snapshots.on, w->snapshots.every, &next);
    soonest(w, w->flow.on, w->flow.every, &next);
    soonest(w, w->contact.on, w->contact.every, &next);
    return next;
}

static enum scree_status take_force(struct scree_world *w, double time_s, struct scree_error *err)
{
    double values[WINDOW_VALUES] = {0};
    dem_take_base_force(w->dem, values);
    window_add(&w->force_window, time_s, (double)w->force.every, values);
    return series_add(&w->force_series, &w->sink, time_s, values, err);
}

/* Energy that nothing supplied: the time step no longer follows the contacts. */
static enum scree_status look_for_explosion(const struct scree_world *w, const struct view *view, struct scree_error *err)
{
    double energy = w->last.kinetic + w->last.elastic, supplied = fabs(view->gravity_work) + w->start_energy;
    if (isfinite(energy) && energy <= 10 * supplied + 1e-12)
        return SCREE_OK;
    size_t fastest = 0;
    double most = -1;
    for (size_t i = 0; i < view->moving; i++) {
        const double *v = view->velocity[i];
        double speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        if (!(speed2 <= most)) {
            most = speed2;
            fastest = i;
        }
    }
    scree_fail(
        err, SCREE_BLOWUP, NULL,
        "step %llu: the grains hold %.3g J and gravity and the start have supplied %.3g J; fastest is grain %u at %.3g m/s; last "
        "good time %.9g s",
        (unsigned long long)w->step, energy, supplied, view->id[fastest], sqrt(most),
        view->time_s - (double)w->bulk.every * w->job.time.step_s);
    scree_hint(err, "a shorter time.step_s may help");
    return SCREE_BLOWUP;
}

static enum scree_status take_bulk(struct scree_world *w, const struct view *view, struct scree_error *err)
{
    const struct bulk *b = &w->last;
    enum scree_status status = look_for_explosion(w, view, err);
    if (status)
        return status;
    double values[WINDOW_VALUES] = {b->centre_z, b->velocity[0], b->speed_rms, b->contacts, b->kinetic};
    window_add(&w->bulk_window, b->time_s, 1, values);
    if (w->area > 0) {
        verdict_add(&w->verdict, b->time_s, b->kinetic, b->elastic, b->speed_rms, b->centre_z);
        if (w->verdict.current != VERDICT_UNDECIDED && (w->job.stop.when >> (w->verdict.current - 1) & 1))
            w->stopped = true;
    }
    if (!w->bulk.on)
        return SCREE_OK;
    double row[BULK_COLUMNS];
    bulk_row(b, row);
    return series_add(&w->bulk_series, &w->sink, b->time_s, row, err);
}

static enum scree_status take_contact(struct scree_world *w, const struct view *view, struct scree_error *err)
{
    double row[CONTACT_COLUMNS];
    contact_measure(view, &w->trace, row);
    if (w->trace.ended)
        w->stopped = true;
    return series_add(&w->contact_series, &w->sink, view->time_s, row, err);
}

static enum scree_status take_samples(struct scree_world *w, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    if (due(w, &w->force) && (status = take_force(w, dem_time(w->dem), err)))
        return status;
    if (!bulk_due(w) && !due(w, &w->energy) && !due(w, &w->snapshots) && !due(w, &w->contact) && !due(w, &w->flow))
        return SCREE_OK;
    struct view view;
    if ((status = dem_view(w->dem, &view, err)))
        return status;
    bulk_measure(&view, &w->last);
    if (bulk_due(w) && (status = take_bulk(w, &view, err)))
        return status;
    if (due(w, &w->energy)) {
        double row[ENERGY_COLUMNS];
        energy_row(&view, &w->last, w->start_energy, row);
        if ((status = series_add(&w->energy_series, &w->sink, view.time_s, row, err)))
            return status;
    }
    if (due(w, &w->contact) && (status = take_contact(w, &view, err)))
        return status;
    if (due(w, &w->flow) && (status = flow_take(w, &view, err)))
        return status;
    return due(w, &w->snapshots) ? frame_put(&view, &snapshots_stream, w->snapshot_seq++, &w->sink, err) : SCREE_OK;
}

static bool finished(const struct scree_world *w)
{
    return w->stopped || w->step >= w->end_step;
}

enum scree_status scree_world_advance(struct scree_world *w, uint64_t steps, struct scree_error *err)
{
    while (steps > 0 && !finished(w)) {
        uint64_t next = next_stop(w), count = next - w->step < steps ? next - w->step : steps;
        enum scree_status status = dem_advance(w->dem, count, err);
        if (status)
            return status;
        w->step += count;
        steps -= count;
        if ((status = take_samples(w, err)))
            return status;
    }
    return SCREE_OK;
}

enum scree_status scree_world_close(struct scree_world *w, struct scree_error *err)
{
    struct series *const all[] = {&w->force_series, &w->bulk_series, &w->energy_series, &w->contact_series};
    enum scree_status status = SCREE_OK;
    if (w->closed)
        return SCREE_OK;
    w->closed = true;
    for (size_t k = 0; k < sizeof all / sizeof *all && !status; k++)
        if (all[k]->values)
            status = series_flush(all[k], &w->sink, err);
    struct view view;
    if (status || (status = dem_view(w->dem, &view, err)) || (status = flow_close(w, &view, err)))
        return status;
    return frame_put(&view, &grains_stream, 0, &w->sink, err);
}

/* ---- looking ---- */

struct scree_progress scree_world_progress(const struct scree_world *w)
{
    return (struct scree_progress){.step = w->step,
                                   .end_step = w->end_step,
                                   .time_s = dem_time(w->dem),
                                   .end_s = w->job.time.end_s,
                                   .moving = dem_moving(w->dem),
                                   .fixed = dem_fixed(w->dem),
                                   .finished = finished(w),
                                   .verdict = w->verdict.current,
                                   .evidence = w->area > 0 ? w->verdict.evidence : "",
                                   .isa = dem_isa(w->dem),
                                   .threads = w->threads};
}

uint64_t scree_world_hash(const struct scree_world *w)
{
    return dem_hash(w->dem);
}

size_t scree_world_streams(const struct scree_world *w, const struct scree_stream *const **streams)
{
    *streams = w->streams;
    return w->stream_count;
}
