/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See requests.h: one function an operation, one line in the table. */
#include "requests.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/cpu.h"
#include "gate.h"
#include "health.h"
#include "limits.h"
#include "meshes.h"
#include "outcome.h"
#include "protocol/job_json.h"
#include "study_requests.h"

enum { PART_MAX = 512 << 10, ASSIGNMENTS_MAX = 32 };

static double monotonic(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double requests_memory(void)
{
    return 0.8 * health_memory_available();
}

static void put_time(cJSON *json, const char *key, double unix_seconds)
{
    if (unix_seconds > 0)
        json_put_real(json, key, unix_seconds);
    else
        json_put(json, key, cJSON_CreateNull());
}

cJSON *requests_summary(const struct job *job)
{
    const struct run_report *r = &job->report;
    cJSON *json = cJSON_CreateObject();
    double end = job->spec.time.end_s, progress = job->state == JOB_DONE ? 1 : end > 0 ? fmin(1, r->time_s / end) : 0;
    double rate = r->rate,
           left = r->moving > 0 && job->spec.time.step_s > 0 ? (end - r->time_s) / job->spec.time.step_s * (double)r->moving : 0;
    json_put_text(json, "id", job->id);
    json_put_text(json, "title", job->spec.title);
    json_put_text(json, "scenario", job->spec.scenario->name);
    json_put_text(json, "state", job_state_word(job->state));
    json_put_text(json, "verdict", scree_verdict_word(r->verdict));
    json_put_real(json, "time_s", r->time_s);
    json_put_real(json, "end_s", end);
    json_put_real(json, "progress", progress);
    json_put_int(json, "steps", (long long)r->steps);
    json_put_int(json, "grains", (long long)(r->moving + r->fixed));
    json_put_int(json, "moving", (long long)r->moving);
    json_put_real(json, "grain_steps_per_s", rate);
    if (job->state == JOB_RUNNING && rate > 0)
        json_put_real(json, "eta_s", left / rate);
    else
        json_put(json, "eta_s", cJSON_CreateNull());
    put_time(json, "submitted", job->submitted);
    put_time(json, "started", job->started);
    put_time(json, "ended", job->ended);
    char study[JOB_ID_MAX];
    studies_parent(job, study);
    json_put_text(json, "study", *study ? study : NULL);
    return json;
}

static enum scree_status find_job(struct daemon *daemon, const cJSON *body, struct job **out, struct scree_error *err)
{
    const char *id = json_text(body, "job");
    *out = scheduler_find(daemon->scheduler, id);
    if (*out)
        return SCREE_OK;
    scree_fail(err, SCREE_NOT_FOUND, "job", "there is no job \"%.32s\"", id ? id : "");
    scree_hint(err, "`scree list` shows the jobs there are");
    return SCREE_NOT_FOUND;
}

/* A whole number of the body; `fallback` when it is not given. */
static enum scree_status whole_number(const cJSON *body, const char *key, double fallback, double low, double high, double *out,
                                      struct scree_error *err)
{
    *out = json_number(body, key, json_get(body, key) ? NAN : fallback);
    if (*out >= low && *out <= high && *out == floor(*out))
        return SCREE_OK;
    return scree_fail(err, SCREE_INVALID, key, "%s: a whole number in %.0f..%.0f is expected", key, low, high);
}

/* ---- operations: each makes *result or fails; `id` is the request's, with its user's name before it ---- */

static enum scree_status do_ping(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)body, (void)id;
    char stream[CONFIG_PATH_MAX], events[CONFIG_PATH_MAX];
    bool outside = daemon->user.network;
    if (outside && (gate_outer(daemon->config, 1, stream, err) || gate_outer(daemon->config, 2, events, err)))
        return SCREE_INTERNAL;
    *result = cJSON_CreateObject();
    json_put_text(*result, "version", scree_build());
    json_put_text(*result, "protocol", PROTOCOL_VERSION);
    json_put_int(*result, "pid", getpid());
    json_put_real(*result, "uptime_s", monotonic() - daemon->started);
    json_put_int(*result, "workers", daemon->config->workers);
    json_put_text(*result, "isa", cpu_isa_name(cpu_best()));
    json_put_text(*result, "stream_endpoint", outside ? stream : daemon->config->stream);
    json_put_text(*result, "events_endpoint", outside ? events : daemon->config->events);
    json_put_text(*result, "data_dir", daemon->config->data);
    json_put_text(*result, "role", role_word(daemon->user.role));
    health_put(*result, daemon->config, daemon->scheduler);
    return SCREE_OK;
}

