/* SPDX-License-Identifier: GPL-3.0-or-later */
/* States of a study:
 *
 *      submit                first trial submitted          nothing left to try
 *   ------------> queued ----------------------> running ------------------------> done | failed
 *                   |                               |
 *                   |------------- pause -----------|--> paused, and its trials with it; resume: back again
 *                   `------------- cancel ----------'--> cancelled, and its trials with it
 *
 * What a study knows, it knows from its trials: the journal keeps its spec, its
 * state and which job is which trial, and the search itself is made anew from how
 * those jobs ended (calibrate/bisect.h). So a restart is no case of its own: the
 * turn after it finds the same trials in the same states and goes on.
 *
 * No trial is lost or run twice by a kill between two commits: the request under
 * which a trial is submitted names study, replica, point and extension
 * ("/s3/0.5.1"), and a scheduler that has such a job answers with it. No client can
 * submit under such a name: none of theirs starts with '/'.
 *
 *   trial's job ends        what happens
 *   bisection, verdict      the point has its answer; perhaps a new round, perhaps others are spared (cancelled)
 *   bisection, undecided    submitted again, twice as long, until extend_to_s; then the point has no answer
 *   root                    the point has its number
 *   failed, cancelled       the point has no answer; a sweep goes on and fails in the end
 *
 * Invariants: at most at_once trials are on their way; an ended study never
 * changes; one that is `done` has every trial (sweep) or every bracket closed. */
#include "studies.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/memory.h"
#include "journal_studies.h"
#include "log.h"
#include "meshes.h"
#include "protocol/frame.h"
#include "requests.h"
#include "studies_state.h"

enum { STUDIES_ACTIVE_MAX = 1000 };

/* ---- one study in memory ---- */

static void free_study(struct study *study)
{
    if (!study)
        return;
    study_plan_free(&study->plan);
    free(study->spec_text);
    free(study->trials);
    free(study->bisects);
    free(study->roots);
    free(study);
}

static enum scree_status keep_study(struct studies *s, struct study *study, struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&s->all, &s->room, s->count + 1, sizeof *s->all, err);
    if (status)
        return status;
    s->all[s->count++] = study;
    s->active += !job_state_ended(study->state);
    return SCREE_OK;
}

static void name_study(struct study *study, int64_t number)
{
    study->number = number;
    snprintf(study->id, sizeof study->id, "s%lld", (long long)number);
}

static struct study *by_number(const struct studies *s, int64_t number)
{
    size_t low = 0, high = s->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (s->all[middle]->number < number)
            low = middle + 1;
        else
            high = middle;
    }
    return low < s->count && s->all[low]->number == number ? s->all[low] : NULL;
}

/* ---- journal ---- */

static enum scree_status load_study(void *context, const struct study_row *row, struct scree_error *err)
{
    struct studies *s = context;
    struct study *study = calloc(1, sizeof *study);
    cJSON *json = NULL;
    enum scree_status status = SCREE_NO_MEMORY;
    if (!study || !(study->spec_text = strdup(row->spec)))
        goto out;
    name_study(study, row->number);
    snprintf(study->request, sizeof study->request, "%s", row->request);
    snprintf(study->build, sizeof study->build, "%s", row->build);
    study->again = row->again;
    study->submitted = row->submitted;
    study->started = row->started;
    study->ended = row->ended;
    study->pause = row->pause;
    study->resumes = row->pause > 0; // a daemon that was killed may have got no further
    study->state = job_state_of(row->state);
    if (*row->error && json_read(row->error, strlen(row->error), "error", &json, NULL) == SCREE_OK)
        error_read(json, &study->error);
    cJSON_Delete(json);
    json = NULL;
    struct scree_error error = {0};
    if (json_read(row->spec, strlen(row->spec), "spec", &json, &error) || study_decode(json, &study->plan, &error) ||
        study->state == JOB_STATES) {
        /* Written by another version: the record stays, the study cannot go on. */
        study_plan_free(&study->plan);
        study->plan = (struct study_plan){.base.scenario = scenario_list[0]};
        if (!job_state_ended(study->state) || study->state == JOB_STATES) {
            study->state = JOB_FAILED;
            study->error = error;
            study->error.status = SCREE_CORRUPT;
        }
    } else {
        study->readable = true;
        if ((status = study_start_searches(study, err)))
            goto out;
    }
    status = keep_study(s, study, err);
out:
    cJSON_Delete(json);
    if (status) {
        free_study(study);
        return status == SCREE_NO_MEMORY ? scree_fail(err, status, NULL, "no memory to load the studies") : status;
    }
    return SCREE_OK;
}

