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

#include "base/failpoint.h"
#include "log.h"
#include "recorder.h"

#define SLICE_SECONDS  0.03
#define SUMMARY_PAUSES 100 // as long as making it takes

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

#define NEVER UINT64_MAX

struct context {
    struct run *run;
    struct chunk_log *log;
    int wake_fd;
    double reached_s;   // how far the streams had come before this run; negative: nowhere
    int64_t applied;    // number of the last command that is in the world
    uint64_t kept_step; // of the newest checkpoint, NEVER: there is none
    double kept_s;      // when it was taken, by the monotonic clock
    double summed_s;    // when the summary's numbers were last made, and how long that took
    double sum_cost_s;
    bool ending; // the world stops for good before its end
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
    enum scree_status status = chunk_log_put(c->log, chunk, c->ending, err);
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
    if (count > JOB_STREAMS_MAX)
        return scree_fail(err, SCREE_INTERNAL, "record", "this job has %zu streams, and %d fit", count, JOB_STREAMS_MAX);
    enum scree_status status = chunk_log_declare(c->log, streams, count, err);
    pthread_mutex_lock(&c->run->lock);
    for (size_t k = 0; k < count && !status; k++)
        c->run->streams[c->run->stream_count++] = streams[k];
    c->run->stands = !status;
    pthread_mutex_unlock(&c->run->lock);
    return status;
}

/* Makes the summary's numbers. Some cost more than a slice (a spectrum's fit): unless
 * `now`, they wait until making them takes less than a hundredth of the time. */
static bool sum_up(struct context *c, const struct scree_world *world, bool now, struct scree_number *numbers, size_t *count)
{
    double started = seconds_now();
    if (!now && started - c->summed_s < SUMMARY_PAUSES * c->sum_cost_s)
        return false;
    *count = scree_world_summary(world, numbers);
    c->summed_s = seconds_now();
    c->sum_cost_s = c->summed_s - started;
    return true;
}

/* Publishes where the world stands; with all its numbers when it stops there. `rate` and wall time are of this run. */
static void publish(struct context *c, const struct scree_world *world, double rate, double wall_s, bool stops)
{
    struct scree_progress p = scree_world_progress(world);
    struct scree_number numbers[SCREE_SUMMARY_MAX];
    size_t count = 0;
    bool summed = sum_up(c, world, stops, numbers, &count);
    struct run_report *report = &c->run->report;
    pthread_mutex_lock(&c->run->lock);
    report->steps = p.step;
    report->time_s = p.time_s;
    report->moving = p.moving;
    report->fixed = p.fixed;
    report->verdict = p.verdict;
    report->threads = p.threads;
    report->rate = rate;
    report->wall_s = c->run->wall_before_s + wall_s;
    snprintf(report->evidence, sizeof report->evidence, "%s", p.evidence);
    snprintf(report->isa, sizeof report->isa, "%s", p.isa);
    if (summed) {
        memcpy(report->numbers, numbers, count * sizeof *numbers);
        report->number_count = count;
    }
    pthread_mutex_unlock(&c->run->lock);
    announce(c);
}

/* ---- images: the world's thread copies, the recorder's writes ---- */

/* Hands a copy of the world to the recorder. One that cannot be made for lack of
 * memory costs the checkpoint, not the run. */
static void hand_over(struct context *c, const struct scree_world *world, enum record_kind kind, int64_t command)
{
    struct run *run = c->run;
    struct scree_error error = {0};
    struct scree_progress p = scree_world_progress(world);
    struct record_order *order = calloc(1, sizeof *order);
    enum scree_status status = order ? scree_image_take(world, &order->image, &error) : SCREE_NO_MEMORY;
    if (status) {
        log_line(LOG_WARNING, "job=j%lld no checkpoint: %s", (long long)run->job, order ? error.message : "no memory");
        if (!order || !command) {
            free(order);
            return;
        }
        order->status = status; // somebody waits for this one: the answer is the fault
        order->error = error;
    }
    order->kind = kind;
    order->job = run->job;
    order->serial = run->serial;
    order->step = p.step;
    order->command = command;
    if (kind == RECORD_FORK) {
        snprintf(order->path, sizeof order->path, "%s/fork-%lld.h5", run->folder, (long long)command);
    } else {
        snprintf(order->path, sizeof order->path, "%s/checkpoint-%012llu-%lld.h5", run->folder, (unsigned long long)p.step,
                 (long long)c->applied);
        if (!status) {
            c->kept_step = p.step;
            c->kept_s = seconds_now();
        }
    }
    atomic_fetch_add(&run->images, 1);
    recorder_ask(run->recorder, order);
}

/* ---- commands ---- */

