/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree replay`: runs a job again from its journal and compares the ends. */
#include <stdio.h>

#include "output.h"
#include "follow.h"
#include "signals.h"
#include "steer.h"
#include "summary.h"
#include "verbs.h"

enum { LOOK_MS = 200 };

static enum outcome wait_for_end(struct link *link, const char *job, cJSON **record, struct scree_error *err)
{
    for (;;) {
        enum outcome outcome = link_job(link, "show", job, record, err);
        if (outcome || state_ended(json_text(*record, "state")))
            return outcome;
        cJSON_Delete(*record);
        *record = NULL;
        wait_ms(LOOK_MS);
    }
}

/* How many commands of a record have taken effect. */
static int effective(const cJSON *record)
{
    const cJSON *command;
    int count = 0;
    cJSON_ArrayForEach(command, json_get(record, "steering")) count += cJSON_IsNumber(json_get(command, "step"));
    return count;
}

static enum outcome report(const char *job, const cJSON *record, bool json)
{
    const cJSON *replay = json_get(json_get(record, "origin"), "replay");
    const char *state = json_text(record, "state"), *first = json_text(replay, "hash"), *second = json_text(record, "hash");
    bool same = json_bool(replay, "same", false);
    if (json)
        put_json_line(record);
    else if (first && second)
        printf("%s replayed as %s: %.0f steps, %d changes, state %s and %s: %s\n", job, json_text(record, "id"),
               json_number(record, "steps", 0), effective(record), first, second, same ? "the same bits" : "DIFFERENT");
    else
        say("the replay of %s is %s: %s", job, state ? state : "?", summary_error(record));
    return same ? OUTCOME_DONE : OUTCOME_FAILED;
}

static enum outcome replay_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *result = NULL, *record = NULL;
    const char *job = arguments->words[0];
    enum outcome verdict = OUTCOME_DONE, outcome = link_open_for(arguments, &link, &err);
    if (!outcome && !(outcome = link_job(link, "replay", job, &result, &err))) {
        const char *replay = json_text(result, "job");
        if (!(outcome = wait_for_end(link, replay ? replay : "", &record, &err)))
            verdict = report(job, record, arguments->json);
    }
    cJSON_Delete(record);
    cJSON_Delete(result);
    link_close(link);
    return outcome ? give_up(outcome, &err) : verdict;
}

const struct verb verb_replay = {
    .name = "replay",
    .synopsis = "ID",
    .doc = "run an ended job again from its journal and compare the last states",
    .help = "A new job with the same spec, the same start and the same commands at the same steps is run from the\n"
            "beginning. Both end in the same state to the bit, or there is a defect. Exits with 0 if they do.\n"
            "\n"
            "  scree replay j17\n",
    .words_min = 1,
    .words_max = 1,
    .run = replay_run,
};
