/* SPDX-License-Identifier: GPL-3.0-or-later */
/* SQLite in write-ahead mode with full syncs: what a call has returned from is on
 * disk. Statements are prepared once. */
#include "journal.h"

#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "protocol/frame.h"

static enum scree_status failed(sqlite3 *db, const char *doing, struct scree_error *err)
{
    return scree_fail(err, SCREE_IO, "", "%s failed: %s", doing, db ? sqlite3_errmsg(db) : "no memory");
}

static enum scree_status open_database(sqlite3 **db, const char *path, int flags, const char *schema, struct scree_error *err)
{
    if (sqlite3_open_v2(path, db, flags | SQLITE_OPEN_NOMUTEX, NULL) != SQLITE_OK) {
        enum scree_status status =
            scree_fail(err, SCREE_IO, "", "cannot open %s: %s", path, *db ? sqlite3_errmsg(*db) : "no memory");
        sqlite3_close(*db);
        *db = NULL;
        return status;
    }
    sqlite3_busy_timeout(*db, 10000);
    /* Only who makes the database turns write-ahead on: two connections that try it at once lock each other out. */
    if ((schema && sqlite3_exec(*db, "PRAGMA journal_mode=WAL", NULL, NULL, NULL) != SQLITE_OK) ||
        sqlite3_exec(*db, "PRAGMA synchronous=FULL", NULL, NULL, NULL) != SQLITE_OK ||
        (schema && sqlite3_exec(*db, schema, NULL, NULL, NULL) != SQLITE_OK)) {
        enum scree_status status = failed(*db, "preparing the database", err);
        sqlite3_close(*db);
        *db = NULL;
        return status;
    }
    return SCREE_OK;
}

static void bind_text(sqlite3_stmt *statement, int at, const char *text)
{
    sqlite3_bind_text(statement, at, text ? text : "", -1, SQLITE_TRANSIENT);
}

/* Runs a statement that returns no rows, and makes it ready for the next time. */
static enum scree_status run(sqlite3 *db, sqlite3_stmt *statement, const char *doing, struct scree_error *err)
{
    int code = sqlite3_step(statement);
    enum scree_status status = code == SQLITE_DONE ? SCREE_OK : failed(db, doing, err);
    sqlite3_reset(statement);
    return status;
}

/* ---- jobs ---- */

struct journal {
    sqlite3 *db;
    sqlite3_stmt *insert, *update;
};

static const char journal_schema[] = "CREATE TABLE IF NOT EXISTS jobs("
                                     " number INTEGER PRIMARY KEY AUTOINCREMENT,"
                                     " request TEXT NOT NULL UNIQUE,"
                                     " state TEXT NOT NULL, spec TEXT NOT NULL, build TEXT NOT NULL, outcome TEXT NOT NULL,"
                                     " submitted REAL NOT NULL, started REAL NOT NULL, ended REAL NOT NULL);";

enum scree_status journal_open(struct journal **out, const char *path, struct scree_error *err)
{
    struct journal *journal = calloc(1, sizeof *journal);
    if (!journal)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the journal");
    enum scree_status status = open_database(&journal->db, path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, journal_schema, err);
    if (!status &&
        (sqlite3_prepare_v2(journal->db,
                            "INSERT INTO jobs(request, state, spec, build, outcome, submitted, started, ended)"
                            " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
                            -1, &journal->insert, NULL) != SQLITE_OK ||
         sqlite3_prepare_v2(journal->db,
                            "UPDATE jobs SET state = ?2, build = ?4, outcome = ?5, started = ?7, ended = ?8 WHERE number = ?9", -1,
                            &journal->update, NULL) != SQLITE_OK))
        status = failed(journal->db, "preparing the journal", err);
    if (status) {
        journal_close(journal);
        return status;
    }
    *out = journal;
    return SCREE_OK;
}

void journal_close(struct journal *journal)
{
    if (!journal)
        return;
    sqlite3_finalize(journal->insert);
    sqlite3_finalize(journal->update);
    sqlite3_close(journal->db);
    free(journal);
}

sqlite3 *journal_database(struct journal *journal)
{
    return journal->db;
}

static void bind_row(sqlite3_stmt *statement, const struct journal_row *row)
{
    bind_text(statement, 2, row->state);
    bind_text(statement, 4, row->build);
    bind_text(statement, 5, row->outcome);
    sqlite3_bind_double(statement, 7, row->started);
    sqlite3_bind_double(statement, 8, row->ended);
}