static enum scree_status read_spec(const struct daemon *daemon, const cJSON *body, struct job_spec *spec, struct scree_error *err)
{
    const cJSON *json = json_get(body, "spec");
    if (!json)
        return scree_fail(err, SCREE_INVALID, "spec", "spec: is missing");
    enum scree_status status = job_decode(json, spec, err);
    if (!status)
        status = job_check(spec, requests_memory(), err);
    return status ? status : meshes_check_job(spec, daemon->config, err);
}

static enum scree_status do_check(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    struct job_spec spec;
    enum scree_status status = read_spec(daemon, body, &spec, err);
    if (status)
        return status;
    const struct job_cost cost = job_cost(&spec);
    *result = cJSON_CreateObject();
    json_put(*result, "spec", job_encode(&spec));
    json_put(*result, "cost", job_cost_encode(&cost));
    return SCREE_OK;
}

static enum scree_status do_submit(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                   struct scree_error *err)
{
    struct job_spec spec;
    struct job *job;
    bool reused;
    enum scree_status status = read_spec(daemon, body, &spec, err);
    if (status || (status = limits_check_jobs(daemon->config, daemon->scheduler, &daemon->user, id, err)) ||
        (status = scheduler_submit(daemon->scheduler, id, &spec, json_bool(body, "again", false), &job, &reused, err)))
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "job", job->id);
    json_put_text(*result, "state", job_state_word(job->state));
    json_put_bool(*result, "reused", reused);
    return SCREE_OK;
}

static enum scree_status do_mesh(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    return meshes_keep(daemon->config, body, result, err);
}

static enum scree_status do_list(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    unsigned wanted = 0;
    const cJSON *word, *states = json_get(body, "states");
    double limit;
    enum scree_status status = whole_number(body, "limit", 1000, 1, 1e6, &limit, err);
    if (status)
        return status;
    if (states && !cJSON_IsArray(states))
        return scree_fail(err, SCREE_INVALID, "states", "states: an array of states is expected");
    cJSON_ArrayForEach(word, states)
    {
        enum job_state state = cJSON_IsString(word) ? job_state_of(word->valuestring) : JOB_STATES;
        if (state == JOB_STATES)
            return scree_fail(err, SCREE_INVALID, "states",
                              "states: queued, running, paused, done, failed, cancelled, held are known");
        wanted |= 1u << state;
    }
    cJSON *jobs = cJSON_CreateArray();
    for (size_t k = scheduler_count(daemon->scheduler), taken = 0; k-- > 0 && taken < (size_t)limit;) {
        const struct job *job = scheduler_at(daemon->scheduler, k);
        if (wanted && !(wanted >> job->state & 1))
            continue;
        cJSON_AddItemToArray(jobs, requests_summary(job));
        taken++;
    }
    *result = cJSON_CreateObject();
    json_put(*result, "jobs", jobs);
    json_put(*result, "studies", study_list(daemon, wanted, (size_t)limit));
    return SCREE_OK;
}

static cJSON *show_streams(struct daemon *daemon, const struct job *job)
{
    char path[CONFIG_PATH_MAX + 64];
    struct chunk_stream known[JOB_STREAMS_MAX];
    struct chunk_log *log = NULL;
    cJSON *streams = cJSON_CreateObject();
    scheduler_log_path(daemon->scheduler, job, path, sizeof path);
    if (chunk_log_open(&log, path, false, NULL) != SCREE_OK)
        return streams;
    size_t count = chunk_log_streams(log, known, JOB_STREAMS_MAX);
    for (size_t k = 0; k < count; k++) {
        cJSON *s = cJSON_CreateObject();
        json_put_int(s, "chunks", (long long)known[k].chunks);
        json_put_int(s, "samples", (long long)known[k].samples);
        json_put(s, "columns", cJSON_CreateRaw(known[k].columns));
        json_put(s, "units", cJSON_CreateRaw(known[k].units));
        json_put_bool(s, "frames", known[k].frames);
        json_put(streams, known[k].name, s);
    }
    chunk_log_close(log);
    return streams;
}

