/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Stream logs: see journal.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/failpoint.h"
#include "base/memory.h"
#include "journal.h"
#include "journal_sql.h"
#include "protocol/frame.h"

struct chunk_log {
    sqlite3 *db;
    sqlite3_stmt *put, *get, *get_hash;
    struct {
        char name[CHUNK_NAME_MAX];
        uint64_t seq, hash;
    } last[16]; // chunks that were put or read last, so that a running hash needs no look-up
    size_t last_count;
    void *payload; // of the chunk that was read last: kept, so that no read transaction stays open
    size_t room;
};

static const char chunk_schema[] =
    "CREATE TABLE IF NOT EXISTS streams(name TEXT PRIMARY KEY, columns TEXT NOT NULL, units TEXT NOT NULL, frames INTEGER NOT "
    "NULL);"
    "CREATE TABLE IF NOT EXISTS chunks(stream TEXT NOT NULL, seq INTEGER NOT NULL, t0 REAL NOT NULL, dt REAL NOT NULL,"
    " rows INTEGER NOT NULL, crc INTEGER NOT NULL, hash INTEGER NOT NULL, payload BLOB NOT NULL, PRIMARY KEY(stream, seq));";

enum scree_status chunk_log_open(struct chunk_log **out, const char *path, bool write, struct scree_error *err)
{
    int flags = write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READWRITE;
    struct chunk_log *log = calloc(1, sizeof *log);
    if (!log)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a stream log");
    enum scree_status status = sql_open(&log->db, path, flags, write ? chunk_schema : NULL, err);
    if (!status &&
        (sqlite3_prepare_v2(log->db, "SELECT t0, dt, rows, crc, hash, payload FROM chunks WHERE stream = ?1 AND seq = ?2", -1,
                            &log->get, NULL) != SQLITE_OK ||
         sqlite3_prepare_v2(log->db, "SELECT hash FROM chunks WHERE stream = ?1 AND seq = ?2", -1, &log->get_hash, NULL) !=
             SQLITE_OK))
        status = sql_failed(log->db, "preparing the stream log", err);
    if (!status && write &&
        sqlite3_prepare_v2(log->db,
                           "INSERT OR REPLACE INTO chunks(stream, seq, t0, dt, rows, crc, hash, payload)"
                           " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
                           -1, &log->put, NULL) != SQLITE_OK)
        status = sql_failed(log->db, "preparing the stream log", err);
    if (status) {
        chunk_log_close(log);
        return write ? status : SCREE_NOT_FOUND;
    }
    *out = log;
    return SCREE_OK;
}

void chunk_log_close(struct chunk_log *log)
{
    if (!log)
        return;
    sqlite3_finalize(log->put);
    sqlite3_finalize(log->get);
    sqlite3_finalize(log->get_hash);
    sqlite3_close(log->db);
    free(log->payload);
    free(log);
}

static void word_list(char *out, size_t size, const struct scree_stream *stream, bool units)
{
    size_t length = (size_t)snprintf(out, size, "[");
    for (size_t k = 0; k < stream->column_count && length < size; k++)
        length += (size_t)snprintf(out + length, size - length, "%s\"%s\"", k ? "," : "",
                                   units ? stream->columns[k].unit : stream->columns[k].name);
    if (length < size)
        snprintf(out + length, size - length, "]");
}

enum scree_status chunk_log_declare(struct chunk_log *log, const struct scree_stream *const *streams, size_t count,
                                    struct scree_error *err)
{
    static const char text[] = "INSERT OR IGNORE INTO streams(name, columns, units, frames) VALUES(?1, ?2, ?3, ?4)";
    sqlite3_stmt *insert = NULL;
    enum scree_status status = SCREE_OK;
    if (sqlite3_prepare_v2(log->db, text, -1, &insert, NULL) != SQLITE_OK ||
        sqlite3_exec(log->db, "BEGIN", NULL, NULL, NULL) != SQLITE_OK)
        status = sql_failed(log->db, "declaring streams", err);
    for (size_t k = 0; k < count && !status; k++) {
        char columns[512], units[512];
        word_list(columns, sizeof columns, streams[k], false);
        word_list(units, sizeof units, streams[k], true);
        sql_bind_text(insert, 1, streams[k]->name);
        sql_bind_text(insert, 2, columns);
        sql_bind_text(insert, 3, units);
        sqlite3_bind_int(insert, 4, streams[k]->frames);
        status = sql_run(log->db, insert, "declaring a stream", err);
    }
    sqlite3_finalize(insert);
    if (sqlite3_exec(log->db, status ? "ROLLBACK" : "COMMIT", NULL, NULL, NULL) != SQLITE_OK && !status)
        status = sql_failed(log->db, "declaring streams", err);
    return status;
}

