/* SPDX-License-Identifier: GPL-3.0-or-later */
/* States of a job:
 *
 *      submit                assign                      run ended, result written
 *   ------------> queued -----------> running ---------------------------------> done
 *                   |                    |  \                                    failed
 *                   | cancel             |   `-- cancel: at the end of the slice  cancelled
 *                   v                    |
 *               cancelled                `-- daemon ends: stays running in the journal,
 *                                            queued in memory at the next start
 *   (paused and held have their place in the protocol and no way in yet)
 *
 *   from      event                          to         what else happens
 *   -         submit, committed              queued     the client gets its answer
 *   queued    a worker is idle               running    run created, journal updated
 *   queued    cancel                         cancelled
 *   running   report: ended                  running    recording: the recorder makes result.h5
 *   running   recorder is through            done | failed | cancelled, by the report
 *   running   cancel                         running    cancelled in the journal, order to the worker
 *
 * Invariants: what the journal says is written before anybody is told; a job has
 * a run exactly while it is running; an ended job never changes; `done` has its
 * result.h5 in place. A job that is run again after a crash writes the same
 * chunks: its log is kept, and chunks that are there are compared, not replaced. */
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

#include "base/memory.h"
#include "log.h"
#include "protocol/frame.h"
#include "protocol/job_json.h"
#include "recorder.h"
#include "worker.h"

enum { QUEUE_MAX = 10000 };

struct scheduler {
    const struct config *config;
    struct scheduler_watch watch;
    struct journal *journal;
    struct workers *workers;
    struct recorder *recorder;
    int lock_fd;
    struct job **jobs;                // by number, ascending
    size_t count, room, queued, busy; // busy: threads of running jobs
    bool closing;
};

static const char *const words[JOB_STATES] = {"queued", "running", "paused", "done", "failed", "cancelled", "held"};

const char *job_state_word(enum job_state state)
{
    return words[state];
}

enum job_state job_state_of(const char *word)
{
    enum job_state state = 0;
    while (state < JOB_STATES && strcmp(words[state], word) != 0)
        state++;
    return state;
}

static double unix_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- outcome: what a run came to, as JSON in the journal ---- */

static cJSON *outcome_json(const struct run_report *r)
{
    cJSON *json = cJSON_CreateObject(), *numbers = cJSON_CreateArray();
    json_put_text(json, "verdict", scree_verdict_word(r->verdict));
    json_put_text(json, "evidence", r->evidence);
    json_put_int(json, "steps", (long long)r->steps);
    json_put_real(json, "time_s", r->time_s);
    json_put_real(json, "wall_s", r->wall_s);
    json_put_real(json, "rate", r->rate);
    json_put_int(json, "moving", (long long)r->moving);
    json_put_int(json, "fixed", (long long)r->fixed);
    json_put_text(json, "isa", r->isa);
    json_put_int(json, "threads", r->threads);
    for (size_t k = 0; numbers && k < r->number_count; k++) {
        cJSON *n = cJSON_CreateObject();
        json_put_text(n, "name", r->numbers[k].name);
        json_put_text(n, "unit", r->numbers[k].unit);
        json_put_text(n, "doc", r->numbers[k].doc);
        json_put_real(n, "value", r->numbers[k].value);
        cJSON_AddItemToArray(numbers, n);
    }
    json_put(json, "numbers", numbers);
    if (r->status && r->status != SCREE_CANCELLED)
        json_put(json, "error", error_json(scree_status_word(r->status), &r->error));
    return json;
}

/* Names of numbers live as long as the daemon: they are few, and kept once. */
static const char *kept_word(const char *word)
{
    static char *kept[512];
    static size_t count;
    for (size_t k = 0; k < count; k++)
        if (strcmp(kept[k], word) == 0)
            return kept[k];
    if (count == sizeof kept / sizeof *kept || !(kept[count] = strdup(word)))
        return "";
    return kept[count++];
}

