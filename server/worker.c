/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See worker.h. Slices aim at some tens of milliseconds of wall time, so that an
 * order is obeyed at once; results do not depend on them. Chunks are committed to
 * the job's log by the worker itself: a few a second, a fraction of a millisecond
 * each, and nothing can pile up. */
#include "worker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>

#include "log.h"

#define SLICE_SECONDS 0.03

struct worker {
    struct workers *owner;
    pthread_t thread;
    bool started;
    struct run *run; // assigned, under the owner's lock
};

struct workers {
    int count, wake_fd;
    bool stop;
    pthread_mutex_t lock;
    pthread_cond_t work;
    struct worker *all;
};

static double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- one run ---- */

struct context {
    struct run *run;
    struct chunk_log *log;
    int wake_fd;
};

static void announce(const struct context *c)
{
    atomic_store(&c->run->dirty, true);
    eventfd_write(c->wake_fd, 1);
}

/* The sink: commits the chunk, then says so. */
static enum scree_status put_chunk(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct context *c = context;
    enum scree_status status = chunk_log_put(c->log, chunk, err);
    if (status)
        return status;
    struct run_report *report = &c->run->report;
    pthread_mutex_lock(&c->run->lock);
    size_t k = 0;
    while (k < report->head_count && strcmp(report->heads[k].name, chunk->stream->name) != 0)
        k++;
    if (k == report->head_count && k < JOB_STREAMS_MAX)
        snprintf(report->heads[report->head_count++].name, CHUNK_NAME_MAX, "%s", chunk->stream->name);
    if (k < JOB_STREAMS_MAX) {
        report->heads[k].chunks = chunk->seq + 1;
        report->heads[k].samples += chunk->rows;
    }
    pthread_mutex_unlock(&c->run->lock);
    announce(c);
    return SCREE_OK;
}

static enum scree_status declare_streams(struct context *c, const struct scree_world *world, struct scree_error *err)
{
    const struct scree_stream *const *streams;
    size_t count = scree_world_streams(world, &streams);
    enum scree_status status = chunk_log_declare(c->log, streams, count, err);
    pthread_mutex_lock(&c->run->lock);
    for (size_t k = 0; k < count && k < JOB_STREAMS_MAX && !status; k++)
        c->run->streams[c->run->stream_count++] = streams[k];
    pthread_mutex_unlock(&c->run->lock);
    return status;
}

/* Publishes where the world stands. `rate` and wall time are of this run. */
static void publish(struct context *c, const struct scree_world *world, double rate, double wall_s)
{
    struct scree_progress p = scree_world_progress(world);
    struct scree_number numbers[SCREE_SUMMARY_MAX];
    size_t count = scree_world_summary(world, numbers);
    struct run_report *report = &c->run->report;
    pthread_mutex_lock(&c->run->lock);
    report->steps = p.step;
    report->time_s = p.time_s;
    report->moving = p.moving;
    report->fixed = p.fixed;
    report->verdict = p.verdict;
    report->threads = p.threads;
    report->rate = rate;
    report->wall_s = wall_s;
    snprintf(report->evidence, sizeof report->evidence, "%s", p.evidence);
    snprintf(report->isa, sizeof report->isa, "%s", p.isa);
    memcpy(report->numbers, numbers, count * sizeof *numbers);
    report->number_count = count;
    pthread_mutex_unlock(&c->run->lock);
    announce(c);
}

/* Slices until the world is finished or an order comes. */
static enum scree_status run_slices(struct context *c, struct scree_world *world, struct scree_error *err)
{
    double started = seconds_now(), last = started, shown = started, rate = 0;
    uint64_t steps = 64;
    struct scree_progress p = scree_world_progress(world);
    while (!p.finished) {
        int order = atomic_load(&c->run->order);
        if (order != RUN_GO)
            return order == RUN_CANCEL ? SCREE_CANCELLED : SCREE_BUSY; // busy: to be run again
        uint64_t before = p.step;
        enum scree_status status = scree_world_advance(world, steps, err);
        if (status)
            return status;
        p = scree_world_progress(world);
        double now = seconds_now(), took = fmax(now - last, 1e-6);
        double sample = (double)(p.step - before) * (double)p.moving / took;
        /* Smoothed over about a second. */
        double weight = fmin(1, took / fmin(1, now - started + 1e-9));
        rate += weight * (sample - rate);
        steps = (uint64_t)fmax(1, fmin(1e9, (double)steps * fmin(2, SLICE_SECONDS / took)));
        last = now;
        if (now - shown >= 0.1) {
            publish(c, world, rate, now - started);
            shown = now;
        }
    }
    double wall = seconds_now() - started;
    publish(c, world, wall > 0 ? (double)p.step * (double)p.moving / wall : 0, wall);
    return SCREE_OK;
}

