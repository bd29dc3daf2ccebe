/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How the scheduler comes up from its journal, and goes down. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/memory.h"
#include "outcome.h"
#include "protocol/job_json.h"
#include "scheduler_state.h"

static enum scree_status keep_job(struct scheduler *s, struct job *job, struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&s->jobs, &s->room, s->count + 1, sizeof *s->jobs, err);
    if (!status)
        s->jobs[s->count++] = job;
    return status;
}

static enum scree_status load_job(void *context, const struct journal_row *row, struct scree_error *err)
{
    struct scheduler *s = context;
    struct job *job = calloc(1, sizeof *job);
    cJSON *json = NULL;
    enum scree_status status = SCREE_NO_MEMORY;
    if (!job || !(job->spec_text = strdup(row->spec)) || !(job->origin = strdup(row->origin)))
        goto out;
    scheduler_name_job(job, row->number);
    snprintf(job->request, sizeof job->request, "%s", row->request);
    snprintf(job->build, sizeof job->build, "%s", row->build);
    job->submitted = row->submitted;
    job->started = row->started;
    job->ended = row->ended;
    outcome_read(row->outcome, &job->report);
    job->state = job_state_of(row->state);
    if (job->state == JOB_RUNNING || job->state == JOB_HELD || job->state == JOB_STATES)
        job->state = JOB_QUEUED; // it goes on from its checkpoint and comes to the same chunks
    struct scree_error error = {0};
    if (json_read(row->spec, strlen(row->spec), "spec", &json, &error) || job_decode(json, &job->base, &error)) {
        /* Written by another version: the record stays, the job cannot run. */
        job_defaults(&job->base, scenario_list[0]);
        if (!job_state_ended(job->state)) {
            job->state = JOB_FAILED;
            job->report.status = SCREE_CORRUPT;
            job->report.error = error;
        }
    }
    job->spec = job->base;
    s->queued += job->state == JOB_QUEUED;
    status = keep_job(s, job, err);
out:
    cJSON_Delete(json);
    if (status) {
        scheduler_free_job(job);
        return status == SCREE_NO_MEMORY ? scree_fail(err, status, NULL, "no memory to load the journal") : status;
    }
    return SCREE_OK;
}

static enum scree_status lock_data(struct scheduler *s, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 64];
    snprintf(path, sizeof path, "%s/lock", s->config->data);
    s->lock_fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (s->lock_fd < 0)
        return scree_fail(err, SCREE_IO, "data", "cannot write in the data directory %s: %s", s->config->data, strerror(errno));
    if (flock(s->lock_fd, LOCK_EX | LOCK_NB) != 0)
        return scree_fail(err, SCREE_BUSY, "data", "another screed works in the data directory %s", s->config->data);
    return SCREE_OK;
}

enum scree_status scheduler_open(struct scheduler **out, const struct config *config, int wake_fd,
                                 const struct scheduler_watch *watch, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 64];
    struct scheduler *s = calloc(1, sizeof *s);
    if (!s)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the scheduler");
    s->config = config;
    s->watch = *watch;
    s->lock_fd = -1;
    snprintf(path, sizeof path, "%s/jobs", config->data);
    enum scree_status status;
    if ((status = scheduler_folder(path, err)) || (status = lock_data(s, err)))
        goto out;
    snprintf(path, sizeof path, "%s/journal.db", config->data);
    if ((status = journal_open(&s->journal, path, err)) || (status = journal_load(s->journal, load_job, s, err)) ||
        (status = steering_load(s, err)) || (status = recorder_start(&s->recorder, wake_fd, err)))
        goto out;
    status = workers_start(&s->workers, config->workers, wake_fd, err);
out:
    if (status)
        scheduler_close(s);
    else
        *out = s;
    return status;
}

void scheduler_close(struct scheduler *s)
{
    if (!s)
        return;
    s->closing = true;
    for (size_t k = 0; k < s->count; k++)
        scheduler_order(s->jobs[k], RUN_STOP); // a cancelled one stays so
    workers_stop(s->workers);
    if (s->workers)
        scheduler_turn(s); // results of runs that had just ended are asked for
    recorder_finish(s->recorder);
    if (s->recorder)
        scheduler_look_at_recorder(s); // and those jobs end
    recorder_free(s->recorder);
    journal_close(s->journal);
    for (size_t k = 0; k < s->count; k++)
        scheduler_free_job(s->jobs[k]);
    for (size_t k = 0; k < s->command_count; k++) {
        free(s->commands[k]->detail);
        free(s->commands[k]);
    }
    free(s->commands);
    free(s->jobs);
    if (s->lock_fd >= 0)
        close(s->lock_fd);
    free(s);
}
