/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What commands make of a job's spec. */
#include <stdlib.h>
#include <string.h>

#include "protocol/job_json.h"
#include "scheduler_state.h"

/* A job as a tree that can be changed and decoded: job_encode's own holds its numbers as text. */
static enum scree_status tree_of(const struct job_spec *job, cJSON **out, struct scree_error *err)
{
    cJSON *json = job_encode(job);
    char *text = json ? json_print(json, false) : NULL;
    enum scree_status status =
        text ? json_read(text, strlen(text), "spec", out, err) : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a job");
    cJSON_Delete(json);
    free(text);
    return status;
}

/* Adds the assignments of a command's detail to a job's JSON. */
static enum scree_status assign(cJSON *spec, const char *detail, struct scree_error *err)
{
    cJSON *json = NULL;
    const cJSON *item;
    enum scree_status status = json_read(detail, strlen(detail), "command", &json, err);
    cJSON_ArrayForEach(item, json_get(json, "set")) if (!status && cJSON_IsString(item))
    {
        status = job_json_set(spec, item->valuestring, err);
    }
    cJSON_Delete(json);
    return status;
}

enum scree_status steering_change(const struct job_spec *from, const char *detail, struct job_spec *to, struct scree_error *err)
{
    cJSON *spec = NULL;
    enum scree_status status;
    if (!(status = tree_of(from, &spec, err)) && !(status = assign(spec, detail, err)))
        status = job_decode(spec, to, err);
    cJSON_Delete(spec);
    return status;
}

enum scree_status steering_compose(const struct scheduler *s, const struct job *job, int64_t last, bool pending,
                                   struct job_spec *out, struct scree_error *err)
{
    cJSON *spec = NULL;
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < s->command_count && !status; k++) {
        const struct command *c = s->commands[k];
        bool counts = c->step >= 0 ? c->number <= last : pending && c->step == COMMAND_PENDING;
        if (c->job != job || c->op != COMMAND_SET || !counts)
            continue;
        if (spec || !(status = tree_of(&job->base, &spec, err)))
            status = assign(spec, c->detail, err);
    }
    if (!status && spec)
        status = job_decode(spec, out, err);
    else if (!status)
        *out = job->base;
    cJSON_Delete(spec);
    return status;
}
