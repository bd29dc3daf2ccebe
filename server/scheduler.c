/* SPDX-License-Identifier: GPL-3.0-or-later */
/* States of a job:
 *
 *      submit               assign                       run ended, result written
 *   ------------> queued ------------> running --------------------------------> done
 *                 ^ |  ^                |  |  \                                   failed
 *          resume | |   `--- held <-----'  |   `-- cancel: at the end of the slice cancelled
 *                 | |      no disk,        |
 *                 | |      memory: goes    | pause: checkpoint, then the world is freed
 *                 | |      on by itself    v
 *                 | `---- pause -------> paused
 *                 `------------------------'
 *
 *   from      event                          to         what else happens
 *   -         submit, committed              queued     the client gets its answer
 *   queued    a worker is idle               running    run created, journal updated
 *   queued    does not fit disk or memory    held       in memory only: at a restart it is queued and looked at again
 *   running   disk runs low                  held       checkpoint first; in memory only
 *   held      room again                     queued
 *   queued, held, running   pause            paused     of a running one: checkpoint, then committed with its step
 *   paused    resume                         queued
 *   queued, held, paused    cancel           cancelled
 *   running   cancel                         running    cancelled in the journal, order to the worker
 *   running   report: ended                  running    recording: the recorder makes result.h5
 *   running   recorder is through            done | failed | cancelled, by the report
 *   running   run or result failed for lack of disk or memory   held, tried again some times
 *   running   daemon ends                    running    checkpoint; queued in memory at the next start
 *
 * Invariants: what the journal says is written before anybody is told; a job has
 * a run exactly while it is running (or held with its result unwritten); an ended
 * job never changes; `done` has its result.h5 in place. A job that is run again
 * goes on from its newest sound checkpoint and writes the same chunks from there:
 * its log is kept, and chunks that are there are compared, not replaced. So nobody
 * who has read ahead of the checkpoint can see a gap or a change, and new steering
 * takes effect only where the streams have not been yet. */
#include "scheduler.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/failpoint.h"
#include "base/memory.h"
#include "log.h"
#include "meshes.h"
#include "outcome.h"
#include "protocol/frame.h"
#include "protocol/job_json.h"
#include "scheduler_state.h"

enum { QUEUE_MAX = 10000 };

