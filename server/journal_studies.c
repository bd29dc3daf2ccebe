/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See journal_studies.h. */
#include "journal_studies.h"

#include <sqlite3.h>
#include <stdlib.h>

struct study_log {
    sqlite3 *db; // the journal's
    sqlite3_stmt *insert, *update, *trial, *command;
};

static const char schema[] = "CREATE TABLE IF NOT EXISTS studies("
                             " number INTEGER PRIMARY KEY AUTOINCREMENT,"
                             " request TEXT NOT NULL UNIQUE,"
                             " state TEXT NOT NULL, spec TEXT NOT NULL, build TEXT NOT NULL, error TEXT NOT NULL,"
                             " again INTEGER NOT NULL, submitted REAL NOT NULL, started REAL NOT NULL, ended REAL NOT NULL);"
                             "CREATE TABLE IF NOT EXISTS trials("
                             " study INTEGER NOT NULL, replica INTEGER NOT NULL, point INTEGER NOT NULL,"
                             " extension INTEGER NOT NULL, job INTEGER NOT NULL,"
                             " PRIMARY KEY(study, replica, point, extension));"
                             "CREATE TABLE IF NOT EXISTS study_commands("
                             " number INTEGER PRIMARY KEY AUTOINCREMENT,"
                             " request TEXT NOT NULL UNIQUE, study INTEGER NOT NULL, op TEXT NOT NULL);";

static enum scree_status failed(const struct study_log *log, const char *doing, struct scree_error *err)
{
    return scree_fail(err, SCREE_IO, "", "%s failed: %s", doing, sqlite3_errmsg(log->db));
}

enum scree_status study_log_open(struct study_log **out, struct journal *journal, struct scree_error *err)
{
    struct study_log *log = calloc(1, sizeof *log);
    if (!log)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the studies");
    log->db = journal_database(journal);
    if (sqlite3_exec(log->db, schema, NULL, NULL, NULL) == SQLITE_OK &&
        sqlite3_prepare_v2(log->db,
                           "INSERT INTO studies(request, state, spec, build, error, again, submitted, started, ended)"
                           " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
                           -1, &log->insert, NULL) == SQLITE_OK &&
        sqlite3_prepare_v2(log->db,
                           "UPDATE studies SET state = ?2, build = ?4, error = ?5, started = ?8, ended = ?9 WHERE number = ?10", -1,
                           &log->update, NULL) == SQLITE_OK &&
        sqlite3_prepare_v2(log->db, "INSERT INTO trials(study, replica, point, extension, job) VALUES(?1, ?2, ?3, ?4, ?5)", -1,
                           &log->trial, NULL) == SQLITE_OK &&
        sqlite3_prepare_v2(log->db, "INSERT OR IGNORE INTO study_commands(request, study, op) VALUES(?1, ?2, ?3)", -1,
                           &log->command, NULL) == SQLITE_OK) {
        *out = log;
        return SCREE_OK;
    }
    enum scree_status status = failed(log, "preparing the journal of studies", err);
    study_log_close(log);
    return status;
}

void study_log_close(struct study_log *log)
{
    if (!log)
        return;
    sqlite3_finalize(log->insert);
    sqlite3_finalize(log->update);
    sqlite3_finalize(log->trial);
    sqlite3_finalize(log->command);
    free(log);
}

static enum scree_status run(const struct study_log *log, sqlite3_stmt *statement, struct scree_error *err)
{
    enum scree_status status = sqlite3_step(statement) == SQLITE_DONE ? SCREE_OK : failed(log, "writing the journal", err);
    sqlite3_reset(statement);
    return status;
}

static void bind_study(sqlite3_stmt *statement, const struct study_row *row)
{
    sqlite3_bind_text(statement, 2, row->state, -1, SQLITE_TRANSIENT);
    sqlite3_bind_text(statement, 4, row->build, -1, SQLITE_TRANSIENT);
    sqlite3_bind_text(statement, 5, row->error, -1, SQLITE_TRANSIENT);
    sqlite3_bind_double(statement, 8, row->started);
    sqlite3_bind_double(statement, 9, row->ended);
}

