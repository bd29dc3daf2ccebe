/* SPDX-License-Identifier: GPL-3.0-or-later */
/* study_decode: a study that is accepted has trials that are jobs within their
 * ranges, and its resolved spec is the same study again. */
#include "check.h"
#include "protocol/study_json.h"

static char *resolved_text(const struct study_plan *plan)
{
    cJSON *json = study_encode(plan);
    char *text = json ? json_print(json, false) : NULL;
    CHECK(text != NULL);
    cJSON_Delete(json);
    return text;
}

static void check_trials(const struct study_plan *plan)
{
    struct scree_error err = {0};
    struct job_spec job;
    enum scree_status status;
    for (size_t k = 0; k < plan->trials && k < 8; k++) { // values were tried one by one: what is wrong now is their company
        status = study_plan_trial(plan, k * (plan->trials - 1) / 7, &job, &err);
        CHECK(status == SCREE_OK || status == SCREE_INVALID);
    }
    if (plan->spec.kind != STUDY_SWEEP)
        CHECK(study_plan_search(plan, plan->spec.low, 0, 0, &job, &err) == SCREE_OK);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cJSON *json = NULL, *read = NULL;
    struct study_plan plan = {0}, again = {0};
    struct scree_error err = {0};
    if (json_read((const char *)data, size, "fuzz", &json, NULL))
        return 0;
    if (study_decode(json, &plan, &err)) {
        check_refusal(&err);
    } else {
        char *text = resolved_text(&plan);
        CHECK(json_read(text, strlen(text), "resolved", &read, &err) == SCREE_OK || strlen(text) > JSON_BYTES_MAX);
        if (read) {
            CHECK(study_decode(read, &again, &err) == SCREE_OK);
            char *second = resolved_text(&again);
            CHECK(strcmp(text, second) == 0);
            free(second);
        }
        check_trials(&plan);
        free(text);
    }
    study_plan_free(&plan);
    study_plan_free(&again);
    cJSON_Delete(json);
    cJSON_Delete(read);
    return 0;
}
