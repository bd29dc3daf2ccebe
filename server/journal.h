/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What must survive: the journal of jobs, and each job's log of stream chunks.
 * The only files that know SQL are journal*.c and this header's promises. */
#ifndef SCREE_SERVER_JOURNAL_H
#define SCREE_SERVER_JOURNAL_H

#include <stdbool.h>
#include <stdint.h>

#include "scree.h"

/* ---- jobs: owned by the control thread ---- */

struct journal;

struct journal_row {
    int64_t number;
    const char *request; // the client's id of the submit
    const char *state, *spec, *build;
    const char *outcome;              // JSON: verdict, numbers, error; "" before there is one
    double submitted, started, ended; // Unix seconds, 0: not yet
};

enum scree_status journal_open(struct journal **out, const char *path, struct scree_error *err);
void journal_close(struct journal *journal);

/* The open database, for the other files that keep tables in it (journal_studies.c). */
struct sqlite3 *journal_database(struct journal *journal);

/* Each returns once the change is on disk. Insert fills row->number. */
enum scree_status journal_insert(struct journal *journal, struct journal_row *row, struct scree_error *err);
enum scree_status journal_update(struct journal *journal, const struct journal_row *row, struct scree_error *err);

/* Every job in order of number; stops at the first failure of `each`. */
enum scree_status journal_load(struct journal *journal,
                               enum scree_status (*each)(void *, const struct journal_row *, struct scree_error *), void *context,
                               struct scree_error *err);

/* ---- stream logs: one file a job; every thread opens its own handle ---- */

struct chunk_log;

enum { CHUNK_NAME_MAX = 32 };

struct chunk_stream { // one stream as the log describes it
    char name[CHUNK_NAME_MAX];
    char columns[512], units[512]; // JSON arrays
    bool frames;
    uint64_t chunks, samples;
};

struct chunk_row {
    uint64_t seq;
    double t0_s, dt_s;
    size_t rows, bytes;
    const void *payload; // valid until the next call on this handle
    uint32_t crc;
};

/* To write: made if it does not exist. To read: SCREE_NOT_FOUND if it does not. */
enum scree_status chunk_log_open(struct chunk_log **out, const char *path, bool write, struct scree_error *err);
void chunk_log_close(struct chunk_log *log);

/* Says which streams there are, all in one commit; what is there already is left alone. */
enum scree_status chunk_log_declare(struct chunk_log *log, const struct scree_stream *const *streams, size_t count,
                                    struct scree_error *err);

/* Appends a chunk and commits. A chunk that is there already must be the same, byte
 * for byte (a job that is run again): SCREE_CORRUPT otherwise. */
enum scree_status chunk_log_put(struct chunk_log *log, const struct scree_chunk *chunk, struct scree_error *err);

/* *found is false when there is no such chunk (yet). */
enum scree_status chunk_log_get(struct chunk_log *log, const char *stream, uint64_t seq, struct chunk_row *row, bool *found,
                                struct scree_error *err);

/* Writes at most `room` descriptions, returns how many there are. */
size_t chunk_log_streams(struct chunk_log *log, struct chunk_stream *out, size_t room);

#endif
