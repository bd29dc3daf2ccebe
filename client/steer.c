/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See steer.h. */
#include "steer.h"

#include <stdio.h>

#include "output.h"

enum outcome steer(struct link *link, const char *op, const char *job, cJSON *set, cJSON **result, struct scree_error *err)
{
    cJSON *body = cJSON_CreateObject();
    if (!body) {
        cJSON_Delete(set);
        return outcome_fail(err, OUTCOME_FAILED, "no memory");
    }
    json_put_text(body, "job", job);
    if (set)
        json_put(body, "set", set);
    return link_request_slow(link, op, false, body, result, err);
}

const char *steer_when(const cJSON *result, char *out, size_t size)
{
    double step = json_number(result, "step", -1);
    if (step >= 0)
        snprintf(out, size, "step %.0f", step);
    else
        snprintf(out, size, "when the job goes on");
    return out;
}

enum outcome steer_each(const struct arguments *arguments, const char *op)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    enum outcome outcome = link_open_for(arguments, &link, &err);
    for (int k = 0; k < arguments->word_count && !outcome; k++) {
        cJSON *result = NULL;
        if ((outcome = steer(link, op, arguments->words[k], NULL, &result, &err)))
            break;
        const char *state = json_text(result, "state");
        if (arguments->json) {
            put_json_line(result);
        } else {
            printf("%s ", arguments->words[k]);
            put_clean(stdout, state ? state : "?");
            putchar('\n');
        }
        cJSON_Delete(result);
    }
    link_close(link);
    return give_up(outcome, &err);
}
