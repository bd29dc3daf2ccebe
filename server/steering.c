/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Steering: commands that change a job while it lives.
 *
 * A command is in the journal before anything else happens, under the client's
 * request id, so that one that is sent again is the same one. It waits
 * (COMMAND_PENDING) until the job's worker stands between two steps and asks; its
 * step is then written down before the world is touched. So after a crash it is
 * either still waiting, and takes effect once, or has its step, and takes effect
 * at exactly that step of the run that is made again. A command that finds its
 * job ended is void. What needs no worker takes effect at once. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/failpoint.h"
#include "base/memory.h"
#include "log.h"
#include "protocol/job_json.h"
#include "scheduler_state.h"

enum { PENDING_MAX = 64 }; // commands that wait for one job

static const char *const op_words[COMMAND_OPS] = {"pause", "resume", "cancel", "checkpoint", "set", "fork"};

const char *command_op_word(enum command_op op)
{
    return op_words[op];
}

enum command_op command_op_of(const char *word)
{
    enum command_op op = 0;
    while (op < COMMAND_OPS && strcmp(op_words[op], word) != 0)
        op++;
    return op;
}

/* ---- the list ---- */

static struct command *by_request(const struct scheduler *s, const char *request)
{
    for (size_t k = s->command_count; k-- > 0;)
        if (strcmp(s->commands[k]->request, request) == 0)
            return s->commands[k];
    return NULL;
}

bool scheduler_knows(const struct scheduler *s, const char *request)
{
    return by_request(s, request) != NULL;
}

static struct command *by_number(const struct scheduler *s, int64_t number)
{
    for (size_t k = s->command_count; k-- > 0 && s->commands[k]->number >= number;)
        if (s->commands[k]->number == number)
            return s->commands[k];
    return NULL;
}

static void free_command(struct command *c)
{
    if (c)
        free(c->detail);
    free(c);
}

/* A command as its row says, with a place in the list made for it: keep cannot fail then. */
static enum scree_status make_command(struct scheduler *s, const struct journal_command *row, struct job *job, struct command **out,
                                      struct scree_error *err)
{
    struct command *c = calloc(1, sizeof *c);
    if (!c || !(c->detail = strdup(row->detail)) ||
        memory_grow((void **)&s->commands, &s->command_room, s->command_count + 1, sizeof *s->commands, err)) {
        free_command(c);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a command");
    }
    c->number = row->number;
    c->job = job;
    snprintf(c->request, sizeof c->request, "%s", row->request);
    c->op = command_op_of(row->op);
    c->step = row->step;
    c->made = row->made;
    c->at = row->at;
    *out = c;
    return SCREE_OK;
}

static void keep(struct scheduler *s, struct command *c)
{
    s->commands[s->command_count++] = c;
}

static struct journal_command row_of(const struct command *c)
{
    return (struct journal_command){.number = c->number, .step = c->step, .made = c->made};
}

/* A new command, committed (within a transaction: once that is). */
enum scree_status steering_insert(struct scheduler *s, const char *request, struct job *job, enum command_op op, const char *detail,
                                  int64_t step, struct command **out, struct scree_error *err)
{
    struct journal_command row = {
        .request = request, .job = job->number, .op = op_words[op], .detail = detail, .step = step, .at = scheduler_unix_now()};
    struct command *c;
    enum scree_status status = make_command(s, &row, job, &c, err);
    if (status)
        return status;
    if ((status = journal_command_insert(journal_commands(s->journal), &row, err))) {
        free_command(c);
        return status;
    }
    c->number = row.number;
    keep(s, c);
    *out = c;
    return SCREE_OK;
}

/* Takes back the newest command, whose transaction failed. */
void steering_forget(struct scheduler *s, struct command *c)
{
    if (!c || s->command_count == 0 || s->commands[s->command_count - 1] != c)
        return;
    s->command_count--;
    free_command(c);
}

static enum scree_status give_step(struct scheduler *s, struct command *c, int64_t step, int64_t made, struct scree_error *err)
{
    struct journal_command row = row_of(c);
    row.step = step;
    row.made = made;
    enum scree_status status = journal_command_update(journal_commands(s->journal), &row, err);
    if (!status) {
        c->step = step;
        c->made = made;
    }
    return status;
}

