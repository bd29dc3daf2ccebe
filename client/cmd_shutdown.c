/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree shutdown`: ends the daemon. */
#include "link.h"
#include "output.h"
#include "verbs.h"

static enum outcome shutdown_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *body = NULL, *result = NULL;
    enum outcome outcome = link_open_for(arguments, &link, &err);
    if (!outcome) {
        body = cJSON_CreateObject();
        if (body)
            json_put_bool(body, "now", arguments_flag(arguments, "--now"));
        outcome = link_request(link, "shutdown", body, &result, &err);
    }
    if (!outcome && arguments->json)
        put_json_line(result);
    else if (!outcome)
        say("the daemon is ending; its running jobs go on when it is started again");
    cJSON_Delete(result);
    link_close(link);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--now", NULL};

const struct verb verb_shutdown = {
    .name = "shutdown",
    .synopsis = "[--now]",
    .doc = "end the daemon; its jobs go on when it is started again",
    .help = "The daemon finishes what it must and ends; with --now it does not wait for anything that can be redone.\n"
            "\n"
            "  scree shutdown\n",
    .options = options,
    .run = shutdown_run,
};
