/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Steering commands in the journal: see journal.h. */
#include <stdlib.h>

#include "base/failpoint.h"
#include "journal.h"
#include "journal_sql.h"

struct journal_commands {
    sqlite3 *db;
    sqlite3_stmt *insert, *update;
};

static const char schema[] = "CREATE TABLE IF NOT EXISTS commands("
                             " number INTEGER PRIMARY KEY AUTOINCREMENT, request TEXT NOT NULL UNIQUE, job INTEGER NOT NULL,"
                             " op TEXT NOT NULL, detail TEXT NOT NULL, step INTEGER NOT NULL, made INTEGER NOT NULL,"
                             " at REAL NOT NULL);";

enum scree_status journal_commands_open(struct journal_commands **out, struct sqlite3 *db, struct scree_error *err)
{
    struct journal_commands *c = calloc(1, sizeof *c);
    if (!c)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the journal");
    c->db = db;
    if (sqlite3_exec(db, schema, NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_prepare_v2(db, "INSERT INTO commands(request, job, op, detail, step, made, at) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7)",
                           -1, &c->insert, NULL) != SQLITE_OK ||
        sqlite3_prepare_v2(db, "UPDATE commands SET step = ?5, made = ?6 WHERE number = ?8", -1, &c->update, NULL) != SQLITE_OK) {
        enum scree_status status = sql_failed(db, "preparing the journal", err);
        journal_commands_close(c);
        return status;
    }
    *out = c;
    return SCREE_OK;
}

void journal_commands_close(struct journal_commands *c)
{
    if (!c)
        return;
    sqlite3_finalize(c->insert);
    sqlite3_finalize(c->update);
    free(c);
}

enum scree_status journal_command_insert(struct journal_commands *c, struct journal_command *command, struct scree_error *err)
{
    sql_bind_text(c->insert, 1, command->request);
    sqlite3_bind_int64(c->insert, 2, command->job);
    sql_bind_text(c->insert, 3, command->op);
    sql_bind_text(c->insert, 4, command->detail);
    sqlite3_bind_int64(c->insert, 5, command->step);
    sqlite3_bind_int64(c->insert, 6, command->made);
    sqlite3_bind_double(c->insert, 7, command->at);
    FAILPOINT("command-insert");
    enum scree_status status = sql_run(c->db, c->insert, "writing the journal", err);
    if (!status)
        command->number = sqlite3_last_insert_rowid(c->db);
    FAILPOINT("command-inserted");
    return status;
}

enum scree_status journal_command_update(struct journal_commands *c, const struct journal_command *command, struct scree_error *err)
{
    sqlite3_bind_int64(c->update, 5, command->step);
    sqlite3_bind_int64(c->update, 6, command->made);
    sqlite3_bind_int64(c->update, 8, command->number);
    FAILPOINT("command-update");
    enum scree_status status = sql_run(c->db, c->update, "writing the journal", err);
    FAILPOINT("command-updated");
    return status;
}

enum scree_status journal_command_load(struct journal_commands *c,
                                       enum scree_status (*each)(void *, const struct journal_command *, struct scree_error *),
                                       void *context, struct scree_error *err)
{
    sqlite3_stmt *select = NULL;
    if (sqlite3_prepare_v2(c->db, "SELECT number, request, job, op, detail, step, made, at FROM commands ORDER BY number", -1,
                           &select, NULL) != SQLITE_OK)
        return sql_failed(c->db, "reading the journal", err);
    enum scree_status status = SCREE_OK;
    int code = SQLITE_DONE;
    while (!status && (code = sqlite3_step(select)) == SQLITE_ROW) {
        const struct journal_command command = {.number = sqlite3_column_int64(select, 0),
                                                .request = sql_text(select, 1),
                                                .job = sqlite3_column_int64(select, 2),
                                                .op = sql_text(select, 3),
                                                .detail = sql_text(select, 4),
                                                .step = sqlite3_column_int64(select, 5),
                                                .made = sqlite3_column_int64(select, 6),
                                                .at = sqlite3_column_double(select, 7)};
        status = each(context, &command, err);
    }
    if (!status && code != SQLITE_DONE)
        status = sql_failed(c->db, "reading the journal", err);
    sqlite3_finalize(select);
    return status;
}
