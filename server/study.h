/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A study as the daemon holds it: shared by what drives it (studies.c) and what
 * shows it (study_view.c). */
#ifndef SCREE_SERVER_STUDY_H
#define SCREE_SERVER_STUDY_H

#include "calibrate/bisect.h"
#include "calibrate/root.h"
#include "job.h"
#include "protocol/study_json.h"

/* One job of a study. */
struct study_trial {
    int replica, point, extension; // a sweep's trial: 0, its number, 0
    struct job *job;               // NULL: the journal does not have it any more
    bool taken;                    // its end has been looked at
    bool spared;                   // cancelled because nothing depends on it any more
};

struct study {
    int64_t number;
    char id[JOB_ID_MAX];
    char request[JOB_REQUEST_MAX]; // of its submit; NAME/ before it if a user from the network sent it
    enum job_state state;          // queued, running, paused, done, failed or cancelled
    int64_t pause;                 // number of its newest command to pause, 0: none
    bool resumes;                  // trials of that pause may still have to go on
    char *spec_text;               // resolved, one line; owned
    struct study_plan plan;
    bool again, readable; // readable: this version understands the spec
    double submitted, started, ended;
    char build[96];
    struct scree_error error; // of a failed one
    struct study_trial *trials;
    size_t trial_count, trial_room;
    size_t first_open; // trials before it have been taken
    /* One search a replica; NULL for other kinds. */
    struct bisect *bisects;
    struct root *roots;
};

/* How the job of a trial answers: "raise", "lower", "undecided", "failed", ... */
const char *study_answer_word(const struct study *study, const struct study_trial *trial);

/* What a search came to, a word: "searching", "found", "same_ends", "reversed", "stuck". */
const char *study_conclusion(const struct study *study, size_t replica);
bool study_found(const struct study *study, size_t replica, double *value, double *low, double *high);
static inline bool study_is_search(const struct study *study)
{
    return study->plan.spec.kind != STUDY_SWEEP;
}

/* Makes the searches of a study that has none yet, one a replica; nothing for a sweep. */
enum scree_status study_start_searches(struct study *study, struct scree_error *err);

/* Gives the end of a trial's job to its search. An undecided one leaves its point waiting for a longer trial. */
void study_take(struct study *study, const struct study_trial *trial);

/* Points of a search: how many there are by now, where, whether the answer still depends on one, whether it has none yet. */
int study_point_count(const struct study *study, int replica);
double study_point_at(const struct study *study, int replica, int point);
bool study_point_needed(const struct study *study, int replica, int point);
bool study_point_waits(const struct study *study, int replica, int point);

/* time.end_s of the trial that follows an undecided one; 0 when that one was at the limit. */
double study_longer(const struct study *study, const struct study_trial *trial);

/* The last trial of a point, NULL if there is none. */
const struct study_trial *study_trial_at(const struct study *study, int replica, int point);

/* Fills *err with why a search that has ended found nothing; false when all its replicas did. */
bool study_explain(const struct study *study, struct scree_error *err);

/* Verdicts that contradict each other within a replica, "" if none. */
void study_contradiction(const struct study *study, size_t replica, char *out, size_t size);

#endif
