/* SPDX-License-Identifier: GPL-3.0-or-later */
/* job_decode: a job that is accepted is within its ranges, has a cost, and comes
 * back from its resolved spec to the bit. The first line, if it has a "=", goes
 * through --set on top of the rest. */
#include "check.h"
#include "protocol/job_json.h"

static void check_round_trip(const struct job_spec *job)
{
    struct job_spec back;
    struct scree_error err = {0};
    cJSON *resolved = job_encode(job), *read = NULL;
    char *text = json_print(resolved, false);
    CHECK(resolved && text);
    CHECK(json_read(text, strlen(text), "resolved", &read, &err) == SCREE_OK);
    CHECK(job_decode(read, &back, &err) == SCREE_OK);
    CHECK(memcmp(job, &back, sizeof back) == 0);
    free(text);
    cJSON_Delete(resolved);
    cJSON_Delete(read);
}

static void decode(const cJSON *json)
{
    struct job_spec job;
    struct scree_error err = {0};
    if (job_decode(json, &job, &err)) {
        check_refusal(&err);
        return;
    }
    struct job_cost cost = job.scenario->cost(&job);
    CHECK(cost.moving >= 0 && cost.fixed >= 0 && cost.steps >= 0 && cost.bytes >= 0);
    enum scree_status status = job_check(&job, 1e9, &err);
    CHECK(status == SCREE_OK || status == SCREE_INVALID || status == SCREE_NO_MEMORY);
    if (status)
        check_text(err.message);
    else
        CHECK(cost.moving >= (job.scenario->kind == SCENARIO_CALCULATION ? 0 : 1) && cost.bytes > 0);
    check_round_trip(&job);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cJSON *json = NULL;
    const uint8_t *line = size ? memchr(data, '\n', size) : NULL;
    if (json_read((const char *)data, size, "fuzz", &json, NULL) == SCREE_OK) {
        decode(json);
    } else if (line && json_read((const char *)line, size - (size_t)(line - data), "fuzz", &json, NULL) == SCREE_OK) {
        struct scree_error err = {0};
        char *assignment = strndup((const char *)data, (size_t)(line - data));
        CHECK(assignment != NULL);
        if (job_json_set(json, assignment, &err))
            check_refusal(&err);
        else
            decode(json);
        free(assignment);
    }
    cJSON_Delete(json);
    return 0;
}
