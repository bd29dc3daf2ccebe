/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every job of a data directory and the only code that changes a job's state.
 * Runs on the control thread. */
#ifndef SCREE_SERVER_SCHEDULER_H
#define SCREE_SERVER_SCHEDULER_H

#include "job.h"
#include "protocol/json.h"

struct scheduler;
struct record_order;

/* Told of every change: `job` has a new state, progress or chunks (`what`). */
enum job_event { EVENT_STATE, EVENT_PROGRESS, EVENT_CHUNKS };
struct scheduler_watch {
    void (*changed)(void *context, const struct job *job, enum job_event what);
    /* A result up to now, asked for by scheduler_fetch, is there, or is not: `error` then says why. */
    void (*fetched)(void *context, uint64_t ticket, const struct job *job, const char *path, const struct scree_error *error);
    /* An order of scheduler_record has been carried out. */
    void (*recorded)(void *context, const struct record_order *order);
    /* A command of scheduler_steer has taken effect, waits for its job (step COMMAND_PENDING), or will not be (`error`). */
    void (*steered)(void *context, uint64_t ticket, const struct job *job, const struct command *command,
                    const struct scree_error *error);
    void *context;
};

/* Opens the journal in config->data (made if need be, locked against a second
 * daemon) and starts workers and recorder. */
enum scree_status scheduler_open(struct scheduler **out, const struct config *config, int wake_fd,
                                 const struct scheduler_watch *watch, struct scree_error *err);
/* Stops workers at the end of their slices, with a checkpoint each; running jobs
 * stay `running` in the journal and go on at the next start. */
void scheduler_close(struct scheduler *scheduler);

/* Looks at what workers and recorder have reported and hands out work. */
void scheduler_turn(struct scheduler *scheduler);

/* Whether nothing can be recorded until the process starts anew. */
bool scheduler_is_lost(const struct scheduler *scheduler);

/* Commits a job. *reused: a finished one of the same spec and build, or one of the same request, answers. */
enum scree_status scheduler_submit(struct scheduler *scheduler, const char *request, const struct job_spec *spec, bool again,
                                   struct job **out, bool *reused, struct scree_error *err);
/* Ends a job for good; the second under a client's request id. */
enum scree_status scheduler_cancel(struct scheduler *scheduler, struct job *job, struct scree_error *err);
enum scree_status scheduler_cancel_as(struct scheduler *scheduler, const char *request, struct job *job, struct scree_error *err);

/* Steers a job. `detail` is {"set": ["path=value", ...]} of COMMAND_SET and COMMAND_FORK. With SCREE_OK
 * `steered` is called with the ticket, perhaps at once; a request that was made before is the same command. */
enum scree_status scheduler_steer(struct scheduler *scheduler, const char *request, struct job *job, enum command_op op,
                                  const char *detail, uint64_t ticket, struct scree_error *err);
/* Whether a command was made under that request. */
bool scheduler_knows(const struct scheduler *scheduler, const char *request);
/* A new job that does the same again from the start: spec, origin, and commands at their steps. */
enum scree_status scheduler_replay(struct scheduler *scheduler, const char *request, struct job *job, struct job **out,
                                   struct scree_error *err);
/* Every command of a job, oldest first. */
cJSON *scheduler_steering(const struct scheduler *scheduler, const struct job *job);
/* A result file of the job as it stands; `fetched` is called with the ticket, perhaps at once. */
enum scree_status scheduler_fetch(struct scheduler *scheduler, struct job *job, uint64_t ticket, struct scree_error *err);

/* Time of day, Unix seconds. */
double scheduler_unix_now(void);

/* Has the recorder write a file that is no job's result (an order with `write`); takes the order over.
 * `recorded` is told when it is there. */
void scheduler_record(struct scheduler *scheduler, struct record_order *order);

/* For tables of others in the same database. */
struct journal *scheduler_journal(struct scheduler *scheduler);

/* By id ("j17"), NULL if there is none. */
struct job *scheduler_find(struct scheduler *scheduler, const char *id);
size_t scheduler_count(const struct scheduler *scheduler);
struct job *scheduler_at(struct scheduler *scheduler, size_t index); // in order of submission
void scheduler_states(const struct scheduler *scheduler, size_t counts[JOB_STATES]);

/* Paths of a job's files. */
void scheduler_log_path(const struct scheduler *scheduler, const struct job *job, char *out, size_t size);
void scheduler_result_path(const struct scheduler *scheduler, const struct job *job, bool final, char *out, size_t size);

#endif