static void outcome_read(const char *text, struct run_report *r)
{
    cJSON *json = NULL;
    memset(r, 0, sizeof *r);
    if (!*text || json_read(text, strlen(text), "outcome", &json, NULL))
        return;
    const char *verdict = json_text(json, "verdict"), *evidence = json_text(json, "evidence"), *isa = json_text(json, "isa");
    for (enum scree_verdict v = VERDICT_UNDECIDED; v <= VERDICT_ACCELERATING; v++)
        if (verdict && strcmp(verdict, scree_verdict_word(v)) == 0)
            r->verdict = v;
    snprintf(r->evidence, sizeof r->evidence, "%s", evidence ? evidence : "");
    snprintf(r->isa, sizeof r->isa, "%s", isa ? isa : "");
    r->steps = (uint64_t)json_number(json, "steps", 0);
    r->time_s = json_number(json, "time_s", 0);
    r->wall_s = json_number(json, "wall_s", 0);
    r->rate = json_number(json, "rate", 0);
    r->moving = (size_t)json_number(json, "moving", 0);
    r->fixed = (size_t)json_number(json, "fixed", 0);
    r->threads = (int)json_number(json, "threads", 1);
    const cJSON *n = NULL, *error = json_get(json, "error");
    cJSON_ArrayForEach(n, json_get(json, "numbers")) if (r->number_count < SCREE_SUMMARY_MAX && json_text(n, "name"))
    {
        const char *unit = json_text(n, "unit"), *doc = json_text(n, "doc");
        r->numbers[r->number_count++] = (struct scree_number){.name = kept_word(json_text(n, "name")),
                                                              .unit = kept_word(unit ? unit : ""),
                                                              .doc = kept_word(doc ? doc : ""),
                                                              .value = json_number(n, "value", 0)};
    }
    if (error)
        r->status = error_read(error, &r->error);
    cJSON_Delete(json);
}

/* ---- journal ---- */

static enum scree_status write_job(struct scheduler *s, const struct job *job, struct scree_error *err)
{
    cJSON *json = job_state_ended(job->state) ? outcome_json(&job->report) : NULL;
    char *outcome = json ? json_print(json, false) : NULL;
    const struct journal_row row = {.number = job->number,
                                    .state = job_state_word(job->state),
                                    .build = job->build,
                                    .outcome = outcome ? outcome : "",
                                    .started = job->started,
                                    .ended = job->ended};
    enum scree_status status = journal_update(s->journal, &row, err);
    free(outcome);
    cJSON_Delete(json);
    return status;
}

static enum scree_status keep_job(struct scheduler *s, struct job *job, struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&s->jobs, &s->room, s->count + 1, sizeof *s->jobs, err);
    if (!status)
        s->jobs[s->count++] = job;
    return status;
}

static void free_job(struct job *job)
{
    if (!job)
        return;
    free(job->spec_text);
    if (job->run)
        pthread_mutex_destroy(&job->run->lock);
    free(job->run);
    free(job);
}

static void name_job(struct job *job, int64_t number)
{
    job->number = number;
    snprintf(job->id, sizeof job->id, "j%lld", (long long)number);
}

static enum scree_status load_job(void *context, const struct journal_row *row, struct scree_error *err)
{
    struct scheduler *s = context;
    struct job *job = calloc(1, sizeof *job);
    cJSON *json = NULL;
    enum scree_status status = SCREE_NO_MEMORY;
    if (!job || !(job->spec_text = strdup(row->spec)))
        goto out;
    name_job(job, row->number);
    snprintf(job->request, sizeof job->request, "%s", row->request);
    snprintf(job->build, sizeof job->build, "%s", row->build);
    job->submitted = row->submitted;
    job->started = row->started;
    job->ended = row->ended;
    outcome_read(row->outcome, &job->report);
    job->state = job_state_of(row->state);
    if (job->state == JOB_RUNNING || job->state == JOB_STATES)
        job->state = JOB_QUEUED; // it is run again and comes to the same chunks
    struct scree_error error = {0};
    if (json_read(row->spec, strlen(row->spec), "spec", &json, &error) || job_decode(json, &job->spec, &error)) {
        /* Written by another version: the record stays, the job cannot run. */
        job->spec.scenario = scenario_list[0];
        if (!job_state_ended(job->state)) {
            job->state = JOB_FAILED;
            job->report.status = SCREE_CORRUPT;
            job->report.error = error;
        }
    }
    s->queued += job->state == JOB_QUEUED;
    status = keep_job(s, job, err);
out:
    cJSON_Delete(json);
    if (status) {
        free_job(job);
        return status == SCREE_NO_MEMORY ? scree_fail(err, status, NULL, "no memory to load the journal") : status;
    }
    return SCREE_OK;
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

static enum scree_status make_folder(const char *path, struct scree_error *err)
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

static enum scree_status lock_data(struct scheduler *s, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 64];
    snprintf(path, sizeof path, "%s/lock", s->config->data);
    s->lock_fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (s->lock_fd < 0)
        return scree_fail(err, SCREE_IO, "data", "cannot write in the data directory %s: %s", s->config->data, strerror(errno));
    if (flock(s->lock_fd, LOCK_EX | LOCK_NB) != 0)
        return scree_fail(err, SCREE_BUSY, "data", "another screed works in the data directory %s", s->config->data);
    return SCREE_OK;
}