static enum scree_status keep_trial(struct study *study, const struct study_trial *trial, struct scree_error *err)
{
    enum scree_status status =
        memory_grow((void **)&study->trials, &study->trial_room, study->trial_count + 1, sizeof *study->trials, err);
    if (!status)
        study->trials[study->trial_count++] = *trial;
    return status;
}

static enum scree_status load_trial(void *context, const struct trial_row *row, struct scree_error *err)
{
    struct studies *s = context;
    struct study *study = by_number(s, row->study);
    char id[JOB_ID_MAX];
    if (!study || !study->readable || row->replica < 0 || row->replica >= study->plan.spec.replicas || row->point < 0)
        return SCREE_OK;
    snprintf(id, sizeof id, "j%lld", (long long)row->job);
    const struct study_trial trial = {
        .replica = row->replica, .point = row->point, .extension = row->extension, .job = scheduler_find(s->scheduler, id)};
    return keep_trial(study, &trial, err);
}

/* ---- what trials say ---- */

/* Takes the ends that have come, in the order in which trials were submitted: a point thus always stands before its answer. */
static bool take_ends(struct study *study)
{
    bool any = false;
    for (size_t k = study->first_open; k < study->trial_count; k++) {
        struct study_trial *t = &study->trials[k];
        if (t->taken || (t->job && !job_state_ended(t->job->state)))
            continue;
        if (study_is_search(study))
            study_take(study, t);
        t->taken = any = true;
    }
    while (study->first_open < study->trial_count && study->trials[study->first_open].taken)
        study->first_open++;
    return any;
}

static size_t on_their_way(const struct study *study)
{
    size_t count = 0;
    for (size_t k = study->first_open; k < study->trial_count; k++)
        count += !study->trials[k].taken;
    return count;
}

/* Cancels trials that no bracket depends on any more. */
static bool spare_trials(struct studies *s, struct study *study)
{
    bool any = false;
    for (size_t k = study->first_open; study_is_search(study) && k < study->trial_count; k++) {
        struct study_trial *t = &study->trials[k];
        if (t->taken || t->spared || !t->job || study_point_needed(study, t->replica, t->point))
            continue;
        struct scree_error error = {0};
        if (scheduler_cancel(s->scheduler, t->job, &error))
            log_line(LOG_WARNING, "study=%s job=%s cannot be cancelled: %s", study->id, t->job->id, error.message);
        log_line(LOG_INFO, "study=%s job=%s is no longer needed", study->id, t->job->id);
        t->spared = any = true;
    }
    return any;
}

/* ---- what comes next ---- */

/* Submits one trial. SCREE_BUSY: later. */
static enum scree_status launch(struct studies *s, struct study *study, int replica, int point, int extension,
                                const struct job_spec *spec, struct scree_error *err)
{
    char request[72];
    bool reused;
    struct study_trial trial = {.replica = replica, .point = point, .extension = extension};
    snprintf(request, sizeof request, "/%s/%d.%d.%d", study->id, replica, point, extension);
    enum scree_status status = scheduler_submit(s->scheduler, request, spec, study->again, &trial.job, &reused, err);
    if (status)
        return status;
    const struct trial_row row = {
        .study = study->number, .replica = replica, .point = point, .extension = extension, .job = trial.job->number};
    if ((status = study_log_add_trial(s->log, &row, err)) || (status = keep_trial(study, &trial, err)))
        return status;
    if (study->state == JOB_QUEUED) {
        snprintf(study->build, sizeof study->build, "%s", scree_build());
        studies_enter(s, study, JOB_RUNNING);
    }
    return SCREE_OK;
}

/* Submits the next trial of a sweep; *more is false when there is none left. */
static enum scree_status launch_sweep(struct studies *s, struct study *study, bool *more, struct scree_error *err)
{
    struct job_spec spec;
    size_t next = study->trial_count; // trials are submitted in order, one a number
    *more = next < study->plan.trials;
    if (!*more)
        return SCREE_OK;
    enum scree_status status = study_plan_trial(&study->plan, next, &spec, err);
    return status ? status : launch(s, study, 0, (int)next, 0, &spec, err);
}