/* The row as it lies on disk, sound or not. */
static enum scree_status get_row(struct chunk_log *log, const char *stream, uint64_t seq, struct chunk_row *row, bool *found,
                                 struct scree_error *err)
{
    sql_bind_text(log->get, 1, stream);
    sqlite3_bind_int64(log->get, 2, (sqlite3_int64)seq);
    int code = sqlite3_step(log->get);
    enum scree_status status =
        code == SQLITE_ROW || code == SQLITE_DONE ? SCREE_OK : sql_failed(log->db, "reading the stream log", err);
    *found = code == SQLITE_ROW;
    if (*found) {
        *row = (struct chunk_row){.seq = seq,
                                  .t0_s = sqlite3_column_double(log->get, 0),
                                  .dt_s = sqlite3_column_double(log->get, 1),
                                  .rows = (size_t)sqlite3_column_int64(log->get, 2),
                                  .crc = sqlite3_column_int64(log->get, 3),
                                  .hash = (uint64_t)sqlite3_column_int64(log->get, 4),
                                  .bytes = (size_t)sqlite3_column_bytes(log->get, 5)};
        status = memory_grow(&log->payload, &log->room, row->bytes, 1, err);
        if (!status && row->bytes)
            memcpy(log->payload, sqlite3_column_blob(log->get, 5), row->bytes);
        row->payload = log->payload;
    }
    sqlite3_reset(log->get);
    return status;
}

/* The running hash up to the chunk before this one; 0 before the first. */
static enum scree_status hash_before(struct chunk_log *log, const char *stream, uint64_t seq, uint64_t *hash,
                                     struct scree_error *err)
{
    *hash = 0;
    if (seq == 0)
        return SCREE_OK;
    for (size_t k = 0; k < log->last_count; k++)
        if (log->last[k].seq == seq - 1 && strcmp(log->last[k].name, stream) == 0) {
            *hash = log->last[k].hash;
            return SCREE_OK;
        }
    sql_bind_text(log->get_hash, 1, stream);
    sqlite3_bind_int64(log->get_hash, 2, (sqlite3_int64)seq - 1);
    int code = sqlite3_step(log->get_hash);
    enum scree_status status = SCREE_OK;
    if (code == SQLITE_ROW)
        *hash = (uint64_t)sqlite3_column_int64(log->get_hash, 0);
    else if (code == SQLITE_DONE)
        status = scree_fail(err, SCREE_CORRUPT, "", "the stream log lacks chunk %llu of %s", (unsigned long long)seq - 1, stream);
    else
        status = sql_failed(log->db, "reading the stream log", err);
    sqlite3_reset(log->get_hash);
    return status;
}

static void keep_last(struct chunk_log *log, const char *stream, uint64_t seq, uint64_t hash)
{
    size_t k = 0, room = sizeof log->last / sizeof *log->last;
    while (k < log->last_count && strcmp(log->last[k].name, stream) != 0)
        k++;
    if (k == room)
        return;
    log->last_count += k == log->last_count;
    snprintf(log->last[k].name, CHUNK_NAME_MAX, "%s", stream);
    log->last[k].seq = seq;
    log->last[k].hash = hash;
}

static bool intact(const struct chunk_row *row, uint64_t before)
{
    return row->bytes % sizeof(double) == 0 && crc32c(0, row->payload, row->bytes) == row->crc &&
           chunk_hash(before, row->seq, row->t0_s, row->dt_s, row->rows, row->payload, row->bytes) == row->hash;
}

enum scree_status chunk_log_get(struct chunk_log *log, const char *stream, uint64_t seq, struct chunk_row *row, bool *found,
                                struct scree_error *err)
{
    uint64_t hash;
    enum scree_status status = get_row(log, stream, seq, row, found, err);
    if (status || !*found || (status = hash_before(log, stream, seq, &hash, err)))
        return status;
    if (!intact(row, hash))
        return scree_fail(err, SCREE_CORRUPT, "", "chunk %llu of %s is damaged in the stream log: its checksum is wrong",
                          (unsigned long long)seq, stream);
    keep_last(log, stream, seq, row->hash);
    return SCREE_OK;
}