/* Asks control to write the step of a command down; false: it will not have it. */
static bool ask(struct context *c, int64_t number, uint64_t step)
{
    struct run *run = c->run;
    pthread_mutex_lock(&run->lock);
    run->ask = ASK_WAITING;
    run->ask_number = number;
    run->ask_step = step;
    pthread_mutex_unlock(&run->lock);
    announce(c);
    pthread_mutex_lock(&run->lock);
    while (run->ask == ASK_TAKEN || (run->ask == ASK_WAITING && atomic_load(&run->order) == RUN_GO))
        pthread_cond_wait(&run->answered, &run->lock);
    bool granted = run->ask == ASK_GRANTED;
    run->ask = ASK_NONE;
    pthread_mutex_unlock(&run->lock);
    return granted;
}

static bool command_at(struct run *run, size_t index, struct run_command *out)
{
    pthread_mutex_lock(&run->lock);
    bool there = index < run->command_count;
    if (there)
        *out = run->commands[index];
    pthread_mutex_unlock(&run->lock);
    return there;
}

/* Carries out what is due at this step. A command that had taken effect in an
 * earlier run does so at its very step; a new one waits until the streams have
 * come as far as somebody may have seen them, for those chunks must come out again. */
static enum scree_status obey(struct context *c, struct scree_world *world, size_t *next, uint64_t *limit, struct scree_error *err)
{
    struct scree_progress p = scree_world_progress(world);
    struct run_command command;
    *limit = UINT64_MAX;
    for (; !p.finished && command_at(c->run, *next, &command); ++*next) {
        if (command.step != NEXT_BOUNDARY && command.number <= c->applied)
            continue;
        if (command.step != NEXT_BOUNDARY && command.step > p.step) {
            *limit = command.step - p.step;
            return SCREE_OK;
        }
        if (command.step == NEXT_BOUNDARY && p.time_s < c->reached_s - 0.5 * c->run->spec.time.step_s)
            return SCREE_OK;
        if (command.step != NEXT_BOUNDARY && command.step < p.step)
            return scree_fail(err, SCREE_INTERNAL, "", "command %lld belongs to step %llu and the world is at %llu",
                              (long long)command.number, (unsigned long long)command.step, (unsigned long long)p.step);
        if (command.step == NEXT_BOUNDARY && !ask(c, command.number, p.step)) {
            if (atomic_load(&c->run->order) != RUN_GO)
                return SCREE_OK; // the loop looks at orders next
            continue;
        }
        FAILPOINT("command-granted");
        enum scree_status status = command.op == COMMAND_SET ? scree_world_steer(world, &command.to, err) : SCREE_OK;
        if (status)
            return status;
        if (command.op == COMMAND_FORK)
            hand_over(c, world, RECORD_FORK, command.number);
        c->applied = command.number;
        if (command.step == NEXT_BOUNDARY)
            hand_over(c, world, RECORD_CHECKPOINT, command.op == COMMAND_CHECKPOINT ? command.number : 0);
        p = scree_world_progress(world);
    }
    return SCREE_OK;
}

/* ---- running ---- */

static bool checkpoint_is_due(const struct context *c, const struct scree_progress *p, double now)
{
    double every = c->run->checkpoint_s;
    return every > 0 && now - c->kept_s >= every && p->step != c->kept_step && atomic_load(&c->run->images) == 0;
}

/* Slices until the world is finished or an order comes. */
static enum scree_status run_slices(struct context *c, struct scree_world *world, struct scree_error *err)
{
    double started = seconds_now(), last = started, shown = started, rate = 0;
    uint64_t steps = 64, limit, first = scree_world_progress(world).step;
    size_t next = 0;
    struct scree_progress p = scree_world_progress(world);
    c->kept_s = started;
    while (!p.finished && p.step <= c->run->stop_step) {
        /* Also where a replay stops: a command may have been the last thing before its job was cancelled. */
        enum scree_status status = obey(c, world, &next, &limit, err);
        int order = atomic_load(&c->run->order);
        if (status || order != RUN_GO) {
            publish(c, world, rate, last - started, true);
            return status ? status : order == RUN_CANCEL ? SCREE_CANCELLED : SCREE_BUSY; // busy: to be run again
        }
        if (p.step == c->run->stop_step)
            break;
        uint64_t before = p.step, left = c->run->stop_step - p.step;
        limit = limit < left ? limit : left;
        double begun = seconds_now();
        if ((status = scree_world_advance(world, steps < limit ? steps : limit, err)))
            return status;
        p = scree_world_progress(world);
        double now = seconds_now(), took = fmax(now - last, 1e-6), slice = fmax(now - begun, 1e-6);
        double sample = (double)(p.step - before) * (double)p.moving / took;
        /* Smoothed over about a second. */
        double weight = fmin(1, took / fmin(1, now - started + 1e-9));
        rate += weight * (sample - rate);
        if (steps <= limit || slice > SLICE_SECONDS)
            steps = (uint64_t)fmax(1, fmin(1e9, (double)steps * fmin(2, SLICE_SECONDS / slice)));
        last = now;
        if (now - shown >= 0.1) {
            publish(c, world, rate, now - started, false);
            shown = now;
        }
        if (!p.finished && checkpoint_is_due(c, &p, now))
            hand_over(c, world, RECORD_CHECKPOINT, 0);
    }
    double wall = seconds_now() - started;
    publish(c, world, wall > 0 ? (double)(p.step - first) * (double)p.moving / wall : 0, wall, true);
    return SCREE_OK;
}