/* Submits the next trial of a search: of the first replica, the first point that waits for one. */
static enum scree_status launch_search(struct studies *s, struct study *study, bool *more, struct scree_error *err)
{
    for (int r = 0; r < study->plan.spec.replicas; r++)
        for (int p = 0; p < study_point_count(study, r); p++) {
            if (!study_point_waits(study, r, p))
                continue;
            const struct study_trial *last = study_trial_at(study, r, p);
            if (last && !last->taken)
                continue;
            struct job_spec spec;
            double end = last ? study_longer(study, last) : 0;
            enum scree_status status = study_plan_search(&study->plan, study_point_at(study, r, p), (size_t)r, end, &spec, err);
            *more = true;
            return status ? status : launch(s, study, r, p, last ? last->extension + 1 : 0, &spec, err);
        }
    *more = false;
    return SCREE_OK;
}

/* ---- endings ---- */

static void conclude_sweep(struct studies *s, struct study *study)
{
    size_t failed = 0, cancelled = 0, altered = 0;
    const struct job *first = NULL;
    for (size_t k = 0; k < study->trial_count; k++) {
        const struct job *job = study->trials[k].job;
        failed += !job || job->state == JOB_FAILED;
        cancelled += job && job->state == JOB_CANCELLED;
        altered += job && job->state == JOB_DONE && job->altered;
        if (!first && job && (job->state != JOB_DONE || job->altered))
            first = job;
    }
    if (failed + cancelled + altered == 0) {
        studies_enter(s, study, JOB_DONE);
        return;
    }
    scree_fail(&study->error, first && first->report.status ? first->report.status : SCREE_CANCELLED, "",
               "of %zu trials %zu failed, %zu were cancelled and %zu were changed with `set`; the first of them is %s%s%s",
               study->trial_count, failed, cancelled, altered, first ? first->id : "lost",
               first && *first->report.error.message ? ": " : "", first ? first->report.error.message : "");
    studies_enter(s, study, JOB_FAILED);
}

static void conclude(struct studies *s, struct study *study)
{
    if (!study_is_search(study))
        conclude_sweep(s, study);
    else
        studies_enter(s, study, study_explain(study, &study->error) ? JOB_FAILED : JOB_DONE);
}

static bool turn_study(struct studies *s, struct study *study)
{
    bool busy = studies_resume_trials(s, study), more = true;
    while (more) {
        while (take_ends(study))
            busy = true;
        busy |= spare_trials(s, study);
        if (on_their_way(study) >= (size_t)study->plan.spec.at_once)
            return busy;
        struct scree_error error = {0};
        enum scree_status status =
            study_is_search(study) ? launch_search(s, study, &more, &error) : launch_sweep(s, study, &more, &error);
        if (status == SCREE_BUSY)
            return busy; // the queue is full: at another turn
        if (status) {
            study->error = error;
            studies_enter(s, study, JOB_FAILED);
            studies_cancel_trials(s, study, NULL);
            return true;
        }
        busy |= more;
    }
    if (on_their_way(study) == 0)
        conclude(s, study);
    return busy;
}

bool studies_turn(struct studies *s)
{
    bool busy = false;
    for (size_t k = 0; k < s->count && s->active > 0; k++)
        if (!job_state_ended(s->all[k]->state) && s->all[k]->state != JOB_PAUSED) // what ends meanwhile is looked at afterwards
            busy |= turn_study(s, s->all[k]);
    return busy;
}

/* ---- opening and closing ---- */

enum scree_status studies_open(struct studies **out, struct scheduler *scheduler, const struct config *config,
                               const struct studies_watch *watch, struct scree_error *err)
{
    struct studies *s = calloc(1, sizeof *s);
    if (!s)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the studies");
    s->config = config;
    s->scheduler = scheduler;
    s->watch = *watch;
    enum scree_status status = study_log_open(&s->log, scheduler_journal(scheduler), err);
    if (!status)
        status = study_log_load(s->log, load_study, load_trial, s, err);
    if (status) {
        studies_close(s);
        return status;
    }
    for (size_t k = 0; k < s->count; k++) {
        while (s->all[k]->readable && take_ends(s->all[k]))
            ;                                  // searches that have ended are made anew, too: they are shown
        if (job_state_ended(s->all[k]->state)) // by a daemon that was killed before it had cancelled the trials
            studies_cancel_trials(s, s->all[k], NULL);
        else if (s->all[k]->state == JOB_PAUSED)
            studies_pause_trials(s, s->all[k]);
    }
    *out = s;
    return SCREE_OK;
}