/* What a chunk that is there already means for one that is put again. */
static enum scree_status compare(const struct chunk_row *there, const struct scree_chunk *chunk, size_t bytes, bool ending,
                                 struct scree_error *err)
{
    bool same = there->bytes == bytes && there->t0_s == chunk->t0_s && memcmp(there->payload, chunk->values, bytes) == 0;
    bool earlier = ending && (bytes < there->bytes || chunk->t0_s < there->t0_s);
    if (same || earlier)
        return SCREE_OK;
    return scree_fail(err, SCREE_CORRUPT, "", "chunk %llu of %s came out differently when the job was run again",
                      (unsigned long long)chunk->seq, chunk->stream->name);
}

enum scree_status chunk_log_put(struct chunk_log *log, const struct scree_chunk *chunk, bool ending, struct scree_error *err)
{
    const char *name = chunk->stream->name;
    size_t bytes = chunk->rows * chunk->stream->column_count * sizeof *chunk->values;
    struct chunk_row there;
    bool found;
    uint64_t hash;
    enum scree_status status = hash_before(log, name, chunk->seq, &hash, err);
    if (status || (status = get_row(log, name, chunk->seq, &there, &found, err)))
        return status;
    if (found && intact(&there, hash)) {
        keep_last(log, name, chunk->seq, there.hash);
        return compare(&there, chunk, bytes, ending, err);
    }
    hash = chunk_hash(hash, chunk->seq, chunk->t0_s, chunk->dt_s, chunk->rows, chunk->values, bytes);
    sql_bind_text(log->put, 1, name);
    sqlite3_bind_int64(log->put, 2, (sqlite3_int64)chunk->seq);
    sqlite3_bind_double(log->put, 3, chunk->t0_s);
    sqlite3_bind_double(log->put, 4, chunk->dt_s);
    sqlite3_bind_int64(log->put, 5, (sqlite3_int64)chunk->rows);
    sqlite3_bind_int64(log->put, 6, crc32c(0, chunk->values, bytes));
    sqlite3_bind_int64(log->put, 7, (sqlite3_int64)hash);
    sqlite3_bind_blob64(log->put, 8, chunk->values, bytes, SQLITE_STATIC);
    FAILPOINT("log-put");
    status = sql_run(log->db, log->put, "writing the stream log", err);
    FAILPOINT("log-written");
    if (!status)
        keep_last(log, name, chunk->seq, hash);
    return status;
}

double chunk_log_reached(struct chunk_log *log)
{
    sqlite3_stmt *select = NULL;
    double reached = -1;
    if (sqlite3_prepare_v2(log->db, "SELECT MAX(t0 + (rows - 1) * dt) FROM chunks", -1, &select, NULL) == SQLITE_OK &&
        sqlite3_step(select) == SQLITE_ROW && sqlite3_column_type(select, 0) != SQLITE_NULL)
        reached = sqlite3_column_double(select, 0);
    sqlite3_finalize(select);
    return reached;
}

size_t chunk_log_streams(struct chunk_log *log, struct chunk_stream *out, size_t room)
{
    sqlite3_stmt *select = NULL;
    size_t count = 0;
    if (sqlite3_prepare_v2(
            log->db,
            "SELECT name, columns, units, frames, (SELECT COALESCE(MAX(seq) + 1, 0) FROM chunks WHERE stream = name),"
            " (SELECT COALESCE(SUM(rows), 0) FROM chunks WHERE stream = name) FROM streams ORDER BY rowid",
            -1, &select, NULL) != SQLITE_OK)
        return 0;
    while (sqlite3_step(select) == SQLITE_ROW) {
        if (count < room) {
            struct chunk_stream *s = &out[count];
            snprintf(s->name, sizeof s->name, "%s", sql_text(select, 0));
            snprintf(s->columns, sizeof s->columns, "%s", sql_text(select, 1));
            snprintf(s->units, sizeof s->units, "%s", sql_text(select, 2));
            s->frames = sqlite3_column_int(select, 3) != 0;
            s->chunks = (uint64_t)sqlite3_column_int64(select, 4);
            s->samples = (uint64_t)sqlite3_column_int64(select, 5);
        }
        count++;
    }
    sqlite3_finalize(select);
    return count < room ? count : room;
}
