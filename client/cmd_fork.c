/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree fork`: a new job that continues another one's state. */
#include <stdio.h>
#include <string.h>

#include "output.h"
#include "steer.h"
#include "verbs.h"

static enum outcome fork_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *set = cJSON_CreateArray(), *result = NULL;
    char when[64];
    for (int k = 0; set && k < arguments->option_count; k++)
        if (strcmp(arguments->options[k].name, "--set") == 0)
            cJSON_AddItemToArray(set, cJSON_CreateString(arguments->options[k].value));
    enum outcome outcome = link_open_for(arguments, &link, &err);
    if (outcome)
        cJSON_Delete(set);
    else
        outcome = steer(link, "fork", arguments->words[0], set, &result, &err);
    const char *child = outcome ? NULL : json_text(result, "fork");
    if (!outcome && arguments->json) {
        put_json_line(result);
    } else if (child) {
        put_clean(stdout, child);
        putchar('\n');
        say("%s goes on from %s of %s", child, steer_when(result, when, sizeof when), arguments->words[0]);
    } else if (!outcome) {
        say("%s is not running yet: the fork is made when it is; `scree show %s` names it then", arguments->words[0],
            arguments->words[0]);
    }
    cJSON_Delete(result);
    link_close(link);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--set=*", NULL};

const struct verb verb_fork = {
    .name = "fork",
    .synopsis = "ID [--set path=value]...",
    .doc = "a new job that continues this one's state with something changed",
    .help = "Both go on; the first one is held up by no more than the copy. The new job's streams start at chunk 0 where it\n"
            "begins; its clock goes on. --set takes what `scree set` takes. Prints the new job's id.\n"
            "\n"
            "  scree fork j17 --set params.slope_deg=22\n"
            "  scree wait $(scree fork j17 --set material.mu_t=0.3)\n",
    .options = options,
    .words_min = 1,
    .words_max = 1,
    .run = fork_run,
};
