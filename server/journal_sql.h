/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files that know SQL (journal*.c) share. */
#ifndef SCREE_SERVER_JOURNAL_SQL_H
#define SCREE_SERVER_JOURNAL_SQL_H

#include <sqlite3.h>

#include "base/status.h"

/* A status for what the database just reported: damage, lack of memory, else SCREE_IO (a full disk too). */
enum scree_status sql_failed(sqlite3 *db, const char *doing, struct scree_error *err);

/* `schema` NULL: to read. */
enum scree_status sql_open(sqlite3 **db, const char *path, int flags, const char *schema, struct scree_error *err);

/* NULL counts as "". */
void sql_bind_text(sqlite3_stmt *statement, int at, const char *text);
const char *sql_text(sqlite3_stmt *statement, int at);

/* Runs a statement that returns no rows, and makes it ready for the next time. */
enum scree_status sql_run(sqlite3 *db, sqlite3_stmt *statement, const char *doing, struct scree_error *err);

#endif
