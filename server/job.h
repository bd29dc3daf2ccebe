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

enum { JOB_ID_MAX = 24, JOB_STREAMS_MAX = 24, JOB_NOTE_MAX = 512, JOB_REQUEST_MAX = 112 };

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
    uint64_t hash; // of the world's state at the end (scree_world_hash)
    bool hashed;
    bool ended;               // the worker is through with it
    enum scree_status status; // how: SCREE_OK, SCREE_CANCELLED, or a failure
    struct scree_error error;
};

/* Orders to a worker; one further down takes the place of one further up. All but
 * RUN_CANCEL leave a checkpoint behind from which the job goes on. */
enum run_order { RUN_GO, RUN_HOLD, RUN_PAUSE, RUN_STOP, RUN_CANCEL };

/* ---- steering ---- */

enum command_op { COMMAND_PAUSE, COMMAND_RESUME, COMMAND_CANCEL, COMMAND_CHECKPOINT, COMMAND_SET, COMMAND_FORK, COMMAND_OPS };

/* One steering command, as the journal has it. */
struct command {
    int64_t number;
    struct job *job;
    char request[JOB_REQUEST_MAX];
    enum command_op op;
    char *detail;    // JSON, owned
    int64_t step;    // at which it took effect, or COMMAND_PENDING, COMMAND_VOID
    int64_t made;    // job that a fork made
    double at;       // Unix seconds
    uint64_t ticket; // of the client that waits for it, 0: none
};

const char *command_op_word(enum command_op op);
/* COMMAND_OPS if there is no such word. */
enum command_op command_op_of(const char *word);

#define NEXT_BOUNDARY UINT64_MAX

/* A command on its way to the worker. */
struct run_command {
    int64_t number;
    enum command_op op; // COMMAND_SET, COMMAND_CHECKPOINT or COMMAND_FORK
    uint64_t step;      // exactly there (it took effect in an earlier run), or NEXT_BOUNDARY: when control grants it
    struct job_spec to; // COMMAND_SET: the job from there on
};

/* A file that a run can go on from. */
struct run_start {
    char path[CONFIG_PATH_MAX + 96];
    uint64_t step;
    int64_t applied;      // number of the last command that is in it
    struct job_spec spec; // as it stood there
};
enum { RUN_STARTS_MAX = 4 };

/* What a worker asks before a command that waited takes effect: the journal has to know the step first.
 * While it is WAITING an order takes the question back; once control has TAKEN it, the answer decides. */
enum run_ask { ASK_NONE, ASK_WAITING, ASK_TAKEN, ASK_GRANTED };

struct recorder;

/* A job that is being run. Lives from assignment until its result is written. */
struct run {
    int64_t job; // number
    uint64_t serial;
    struct job_spec spec;                    // as at the start of its streams; commands change it on the way
    struct run_start starts[RUN_STARTS_MAX]; // checkpoints, newest first
    size_t start_count;
    struct run_start origin; // of a fork: where its parent stood; path "" if there is none
    char log_path[CONFIG_PATH_MAX + 64], folder[CONFIG_PATH_MAX + 64];
    char meshes[CONFIG_PATH_MAX + 64]; // folder
    struct recorder *recorder;
    double checkpoint_s;  // wall time between checkpoints, 0: none by the clock
    uint64_t stop_step;   // a replay of a job that was stopped ends here, UINT64_MAX: no such step
    double wall_before_s; // of earlier runs
    atomic_int order;     // enum run_order: written by control, read by the worker between slices
    atomic_bool dirty;    // the report has changed: set by the worker, cleared by control
    atomic_int images;    // on their way to the disk: counted up by the worker, down by control
    pthread_mutex_t lock;
    pthread_cond_t answered;
    /* Under `lock`. */
    struct run_command *commands; // in the order in which they take effect; owned
    size_t command_count, command_room;
    enum run_ask ask;
    int64_t ask_number;
    uint64_t ask_step;
    struct run_report report;
    bool stands; // the world does: there is something to record; under `lock`, as are its streams, for the recorder
    const struct scree_stream *streams[JOB_STREAMS_MAX];
    size_t stream_count;
};

/* Why a job is held. */
enum hold { HOLD_NONE, HOLD_DISK, HOLD_MEMORY, HOLD_FAULT };

struct job {
    int64_t number;
    char id[JOB_ID_MAX];
    char request[JOB_REQUEST_MAX]; // of its submit; NAME/ before it if a user from the network sent it
    enum job_state state;
    char *spec_text;                  // resolved, one line, as submitted; owned
    char *origin;                     // JSON: {"fork": {...}} and, or {"replay": {...}}; "" if it starts by itself; owned
    struct job_spec base;             // as submitted
    struct job_spec spec;             // as it stands now: with every `set` that has taken effect
    bool steered;                     // some has
    bool altered;                     // one of them changed the world: its result is not that of `base`
    double submitted, started, ended; // Unix seconds, 0: not yet
    struct run_report report;         // as last seen; the final one once ended
    char build[96];
    char why[JOB_NOTE_MAX]; // why it is held
    enum hold hold;
    int faults;                   // failures of disk or memory in a row
    double retry_at;              // monotonic s: when a fault is tried again
    bool recording;               // the run has ended and its result is being written
    enum job_state verdict_state; // what it will be once that is done
    bool late;                    // verdict_state could not be written to the journal yet
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
