/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A job from now to its end, with its progress on stderr. */
#ifndef SCREE_CLIENT_FOLLOW_H
#define SCREE_CLIENT_FOLLOW_H

#include "daemon.h"

enum follow_end {
    FOLLOW_ENDED,    // *record is the job's last record
    FOLLOW_DETACHED, // the user pressed Ctrl-C and the job goes on
    FOLLOW_FAILED    // *err and *outcome say why
};

/* `own` is the private daemon of this run, or NULL: then Ctrl-C leaves the job
 * alone. With one, the first Ctrl-C cancels the job, the second gives up.
 * Interrupts must be caught (signals_catch). *record is the caller's. */
enum follow_end follow_job(struct link *link, struct daemon *own, const char *job, cJSON **record, enum outcome *outcome,
                           struct scree_error *err);

/* How long a daemon that has gone is waited for, seconds. */
enum { FOLLOW_PATIENCE_S = 10 };

/* Whether an id is a study's; a study is followed as a job is. */
bool is_study_id(const char *id);

/* The record of `show`; of a study without the trials that have ended, unless `all`. */
enum outcome ask_record(struct link *link, const char *id, bool all, cJSON **record, struct scree_error *err);

/* Whether a job in that state has ended for good. */
bool state_ended(const char *state);

#endif