double scheduler_unix_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double scheduler_monotonic(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- journal ---- */

enum scree_status scheduler_write_job(struct scheduler *s, const struct job *job, enum job_state state, struct scree_error *err)
{
    unsigned long before = json_lacked();
    char *outcome = json_print_whole(outcome_json(&job->report), before);
    if (!outcome)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for what a job came to");
    const struct journal_row row = {.number = job->number,
                                    .state = job_state_word(state),
                                    .build = job->build,
                                    .outcome = outcome,
                                    .started = job->started,
                                    .ended = job->ended};
    enum scree_status status = journal_update(s->journal, &row, err);
    free(outcome);
    return status;
}

static void free_run(struct run *run)
{
    if (!run)
        return;
    pthread_cond_destroy(&run->answered);
    pthread_mutex_destroy(&run->lock);
    free(run->commands);
    free(run);
}

void scheduler_free_job(struct job *job)
{
    if (!job)
        return;
    free(job->spec_text);
    free(job->origin);
    free_run(job->run);
    free(job);
}

void scheduler_name_job(struct job *job, int64_t number)
{
    job->number = number;
    snprintf(job->id, sizeof job->id, "j%lld", (long long)number);
}

/* ---- files ---- */

void scheduler_log_path(const struct scheduler *s, const struct job *job, char *out, size_t size)
{
    snprintf(out, size, "%s/jobs/%s/streams.db", s->config->data, job->id);
}

void scheduler_result_path(const struct scheduler *s, const struct job *job, bool final, char *out, size_t size)
{
    snprintf(out, size, "%s/jobs/%s/%s", s->config->data, job->id, final ? "result.h5" : "so-far.h5");
}

enum scree_status scheduler_folder(const char *path, struct scree_error *err)
{
    char part[CONFIG_PATH_MAX + 64];
    snprintf(part, sizeof part, "%s", path);
    for (char *p = part + 1;; p++) {
        if (*p && *p != '/')
            continue;
        char kept = *p;
        *p = 0;
        if (mkdir(part, 0700) != 0 && errno != EEXIST)
            return scree_fail(err, SCREE_IO, "", "cannot make the folder %s: %s", part, strerror(errno));
        if (!kept)
            return SCREE_OK;
        *p = kept;
    }
}

/* ---- transitions ---- */

void scheduler_changed(struct scheduler *s, const struct job *job, enum job_event what)
{
    if (!s->closing)
        s->watch.changed(s->watch.context, job, what);
}

void scheduler_set_state(struct scheduler *s, struct job *job, enum job_state state)
{
    s->queued -= job->state == JOB_QUEUED;
    job->state = state;
    s->queued += state == JOB_QUEUED;
    if (state != JOB_HELD) {
        job->why[0] = 0;
        job->hold = HOLD_NONE;
    }
    log_line(LOG_INFO, "job=%s scenario=%s state=%s%s%s%s%s", job->id, job->spec.scenario->name, job_state_word(state),
             state == JOB_HELD ? " why=" : "", job->why, job->report.status && state == JOB_FAILED ? " error=" : "",
             state == JOB_FAILED ? job->report.error.message : "");
    scheduler_changed(s, job, EVENT_STATE);
}

void scheduler_enter(struct scheduler *s, struct job *job, enum job_state state)
{
    struct scree_error error = {0};
    if (job_state_ended(state))
        job->ended = scheduler_unix_now();
    if (scheduler_write_job(s, job, state, &error)) {
        log_line(LOG_ERROR, "job=%s state=%s %s", job->id, job_state_word(state), error.message);
        job->late = job_state_ended(state); // nobody is told before it is written
        job->verdict_state = state;
        if (job->late) {
            job->ended = 0;
            return;
        }
    }
    job->late = false;
    scheduler_set_state(s, job, state);
    if (job_state_ended(state)) {
        steering_ended(s, job);
        restart_forget(s, job);
    }
}

static void fail_job(struct scheduler *s, struct job *job, const struct scree_error *error)
{
    job->report.status = error->status;
    job->report.error = *error;
    scheduler_enter(s, job, JOB_FAILED);
}

static int threads_of(const struct scheduler *s, const struct job *job)
{
    return job->base.threads < s->config->workers ? (int)job->base.threads : s->config->workers;
}

void scheduler_order(struct job *job, enum run_order order)
{
    if (!job->run)
        return;
    int now = atomic_load(&job->run->order);
    while (now < (int)order && !atomic_compare_exchange_weak(&job->run->order, &now, (int)order))
        ;
    pthread_mutex_lock(&job->run->lock);
    pthread_cond_broadcast(&job->run->answered);
    pthread_mutex_unlock(&job->run->lock);
}

static enum scree_status make_run(struct scheduler *s, struct job *job, struct run **out, struct scree_error *err)
{
    struct run *run = calloc(1, sizeof *run);
    if (!run)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to run %s", job->id);
    run->job = job->number;
    run->serial = ++s->serials;
    run->spec = job->base;
    run->recorder = s->recorder;
    run->checkpoint_s = s->config->checkpoint_s;
    run->stop_step = UINT64_MAX;
    run->wall_before_s = job->report.wall_s;
    pthread_mutex_init(&run->lock, NULL);
    pthread_cond_init(&run->answered, NULL);
    snprintf(run->folder, sizeof run->folder, "%s/jobs/%s", s->config->data, job->id);
    meshes_folder(s->config, run->meshes);
    scheduler_log_path(s, job, run->log_path, sizeof run->log_path);
    enum scree_status status;
    if ((status = scheduler_folder(run->folder, err)) || (status = restart_find(s, job, run, err)) ||
        (status = steering_script(s, job, run, err)))
        free_run(run);
    else
        *out = run;
    return status;
}

void scheduler_start(struct scheduler *s, struct job *job)
{
    struct scree_error error = {0};
    struct run *run = NULL;
    if (make_run(s, job, &run, &error)) {
        if (!holds_fault(s, job, &error))
            fail_job(s, job, &error);
        return;
    }
    run->report = job->report;                                          // what is known until the worker says more
    job->report.ended = run->report.ended = run->report.hashed = false; // of the run before, if it was parked
    run->report.head_count = 0;
    run->report.status = job->report.status = SCREE_OK;
    if (!workers_assign(s->workers, run)) { // the idle one has not come back yet
        free_run(run);
        return;
    }
    job->run = run;
    job->started = job->started > 0 ? job->started : scheduler_unix_now();
    snprintf(job->build, sizeof job->build, "%s", scree_build());
    s->busy += (size_t)threads_of(s, job);
    scheduler_enter(s, job, JOB_RUNNING);
}

/* Highest priority first, then oldest. */
static struct job *next_queued(const struct scheduler *s)
{
    struct job *best = NULL;
    for (size_t k = 0; k < s->count; k++)
        if (s->jobs[k]->state == JOB_QUEUED && (!best || s->jobs[k]->spec.priority > best->spec.priority))
            best = s->jobs[k];
    return best;
}

static struct record_order *order_for(struct scheduler *s, const struct job *job, bool final, uint64_t ticket, const char *state)
{
    struct record_order *order = calloc(1, sizeof *order);
    cJSON *journal = scheduler_steering(s, job);
    if (!order || !journal || !(order->spec_text = strdup(job->spec_text)) || !(order->journal_text = json_print(journal, false))) {
        cJSON_Delete(journal);
        record_order_free(order);
        return NULL;
    }
    cJSON_Delete(journal);
    order->job = job->number;
    order->final = final;
    order->ticket = ticket;
    order->spec = job->spec;
    order->report = job->report;
    snprintf(order->id, sizeof order->id, "%s", job->id);
    snprintf(order->state, sizeof order->state, "%s", state);
    scheduler_log_path(s, job, order->log_path, sizeof order->log_path);
    scheduler_result_path(s, job, final, order->path, sizeof order->path);
    pthread_mutex_lock(&job->run->lock);
    order->stands = job->run->stands;
    order->stream_count = job->run->stream_count;
    memcpy(order->streams, job->run->streams, sizeof order->streams);
    pthread_mutex_unlock(&job->run->lock);
    return order;
}

static void end_run(struct scheduler *s, struct job *job)
{
    s->busy -= (size_t)threads_of(s, job);
    free_run(job->run);
    job->run = NULL;
    job->recording = false;
}

/* The run was stopped and its checkpoint is written: it goes on later. */
static void run_parked(struct scheduler *s, struct job *job)
{
    int order = atomic_load(&job->run->order);
    end_run(s, job);
    if (order == RUN_STOP) // with the daemon: the journal keeps it running
        return;
    if (steering_paused(s, job)) // a hold that came after the pause outranks it as an order, and must not lose it
        return;
    scheduler_set_state(s, job, order == RUN_HOLD && *s->disk_low ? JOB_HELD : JOB_QUEUED);
    if (job->state == JOB_HELD) {
        job->hold = HOLD_DISK;
        snprintf(job->why, sizeof job->why, "%s", s->disk_low);
    }
}

void scheduler_record_again(struct scheduler *s, struct job *job)
{
    struct record_order *order = order_for(s, job, true, 0, job_state_word(job->verdict_state));
    if (order)
        recorder_ask(s->recorder, order);
}

/* The worker is through: a result is made of what there is, then the job ends. */
static void run_ended(struct scheduler *s, struct job *job)
{
    enum scree_status status = job->report.status;
    if (status == SCREE_BUSY) {
        run_parked(s, job);
        return;
    }
    if (!s->closing && holds_fault(s, job, &job->report.error)) {
        end_run(s, job);
        steering_paused(s, job); // or nobody would answer a pause that was on its way
        return;
    }
    job->verdict_state = status == SCREE_OK ? JOB_DONE : status == SCREE_CANCELLED ? JOB_CANCELLED : JOB_FAILED;
    struct record_order *order = order_for(s, job, true, 0, job_state_word(job->verdict_state));
    if (order && order->stands) {
        job->recording = true;
        recorder_ask(s->recorder, order);
        return;
    }
    record_order_free(order);
    end_run(s, job);
    scheduler_enter(s, job, job->verdict_state);
}

static void look_at_run(struct scheduler *s, struct job *job)
{
    steering_answer(s, job);
    if (!atomic_exchange(&job->run->dirty, false))
        return;
    pthread_mutex_lock(&job->run->lock);
    job->report = job->run->report;
    pthread_mutex_unlock(&job->run->lock);
    scheduler_changed(s, job, EVENT_CHUNKS);
    scheduler_changed(s, job, EVENT_PROGRESS);
    /* A run that is to go on is over once its checkpoints are where the next one looks for them. */
    if (job->report.ended && !job->recording && atomic_load(&job->run->images) == 0)
        run_ended(s, job);
}

struct job *scheduler_by_number(const struct scheduler *s, int64_t number)
{
    size_t low = 0, high = s->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (s->jobs[middle]->number < number)
            low = middle + 1;
        else
            high = middle;
    }
    return low < s->count && s->jobs[low]->number == number ? s->jobs[low] : NULL;
}