static void answer(struct scheduler *s, struct command *c, const struct scree_error *error)
{
    uint64_t ticket = c->ticket;
    c->ticket = 0;
    if (ticket && !s->closing)
        s->watch.steered(s->watch.context, ticket, c->job, c, error);
}

/* ---- what a run is told ---- */

/* A place for one more command, so that push cannot fail. */
static enum scree_status make_room(struct run *run, struct scree_error *err)
{
    pthread_mutex_lock(&run->lock);
    enum scree_status status =
        memory_grow((void **)&run->commands, &run->command_room, run->command_count + 1, sizeof *run->commands, err);
    pthread_mutex_unlock(&run->lock);
    return status;
}

static void push(struct run *run, const struct run_command *command)
{
    pthread_mutex_lock(&run->lock);
    run->commands[run->command_count++] = *command;
    pthread_mutex_unlock(&run->lock);
}

enum scree_status steering_script(struct scheduler *s, const struct job *job, struct run *run, struct scree_error *err)
{
    struct job_spec now = job->base;
    enum scree_status status = SCREE_OK;
    for (int pass = 0; pass < 2; pass++) // those with a step first
        for (size_t k = 0; k < s->command_count && !status; k++) {
            const struct command *c = s->commands[k];
            struct run_command command = {.number = c->number, .op = c->op, .step = NEXT_BOUNDARY, .to = now};
            bool waits = c->step == COMMAND_PENDING && c->op >= COMMAND_CHECKPOINT;
            if (c->job != job || (pass == 0 ? c->step < 0 || c->op != COMMAND_SET : !waits))
                continue;
            if (pass == 0)
                command.step = (uint64_t)c->step;
            if (c->op == COMMAND_SET && (status = steering_change(&now, c->detail, &command.to, err)))
                break;
            bool matters = pass == 1 || !job_same(&now, &command.to); // priorities are no business of the world
            if (matters && !(status = make_room(run, err)))
                push(run, &command);
            now = command.to;
        }
    return status;
}

/* What has taken effect, as the job now stands. */
void steering_refresh(struct scheduler *s, struct job *job)
{
    struct scree_error error = {0};
    if (steering_compose(s, job, INT64_MAX, false, &job->spec, &error)) {
        job->spec = job->base;
        log_line(LOG_ERROR, "job=%s %s", job->id, error.message);
    }
    job->altered |= !job_same(&job->base, &job->spec); // stays, should a later one set the value back
    for (size_t k = 0; k < s->command_count && !job->steered; k++)
        job->steered = s->commands[k]->job == job && s->commands[k]->op == COMMAND_SET && s->commands[k]->step >= 0;
}

/* ---- forks ---- */

/* Makes the child in one transaction with the command's step. `file` below jobs/. */
static enum scree_status make_child(struct scheduler *s, struct command *c, const struct job_spec *from, uint64_t step,
                                    const char *file, struct scree_error *err)
{
    struct job_spec to;
    struct job *child = NULL;
    char request[JOB_REQUEST_MAX + 8];
    unsigned long before = json_lacked();
    cJSON *origin = cJSON_CreateObject(), *fork = cJSON_AddObjectToObject(origin, "fork");
    json_put_text(fork, "job", c->job->id);
    json_put_int(fork, "step", (long long)step);
    json_put_text(fork, "file", file);
    json_put(fork, "spec", job_encode(from));
    char *text = json_print_whole(origin, before);
    snprintf(request, sizeof request, "%s:fork", c->request); // no client can send that, and it starts with the user
    enum scree_status status = text ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a fork");
    if (!status && !(status = steering_change(from, c->detail, &to, err)) && !(status = job_check(&to, 0, err)) &&
        !(status = job_steer_check(from, &to, err)) && !(status = journal_begin(s->journal, err))) {
        if (!(status = scheduler_insert(s, request, &to, text, &child, err)))
            status = give_step(s, c, (int64_t)step, child->number, err);
        if ((status = journal_end(s->journal, status, err))) {
            c->step = COMMAND_PENDING;
            c->made = 0;
            if (child)
                scheduler_forget(s, child);
        } else {
            scheduler_changed(s, child, EVENT_STATE);
        }
    }
    free(text);
    return status;
}

