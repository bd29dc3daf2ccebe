/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A job as the daemon holds it, and what passes between the control thread and
 * the worker that runs it. */
#ifndef SCREE_SERVER_JOB_H
#define SCREE_SERVER_JOB_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "config.h"
#include "journal.h"
#include "scree.h"

enum job_state { JOB_QUEUED, JOB_RUNNING, JOB_PAUSED, JOB_DONE, JOB_FAILED, JOB_CANCELLED, JOB_HELD, JOB_STATES };

enum { JOB_ID_MAX = 24, JOB_STREAMS_MAX = 12, JOB_NOTE_MAX = 512, JOB_REQUEST_MAX = 112 };

/* What a run has come to; written by the worker under `lock`, read by control. */
struct run_report {
    uint64_t steps;
    double time_s, wall_s;
    double rate; // moving grain-steps per second of wall time, lately
    size_t moving, fixed;
    enum scree_verdict verdict;
    char evidence[JOB_NOTE_MAX];
    char isa[16];
    int threads;
    struct scree_number numbers[SCREE_SUMMARY_MAX];
    size_t number_count;
    struct {
        char name[CHUNK_NAME_MAX];
        uint64_t chunks, samples;
    } heads[JOB_STREAMS_MAX];
    size_t head_count;
    bool ended;               // the worker is through with it
    enum scree_status status; // how: SCREE_OK, SCREE_CANCELLED, or a failure
    struct scree_error error;
};

/* Orders to a worker; a later one may overtake an earlier one. */
enum run_order { RUN_GO, RUN_CANCEL, RUN_STOP };

/* A job that is being run. Lives from assignment until its result is written. */
struct run {
    struct job_spec spec;
    char log_path[CONFIG_PATH_MAX + 64];
    atomic_int order;  // enum run_order: written by control, read by the worker between slices
    atomic_bool dirty; // the report has changed: set by the worker, cleared by control
    pthread_mutex_t lock;
    struct run_report report;
    /* Streams of the world, for the recorder; under `lock`, none before the world stands. */
    const struct scree_stream *streams[JOB_STREAMS_MAX];
    size_t stream_count;
};

struct job {
    int64_t number;
    char id[JOB_ID_MAX];
    char request[JOB_REQUEST_MAX]; // of its submit; NAME/ before it if a user from the network sent it
    enum job_state state;
    char *spec_text; // resolved, one line; owned
    struct job_spec spec;
    double submitted, started, ended; // Unix seconds, 0: not yet
    struct run_report report;         // as last seen; the final one once ended
    char build[96];
    char why[JOB_NOTE_MAX];       // why it is held
    bool recording;               // the run has ended and its result is being written
    enum job_state verdict_state; // what it will be once that is done
    struct run *run;              // NULL unless running
};

const char *job_state_word(enum job_state state);
/* JOB_STATES if there is no such word. */
enum job_state job_state_of(const char *word);
static inline bool job_state_ended(enum job_state state)
{
    return state == JOB_DONE || state == JOB_FAILED || state == JOB_CANCELLED;
}

#endif