/* What was done to the job, where it came from, and the hash of its last state. */
static void show_steering(struct daemon *daemon, const struct job *job, cJSON *json)
{
    char hash[OUTCOME_HASH_MAX];
    cJSON *origin = NULL, *from;
    json_put(json, "steering", scheduler_steering(daemon->scheduler, job));
    json_put_text(json, "hash", job->report.hashed ? outcome_hash(&job->report, hash) : NULL);
    if (*job->origin && json_read(job->origin, strlen(job->origin), "origin", &origin, NULL) == SCREE_OK) {
        cJSON_DeleteItemFromObjectCaseSensitive(cJSON_GetObjectItemCaseSensitive(origin, "fork"), "spec");
        from = cJSON_GetObjectItemCaseSensitive(origin, "replay");
        const struct job *first = from ? scheduler_find(daemon->scheduler, json_text(from, "job")) : NULL;
        if (first && job->report.hashed) {
            json_put_text(from, "hash", outcome_hash(&first->report, hash));
            json_put_bool(from, "same", first->report.hash == job->report.hash && first->report.steps == job->report.steps);
        }
    }
    json_put(json, "origin", origin ? origin : cJSON_CreateNull());
}

static enum scree_status do_show(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    struct job *job;
    char path[CONFIG_PATH_MAX + 64], paper[OUTCOME_PAPER_MAX];
    enum scree_status status = find_job(daemon, body, &job, err);
    if (status)
        return status;
    const struct run_report *r = &job->report;
    cJSON *json = requests_summary(job), *numbers = cJSON_CreateArray();
    json_put(json, "spec", job->steered ? job_encode(&job->spec) : cJSON_CreateRaw(job->spec_text));
    show_steering(daemon, job, json);
    json_put(json, "streams", show_streams(daemon, job));
    json_put_text(json, "build", *job->build ? job->build : scree_build());
    json_put_text(json, "isa", r->isa);
    json_put_int(json, "threads", r->threads ? r->threads : job->spec.threads);
    json_put_real(json, "wall_s", r->wall_s);
    json_put_text(json, "evidence", r->evidence);
    outcome_fill(job->spec.paper, r->numbers, r->number_count, paper);
    json_put_text(json, "paper", paper);
    for (size_t k = 0; k < r->number_count; k++) {
        cJSON *n = cJSON_CreateObject();
        json_put_text(n, "name", r->numbers[k].name);
        json_put_real(n, "value", r->numbers[k].value);
        json_put_text(n, "unit", r->numbers[k].unit);
        json_put_text(n, "doc", r->numbers[k].doc);
        cJSON_AddItemToArray(numbers, n);
    }
    json_put(json, "numbers", numbers);
    json_put(json, "error", job->state == JOB_FAILED ? error_json(scree_status_word(r->status), &r->error) : cJSON_CreateNull());
    scheduler_result_path(daemon->scheduler, job, true, path, sizeof path);
    json_put_text(json, "result", job_state_ended(job->state) && access(path, R_OK) == 0 ? path : NULL);
    json_put_text(json, "why", job->why);
    *result = json;
    return SCREE_OK;
}

static enum scree_status do_cancel(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                   struct scree_error *err)
{
    struct job *job;
    enum scree_status status = find_job(daemon, body, &job, err);
    if (status || (status = scheduler_cancel_as(daemon->scheduler, id, job, err)))
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "job", job->id);
    json_put_text(*result, "state", job_state_word(job->state));
    return SCREE_OK;
}

