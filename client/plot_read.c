/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See plot_read.h. */
#include "plot_read.h"

#include <math.h>
#include <string.h>

#include "output.h"

enum { QUIET_SECONDS = 60 };

/* Chunks `from` to `to`. What the daemon will say after the last one of an ended job is waited for: a socket that is closed
 * while a message arrives loses memory (libzmq 4.3.4). */
static enum outcome read_chunks(struct link *link, const cJSON *record, const char *stream, uint64_t from, uint64_t to,
                                void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err)
{
    struct reader *reader = NULL;
    struct reader_chunk chunk;
    const char *job = json_text(record, "id");
    enum outcome outcome =
        from < to ? reader_open(link, job, stream, from, to - from == 1 ? READER_ONE : READER_MANY, &reader, err) : OUTCOME_DONE;
    if (cJSON_IsNumber(json_get(record, "ended")) && to == plot_chunks_of(record, stream))
        to = UINT64_MAX; // until the end is said
    double quiet = now_s();
    while (!outcome && reader && reader_position(reader) < to) {
        switch (reader_next(reader, 200, &chunk, err)) {
        case READER_CHUNK:
            take(context, &chunk);
            quiet = now_s();
            break;
        case READER_QUIET:
            if (now_s() - quiet > QUIET_SECONDS)
                outcome = outcome_fail(err, OUTCOME_UNREACHABLE, "the stream %s of %s has been silent for %d s", stream, job,
                                       QUIET_SECONDS);
            break;
        case READER_END:
            to = 0;
            break;
        case READER_ERROR:
            outcome = OUTCOME_FAILED;
            break;
        case READER_DAMAGED:
            outcome = outcome_fail(err, OUTCOME_FAILED, "the stream %s of %s did not arrive whole", stream, job);
            break;
        }
    }
    reader_close(reader);
    return outcome;
}

enum outcome plot_read_stream(struct link *link, const cJSON *record, const char *stream,
                              void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err)
{
    return read_chunks(link, record, stream, 0, plot_chunks_of(record, stream), take, context, err);
}

enum outcome plot_read_chunk(struct link *link, const cJSON *record, const char *stream, uint64_t at,
                             void (*take)(void *, const struct reader_chunk *), void *context, struct scree_error *err)
{
    return read_chunks(link, record, stream, at, at + 1, take, context, err);
}

uint64_t plot_chunks_of(const cJSON *record, const char *stream)
{
    double chunks = json_number(json_get(json_get(record, "streams"), stream), "chunks", 0);
    return chunks > 0 ? (uint64_t)chunks : 0;
}

double plot_number_of(const cJSON *record, const char *name)
{
    const cJSON *row;
    cJSON_ArrayForEach(row, json_get(record, "numbers"))
    {
        const char *here = json_text(row, "name");
        if (here && strcmp(here, name) == 0)
            return json_number(row, "value", NAN);
    }
    return NAN;
}