/* The job's world is not in memory: its newest checkpoint is taken. */
static enum scree_status fork_from_checkpoint(struct scheduler *s, struct command *c, struct scree_error *err)
{
    struct run_start start;
    char file[96], path[CONFIG_PATH_MAX + 128];
    if (!restart_newest(s, c->job, &start))
        return scree_fail(err, SCREE_CONFLICT, "job", "%s has not begun: there is nothing to continue", c->job->id);
    snprintf(file, sizeof file, "%s/fork-%lld.h5", c->job->id, (long long)c->number);
    snprintf(path, sizeof path, "%s/jobs/%s", s->config->data, file);
    enum scree_status status = restart_link(start.path, path, err);
    return status ? status : make_child(s, c, &start.spec, start.step, file, err);
}

void steering_recorded(struct scheduler *s, const struct record_order *order)
{
    struct command *c = order->command ? by_number(s, order->command) : NULL;
    struct scree_error error = order->error;
    enum scree_status status = order->status;
    if (!status && order->kind == RECORD_CHECKPOINT)
        scheduler_by_number(s, order->job)->faults = 0;
    if (!c)
        return;
    if (c->op == COMMAND_FORK && c->step == COMMAND_PENDING) {
        struct job_spec from;
        char file[96];
        snprintf(file, sizeof file, "%s/fork-%lld.h5", c->job->id, (long long)c->number);
        FAILPOINT("fork-recorded");
        if (!status && !(status = steering_compose(s, c->job, c->number, false, &from, &error)))
            status = make_child(s, c, &from, order->step, file, &error);
    }
    if (status)
        give_step(s, c, COMMAND_VOID, 0, NULL);
    answer(s, c, status ? &error : NULL);
}

/* ---- worker and end ---- */

/* The command whose step a worker waits to be written down, NULL if there is none. From
 * here until settle the worker waits, whatever it is ordered: else the journal could
 * give a step to a command that the world never saw. */
static struct command *take_question(struct scheduler *s, struct run *run, uint64_t *step)
{
    pthread_mutex_lock(&run->lock);
    struct command *c = run->ask == ASK_WAITING ? by_number(s, run->ask_number) : NULL;
    if (c) {
        run->ask = ASK_TAKEN;
        *step = run->ask_step;
    }
    pthread_mutex_unlock(&run->lock);
    return c;
}

static void settle(struct run *run, enum run_ask ask)
{
    pthread_mutex_lock(&run->lock);
    run->ask = ask;
    pthread_cond_broadcast(&run->answered);
    pthread_mutex_unlock(&run->lock);
}

void steering_answer(struct scheduler *s, struct job *job)
{
    struct scree_error error = {0};
    uint64_t step;
    struct command *c = take_question(s, job->run, &step);
    if (!c)
        return;
    /* A fork gets its step with its child. Should the journal not take it, the worker asks on, or is held. */
    if (c->op != COMMAND_FORK && give_step(s, c, (int64_t)step, 0, &error)) {
        log_line(LOG_ERROR, "job=%s command=%lld %s", job->id, (long long)c->number, error.message);
        settle(job->run, ASK_WAITING);
        return;
    }
    if (c->op == COMMAND_SET)
        steering_refresh(s, job);
    log_line(LOG_INFO, "job=%s command=%lld op=%s step=%llu", job->id, (long long)c->number, op_words[c->op],
             (unsigned long long)step);
    settle(job->run, ASK_GRANTED);
    if (c->op == COMMAND_SET)
        answer(s, c, NULL);
}

/* Whoever waits for a command of a job that is not running any more is told that it waits. */
static void answer_all(struct scheduler *s, const struct job *job)
{
    for (size_t k = 0; k < s->command_count; k++)
        if (s->commands[k]->job == job && s->commands[k]->ticket)
            answer(s, s->commands[k], NULL);
}

/* Pauses that wait have taken effect where the job now stands: into the open transaction, and, once that is written, here.
 * Returns how many. */