void studies_close(struct studies *s)
{
    if (!s)
        return;
    study_log_close(s->log);
    for (size_t k = 0; k < s->count; k++)
        free_study(s->all[k]);
    free(s->all);
    free(s);
}

/* ---- requests ---- */

static struct study *same_study(const struct studies *s, const char *request, const char *text)
{
    for (size_t k = s->count; k-- > 0;) {
        struct study *study = s->all[k];
        if (request && strcmp(study->request, request) == 0)
            return study;
        if (text && study->state == JOB_DONE && strcmp(study->build, scree_build()) == 0 && strcmp(study->spec_text, text) == 0)
            return study;
    }
    return NULL;
}

/* Decodes, settles what depends on this daemon, checks every trial. */
static enum scree_status make_study(struct studies *s, const cJSON *json, struct study *study, struct scree_error *err)
{
    enum scree_status status = study_decode(json, &study->plan, err);
    study->readable = true;
    if (status || (status = study_plan_check(&study->plan, requests_memory(), meshes_check_job, s->config, NULL, err)))
        return status;
    if (study->plan.spec.at_once == 0)
        study->plan.spec.at_once = s->config->workers;
    cJSON *resolved = study_encode(&study->plan);
    study->spec_text = resolved ? json_print(resolved, false) : NULL;
    cJSON_Delete(resolved);
    if (!study->spec_text)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    return study_start_searches(study, err);
}

enum scree_status studies_submit(struct studies *s, const char *request, const cJSON *json, bool again, struct study **out,
                                 bool *reused, struct scree_error *err)
{
    *reused = true;
    if ((*out = same_study(s, request, NULL)))
        return SCREE_OK;
    struct study *study = calloc(1, sizeof *study);
    if (!study)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    enum scree_status status = make_study(s, json, study, err);
    if (status || (!again && (*out = same_study(s, NULL, study->spec_text))))
        goto out;
    *reused = false;
    if (s->active >= STUDIES_ACTIVE_MAX) {
        status = scree_fail(err, SCREE_BUSY, "", "%d studies are under way; try again later", STUDIES_ACTIVE_MAX);
        goto out;
    }
    study->state = JOB_QUEUED;
    study->again = again;
    study->submitted = scheduler_unix_now();
    snprintf(study->request, sizeof study->request, "%s", request);
    struct study_row row = {.request = request,
                            .state = "queued",
                            .spec = study->spec_text,
                            .build = "",
                            .error = "",
                            .again = again,
                            .submitted = study->submitted};
    if ((status = study_log_insert(s->log, &row, err)))
        goto out;
    name_study(study, row.number);
    if ((status = keep_study(s, study, err)))
        goto out;
    *out = study;
    study = NULL;
    log_line(LOG_INFO, "study=%s kind=%s state=queued", (*out)->id, study_kinds[(*out)->plan.spec.kind].name);
    s->watch.changed(s->watch.context, *out);
out:
    free_study(study);
    return status;
}

struct study *studies_find(struct studies *s, const char *id)
{
    char *end;
    if (!id || id[0] != 's' || id[1] < '1' || id[1] > '9' || strlen(id) > 18)
        return NULL;
    long long number = strtoll(id + 1, &end, 10);
    return *end ? NULL : by_number(s, number);
}

size_t studies_count(const struct studies *s)
{
    return s->count;
}

struct study *studies_at(struct studies *s, size_t index)
{
    return s->all[index];
}

void studies_parent(const struct job *job, char out[JOB_ID_MAX])
{
    *out = 0;
    if (job->request[0] != '/')
        return;
    size_t length = strcspn(job->request + 1, "/");
    if (length < JOB_ID_MAX)
        snprintf(out, JOB_ID_MAX, "%.*s", (int)length, job->request + 1);
}