enum scree_status journal_insert(struct journal *journal, struct journal_row *row, struct scree_error *err)
{
    bind_row(journal->insert, row);
    bind_text(journal->insert, 1, row->request);
    bind_text(journal->insert, 3, row->spec);
    sqlite3_bind_double(journal->insert, 6, row->submitted);
    enum scree_status status = run(journal->db, journal->insert, "writing the journal", err);
    if (!status)
        row->number = sqlite3_last_insert_rowid(journal->db);
    return status;
}

enum scree_status journal_update(struct journal *journal, const struct journal_row *row, struct scree_error *err)
{
    bind_row(journal->update, row);
    sqlite3_bind_int64(journal->update, 9, row->number);
    return run(journal->db, journal->update, "writing the journal", err);
}

static const char *column(sqlite3_stmt *statement, int at)
{
    const unsigned char *text = sqlite3_column_text(statement, at);
    return text ? (const char *)text : "";
}

enum scree_status journal_load(struct journal *journal,
                               enum scree_status (*each)(void *, const struct journal_row *, struct scree_error *), void *context,
                               struct scree_error *err)
{
    sqlite3_stmt *select = NULL;
    if (sqlite3_prepare_v2(
            journal->db, "SELECT number, request, state, spec, build, outcome, submitted, started, ended FROM jobs ORDER BY number",
            -1, &select, NULL) != SQLITE_OK)
        return failed(journal->db, "reading the journal", err);
    enum scree_status status = SCREE_OK;
    int code;
    while (!status && (code = sqlite3_step(select)) == SQLITE_ROW) {
        const struct journal_row row = {.number = sqlite3_column_int64(select, 0),
                                        .request = column(select, 1),
                                        .state = column(select, 2),
                                        .spec = column(select, 3),
                                        .build = column(select, 4),
                                        .outcome = column(select, 5),
                                        .submitted = sqlite3_column_double(select, 6),
                                        .started = sqlite3_column_double(select, 7),
                                        .ended = sqlite3_column_double(select, 8)};
        status = each(context, &row, err);
    }
    if (!status && code != SQLITE_DONE)
        status = failed(journal->db, "reading the journal", err);
    sqlite3_finalize(select);
    return status;
}

/* ---- stream logs ---- */

struct chunk_log {
    sqlite3 *db;
    sqlite3_stmt *put, *get;
    void *payload; // of the chunk that was read last: kept, so that no read transaction stays open
    size_t room;
};

static const char chunk_schema[] =
    "CREATE TABLE IF NOT EXISTS streams(name TEXT PRIMARY KEY, columns TEXT NOT NULL, units TEXT NOT NULL, frames INTEGER NOT "
    "NULL);"
    "CREATE TABLE IF NOT EXISTS chunks(stream TEXT NOT NULL, seq INTEGER NOT NULL, t0 REAL NOT NULL, dt REAL NOT NULL,"
    " rows INTEGER NOT NULL, crc INTEGER NOT NULL, payload BLOB NOT NULL, PRIMARY KEY(stream, seq));";

enum scree_status chunk_log_open(struct chunk_log **out, const char *path, bool write, struct scree_error *err)
{
    int flags = write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READWRITE;
    struct chunk_log *log = calloc(1, sizeof *log);
    if (!log)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a stream log");
    enum scree_status status = open_database(&log->db, path, flags, write ? chunk_schema : NULL, err);
    if (!status && sqlite3_prepare_v2(log->db, "SELECT t0, dt, rows, crc, payload FROM chunks WHERE stream = ?1 AND seq = ?2", -1,
                                      &log->get, NULL) != SQLITE_OK)
        status = failed(log->db, "preparing the stream log", err);
    if (!status && write &&
        sqlite3_prepare_v2(log->db,
                           "INSERT INTO chunks(stream, seq, t0, dt, rows, crc, payload) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7)", -1,
                           &log->put, NULL) != SQLITE_OK)
        status = failed(log->db, "preparing the stream log", err);
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
        status = failed(log->db, "declaring streams", err);
    for (size_t k = 0; k < count && !status; k++) {
        char columns[512], units[512];
        word_list(columns, sizeof columns, streams[k], false);
        word_list(units, sizeof units, streams[k], true);
        bind_text(insert, 1, streams[k]->name);
        bind_text(insert, 2, columns);
        bind_text(insert, 3, units);
        sqlite3_bind_int(insert, 4, streams[k]->frames);
        status = run(log->db, insert, "declaring a stream", err);
    }
    sqlite3_finalize(insert);
    if (sqlite3_exec(log->db, status ? "ROLLBACK" : "COMMIT", NULL, NULL, NULL) != SQLITE_OK && !status)
        status = failed(log->db, "declaring streams", err);
    return status;
}