/* A checkpoint is on disk, or could not be written: the job goes on all the same. */
static void image_recorded(struct scheduler *s, const struct record_order *order)
{
    struct job *job = scheduler_by_number(s, order->job);
    struct scree_error error = {0};
    if (order->status)
        log_line(LOG_WARNING, "job=%s step=%llu no checkpoint: %s", job->id, (unsigned long long)order->step, order->error.message);
    else if (job->state == JOB_RUNNING && order->kind == RECORD_CHECKPOINT && !job->late && !job->recording &&
             scheduler_write_job(s, job, atomic_load(&job->run->order) == RUN_CANCEL ? JOB_CANCELLED : JOB_RUNNING, &error))
        log_line(LOG_WARNING, "job=%s %s", job->id, error.message);
    steering_recorded(s, order);
    if (job->run && job->run->serial == order->serial) {
        atomic_fetch_sub(&job->run->images, 1);
        atomic_store(&job->run->dirty, true);
    }
}

void scheduler_look_at_recorder(struct scheduler *s)
{
    for (struct record_order *order; (order = recorder_take(s->recorder)); record_order_free(order)) {
        if (order->write) {
            s->watch.recorded(s->watch.context, order);
            continue;
        }
        struct job *job = scheduler_by_number(s, order->job);
        if (order->kind != RECORD_RESULT) {
            image_recorded(s, order);
            continue;
        }
        if (!order->final) {
            s->watch.fetched(s->watch.context, order->ticket, job, order->path, order->status ? &order->error : NULL);
            continue;
        }
        if (order->status && !s->closing && holds_fault(s, job, &order->error))
            continue; // with its run: the result is asked for again
        if (order->status && s->closing) {
            end_run(s, job); // the next start makes it
            continue;
        }
        if (order->status && job->verdict_state != JOB_FAILED) {
            job->verdict_state = JOB_FAILED;
            job->report.status = order->status;
            job->report.error = order->error;
        }
        FAILPOINT("result-known");
        end_run(s, job);
        scheduler_enter(s, job, job->verdict_state);
    }
}