static enum scree_status do_replay(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                   struct scree_error *err)
{
    struct job *job, *replay;
    enum scree_status status = find_job(daemon, body, &job, err);
    if (status || (status = limits_check_jobs(daemon->config, daemon->scheduler, &daemon->user, id, err)) ||
        (status = scheduler_replay(daemon->scheduler, id, job, &replay, err)))
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "job", replay->id);
    json_put_text(*result, "state", job_state_word(replay->state));
    json_put_text(*result, "of", job->id);
    return SCREE_OK;
}

enum scree_status requests_file_part(const char *id, const char *path, double offset, double bytes, cJSON **result,
                                     struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    int file = open(path, O_RDONLY | O_CLOEXEC);
    struct stat info;
    unsigned char *data = malloc((size_t)bytes);
    char *text = malloc(4 * ((size_t)bytes + 2) / 3 + 8);
    ssize_t size = file >= 0 && data && text && fstat(file, &info) == 0 ? pread(file, data, (size_t)bytes, (off_t)offset) : -1;
    if (size < 0) {
        status = scree_fail(err, SCREE_NOT_FOUND, "job", "%s has no file to read from: `fetch` comes first", id);
    } else {
        base64_encode(data, (size_t)size, text);
        *result = cJSON_CreateObject();
        json_put_int(*result, "offset", (long long)offset);
        json_put_int(*result, "bytes", size);
        json_put_int(*result, "total", (long long)info.st_size);
        json_put_text(*result, "data", text);
    }
    if (file >= 0)
        close(file);
    free(data);
    free(text);
    return status;
}

static enum scree_status do_fetch_part(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                       struct scree_error *err)
{
    (void)id;
    struct job *job;
    char path[CONFIG_PATH_MAX + 64];
    double offset, bytes;
    enum scree_status status = find_job(daemon, body, &job, err);
    if (status || (status = whole_number(body, "offset", 0, 0, 9e15, &offset, err)) ||
        (status = whole_number(body, "bytes", PART_MAX, 1, PART_MAX, &bytes, err)))
        return status;
    scheduler_result_path(daemon->scheduler, job, job_state_ended(job->state), path, sizeof path);
    return requests_file_part(job->id, path, offset, bytes, result, err);
}

static enum scree_status do_shutdown(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                     struct scree_error *err)
{
    (void)body, (void)id, (void)err;
    daemon->ending = true;
    *result = cJSON_CreateObject();
    return SCREE_OK;
}

static const struct operation {
    const char *name;
    enum scree_status (*carry_out)(struct daemon *, const cJSON *, const char *, cJSON **, struct scree_error *);
} operations[] = {
    {"ping", do_ping},     {"check", do_check},           {"submit", do_submit},     {"list", do_list},     {"show", do_show},
    {"cancel", do_cancel}, {"fetch_part", do_fetch_part}, {"shutdown", do_shutdown}, {"replay", do_replay}, {"mesh", do_mesh},
};

cJSON *requests_fetched(const struct job *job, const char *path)
{
    struct stat info;
    cJSON *json = cJSON_CreateObject();
    json_put_text(json, "job", job->id);
    json_put_text(json, "path", path);
    json_put_int(json, "bytes", stat(path, &info) == 0 ? (long long)info.st_size : 0);
    json_put_bool(json, "complete", job_state_ended(job->state));
    return json;
}

/* `fetch` may have to wait for the recorder; its answer always comes through the ticket. */
static enum scree_status start_fetch(struct daemon *daemon, const cJSON *body, struct scree_error *err)
{
    struct job *job;
    enum scree_status status = find_job(daemon, body, &job, err);
    return status ? status : scheduler_fetch(daemon->scheduler, job, daemon->tickets, err);
}

