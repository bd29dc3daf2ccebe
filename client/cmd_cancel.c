/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree cancel`: stops jobs; what they have recorded stays. */
#include <stdio.h>

#include "link.h"
#include "output.h"
#include "verbs.h"

static enum outcome cancel_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    enum outcome outcome = link_open_for(arguments, &link, &err);
    for (int k = 0; k < arguments->word_count && !outcome; k++) {
        cJSON *result = NULL;
        if ((outcome = link_job(link, "cancel", arguments->words[k], &result, &err)))
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

const struct verb verb_cancel = {
    .name = "cancel",
    .synopsis = "ID...",
    .doc = "stop jobs and studies; what they have recorded so far stays",
    .help = "A running job stops at the end of its slice, a queued one never starts, an ended one stays as it is.\n"
            "A study takes its trials with it. Prints `ID STATE`.\n"
            "\n"
            "  scree cancel j17 j18\n",
    .words_min = 1,
    .words_max = -1,
    .run = cancel_run,
};