void scheduler_turn(struct scheduler *s)
{
    holds_turn(s);
    scheduler_look_at_recorder(s);
    for (size_t k = 0; k < s->count; k++)
        if (s->jobs[k]->run)
            look_at_run(s, s->jobs[k]);
    while (!s->closing && s->queued > 0) {
        struct job *job = next_queued(s);
        if (s->busy > 0 && s->busy + (size_t)threads_of(s, job) > (size_t)s->config->workers)
            break;
        if (holds_stop(s, job))
            continue;
        scheduler_start(s, job);
        if (job->state == JOB_QUEUED)
            break;
    }
}

/* ---- requests ---- */

static struct job *same_request(const struct scheduler *s, const char *request)
{
    for (size_t k = s->count; k-- > 0;)
        if (strcmp(s->jobs[k]->request, request) == 0)
            return s->jobs[k];
    return NULL;
}

static struct job *same_result(const struct scheduler *s, const char *spec_text)
{
    for (size_t k = s->count; k-- > 0;) {
        struct job *job = s->jobs[k];
        if (job->state == JOB_DONE && !job->steered && !*job->origin && strcmp(job->build, scree_build()) == 0 &&
            strcmp(job->spec_text, spec_text) == 0)
            return job;
    }
    return NULL;
}

enum scree_status scheduler_submit(struct scheduler *s, const char *request, const struct job_spec *spec, bool again,
                                   struct job **out, bool *reused, struct scree_error *err)
{
    *reused = true;
    if ((*out = same_request(s, request)))
        return SCREE_OK;
    cJSON *json = job_encode(spec);
    char *text = json ? json_print(json, false) : NULL;
    cJSON_Delete(json);
    enum scree_status status = SCREE_OK;
    if (!text) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the job");
        goto out;
    }
    if (!again && (*out = same_result(s, text)))
        goto out;
    *reused = false;
    if (s->queued >= QUEUE_MAX) {
        status = scree_fail(err, SCREE_BUSY, "", "%d jobs are queued; try again later", QUEUE_MAX);
        goto out;
    }
    if (!(status = scheduler_insert(s, request, spec, "", out, err))) {
        log_line(LOG_INFO, "job=%s scenario=%s state=queued", (*out)->id, spec->scenario->name);
        scheduler_changed(s, *out, EVENT_STATE);
    }
