/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What has been done to a job, as a list, and the same done again.
 *
 * A replay is a job with the same spec, the same start and the same commands at
 * the same steps, run from its beginning and never from a checkpoint of the first
 * one; that both end in the same bits is then seen from the hashes of their states. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/job_json.h"
#include "scheduler_state.h"

cJSON *scheduler_steering(const struct scheduler *s, const struct job *job)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t k = 0; list && k < s->command_count; k++) {
        const struct command *c = s->commands[k];
        if (c->job != job)
            continue;
        cJSON *item = cJSON_CreateObject(), *detail = NULL;
        json_put_int(item, "number", c->number);
        json_put_text(item, "op", command_op_word(c->op));
        if (c->step >= 0)
            json_put_int(item, "step", c->step);
        else
            json_put(item, "step", cJSON_CreateNull());
        json_put_bool(item, "void", c->step == COMMAND_VOID);
        json_put_real(item, "at", c->at);
        if (json_read(c->detail, strlen(c->detail), "command", &detail, NULL) == SCREE_OK && json_get(detail, "set"))
            json_put(item, "set", cJSON_DetachItemFromObjectCaseSensitive(detail, "set"));
        cJSON_Delete(detail);
        if (c->made) {
            char id[JOB_ID_MAX];
            snprintf(id, sizeof id, "j%lld", (long long)c->made);
            json_put_text(item, "fork", id);
        }
        cJSON_AddItemToArray(list, item);
    }
    return list;
}

/* ---- replays ---- */

/* What is known of where the job came from, and that it is to be replayed. */
static char *replay_origin(const struct job *job)
{
    unsigned long before = json_lacked();
    cJSON *origin = NULL, *replay;
    if (*job->origin ? json_read(job->origin, strlen(job->origin), "origin", &origin, NULL) : !(origin = cJSON_CreateObject()))
        return NULL;
    cJSON_DeleteItemFromObjectCaseSensitive(origin, "replay");
    replay = cJSON_AddObjectToObject(origin, "replay");
    json_put_text(replay, "job", job->id);
    if (job->state == JOB_CANCELLED)
        json_put_int(replay, "stop_step", (long long)job->report.steps);
    return json_print_whole(origin, before);
}

static enum scree_status copy_commands(struct scheduler *s, const struct job *from, struct job *to, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (size_t k = 0, count = s->command_count; k < count && !status; k++) {
        const struct command *c = s->commands[k];
        char request[72];
        struct command *copy;
        if (c->job != from || c->op != COMMAND_SET || c->step < 0)
            continue;
        snprintf(request, sizeof request, "replay:%s:%lld", to->id, (long long)c->number);
        status = steering_insert(s, request, to, COMMAND_SET, c->detail, c->step, &copy, err);
    }
    return status;
}

enum scree_status scheduler_replay(struct scheduler *s, const char *request, struct job *job, struct job **out,
                                   struct scree_error *err)
{
    for (size_t k = s->count; k-- > 0;)
        if (strcmp(s->jobs[k]->request, request) == 0) {
            *out = s->jobs[k];
            return SCREE_OK;
        }
    if (!job_state_ended(job->state) || !job->report.hashed)
        return scree_fail(err, SCREE_CONFLICT, "job", "%s is %s and has no final state to compare a replay with", job->id,
                          job_state_word(job->state));
    size_t commands = s->command_count;
    char *origin = replay_origin(job);
    *out = NULL;
    enum scree_status status = origin ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a replay");
    if (!status && !(status = journal_begin(s->journal, err))) {
        if (!(status = scheduler_insert(s, request, &job->base, origin, out, err)))
            status = copy_commands(s, job, *out, err);
        if ((status = journal_end(s->journal, status, err))) {
            while (s->command_count > commands)
                steering_forget(s, s->commands[s->command_count - 1]);
            if (*out)
                scheduler_forget(s, *out);
        } else {
            steering_refresh(s, *out);
            scheduler_changed(s, *out, EVENT_STATE);
        }
    }
    free(origin);
    return status;
}