enum scree_status study_log_insert(struct study_log *log, struct study_row *row, struct scree_error *err)
{
    bind_study(log->insert, row);
    sqlite3_bind_text(log->insert, 1, row->request, -1, SQLITE_TRANSIENT);
    sqlite3_bind_text(log->insert, 3, row->spec, -1, SQLITE_TRANSIENT);
    sqlite3_bind_int(log->insert, 6, row->again);
    sqlite3_bind_double(log->insert, 7, row->submitted);
    enum scree_status status = run(log, log->insert, err);
    if (!status)
        row->number = sqlite3_last_insert_rowid(log->db);
    return status;
}

enum scree_status study_log_update(struct study_log *log, const struct study_row *row, struct scree_error *err)
{
    bind_study(log->update, row);
    sqlite3_bind_int64(log->update, 10, row->number);
    return run(log, log->update, err);
}

enum scree_status study_log_add_trial(struct study_log *log, const struct trial_row *row, struct scree_error *err)
{
    sqlite3_bind_int64(log->trial, 1, row->study);
    sqlite3_bind_int(log->trial, 2, row->replica);
    sqlite3_bind_int(log->trial, 3, row->point);
    sqlite3_bind_int(log->trial, 4, row->extension);
    sqlite3_bind_int64(log->trial, 5, row->job);
    return run(log, log->trial, err);
}

enum scree_status study_log_add_command(struct study_log *log, const char *request, int64_t study, const char *op, int64_t *number,
                                        struct scree_error *err)
{
    sqlite3_bind_text(log->command, 1, request, -1, SQLITE_TRANSIENT);
    sqlite3_bind_int64(log->command, 2, study);
    sqlite3_bind_text(log->command, 3, op, -1, SQLITE_TRANSIENT);
    enum scree_status status = run(log, log->command, err);
    if (!status)
        *number = sqlite3_changes(log->db) > 0 ? sqlite3_last_insert_rowid(log->db) : 0;
    return status;
}

static const char *text(sqlite3_stmt *statement, int at)
{
    const unsigned char *value = sqlite3_column_text(statement, at);
    return value ? (const char *)value : "";
}

static enum scree_status give_study(sqlite3_stmt *s,
                                    enum scree_status (*each)(void *, const struct study_row *, struct scree_error *),
                                    void *context, struct scree_error *err)
{
    const struct study_row row = {.number = sqlite3_column_int64(s, 0),
                                  .request = text(s, 1),
                                  .state = text(s, 2),
                                  .spec = text(s, 3),
                                  .build = text(s, 4),
                                  .error = text(s, 5),
                                  .again = sqlite3_column_int(s, 6) != 0,
                                  .submitted = sqlite3_column_double(s, 7),
                                  .started = sqlite3_column_double(s, 8),
                                  .ended = sqlite3_column_double(s, 9),
                                  .pause = sqlite3_column_int64(s, 10)};
    return each(context, &row, err);
}

static enum scree_status give_trial(sqlite3_stmt *s,
                                    enum scree_status (*each)(void *, const struct trial_row *, struct scree_error *),
                                    void *context, struct scree_error *err)
{
    const struct trial_row row = {.study = sqlite3_column_int64(s, 0),
                                  .replica = sqlite3_column_int(s, 1),
                                  .point = sqlite3_column_int(s, 2),
                                  .extension = sqlite3_column_int(s, 3),
                                  .job = sqlite3_column_int64(s, 4)};
    return each(context, &row, err);
}

enum scree_status study_log_load(struct study_log *log,
                                 enum scree_status (*study)(void *, const struct study_row *, struct scree_error *),
                                 enum scree_status (*trial)(void *, const struct trial_row *, struct scree_error *), void *context,
                                 struct scree_error *err)
{
    static const char *const selects[] = {
        "SELECT number, request, state, spec, build, error, again, submitted, started, ended,"
        " (SELECT MAX(number) FROM study_commands WHERE study = studies.number AND op = 'pause') FROM studies ORDER BY number",
        "SELECT study, replica, point, extension, job FROM trials ORDER BY rowid"};
    enum scree_status status = SCREE_OK;
    for (int k = 0; k < 2 && !status; k++) {
        sqlite3_stmt *select = NULL;
        int code;
        if (sqlite3_prepare_v2(log->db, selects[k], -1, &select, NULL) != SQLITE_OK)
            return failed(log, "reading the journal of studies", err);
        while (!status && (code = sqlite3_step(select)) == SQLITE_ROW)
            status = k == 0 ? give_study(select, study, context, err) : give_trial(select, trial, context, err);
        if (!status && code != SQLITE_DONE)
            status = failed(log, "reading the journal of studies", err);
        sqlite3_finalize(select);
    }
    return status;
}
