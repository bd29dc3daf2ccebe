/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The journal of jobs. Statements are prepared once. Columns that came later are
 * added to a journal of an earlier version when it is opened. */
#include "journal.h"

#include <stdlib.h>
#include <string.h>

#include "base/failpoint.h"
#include "journal_sql.h"

struct journal {
    sqlite3 *db;
    sqlite3_stmt *insert, *update;
    struct journal_commands *commands;
};

static const char journal_schema[] = "CREATE TABLE IF NOT EXISTS jobs("
                                     " number INTEGER PRIMARY KEY AUTOINCREMENT,"
                                     " request TEXT NOT NULL UNIQUE,"
                                     " state TEXT NOT NULL, spec TEXT NOT NULL, build TEXT NOT NULL, outcome TEXT NOT NULL,"
                                     " submitted REAL NOT NULL, started REAL NOT NULL, ended REAL NOT NULL,"
                                     " origin TEXT NOT NULL DEFAULT '');";

static enum scree_status add_columns(sqlite3 *db, struct scree_error *err)
{
    if (sqlite3_exec(db, "ALTER TABLE jobs ADD COLUMN origin TEXT NOT NULL DEFAULT ''", NULL, NULL, NULL) == SQLITE_OK ||
        strncmp(sqlite3_errmsg(db), "duplicate column", 16) == 0)
        return SCREE_OK;
    return sql_failed(db, "preparing the journal", err);
}

enum scree_status journal_open(struct journal **out, const char *path, struct scree_error *err)
{
    struct journal *journal = calloc(1, sizeof *journal);
    if (!journal)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the journal");
    enum scree_status status = sql_open(&journal->db, path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, journal_schema, err);
    if (!status)
        status = add_columns(journal->db, err);
    if (!status &&
        (sqlite3_prepare_v2(journal->db,
                            "INSERT INTO jobs(request, state, spec, build, outcome, submitted, started, ended, origin)"
                            " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?10)",
                            -1, &journal->insert, NULL) != SQLITE_OK ||
         sqlite3_prepare_v2(journal->db,
                            "UPDATE jobs SET state = ?2, build = ?4, outcome = ?5, started = ?7, ended = ?8 WHERE number = ?9", -1,
                            &journal->update, NULL) != SQLITE_OK))
        status = sql_failed(journal->db, "preparing the journal", err);
    if (!status)
        status = journal_commands_open(&journal->commands, journal->db, err);
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
    journal_commands_close(journal->commands);
    sqlite3_finalize(journal->insert);
    sqlite3_finalize(journal->update);
    sqlite3_close(journal->db);
    free(journal);
}

sqlite3 *journal_database(struct journal *journal)
{
    return journal->db;
}

struct journal_commands *journal_commands(struct journal *journal)
{
    return journal->commands;
}

enum scree_status journal_begin(struct journal *journal, struct scree_error *err)
{
    return sqlite3_exec(journal->db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK
               ? SCREE_OK
               : sql_failed(journal->db, "writing the journal", err);
}

enum scree_status journal_end(struct journal *journal, enum scree_status status, struct scree_error *err)
{
    FAILPOINT("journal-commit");
    if (!status && sqlite3_exec(journal->db, "COMMIT", NULL, NULL, NULL) != SQLITE_OK)
        status = sql_failed(journal->db, "writing the journal", err);
    if (status && !sqlite3_get_autocommit(journal->db))
        sqlite3_exec(journal->db, "ROLLBACK", NULL, NULL, NULL);
    FAILPOINT("journal-committed");
    return status;
}

static void bind_row(sqlite3_stmt *statement, const struct journal_row *row)
{
    sql_bind_text(statement, 2, row->state);
    sql_bind_text(statement, 4, row->build);
    sql_bind_text(statement, 5, row->outcome);
    sqlite3_bind_double(statement, 7, row->started);
    sqlite3_bind_double(statement, 8, row->ended);
}

enum scree_status journal_insert(struct journal *journal, struct journal_row *row, struct scree_error *err)
{
    bind_row(journal->insert, row);
    sql_bind_text(journal->insert, 1, row->request);
    sql_bind_text(journal->insert, 3, row->spec);
    sqlite3_bind_double(journal->insert, 6, row->submitted);
    sql_bind_text(journal->insert, 10, row->origin);
    FAILPOINT("journal-insert");
    enum scree_status status = sql_run(journal->db, journal->insert, "writing the journal", err);
    if (!status)
        row->number = sqlite3_last_insert_rowid(journal->db);
    FAILPOINT("journal-inserted");
    return status;
}

enum scree_status journal_update(struct journal *journal, const struct journal_row *row, struct scree_error *err)
{
    bind_row(journal->update, row);
    sqlite3_bind_int64(journal->update, 9, row->number);
    FAILPOINT("journal-update");
    enum scree_status status = sql_run(journal->db, journal->update, "writing the journal", err);
    FAILPOINT("journal-updated");
    return status;
}

enum scree_status journal_load(struct journal *journal,
                               enum scree_status (*each)(void *, const struct journal_row *, struct scree_error *), void *context,
                               struct scree_error *err)
{
    sqlite3_stmt *select = NULL;
    if (sqlite3_prepare_v2(
            journal->db,
            "SELECT number, request, state, spec, build, outcome, submitted, started, ended, origin FROM jobs ORDER BY number", -1,
            &select, NULL) != SQLITE_OK)
        return sql_failed(journal->db, "reading the journal", err);
    enum scree_status status = SCREE_OK;
    int code;
    while (!status && (code = sqlite3_step(select)) == SQLITE_ROW) {
        const struct journal_row row = {.number = sqlite3_column_int64(select, 0),
                                        .request = sql_text(select, 1),
                                        .state = sql_text(select, 2),
                                        .spec = sql_text(select, 3),
                                        .build = sql_text(select, 4),
                                        .outcome = sql_text(select, 5),
                                        .submitted = sqlite3_column_double(select, 6),
                                        .started = sqlite3_column_double(select, 7),
                                        .ended = sqlite3_column_double(select, 8),
                                        .origin = sql_text(select, 9)};
        status = each(context, &row, err);
    }
    if (!status && code != SQLITE_DONE)
        status = sql_failed(journal->db, "reading the journal", err);
    sqlite3_finalize(select);
    return status;
}