/* ---- where a run goes on ---- */

struct restore {
    const struct run_start *start;
    const struct scree_sink *sink;
    struct scree_world *world;
};

static enum scree_status restore_errand(void *context, struct scree_error *err)
{
    struct restore *r = context;
    const struct scree_options options = {.threads = 0};
    return scree_checkpoint_read(r->start->path, &r->start->spec, &options, r->sink, &r->world, err);
}

/* The log has what the streams have said up to where the world stands. */
static bool log_covers(struct context *c, const struct scree_world *world)
{
    const struct scree_stream *const *streams;
    size_t count = scree_world_streams(world, &streams);
    for (size_t k = 0; k < count; k++) {
        uint64_t next = scree_world_next_chunk(world, k);
        struct chunk_row row;
        bool found = true;
        if (next > 0 && (chunk_log_get(c->log, streams[k]->name, next - 1, &row, &found, NULL) || !found))
            return false;
    }
    return true;
}

/* From the newest checkpoint that is sound, else from where a fork began, else from nothing. */
static enum scree_status make_world(struct context *c, const struct scree_sink *sink, struct scree_world **world,
                                    struct scree_error *err)
{
    struct run *run = c->run;
    struct restore r = {.sink = sink};
    for (size_t k = 0; k < run->start_count; k++) {
        struct scree_error why = {0};
        r.start = &run->starts[k];
        enum scree_status status = recorder_run(run->recorder, restore_errand, &r, &why);
        if (status == SCREE_NO_MEMORY) {
            *err = why;
            return status;
        }
        if (!status && log_covers(c, r.world)) {
            c->applied = r.start->applied;
            c->kept_step = r.start->step;
            *world = r.world;
            log_line(LOG_INFO, "job=j%lld resumed at step=%llu", (long long)run->job, (unsigned long long)r.start->step);
            return SCREE_OK;
        }
        if (!status)
            scree_world_free(r.world);
        log_line(LOG_WARNING, "job=j%lld %s", (long long)run->job, status ? why.message : "the stream log lacks chunks");
    }
    if (!*run->origin.path) {
        const struct scree_options options = {.meshes = run->meshes};
        return scree_world_create(&run->spec, &options, sink, world, err);
    }
    r.start = &run->origin;
    enum scree_status status = recorder_run(run->recorder, restore_errand, &r, err);
    if (status)
        return status;
    scree_world_branch(r.world);
    if ((status = scree_world_steer(r.world, &run->spec, err)))
        scree_world_free(r.world);
    else
        *world = r.world;
    return status;
}

static enum scree_status run_world(struct context *c, struct scree_error *err)
{
    struct scree_world *world = NULL;
    const struct scree_sink sink = {.put = put_chunk, .context = c};
    enum scree_status status = chunk_log_open(&c->log, c->run->log_path, true, err);
    if (status)
        return status;
    c->reached_s = chunk_log_reached(c->log);
    if ((status = make_world(c, &sink, &world, err)) || (status = declare_streams(c, world, err)))
        goto out;
    publish(c, world, 0, 0, true);
    status = run_slices(c, world, err);
    if (status == SCREE_BUSY && scree_world_progress(world).step != c->kept_step)
        hand_over(c, world, RECORD_CHECKPOINT, 0);
    /* What there is belongs to the result, of a cancelled job too; a stopped one will go on. */
    if (status == SCREE_OK || status == SCREE_CANCELLED) {
        c->ending = !scree_world_progress(world).finished;
        uint64_t hash = scree_world_hash(world);
        enum scree_status closed = scree_world_close(world, err);
        if (closed)
            status = closed;
        pthread_mutex_lock(&c->run->lock);
        c->run->report.hash = hash;
        c->run->report.hashed = true;
        pthread_mutex_unlock(&c->run->lock);
    }
out:
    scree_world_free(world);
    chunk_log_close(c->log);
    return status;
}

static void run_job(struct run *run, int wake_fd)
{
    struct context c = {.run = run, .wake_fd = wake_fd, .kept_step = NEVER};
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
    pthread_setname_np(pthread_self(), "worker"); // as `top -H` shows it
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
