/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See journal_sql.h. Write-ahead mode with full syncs: what a call has returned
 * from is on disk. */
#include "journal_sql.h"

#include <stddef.h>

enum scree_status sql_failed(sqlite3 *db, const char *doing, struct scree_error *err)
{
    int code = db ? sqlite3_errcode(db) : SQLITE_NOMEM;
    enum scree_status status = code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? SCREE_CORRUPT
                               : code == SQLITE_NOMEM                          ? SCREE_NO_MEMORY
                                                                               : SCREE_IO;
    return scree_fail(err, status, "", "%s failed: %s", doing, db ? sqlite3_errmsg(db) : "no memory");
}

enum scree_status sql_open(sqlite3 **db, const char *path, int flags, const char *schema, struct scree_error *err)
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
        enum scree_status status = sql_failed(*db, "preparing the database", err);
        sqlite3_close(*db);
        *db = NULL;
        return status;
    }
    return SCREE_OK;
}

void sql_bind_text(sqlite3_stmt *statement, int at, const char *text)
{
    sqlite3_bind_text(statement, at, text ? text : "", -1, SQLITE_TRANSIENT);
}

/* Runs a statement that returns no rows, and makes it ready for the next time. */
enum scree_status sql_run(sqlite3 *db, sqlite3_stmt *statement, const char *doing, struct scree_error *err)
{
    int code = sqlite3_step(statement);
    enum scree_status status = code == SQLITE_DONE ? SCREE_OK : sql_failed(db, doing, err);
    sqlite3_reset(statement);
    return status;
}

const char *sql_text(sqlite3_stmt *statement, int at)
{
    const unsigned char *text = sqlite3_column_text(statement, at);
    return text ? (const char *)text : "";
}