/* The assignments of a set or a fork, as the journal keeps them. */
static enum scree_status read_assignments(const cJSON *body, enum command_op op, char **out, struct scree_error *err)
{
    const cJSON *set = json_get(body, "set"), *item;
    int count = cJSON_IsArray(set) ? cJSON_GetArraySize(set) : 0;
    if (op != COMMAND_SET && op != COMMAND_FORK)
        return SCREE_OK;
    if ((set && !cJSON_IsArray(set)) || (op == COMMAND_SET && count == 0) || count > ASSIGNMENTS_MAX)
        return scree_fail(err, SCREE_INVALID, "set", "set: an array of %d to %d texts \"path=value\" is expected",
                          op == COMMAND_SET, ASSIGNMENTS_MAX);
    cJSON_ArrayForEach(item, set) if (!cJSON_IsString(item) || !strchr(item->valuestring, '='))
    {
        return scree_fail(err, SCREE_INVALID, "set", "set: an array of texts \"path=value\" is expected");
    }
    unsigned long before = json_lacked();
    cJSON *detail = cJSON_CreateObject();
    json_put(detail, "set", set ? cJSON_Duplicate(set, true) : cJSON_CreateArray());
    *out = json_print_whole(detail, before);
    return *out ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a command");
}

static enum scree_status start_steering(struct daemon *daemon, const struct envelope *envelope, const cJSON *body,
                                        struct scree_error *err)
{
    struct job *job;
    char *detail = NULL, request[LIMITS_REQUEST_MAX];
    enum command_op op = command_op_of(envelope->op);
    limits_request(&daemon->user, envelope->id, request);
    enum scree_status status = find_job(daemon, body, &job, err);
    if (!status && op == COMMAND_FORK)
        status = limits_check_jobs(daemon->config, daemon->scheduler, &daemon->user, request, err);
    if (!status && !(status = read_assignments(body, op, &detail, err)))
        status = scheduler_steer(daemon->scheduler, request, job, op, detail ? detail : "{}", daemon->tickets, err);
    free(detail);
    return status;
}

bool requests_may_wait(const char *op)
{
    enum command_op steering = command_op_of(op);
    return strcmp(op, "fetch") == 0 || (steering != COMMAND_OPS && steering != COMMAND_CANCEL);
}

cJSON *requests_steered(const struct job *job, const struct command *command)
{
    char child[JOB_ID_MAX];
    cJSON *json = cJSON_CreateObject();
    json_put_text(json, "job", job->id);
    json_put_text(json, "op", command_op_word(command->op));
    json_put_text(json, "state", job_state_word(job->state));
    if (command->number)
        json_put_int(json, "number", command->number);
    else
        json_put(json, "number", cJSON_CreateNull()); // there was nothing to do
    if (command->step >= 0)
        json_put_int(json, "step", command->step);
    else
        json_put(json, "step", cJSON_CreateNull());
    snprintf(child, sizeof child, "j%lld", (long long)command->made);
    if (command->op == COMMAND_FORK)
        json_put_text(json, "fork", command->made ? child : NULL);
    return json;
}

enum answer requests_handle(struct daemon *daemon, const struct envelope *envelope, const cJSON *body, cJSON **reply)
{
    struct scree_error error = {0};
    cJSON *result = NULL;
    enum scree_status status = SCREE_NOT_FOUND;
    size_t k = 0, count = sizeof operations / sizeof *operations;
    if (study_request_is(envelope->op, body))
        return study_request(daemon, envelope, body, reply);

    if (requests_may_wait(envelope->op)) {
        daemon->tickets++;
        bool fetch = strcmp(envelope->op, "fetch") == 0;
        if (!(status = fetch ? start_fetch(daemon, body, &error) : start_steering(daemon, envelope, body, &error)))
            return ANSWER_LATER;
        *reply = reply_error(envelope->id, scree_status_word(status), &error);
        return ANSWER_NOW;
    }
    while (k < count && strcmp(operations[k].name, envelope->op) != 0)
        k++;
    if (k == count) {
        scree_fail(&error, SCREE_INVALID, "op", "unknown operation \"%s\"", envelope->op);
        *reply = reply_error(envelope->id, "bad_request", &error);
        return ANSWER_NOW;
    }
    char request[LIMITS_REQUEST_MAX];
    limits_request(&daemon->user, envelope->id, request);
    status = operations[k].carry_out(daemon, body, request, &result, &error);
    *reply = status ? reply_error(envelope->id, scree_status_word(status), &error) : reply_ok(envelope->id, result);
    return ANSWER_NOW;
}
