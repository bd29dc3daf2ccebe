/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What must survive of studies: what was asked for, how it ended, and which job is
 * which trial. Everything else follows from the jobs. In the journal's database,
 * on the control thread; calls return once the change is on disk. */
#ifndef SCREE_SERVER_JOURNAL_STUDIES_H
#define SCREE_SERVER_JOURNAL_STUDIES_H

#include "journal.h"

struct study_log;

struct study_row {
    int64_t number;
    const char *request, *state, *spec, *build;
    const char *error; // JSON, "" if none
    bool again;        // its trials do not take results of jobs that ended before it
    double submitted, started, ended;
    int64_t pause; // number of its newest command to pause, 0: none
};

struct trial_row {
    int64_t study;
    int replica, point, extension; // a sweep's trial: 0, its number, 0
    int64_t job;                   // number
};

/* Makes the tables if need be. The journal must outlive the log. */
enum scree_status study_log_open(struct study_log **out, struct journal *journal, struct scree_error *err);
void study_log_close(struct study_log *log);

/* Insert fills row->number; update writes state, build, error, started, ended. */
enum scree_status study_log_insert(struct study_log *log, struct study_row *row, struct scree_error *err);
enum scree_status study_log_update(struct study_log *log, const struct study_row *row, struct scree_error *err);
enum scree_status study_log_add_trial(struct study_log *log, const struct trial_row *row, struct scree_error *err);
/* *number is 0 when that request has been noted before. */
enum scree_status study_log_add_command(struct study_log *log, const char *request, int64_t study, const char *op, int64_t *number,
                                        struct scree_error *err);

/* Every study in order of number, then every trial in the order in which they were added. */
enum scree_status study_log_load(struct study_log *log,
                                 enum scree_status (*study)(void *, const struct study_row *, struct scree_error *),
                                 enum scree_status (*trial)(void *, const struct trial_row *, struct scree_error *), void *context,
                                 struct scree_error *err);

#endif