enum scree_status chunk_log_get(struct chunk_log *log, const char *stream, uint64_t seq, struct chunk_row *row, bool *found,
                                struct scree_error *err)
{
    bind_text(log->get, 1, stream);
    sqlite3_bind_int64(log->get, 2, (sqlite3_int64)seq);
    int code = sqlite3_step(log->get);
    enum scree_status status =
        code == SQLITE_ROW || code == SQLITE_DONE ? SCREE_OK : failed(log->db, "reading the stream log", err);
    *found = code == SQLITE_ROW;
    if (*found) {
        *row = (struct chunk_row){.seq = seq,
                                  .t0_s = sqlite3_column_double(log->get, 0),
                                  .dt_s = sqlite3_column_double(log->get, 1),
                                  .rows = (size_t)sqlite3_column_int64(log->get, 2),
                                  .crc = (uint32_t)sqlite3_column_int64(log->get, 3),
                                  .bytes = (size_t)sqlite3_column_bytes(log->get, 4)};
        status = memory_grow(&log->payload, &log->room, row->bytes, 1, err);
        if (!status)
            memcpy(log->payload, sqlite3_column_blob(log->get, 4), row->bytes);
        row->payload = log->payload;
    }
    sqlite3_reset(log->get);
    return status;
}

enum scree_status chunk_log_put(struct chunk_log *log, const struct scree_chunk *chunk, struct scree_error *err)
{
    size_t bytes = chunk->rows * chunk->stream->column_count * sizeof *chunk->values;
    uint32_t crc = crc32c(0, chunk->values, bytes);
    struct chunk_row there;
    bool found;
    enum scree_status status = chunk_log_get(log, chunk->stream->name, chunk->seq, &there, &found, err);
    if (status)
        return status;
    if (found) {
        bool same = there.bytes == bytes && there.crc == crc && memcmp(there.payload, chunk->values, bytes) == 0;
        return same ? SCREE_OK
                    : scree_fail(err, SCREE_CORRUPT, "", "chunk %llu of %s came out differently when the job was run again",
                                 (unsigned long long)chunk->seq, chunk->stream->name);
    }
    bind_text(log->put, 1, chunk->stream->name);
    sqlite3_bind_int64(log->put, 2, (sqlite3_int64)chunk->seq);
    sqlite3_bind_double(log->put, 3, chunk->t0_s);
    sqlite3_bind_double(log->put, 4, chunk->dt_s);
    sqlite3_bind_int64(log->put, 5, (sqlite3_int64)chunk->rows);
    sqlite3_bind_int64(log->put, 6, crc);
    sqlite3_bind_blob64(log->put, 7, chunk->values, bytes, SQLITE_STATIC);
    return run(log->db, log->put, "writing the stream log", err);
}

size_t chunk_log_streams(struct chunk_log *log, struct chunk_stream *out, size_t room)
{
    sqlite3_stmt *select = NULL;
    size_t count = 0;
    if (sqlite3_prepare_v2(log->db,
                           "SELECT name, columns, units, frames, (SELECT COUNT(*) FROM chunks WHERE stream = name),"
                           " (SELECT COALESCE(SUM(rows), 0) FROM chunks WHERE stream = name) FROM streams ORDER BY rowid",
                           -1, &select, NULL) != SQLITE_OK)
        return 0;
    while (sqlite3_step(select) == SQLITE_ROW) {
        if (count < room) {
            struct chunk_stream *s = &out[count];
            snprintf(s->name, sizeof s->name, "%s", column(select, 0));
            snprintf(s->columns, sizeof s->columns, "%s", column(select, 1));
            snprintf(s->units, sizeof s->units, "%s", column(select, 2));
            s->frames = sqlite3_column_int(select, 3) != 0;
            s->chunks = (uint64_t)sqlite3_column_int64(select, 4);
            s->samples = (uint64_t)sqlite3_column_int64(select, 5);
        }
        count++;
    }
    sqlite3_finalize(select);
    return count < room ? count : room;
}
