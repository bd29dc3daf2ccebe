/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See reader.h. */
#include "reader.h"

#include <stdlib.h>
#include <string.h>

#include "protocol/frame.h"

#define KEY "r" // one subscription a connection needs no more of a name
enum { COLUMNS_MAX = 4096 };

struct reader {
    void *socket;
    uint64_t next;
    long long owed;              // bytes of the chunk handed out, to be granted again
    struct wire_message message; // holds the names of the chunk handed out
    double *values;              // a frame's bytes need not be aligned
    size_t room;
};

static bool send_header(struct reader *reader, const char *op, long long credit)
{
    cJSON *header = cJSON_CreateObject();
    if (!header)
        return false;
    json_put_text(header, "op", op);
    json_put_text(header, "key", KEY);
    if (credit)
        json_put_int(header, "bytes", credit);
    bool sent = wire_send(reader->socket, header, NULL);
    cJSON_Delete(header);
    return sent;
}

static bool send_open(struct reader *reader, const char *job, const char *stream, uint64_t from)
{
    cJSON *header = cJSON_CreateObject();
    if (!header)
        return false;
    json_put_text(header, "op", "open");
    json_put_text(header, "key", KEY);
    json_put_text(header, "job", job);
    json_put_text(header, "stream", stream);
    json_put_int(header, "from", (long long)from);
    bool sent = wire_send(reader->socket, header, NULL);
    cJSON_Delete(header);
    return sent;
}

enum outcome reader_open(struct link *link, const char *job, const char *stream, uint64_t from, enum reader_ahead ahead,
                         struct reader **out, struct scree_error *err)
{
    struct reader *reader = calloc(1, sizeof *reader);
    *out = NULL;
    if (!reader)
        return outcome_fail(err, OUTCOME_FAILED, "no memory to read a stream");
    const long long credit = ahead == READER_ONE ? 1 : PROTOCOL_CREDIT_MAX; // a chunk larger than any credit comes alone
    reader->next = from;
    enum outcome outcome = link_stream_socket(link, &reader->socket, err);
    if (!outcome && (!send_open(reader, job, stream, from) || !send_header(reader, "credit", credit)))
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot open the stream %s", stream);
    if (outcome) {
        reader_close(reader);
        return outcome;
    }
    *out = reader;
    return OUTCOME_DONE;
}

void reader_close(struct reader *reader)
{
    if (!reader)
        return;
    if (reader->socket) {
        send_header(reader, "close", 0);
        zmq_close(reader->socket);
    }
    wire_release(&reader->message);
    free(reader->values);
    free(reader);
}

uint64_t reader_position(const struct reader *reader)
{
    return reader->next;
}

/* A whole number of the header that is not negative, SIZE_MAX if it is none. */
static size_t whole(const cJSON *header, const char *key)
{
    double value = json_number(header, key, -1);
    return value >= 0 && value <= 9007199254740992.0 && value == (double)(size_t)value ? (size_t)value : SIZE_MAX;
}

static enum reader_event damaged(struct scree_error *err, const char *what)
{
    scree_fail(err, SCREE_CORRUPT, NULL, "a chunk arrived %s", what);
    return READER_DAMAGED;
}

/* Checks the chunk in reader->message and hands it out. */
static enum reader_event take_chunk(struct reader *reader, struct reader_chunk *chunk, struct scree_error *err)
{
    const cJSON *header = reader->message.header;
    const cJSON *names = json_get(header, "columns");
    size_t rows = whole(header, "n"), columns = cJSON_IsArray(names) ? (size_t)cJSON_GetArraySize(names) : 0;
    size_t bytes = reader->message.count == 3 ? zmq_msg_size(&reader->message.frames[2]) : 0;
    const char *dtype = json_text(header, "dtype");
    if (columns == 0 || columns > COLUMNS_MAX || rows > bytes || rows * columns * sizeof(double) != bytes || !dtype ||
        strcmp(dtype, "<f8") != 0)
        return damaged(err, "whose size is not what its header says");
    const void *payload = zmq_msg_data(&reader->message.frames[2]);
    if (crc32c(0, payload, bytes) != whole(header, "crc32c"))
        return damaged(err, "with a wrong checksum");
    if (whole(header, "seq") != reader->next)
        return damaged(err, "out of turn");
    if (bytes > reader->room) {
        double *grown = realloc(reader->values, bytes);
        if (!grown)
            return damaged(err, "that does not fit in memory");
        reader->values = grown;
        reader->room = bytes;
    }
    if (bytes)
        memcpy(reader->values, payload, bytes);
    *chunk = (struct reader_chunk){.seq = reader->next,
                                   .t0_s = json_number(header, "t0_s", 0),
                                   .dt_s = json_number(header, "dt_s", 0),
                                   .rows = rows,
                                   .columns = columns,
                                   .values = reader->values,
                                   .hash = json_text(header, "hash"),
                                   .column_names = names,
                                   .units = json_get(header, "units")};
    reader->next++;
    reader->owed = (long long)bytes;
    return READER_CHUNK;
}

enum reader_event reader_next(struct reader *reader, int milliseconds, struct reader_chunk *chunk, struct scree_error *err)
{
    wire_release(&reader->message);
    if (reader->owed)
        send_header(reader, "credit", reader->owed);
    reader->owed = 0;
    if (!wire_receive(reader->socket, milliseconds, &reader->message))
        return READER_QUIET;
    const cJSON *header = reader->message.header;
    const char *op = json_text(header, "op"), *key = json_text(header, "key");
    if (!op)
        return READER_QUIET;
    if (strcmp(op, "error") == 0) { // whatever its key: an opening that could not even be read has none
        error_read(json_get(header, "error"), err);
        return READER_ERROR;
    }
    if (!key || strcmp(key, KEY) != 0)
        return READER_QUIET;
    if (strcmp(op, "chunk") == 0)
        return take_chunk(reader, chunk, err);
    if (strcmp(op, "end") != 0)
        return READER_QUIET;
    return whole(header, "chunks") == reader->next ? READER_END : damaged(err, "too few before the end");
}

int reader_column(const struct reader_chunk *chunk, const char *name)
{
    for (size_t c = 0; c < chunk->columns; c++) {
        const char *here = cJSON_GetStringValue(cJSON_GetArrayItem(chunk->column_names, (int)c));
        if (here && strcmp(here, name) == 0)
            return (int)c;
    }
    return -1;
}
