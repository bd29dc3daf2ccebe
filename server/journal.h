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
    const char *origin;               // JSON: what the job continues or replays; "" if it starts by itself
    double submitted, started, ended; // Unix seconds, 0: not yet
};

enum scree_status journal_open(struct journal **out, const char *path, struct scree_error *err);
void journal_close(struct journal *journal);

/* The open database, for the other files that keep tables in it (journal_studies.c). */
struct sqlite3 *journal_database(struct journal *journal);

/* Several changes as one: all of them are on disk when journal_end returns SCREE_OK,
 * none when it returns something else; a `status` that is not SCREE_OK takes them back. */
enum scree_status journal_begin(struct journal *journal, struct scree_error *err);
enum scree_status journal_end(struct journal *journal, enum scree_status status, struct scree_error *err);

/* Each returns once the change is on disk. Insert fills row->number. */
enum scree_status journal_insert(struct journal *journal, struct journal_row *row, struct scree_error *err);
enum scree_status journal_update(struct journal *journal, const struct journal_row *row, struct scree_error *err);

/* Every job in order of number; stops at the first failure of `each`. */
enum scree_status journal_load(struct journal *journal,
                               enum scree_status (*each)(void *, const struct journal_row *, struct scree_error *), void *context,
                               struct scree_error *err);

/* ---- steering commands: owned by the control thread ---- */

enum { COMMAND_PENDING = -1, COMMAND_VOID = -2 }; // steps of a command that waits for its job; that came too late for it

struct journal_command {
    int64_t number;      // commands of a job take effect in this order
    const char *request; // the client's id: a command that is sent again is the same one
    int64_t job;
    const char *op, *detail; // detail: JSON, {"set": ["path=value", ...]}
    int64_t step;            // at which it took effect
    int64_t made;            // number of the job that a fork made, 0: none
    double at;               // Unix seconds
};

struct journal_commands;
struct journal_commands *journal_commands(struct journal *journal);
enum scree_status journal_commands_open(struct journal_commands **out, struct sqlite3 *db, struct scree_error *err);
void journal_commands_close(struct journal_commands *commands);

/* Insert fills command->number; update writes step and made. */
enum scree_status journal_command_insert(struct journal_commands *commands, struct journal_command *command,
                                         struct scree_error *err);
enum scree_status journal_command_update(struct journal_commands *commands, const struct journal_command *command,
                                         struct scree_error *err);
/* Every command in order of number; stops at the first failure of `each`. */
enum scree_status journal_command_load(struct journal_commands *commands,
                                       enum scree_status (*each)(void *, const struct journal_command *, struct scree_error *),
                                       void *context, struct scree_error *err);

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
    int64_t crc;         // as it lies on disk: a sound one has 32 bits
    uint64_t hash;       // of the stream from its first chunk to the end of this one (chunk_hash)
};

/* To write: made if it does not exist. To read: SCREE_NOT_FOUND if it does not. */
enum scree_status chunk_log_open(struct chunk_log **out, const char *path, bool write, struct scree_error *err);
void chunk_log_close(struct chunk_log *log);

/* Says which streams there are, all in one commit; what is there already is left alone. */
enum scree_status chunk_log_declare(struct chunk_log *log, const struct scree_stream *const *streams, size_t count,
                                    struct scree_error *err);

/* Appends a chunk and commits. A chunk that is there already (a job that is run
 * again) must be the same, byte for byte: SCREE_CORRUPT otherwise. One that was
 * damaged on disk is replaced. With `ending` what is there may be longer: a job
 * that is stopped for good before it has come as far as it had once. */
enum scree_status chunk_log_put(struct chunk_log *log, const struct scree_chunk *chunk, bool ending, struct scree_error *err);

/* *found is false when there is no such chunk (yet). SCREE_CORRUPT when it is damaged. */
enum scree_status chunk_log_get(struct chunk_log *log, const char *stream, uint64_t seq, struct chunk_row *row, bool *found,
                                struct scree_error *err);

/* How far the streams have come: the latest time of a row, s; negative: there is none. */
double chunk_log_reached(struct chunk_log *log);

/* Writes at most `room` descriptions, returns how many there are. */
size_t chunk_log_streams(struct chunk_log *log, struct chunk_stream *out, size_t room);

#endif
