/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the scheduler's own files (scheduler*.c, steering*.c, holds.c, restart.c) share. Nobody else includes it. */
#ifndef SCREE_SERVER_SCHEDULER_STATE_H
#define SCREE_SERVER_SCHEDULER_STATE_H

#include "recorder.h"
#include "scheduler.h"
#include "worker.h"

struct scheduler {
    const struct config *config;
    struct scheduler_watch watch;
    struct journal *journal;
    struct workers *workers;
    struct recorder *recorder;
    int lock_fd;
    struct job **jobs;                // by number, ascending
    size_t count, room, queued, busy; // busy: threads of running jobs
    struct command **commands;        // by number, ascending
    size_t command_count, command_room;
    uint64_t serials;            // of runs
    double looked_s;             // when disk and memory were looked at last, monotonic
    char disk_low[JOB_NOTE_MAX]; // why no job may run, "" if they may
    bool closing;
};

/* ---- scheduler.c ---- */

double scheduler_monotonic(void);
struct job *scheduler_by_number(const struct scheduler *s, int64_t number);
void scheduler_changed(struct scheduler *s, const struct job *job, enum job_event what);
/* The job's state in memory; tells the watch. */
void scheduler_set_state(struct scheduler *s, struct job *job, enum job_state state);
/* The same, written to the journal first; a failure is logged and, for an end, tried again later. */
void scheduler_enter(struct scheduler *s, struct job *job, enum job_state state);
enum scree_status scheduler_write_job(struct scheduler *s, const struct job *job, enum job_state state, struct scree_error *err);
/* A new job, committed (within a transaction: once that is): its number is in *out. */
enum scree_status scheduler_insert(struct scheduler *s, const char *request, const struct job_spec *spec, const char *origin,
                                   struct job **out, struct scree_error *err);
/* Takes back what scheduler_insert kept, when its transaction failed. */
void scheduler_forget(struct scheduler *s, struct job *job);
void scheduler_start(struct scheduler *s, struct job *job);
/* An order to the job's worker, unless it has a stronger one. */
void scheduler_order(struct job *job, enum run_order order);
/* Asks for the job's result once more. */
void scheduler_record_again(struct scheduler *s, struct job *job);

void scheduler_look_at_recorder(struct scheduler *s);
void scheduler_name_job(struct job *job, int64_t number);
void scheduler_free_job(struct job *job);
/* Makes a folder with its parents. */
enum scree_status scheduler_folder(const char *path, struct scree_error *err);

/* ---- steering_specs.c ---- */

/* *to is *from with the assignments of a command's `detail`. */
enum scree_status steering_change(const struct job_spec *from, const char *detail, struct job_spec *to, struct scree_error *err);
/* The job's spec with every `set` up to and with number `last` that has taken effect; with `pending` those that wait, too. */
enum scree_status steering_compose(const struct scheduler *s, const struct job *job, int64_t last, bool pending,
                                   struct job_spec *out, struct scree_error *err);

/* ---- steering.c ---- */

enum scree_status steering_load(struct scheduler *s, struct scree_error *err);
/* A worker waits for a command's step to be written down. */
void steering_answer(struct scheduler *s, struct job *job);
/* The job was stopped at report.steps because somebody paused it: true, and it is paused. */
bool steering_paused(struct scheduler *s, struct job *job);
/* The job has ended: what waits for it came too late. */
void steering_ended(struct scheduler *s, struct job *job);
/* A checkpoint or a fork's file has been written, or not. */
void steering_recorded(struct scheduler *s, const struct record_order *order);
/* A new command, committed (within a transaction: once that is), and how it is taken back when that failed. */
enum scree_status steering_insert(struct scheduler *s, const char *request, struct job *job, enum command_op op, const char *detail,
                                  int64_t step, struct command **out, struct scree_error *err);
void steering_forget(struct scheduler *s, struct command *command);
/* Sets job->spec and job->steered by what has taken effect. */
void steering_refresh(struct scheduler *s, struct job *job);
/* Commands for a run: those with a step, then those that wait. */
enum scree_status steering_script(struct scheduler *s, const struct job *job, struct run *run, struct scree_error *err);

/* ---- restart.c ---- */

/* Fills starts and origin of a run from what lies in the job's folder. */
enum scree_status restart_find(const struct scheduler *s, const struct job *job, struct run *run, struct scree_error *err);
/* The newest checkpoint of a job: false if there is none. */
bool restart_newest(const struct scheduler *s, const struct job *job, struct run_start *out);

/* Removes the checkpoints of a job that has ended: it goes on from nothing. */
void restart_forget(const struct scheduler *s, const struct job *job);

/* A second name for a checkpoint, on disk when it returns. */
enum scree_status restart_link(const char *from, const char *to, struct scree_error *err);

/* ---- holds.c ---- */

/* Looks at disk and memory about once a second, holds and releases. */
void holds_turn(struct scheduler *s);
/* The job cannot run now: it is held, and true is returned. */
bool holds_stop(struct scheduler *s, struct job *job);
/* A run or a result failed for lack of disk or memory: true if it is to be tried again. */
bool holds_fault(struct scheduler *s, struct job *job, const struct scree_error *error);

#endif
