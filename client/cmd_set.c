/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree set`: changes steerable values of a job while it runs. */
#include <stdio.h>

#include "output.h"
#include "steer.h"
#include "verbs.h"

static enum outcome set_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *set = cJSON_CreateArray(), *result = NULL;
    char when[64];
    for (int k = 1; set && k < arguments->word_count; k++)
        cJSON_AddItemToArray(set, cJSON_CreateString(arguments->words[k]));
    enum outcome outcome = link_open_for(arguments, &link, &err);
    if (outcome)
        cJSON_Delete(set);
    else
        outcome = steer(link, "set", arguments->words[0], set, &result, &err);
    if (!outcome && arguments->json)
        put_json_line(result);
    else if (!outcome)
        printf("%s %s\n", arguments->words[0], steer_when(result, when, sizeof when));
    cJSON_Delete(result);
    link_close(link);
    return give_up(outcome, &err);
}

const struct verb verb_set = {
    .name = "set",
    .synopsis = "ID path=value...",
    .doc = "change values of a job while it runs",
    .help = "Values that `scree scenarios NAME` marks as steerable: slope, gravity, friction, record rates, time.end_s,\n"
            "stop.when, priority. All values of one call change together, between two steps; the step is printed and kept\n"
            "in the journal, so that the run can be made again to the bit (`scree replay`). A job that is not running\n"
            "takes them up when it goes on. Exit code 2: not steerable, out of range, or the job has ended.\n"
            "\n"
            "  scree set j17 params.slope_deg=24\n"
            "  scree set j17 time.end_s=10 stop.when='[]'\n",
    .words_min = 2,
    .words_max = -1,
    .run = set_run,
};
