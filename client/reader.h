/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One subscription to one stream of one job, paid for with credit.
 *
 * The reader grants what it is ready to hold and, when the next is asked for, again
 * what it has handed on, so that a slow consumer slows the daemon's sending and nothing else. */
#ifndef SCREE_CLIENT_READER_H
#define SCREE_CLIENT_READER_H

#include <stddef.h>
#include <stdint.h>

#include "link.h"

struct reader;

struct reader_chunk {
    uint64_t seq;
    double t0_s, dt_s; // row k is at t0_s + k * dt_s
    size_t rows, columns;
    const double *values;              // rows * columns, until the next call
    const char *hash;                  // running hash as the daemon says it, NULL if it does not; until the next call
    const cJSON *column_names, *units; // arrays of strings, until the next call
};

/* Which column of a chunk has that name; -1: none. */
int reader_column(const struct reader_chunk *chunk, const char *name);

enum reader_event {
    READER_QUIET,   // nothing came in time
    READER_CHUNK,   // *chunk is the next one
    READER_END,     // the job has ended and every chunk was read
    READER_ERROR,   // the daemon refused; the subscription is gone
    READER_DAMAGED, // a gap, a wrong checksum or a wrong size: open it again
};

/* READER_ONE: chunks come one by one, each when it is asked for. READER_MANY: up to PROTOCOL_CREDIT_MAX bytes are on their way. */
enum reader_ahead { READER_ONE, READER_MANY };

enum outcome reader_open(struct link *link, const char *job, const char *stream, uint64_t from, enum reader_ahead ahead,
                         struct reader **out, struct scree_error *err);
void reader_close(struct reader *reader); // before its link is closed

/* Waits up to `milliseconds` for what comes next. */
enum reader_event reader_next(struct reader *reader, int milliseconds, struct reader_chunk *chunk, struct scree_error *err);

/* The number of the chunk that has not been read yet. */
uint64_t reader_position(const struct reader *reader);

#endif