/* ---- opening and closing ---- */

enum scree_status scheduler_open(struct scheduler **out, const struct config *config, int wake_fd,
                                 const struct scheduler_watch *watch, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 64];
    struct scheduler *s = calloc(1, sizeof *s);
    if (!s)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the scheduler");
    s->config = config;
    s->watch = *watch;
    s->lock_fd = -1;
    snprintf(path, sizeof path, "%s/jobs", config->data);
    enum scree_status status;
    if ((status = make_folder(path, err)) || (status = lock_data(s, err)))
        goto out;
    snprintf(path, sizeof path, "%s/journal.db", config->data);
    if ((status = journal_open(&s->journal, path, err)) || (status = journal_load(s->journal, load_job, s, err)) ||
        (status = recorder_start(&s->recorder, wake_fd, err)))
        goto out;
    status = workers_start(&s->workers, config->workers, wake_fd, err);
out:
    if (status)
        scheduler_close(s);
    else
        *out = s;
    return status;
}

void scheduler_close(struct scheduler *s)
{
    if (!s)
        return;
    s->closing = true;
    for (size_t k = 0; k < s->count; k++)
        if (s->jobs[k]->run) {
            int go = RUN_GO; // a cancelled one stays so
            atomic_compare_exchange_strong(&s->jobs[k]->run->order, &go, RUN_STOP);
        }
    workers_stop(s->workers);
    if (s->workers)
        scheduler_turn(s); // runs that had just ended are recorded
    recorder_stop(s->recorder);
    journal_close(s->journal);
    for (size_t k = 0; k < s->count; k++)
        free_job(s->jobs[k]);
    free(s->jobs);
    if (s->lock_fd >= 0)
        close(s->lock_fd);
    free(s);
}

/* ---- transitions ---- */

static void changed(struct scheduler *s, const struct job *job, enum job_event what)
{
    if (!s->closing)
        s->watch.changed(s->watch.context, job, what);
}

static void enter(struct scheduler *s, struct job *job, enum job_state state)
{
    struct scree_error error = {0};
    s->queued -= job->state == JOB_QUEUED;
    job->state = state;
    s->queued += state == JOB_QUEUED;
    if (job_state_ended(state))
        job->ended = unix_now();
    if (write_job(s, job, &error))
        log_line(LOG_ERROR, "job=%s state=%s %s", job->id, job_state_word(state), error.message);
    log_line(LOG_INFO, "job=%s scenario=%s state=%s%s%s", job->id, job->spec.scenario->name, job_state_word(state),
             job->report.status && state == JOB_FAILED ? " error=" : "", state == JOB_FAILED ? job->report.error.message : "");
    changed(s, job, EVENT_STATE);
}

static void fail_job(struct scheduler *s, struct job *job, const struct scree_error *error)
{
    job->report.status = error->status;
    job->report.error = *error;
    enter(s, job, JOB_FAILED);
}

static int threads_of(const struct scheduler *s, const struct job *job)
{
    return job->spec.threads < s->config->workers ? (int)job->spec.threads : s->config->workers;
}

static void start_job(struct scheduler *s, struct job *job)
{
    char folder[CONFIG_PATH_MAX + 64];
    struct scree_error error = {0};
    struct run *run = calloc(1, sizeof *run);
    snprintf(folder, sizeof folder, "%s/jobs/%s", s->config->data, job->id);
    if (!run)
        scree_fail(&error, SCREE_NO_MEMORY, NULL, "no memory to run %s", job->id);
    if (!run || make_folder(folder, &error)) {
        free(run);
        fail_job(s, job, &error);
        return;
    }
    run->spec = job->spec;
    pthread_mutex_init(&run->lock, NULL);
    scheduler_log_path(s, job, run->log_path, sizeof run->log_path);
    if (!workers_assign(s->workers, run)) { // the idle one has not come back yet
        pthread_mutex_destroy(&run->lock);
        free(run);
        return;
    }
    job->run = run;
    job->started = unix_now();
    snprintf(job->build, sizeof job->build, "%s", scree_build());
    memset(&job->report, 0, sizeof job->report);
    s->busy += (size_t)threads_of(s, job);
    enter(s, job, JOB_RUNNING);
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
    if (!order || !(order->spec_text = strdup(job->spec_text))) {
        free(order);
        return NULL;
    }
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
    order->stream_count = job->run->stream_count;
    memcpy(order->streams, job->run->streams, sizeof order->streams);
    pthread_mutex_unlock(&job->run->lock);
    return order;
}

