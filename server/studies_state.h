/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of the studies share: which there are (studies.c), and what changes
 * the state of one (studies_states.c). */
#ifndef SCREE_SERVER_STUDIES_STATE_H
#define SCREE_SERVER_STUDIES_STATE_H

#include "journal_studies.h"
#include "studies.h"

struct studies {
    const struct config *config;
    struct scheduler *scheduler;
    struct studies_watch watch;
    struct study_log *log;
    struct study **all; // by number, ascending
    size_t count, room, active;
};

/* Writes what follows from the trials, and will again should the journal not take it. */
void studies_enter(struct studies *s, struct study *study, enum job_state state);

/* Cancels what is on its way of a study that is over. */
enum scree_status studies_cancel_trials(struct studies *s, struct study *study, struct scree_error *err);

/* A paused study's trials are paused; those of one that goes on again are resumed, turn by turn, as
 * their pauses may still be on their way: true if one was. Both may be said again. */
void studies_pause_trials(struct studies *s, struct study *study);
bool studies_resume_trials(struct studies *s, struct study *study);

#endif
