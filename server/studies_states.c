/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How a study comes into another state: by what its trials came to, or because
 * somebody cancels, pauses or resumes it. The journal has it first, its trials follow. */
#include <stdio.h>
#include <stdlib.h>

#include "log.h"
#include "protocol/frame.h"
#include "studies_state.h"

/* Writes a study in another state, with the command that brought it there if `request`: *number is 0, and nothing is
 * written, when that request was made before. */
static enum scree_status write_state(struct studies *s, const struct study *study, enum job_state state, double now,
                                     const char *request, int64_t *number, struct scree_error *err)
{
    char *text = NULL;
    if (state == JOB_FAILED) {
        cJSON *json = error_json(scree_status_word(study->error.status), &study->error);
        text = json ? json_print(json, false) : NULL;
        cJSON_Delete(json);
    }
    const struct study_row row = {.number = study->number,
                                  .state = job_state_word(state),
                                  .build = study->build,
                                  .error = text ? text : "",
                                  .started = study->started > 0 || state != JOB_RUNNING ? study->started : now,
                                  .ended = job_state_ended(state) ? now : 0};
    struct journal *journal = scheduler_journal(s->scheduler);
    enum scree_status status = journal_begin(journal, err);
    if (!status) {
        if (request)
            status = study_log_add_command(s->log, request, study->number, state == JOB_PAUSED ? "pause" : "resume", number, err);
        if (!status && (!request || *number > 0))
            status = study_log_update(s->log, &row, err);
        status = journal_end(journal, status, err);
    }
    free(text);
    return status;
}

static void set_state(struct studies *s, struct study *study, enum job_state state, double now)
{
    s->active -= !job_state_ended(study->state) && job_state_ended(state);
    study->state = state;
    if (state == JOB_RUNNING && study->started == 0)
        study->started = now;
    if (job_state_ended(state))
        study->ended = now;
    log_line(LOG_INFO, "study=%s kind=%s state=%s%s%s", study->id, study_kinds[study->plan.spec.kind].name, job_state_word(state),
             state == JOB_FAILED ? " error=" : "", state == JOB_FAILED ? study->error.message : "");
    s->watch.changed(s->watch.context, study);
}

void studies_enter(struct studies *s, struct study *study, enum job_state state)
{
    struct scree_error error = {0};
    double now = scheduler_unix_now();
    if (write_state(s, study, state, now, NULL, NULL, &error))
        log_line(LOG_ERROR, "study=%s state=%s %s", study->id, job_state_word(state), error.message);
    set_state(s, study, state, now);
}

enum scree_status studies_cancel_trials(struct studies *s, struct study *study, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (size_t k = study->first_open; k < study->trial_count && !status; k++)
        if (study->trials[k].job && !job_state_ended(study->trials[k].job->state))
            status = scheduler_cancel(s->scheduler, study->trials[k].job, err);
    return status;
}

/* Each trial rests, and goes on, once for each pause of its study: what somebody does with one by hand stands. */
static void trial_request(const struct study *study, const struct job *job, enum command_op op, char *out, size_t size)
{
    snprintf(out, size, "/%s/%s.%lld/%s", study->id, command_op_word(op), (long long)study->pause, job->id);
}

void studies_pause_trials(struct studies *s, struct study *study)
{
    for (size_t k = study->first_open; k < study->trial_count; k++) {
        struct job *job = study->trials[k].job;
        struct scree_error error = {0};
        char request[JOB_REQUEST_MAX];
        if (!job || job_state_ended(job->state))
            continue;
        trial_request(study, job, COMMAND_PAUSE, request, sizeof request);
        if (scheduler_steer(s->scheduler, request, job, COMMAND_PAUSE, "{}", 0, &error)) // at its end
            log_line(LOG_INFO, "study=%s job=%s %s", study->id, job->id, error.message);
    }
}

bool studies_resume_trials(struct studies *s, struct study *study)
{
    bool any = false, left = false;
    for (size_t k = study->first_open; study->resumes && k < study->trial_count; k++) {
        struct job *job = study->trials[k].job;
        struct scree_error error = {0};
        char paused[JOB_REQUEST_MAX], resumed[JOB_REQUEST_MAX];
        if (!job || job_state_ended(job->state))
            continue;
        trial_request(study, job, COMMAND_PAUSE, paused, sizeof paused);
        trial_request(study, job, COMMAND_RESUME, resumed, sizeof resumed);
        if (!scheduler_knows(s->scheduler, paused) || scheduler_knows(s->scheduler, resumed))
            continue;
        if (job->state != JOB_PAUSED) { // its pause is still on its way
            left = true;
        } else if (scheduler_steer(s->scheduler, resumed, job, COMMAND_RESUME, "{}", 0, &error)) {
            log_line(LOG_ERROR, "study=%s job=%s %s", study->id, job->id, error.message);
            left = true;
        } else {
            any = true;
        }
    }
    study->resumes = left;
    return any;
}

enum scree_status studies_cancel(struct studies *s, struct study *study, struct scree_error *err)
{
    if (job_state_ended(study->state))
        return SCREE_OK;
    double now = scheduler_unix_now();
    enum scree_status status = write_state(s, study, JOB_CANCELLED, now, NULL, NULL, err);
    if (status)
        return status;
    set_state(s, study, JOB_CANCELLED, now); // first, or a daemon that ends here would go on with it
    return studies_cancel_trials(s, study, err);
}

enum scree_status studies_steer(struct studies *s, const char *request, struct study *study, enum command_op op,
                                struct scree_error *err)
{
    if (job_state_ended(study->state))
        return scree_fail(err, SCREE_CONFLICT, "job", "%s is %s: it cannot be steered any more", study->id,
                          job_state_word(study->state));
    if ((op == COMMAND_PAUSE) == (study->state == JOB_PAUSED))
        return SCREE_OK;
    enum job_state state = op == COMMAND_PAUSE ? JOB_PAUSED : study->trial_count > 0 ? JOB_RUNNING : JOB_QUEUED;
    int64_t number = 0;
    double now = scheduler_unix_now();
    enum scree_status status = write_state(s, study, state, now, request, &number, err);
    if (status || number == 0)
        return status;
    if (op == COMMAND_PAUSE)
        study->pause = number;
    study->resumes = op == COMMAND_RESUME; // at the next turn
    set_state(s, study, state, now);
    if (op == COMMAND_PAUSE)
        studies_pause_trials(s, study); // the journal has it: a daemon that ends here does it when it starts again
    return SCREE_OK;
}