static enum scree_status run_world(struct context *c, struct scree_error *err)
{
    struct scree_world *world = NULL;
    const struct scree_sink sink = {.put = put_chunk, .context = c};
    const struct scree_options options = {.threads = 0};
    enum scree_status status = chunk_log_open(&c->log, c->run->log_path, true, err);
    if (status)
        return status;
    if ((status = scree_world_create(&c->run->spec, &options, &sink, &world, err)) || (status = declare_streams(c, world, err)))
        goto out;
    publish(c, world, 0, 0);
    status = run_slices(c, world, err);
    /* What there is belongs to the result, of a cancelled job too; a stopped one will go on. */
    if (status == SCREE_OK || status == SCREE_CANCELLED) {
        enum scree_status closed = scree_world_close(world, err);
        if (closed)
            status = closed;
    }
out:
    scree_world_free(world);
    chunk_log_close(c->log);
    return status;
}

static void run_job(struct run *run, int wake_fd)
{
    struct context c = {.run = run, .wake_fd = wake_fd};
    struct scree_error error = {0};
    enum scree_status status = run_world(&c, &error);
    pthread_mutex_lock(&run->lock);
    run->report.status = status;
    run->report.error = error;
    run->report.ended = true;
    pthread_mutex_unlock(&run->lock);
    announce(&c);
}

/* ---- the threads ---- */

static void *worker_main(void *argument)
{
    struct worker *self = argument;
    struct workers *all = self->owner;
    for (;;) {
        pthread_mutex_lock(&all->lock);
        while (!self->run && !all->stop)
            pthread_cond_wait(&all->work, &all->lock);
        struct run *run = self->run;
        pthread_mutex_unlock(&all->lock);
        if (!run)
            return NULL;
        run_job(run, all->wake_fd);
        pthread_mutex_lock(&all->lock);
        self->run = NULL;
        pthread_mutex_unlock(&all->lock);
        eventfd_write(all->wake_fd, 1); // a worker is idle
    }
}

enum scree_status workers_start(struct workers **out, int count, int wake_fd, struct scree_error *err)
{
    struct workers *workers = calloc(1, sizeof *workers);
    if (!workers || !(workers->all = calloc((size_t)count, sizeof *workers->all))) {
        free(workers);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %d workers", count);
    }
    workers->count = count;
    workers->wake_fd = wake_fd;
    pthread_mutex_init(&workers->lock, NULL);
    pthread_cond_init(&workers->work, NULL);
    for (int k = 0; k < count; k++) {
        workers->all[k].owner = workers;
        if (pthread_create(&workers->all[k].thread, NULL, worker_main, &workers->all[k]) != 0) {
            workers_stop(workers);
            return scree_fail(err, SCREE_NO_MEMORY, NULL, "the system gave only %d of %d threads", k, count);
        }
        workers->all[k].started = true;
    }
    *out = workers;
    return SCREE_OK;
}

bool workers_assign(struct workers *workers, struct run *run)
{
    bool given = false;
    pthread_mutex_lock(&workers->lock);
    for (int k = 0; k < workers->count && !given; k++)
        if (!workers->all[k].run) {
            workers->all[k].run = run;
            given = true;
        }
    pthread_cond_broadcast(&workers->work);
    pthread_mutex_unlock(&workers->lock);
    return given;
}

void workers_stop(struct workers *workers)
{
    if (!workers)
        return;
    pthread_mutex_lock(&workers->lock);
    workers->stop = true;
    pthread_cond_broadcast(&workers->work);
    pthread_mutex_unlock(&workers->lock);
    for (int k = 0; k < workers->count; k++)
        if (workers->all[k].started)
            pthread_join(workers->all[k].thread, NULL);
    pthread_cond_destroy(&workers->work);
    pthread_mutex_destroy(&workers->lock);
    free(workers->all);
    free(workers);
}