out:
    free(text);
    return status;
}

enum scree_status scheduler_insert(struct scheduler *s, const char *request, const struct job_spec *spec, const char *origin,
                                   struct job **out, struct scree_error *err)
{
    cJSON *json = job_encode(spec);
    struct job *job = calloc(1, sizeof *job);
    enum scree_status status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the job");
    if (!json || !job || !(job->spec_text = json_print(json, false)) || !(job->origin = strdup(origin)) ||
        memory_grow((void **)&s->jobs, &s->room, s->count + 1, sizeof *s->jobs, err))
        goto out;
    job->base = job->spec = *spec;
    job->submitted = scheduler_unix_now();
    snprintf(job->request, sizeof job->request, "%s", request);
    struct journal_row row = {
        .request = request, .state = "queued", .spec = job->spec_text, .origin = origin, .submitted = job->submitted};
    if ((status = journal_insert(s->journal, &row, err)))
        goto out;
    scheduler_name_job(job, row.number);
    s->jobs[s->count++] = job; // its place was made above
    s->queued++;
    *out = job;
    job = NULL;
out:
    cJSON_Delete(json);
    scheduler_free_job(job);
    return status;
}

void scheduler_forget(struct scheduler *s, struct job *job)
{
    if (s->count == 0 || s->jobs[s->count - 1] != job)
        return;
    s->count--;
    s->queued -= job->state == JOB_QUEUED;
    scheduler_free_job(job);
}

enum scree_status scheduler_fetch(struct scheduler *s, struct job *job, uint64_t ticket, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 64];
    if (job->run) {
        struct record_order *order = order_for(s, job, false, ticket, job_state_word(job->state));
        if (!order || !order->stands) {
            record_order_free(order);
            return scree_fail(err, SCREE_NOT_FOUND, "job", "%s has only just begun: there is nothing to fetch yet", job->id);
        }
        recorder_ask(s->recorder, order);
        return SCREE_OK;
    }
    scheduler_result_path(s, job, true, path, sizeof path);
    if (access(path, R_OK) != 0)
        return scree_fail(err, SCREE_NOT_FOUND, "job", "%s is %s and has no result", job->id, job_state_word(job->state));
    s->watch.fetched(s->watch.context, ticket, job, path, NULL);
    return SCREE_OK;
}

void scheduler_record(struct scheduler *s, struct record_order *order)
{
    recorder_ask(s->recorder, order);
}

struct journal *scheduler_journal(struct scheduler *s)
{
    return s->journal;
}

struct job *scheduler_find(struct scheduler *s, const char *id)
{
    char *end;
    if (!id || id[0] != 'j' || id[1] < '1' || id[1] > '9' || strlen(id) > 18)
        return NULL;
    long long number = strtoll(id + 1, &end, 10);
    return *end ? NULL : scheduler_by_number(s, number);
}

bool scheduler_is_lost(const struct scheduler *s)
{
    return recorder_is_lost(s->recorder);
}

size_t scheduler_count(const struct scheduler *s)
{
    return s->count;
}

struct job *scheduler_at(struct scheduler *s, size_t index)
{
    return s->jobs[index];
}

void scheduler_states(const struct scheduler *s, size_t counts[JOB_STATES])
{
    memset(counts, 0, JOB_STATES * sizeof *counts);
    for (size_t k = 0; k < s->count; k++)
        counts[s->jobs[k]->state]++;
}
