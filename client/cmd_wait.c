/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree wait`: until jobs have ended, for scripts. */
#include <stdio.h>

#include "follow.h"
#include "output.h"
#include "signals.h"
#include "summary.h"
#include "verbs.h"

enum { FIRST_MS = 50, SLOWEST_MS = 1000 };

/* The record of a job that has ended. A daemon that is gone is waited for as `watch` does. */
static enum outcome wait_for(struct link *link, const char *job, cJSON **record, struct scree_error *err)
{
    double gone = 0;
    int pause = FIRST_MS;
    for (;;) {
        enum outcome outcome = ask_record(link, job, false, record, err);
        if (outcome == OUTCOME_UNREACHABLE && (gone == 0 || now_s() - gone < FOLLOW_PATIENCE_S)) {
            if (gone == 0) {
                gone = now_s();
                say("the daemon is gone; waiting for it (at most %d s)", FOLLOW_PATIENCE_S);
            }
            wait_ms(500);
            continue;
        }
        if (outcome)
            return outcome;
        gone = 0;
        if (state_ended(json_text(*record, "state"))) {
            cJSON *whole = NULL;
            if (is_study_id(job) && ask_record(link, job, true, &whole, err) == OUTCOME_DONE) {
                cJSON_Delete(*record);
                *record = whole;
            }
            return OUTCOME_DONE;
        }
        cJSON_Delete(*record);
        *record = NULL;
        wait_ms(pause);
        pause = pause * 3 / 2 < SLOWEST_MS ? pause * 3 / 2 : SLOWEST_MS;
    }
}

/* A failed job outweighs a cancelled one, and that one a done one. */
static enum outcome worse(enum outcome a, enum outcome b)
{
    if (a == OUTCOME_FAILED || b == OUTCOME_FAILED)
        return OUTCOME_FAILED;
    return a == OUTCOME_DONE ? b : a;
}

static enum outcome wait_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    enum outcome worst = OUTCOME_DONE, outcome = link_open_for(arguments, &link, &err);
    for (int k = 0; k < arguments->word_count && !outcome; k++) {
        cJSON *record = NULL;
        if ((outcome = wait_for(link, arguments->words[k], &record, &err)))
            break;
        const char *state = json_text(record, "state");
        const char *verdict = json_text(record, is_study_id(arguments->words[k]) ? "conclusion" : "verdict");
        worst = worse(worst, outcome_of_state(state));
        if (*summary_error(record))
            say("%s failed: %s", arguments->words[k], summary_error(record));
        if (arguments->json) {
            put_json_line(record);
        } else {
            printf("%s %s %s\n", arguments->words[k], state, verdict ? verdict : "undecided");
            fflush(stdout);
        }
        cJSON_Delete(record);
    }
    link_close(link);
    return outcome ? give_up(outcome, &err) : worst;
}

const struct verb verb_wait = {
    .name = "wait",
    .synopsis = "ID...",
    .doc = "wait until jobs have ended; exits with their outcome",
    .help = "Prints `ID STATE VERDICT` for each (of a study what it came to), with --json its record. Exits with 0 if all are "
            "done, 1 if one failed,\n"
            "3 if one was cancelled and none failed, 69 if the daemon is gone for 10 s.\n"
            "\n"
            "  scree wait j17 && scree fetch j17\n",
    .words_min = 1,
    .words_max = -1,
    .run = wait_run,
};
