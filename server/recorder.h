/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The one thread that calls HDF5: turns stream logs into result files and images
 * of worlds into checkpoints, in the order in which they were asked for. */
#ifndef SCREE_SERVER_RECORDER_H
#define SCREE_SERVER_RECORDER_H

#include "job.h"

struct recorder;

enum record_kind { RECORD_RESULT, RECORD_CHECKPOINT, RECORD_FORK };

struct record_order {
    enum record_kind kind;
    /* A checkpoint, or the file that a fork starts from: */
    struct scree_image *image; // owned
    uint64_t step, serial;     // of the world, of the run
    int64_t command;           // the one that asked for it, 0: the clock did
    int64_t job;               // number
    bool final;                // result.h5 of an ended job, else a result up to now
    uint64_t ticket;           // the asker's, given back
    struct job_spec spec;
    char id[JOB_ID_MAX], state[16], log_path[CONFIG_PATH_MAX + 64], path[CONFIG_PATH_MAX + 64];
    char *spec_text, *journal_text; // owned
    /* When set, this writes the file instead, out of `content` (owned, freed by `release`). */
    enum scree_status (*write)(const struct record_order *order, struct scree_error *err);
    void (*release)(void *content);
    void *content;
    struct run_report report;
    bool stands; // the world did: else there is nothing to record
    const struct scree_stream *streams[JOB_STREAMS_MAX];
    size_t stream_count;
    /* Filled by the recorder. */
    enum scree_status status;
    struct scree_error error;
    struct record_order *next;
};

enum scree_status recorder_start(struct recorder **out, int wake_fd, struct scree_error *err);

/* Takes the order over (malloc). It comes back through recorder_take. */
void recorder_ask(struct recorder *recorder, struct record_order *order);

/* An order that has been carried out, or NULL; the caller frees it with record_order_free. */
struct record_order *recorder_take(struct recorder *recorder);
void record_order_free(struct record_order *order);

/* Runs `errand` on the recorder's thread, behind what was asked for before, and waits for it. */
enum scree_status recorder_run(struct recorder *recorder, enum scree_status (*errand)(void *context, struct scree_error *err),
                               void *context, struct scree_error *err);

/* Whether libhdf5 has become unusable: nothing will be written until the process starts anew. */
bool recorder_is_lost(const struct recorder *recorder);

/* Carries out the orders that were asked for and ends the thread; they can still be taken. */
void recorder_finish(struct recorder *recorder);
void recorder_free(struct recorder *recorder);

#endif