static size_t take_pauses(struct scheduler *s, const struct job *job, bool written, enum scree_status *status,
                          struct scree_error *err)
{
    size_t count = 0;
    for (size_t k = 0; k < s->command_count; k++) {
        struct command *c = s->commands[k];
        if (c->job != job || c->op != COMMAND_PAUSE || c->step != COMMAND_PENDING)
            continue;
        count++;
        struct journal_command row = row_of(c);
        row.step = (int64_t)job->report.steps;
        if (written)
            c->step = row.step;
        else if (!*status)
            *status = journal_command_update(journal_commands(s->journal), &row, err);
    }
    return count;
}

bool steering_paused(struct scheduler *s, struct job *job)
{
    struct scree_error error = {0};
    enum scree_status status = journal_begin(s->journal, &error);
    bool paused = take_pauses(s, job, false, &status, &error) > 0;
    if (!status && paused)
        status = scheduler_write_job(s, job, JOB_PAUSED, &error);
    if ((status = journal_end(s->journal, status, &error)))
        log_line(LOG_ERROR, "job=%s state=paused %s", job->id, error.message); // the pauses wait on, at most until it is resumed
    else
        take_pauses(s, job, true, &status, &error);
    if (paused)
        scheduler_set_state(s, job, JOB_PAUSED);
    answer_all(s, job); // a job that is held instead may be so for hours: nobody waits for its next run
    return paused;
}

void steering_ended(struct scheduler *s, struct job *job)
{
    for (size_t k = 0; k < s->command_count; k++) {
        struct command *c = s->commands[k];
        struct scree_error error = {0};
        if (c->job != job || c->step != COMMAND_PENDING)
            continue;
        if (c->op == COMMAND_CANCEL && job->state == JOB_CANCELLED) {
            give_step(s, c, (int64_t)job->report.steps, 0, NULL);
            answer(s, c, NULL);
            continue;
        }
        give_step(s, c, COMMAND_VOID, 0, NULL);
        scree_fail(&error, SCREE_CONFLICT, "job", "%s ended before the command could take effect", job->id);
        answer(s, c, &error);
    }
}

/* ---- loading ---- */

static enum scree_status load(void *context, const struct journal_command *row, struct scree_error *err)
{
    struct scheduler *s = context;
    struct job *job = scheduler_by_number(s, row->job);
    struct command *c;
    if (!job || command_op_of(row->op) == COMMAND_OPS)
        return SCREE_OK;
    enum scree_status status = make_command(s, row, job, &c, err);
    if (!status)
        keep(s, c);
    return status;
}

enum scree_status steering_load(struct scheduler *s, struct scree_error *err)
{
    enum scree_status status = journal_command_load(journal_commands(s->journal), load, s, err);
    for (size_t k = 0; k < s->command_count && !status; k++) {
        struct command *c = s->commands[k];
        struct run_start start;
        if (c->op == COMMAND_SET) {
            struct job_spec then;
            if (c->step >= 0 && !c->job->altered && !steering_compose(s, c->job, c->number, false, &then, NULL))
                c->job->altered = !job_same(&c->job->base, &then);
            steering_refresh(s, c->job);
        }
        if (c->step != COMMAND_PENDING)
            continue;
        int64_t step = restart_newest(s, c->job, &start) ? (int64_t)start.step : 0;
        if (c->op == COMMAND_PAUSE && c->job->state == JOB_QUEUED) {
            c->job->report.steps = (uint64_t)step;
            steering_paused(s, c->job);
        } else if (c->op == COMMAND_CANCEL && c->job->state == JOB_CANCELLED) {
            status = give_step(s, c, step, 0, err);
        } else if (job_state_ended(c->job->state)) {
            status = give_step(s, c, COMMAND_VOID, 0, err);
        }
    }
    return status;
}

/* ---- requests ---- */