static void end_run(struct scheduler *s, struct job *job)
{
    s->busy -= (size_t)threads_of(s, job);
    pthread_mutex_destroy(&job->run->lock);
    free(job->run);
    job->run = NULL;
    job->recording = false;
}

/* The worker is through: a result is made of what there is, then the job ends. */
static void run_ended(struct scheduler *s, struct job *job)
{
    enum scree_status status = job->report.status;
    if (status == SCREE_BUSY) { // stopped with the daemon: the journal keeps it running
        end_run(s, job);
        return;
    }
    job->verdict_state = status == SCREE_OK ? JOB_DONE : status == SCREE_CANCELLED ? JOB_CANCELLED : JOB_FAILED;
    struct record_order *order = order_for(s, job, true, 0, job_state_word(job->verdict_state));
    if (order && order->stream_count > 0) {
        job->recording = true;
        recorder_ask(s->recorder, order);
        return;
    }
    record_order_free(order);
    end_run(s, job);
    enter(s, job, job->verdict_state);
}

static void look_at_run(struct scheduler *s, struct job *job)
{
    if (!atomic_exchange(&job->run->dirty, false))
        return;
    pthread_mutex_lock(&job->run->lock);
    job->report = job->run->report;
    pthread_mutex_unlock(&job->run->lock);
    changed(s, job, EVENT_CHUNKS);
    changed(s, job, EVENT_PROGRESS);
    if (job->report.ended && !job->recording)
        run_ended(s, job);
}

static struct job *by_number(const struct scheduler *s, int64_t number)
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

static void look_at_recorder(struct scheduler *s)
{
    for (struct record_order *order; (order = recorder_take(s->recorder)); record_order_free(order)) {
        if (order->write) {
            s->watch.recorded(s->watch.context, order);
            continue;
        }
        struct job *job = by_number(s, order->job);
        if (!order->final) {
            s->watch.fetched(s->watch.context, order->ticket, job, order->path, order->status ? &order->error : NULL);
            continue;
        }
        if (order->status && job->verdict_state != JOB_FAILED) {
            job->verdict_state = JOB_FAILED;
            job->report.status = order->status;
            job->report.error = order->error;
        }
        end_run(s, job);
        enter(s, job, job->verdict_state);
    }
}

void scheduler_turn(struct scheduler *s)
{
    for (size_t k = 0; k < s->count; k++)
        if (s->jobs[k]->run)
            look_at_run(s, s->jobs[k]);
    look_at_recorder(s);
    while (!s->closing && s->queued > 0) {
        struct job *job = next_queued(s);
        if (s->busy > 0 && s->busy + (size_t)threads_of(s, job) > (size_t)s->config->workers)
            break;
        start_job(s, job);
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
        if (job->state == JOB_DONE && strcmp(job->build, scree_build()) == 0 && strcmp(job->spec_text, spec_text) == 0)
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
    struct job *job = NULL;
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
    struct journal_row row = {.request = request, .state = "queued", .spec = text, .submitted = unix_now()};
    if (!(job = calloc(1, sizeof *job))) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the job");
        goto out;
    }
    job->spec = *spec;
    job->spec_text = text;
    text = NULL;
    job->submitted = row.submitted;
    snprintf(job->request, sizeof job->request, "%s", request);
    if ((status = journal_insert(s->journal, &row, err)))
        goto out;
    name_job(job, row.number);
    if ((status = keep_job(s, job, err)))
        goto out;
    s->queued++;
    *out = job;
    job = NULL;
    log_line(LOG_INFO, "job=%s scenario=%s state=queued", (*out)->id, spec->scenario->name);
    changed(s, *out, EVENT_STATE);
out:
    free_job(job);
    free(text);
    return status;
}

enum scree_status scheduler_cancel(struct scheduler *s, struct job *job, struct scree_error *err)
{
    if (job->state == JOB_QUEUED)
        enter(s, job, JOB_CANCELLED);
    if (!job->run)
        return SCREE_OK;
    /* The journal first: should the daemon end before the worker does, the job must not run again. */
    job->state = JOB_CANCELLED;
    enum scree_status status = write_job(s, job, err);
    job->state = JOB_RUNNING;
    if (!status)
        atomic_store(&job->run->order, RUN_CANCEL);
    return status;
}

enum scree_status scheduler_fetch(struct scheduler *s, struct job *job, uint64_t ticket, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 64];
    if (job->run) {
        struct record_order *order = order_for(s, job, false, ticket, job_state_word(job->state));
        if (!order || order->stream_count == 0) {
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
    return *end ? NULL : by_number(s, number);
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