/* A command that takes effect at once, together with the job's new state. */
static enum scree_status at_once(struct scheduler *s, const char *request, struct job *job, enum command_op op, const char *detail,
                                 enum job_state state, uint64_t ticket, struct scree_error *err)
{
    struct command *c = NULL;
    enum scree_status status = journal_begin(s->journal, err);
    if (status)
        return status;
    if (!(status = steering_insert(s, request, job, op, detail, (int64_t)job->report.steps, &c, err)) && state != JOB_STATES)
        status = scheduler_write_job(s, job, state, err);
    if (op == COMMAND_RESUME)
        take_pauses(s, job, false, &status, err);
    if ((status = journal_end(s->journal, status, err))) {
        steering_forget(s, c);
        return status;
    }
    if (op == COMMAND_RESUME)
        take_pauses(s, job, true, &status, err);
    if (state != JOB_STATES)
        scheduler_set_state(s, job, state);
    if (op == COMMAND_SET)
        steering_refresh(s, job);
    c->ticket = ticket;
    answer(s, c, NULL);
    return SCREE_OK;
}

/* A command that waits for the job: delivered now if it runs, else when it does. */
static enum scree_status in_time(struct scheduler *s, const char *request, struct job *job, enum command_op op, const char *detail,
                                 const struct job_spec *to, uint64_t ticket, struct scree_error *err)
{
    struct command *c = NULL;
    size_t waiting = 0;
    for (size_t k = 0; k < s->command_count; k++)
        waiting += s->commands[k]->job == job && s->commands[k]->step == COMMAND_PENDING;
    if (waiting >= PENDING_MAX)
        return scree_fail(err, SCREE_BUSY, "job", "%zu commands wait for %s already; try again later", waiting, job->id);
    bool delivered = job->run && op != COMMAND_PAUSE;
    enum scree_status status = delivered ? make_room(job->run, err) : SCREE_OK;
    if (status || (status = steering_insert(s, request, job, op, detail, COMMAND_PENDING, &c, err)))
        return status;
    c->ticket = ticket;
    if (delivered)
        push(job->run, &(struct run_command){.number = c->number, .op = op, .step = NEXT_BOUNDARY, .to = *to});
    else if (job->run)
        scheduler_order(job, RUN_PAUSE);
    else
        answer(s, c, NULL);
    return SCREE_OK;
}

static void nothing_to_do(struct scheduler *s, struct job *job, enum command_op op, uint64_t ticket)
{
    struct command c = {.job = job, .op = op, .step = (int64_t)job->report.steps, .ticket = ticket};
    answer(s, &c, NULL);
}

enum scree_status scheduler_cancel(struct scheduler *s, struct job *job, struct scree_error *err)
{
    char request[48];
    snprintf(request, sizeof request, "cancel:%s", job->id);
    return job_state_ended(job->state) || by_request(s, request) ? SCREE_OK : scheduler_cancel_as(s, request, job, err);
}

enum scree_status scheduler_cancel_as(struct scheduler *s, const char *request, struct job *job, struct scree_error *err)
{
    struct command *c = NULL;
    if (job_state_ended(job->state) || by_request(s, request))
        return SCREE_OK;
    /* The journal first: should the daemon end before the worker does, the job must not run again. */
    enum scree_status status = journal_begin(s->journal, err);
    if (status)
        return status;
    if (!(status = steering_insert(s, request, job, COMMAND_CANCEL, "{}", COMMAND_PENDING, &c, err)))
        status = scheduler_write_job(s, job, JOB_CANCELLED, err);
    if ((status = journal_end(s->journal, status, err))) {
        steering_forget(s, c);
        return status;
    }
    if (job->run)
        scheduler_order(job, RUN_CANCEL);
    else
        scheduler_enter(s, job, JOB_CANCELLED);
    return SCREE_OK;
}

static enum scree_status steer_set(struct scheduler *s, const char *request, struct job *job, const char *detail, uint64_t ticket,
                                   struct scree_error *err)
{
    struct job_spec from, to, now;
    enum scree_status status;
    if ((status = steering_compose(s, job, INT64_MAX, true, &from, err)) || (status = steering_change(&from, detail, &to, err)) ||
        (status = job_check(&to, 0, err)) || (status = job_steer_check(&from, &to, err)) ||
        (status = steering_change(&job->spec, detail, &now, err)))
        return status;
    /* A priority is no business of the world. What is no change to commands that wait may still be one to the world as it is. */
    if (job_same(&from, &to) && job_same(&job->spec, &now))
        return at_once(s, request, job, COMMAND_SET, detail, JOB_STATES, ticket, err);
    return in_time(s, request, job, COMMAND_SET, detail, &to, ticket, err);
}

/* Of a job that does not run: the child is made now. */
static enum scree_status fork_idle(struct scheduler *s, struct command *c, uint64_t ticket, struct scree_error *err)
{
    enum scree_status status = fork_from_checkpoint(s, c, err);
    if (status) {
        give_step(s, c, COMMAND_VOID, 0, NULL);
        return status;
    }
    c->ticket = ticket;
    answer(s, c, NULL);
    return SCREE_OK;
}

static enum scree_status steer_fork(struct scheduler *s, const char *request, struct job *job, const char *detail, uint64_t ticket,
                                    struct scree_error *err)
{
    struct job_spec from, to;
    struct run_start start;
    struct command *c = NULL;
    enum scree_status status;
    if ((status = steering_compose(s, job, INT64_MAX, true, &from, err)) || (status = steering_change(&from, detail, &to, err)) ||
        (status = job_check(&to, 0, err)) || (status = job_steer_check(&from, &to, err)))
        return status;
    if (job->run)
        return in_time(s, request, job, COMMAND_FORK, detail, &from, ticket, err);
    if (!restart_newest(s, job, &start))
        return scree_fail(err, SCREE_CONFLICT, "job", "%s has not begun: there is nothing to continue", job->id);
    if ((status = steering_insert(s, request, job, COMMAND_FORK, detail, COMMAND_PENDING, &c, err)))
        return status;
    return fork_idle(s, c, ticket, err);
}

static enum scree_status repeated(struct scheduler *s, struct command *c, uint64_t ticket, struct scree_error *err)
{
    if (c->step == COMMAND_VOID)
        return scree_fail(err, SCREE_CONFLICT, "job", "%s ended before the command could take effect", c->job->id);
    /* A crash may have come between a fork's row and its child. */
    if (c->op == COMMAND_FORK && c->step == COMMAND_PENDING && c->job->state == JOB_PAUSED)
        return fork_idle(s, c, ticket, err);
    c->ticket = ticket;
    if (c->step != COMMAND_PENDING || !c->job->run)
        answer(s, c, NULL);
    return SCREE_OK;
}

enum scree_status scheduler_steer(struct scheduler *s, const char *request, struct job *job, enum command_op op, const char *detail,
                                  uint64_t ticket, struct scree_error *err)
{
    struct command *c = by_request(s, request);
    if (c)
        return repeated(s, c, ticket, err);
    bool ending = job->recording || job->late || (job->run && job->report.ended && job->report.status != SCREE_BUSY);
    if (job_state_ended(job->state) || ending) {
        scree_fail(err, SCREE_CONFLICT, "job", "%s is %s: it cannot be steered any more", job->id,
                   job_state_ended(job->state) ? job_state_word(job->state) : "at its end");
        scree_hint(err, "`scree submit` runs a changed spec, `scree replay` the same again");
        return SCREE_CONFLICT;
    }
    switch (op) {
    case COMMAND_PAUSE:
        if (job->run)
            return in_time(s, request, job, op, "{}", NULL, ticket, err);
        if (job->state != JOB_PAUSED)
            return at_once(s, request, job, op, "{}", JOB_PAUSED, ticket, err);
        break;
    case COMMAND_RESUME:
        if (job->state == JOB_PAUSED)
            return at_once(s, request, job, op, "{}", JOB_QUEUED, ticket, err);
        break;
    case COMMAND_CHECKPOINT:
        if (job->run)
            return in_time(s, request, job, op, "{}", &job->spec, ticket, err);
        break; // a job that does not run was left with one
    case COMMAND_SET:
        return steer_set(s, request, job, detail, ticket, err);
    case COMMAND_FORK:
        return steer_fork(s, request, job, detail, ticket, err);
    case COMMAND_CANCEL:
    case COMMAND_OPS:
        return scree_fail(err, SCREE_INTERNAL, "", "no such command");
    }
    nothing_to_do(s, job, op, ticket);
    return SCREE_OK;
}
