/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree ping`: whether a daemon is there, and which. */
#include <stdio.h>

#include "link.h"
#include "output.h"
#include "verbs.h"

static void print_pong(const cJSON *pong)
{
    char uptime[TEXT_MAX];
    const char *const names[] = {"version", "protocol", "isa", "data_dir", "stream_endpoint", "events_endpoint"};
    const cJSON *state;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const char *text = json_text(pong, names[k]);
        printf("%-16s ", names[k]);
        put_clean(stdout, text ? text : "-");
        putchar('\n');
    }
    printf("%-16s %.0f\n%-16s %s\n%-16s %.0f\n%-16s", "pid", json_number(pong, "pid", 0), "up",
           text_duration(json_number(pong, "uptime_s", 0), uptime), "workers", json_number(pong, "workers", 0), "jobs");
    cJSON_ArrayForEach(state, json_get(pong, "jobs"))
    {
        if (cJSON_IsNumber(state) && state->valuedouble > 0) {
            printf(" %.0f ", state->valuedouble);
            put_clean(stdout, state->string);
        }
    }
    char rate[TEXT_MAX], space[TEXT_MAX], used[TEXT_MAX], left[TEXT_MAX];
    const cJSON *memory = json_get(pong, "memory"), *disk = json_get(pong, "disk");
    printf("\n%-16s %s\n%-16s %s used, %s available\n%-16s %s free\n", "rate",
           text_rate(json_number(pong, "grain_steps_per_s", 0), rate), "memory",
           text_bytes(json_number(memory, "used_bytes", 0), used), text_bytes(json_number(memory, "available_bytes", 0), left),
           "disk", text_bytes(json_number(disk, "free_bytes", 0), space));
}

static enum outcome ping_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *pong = NULL;
    enum outcome outcome = link_open_for(arguments, &link, &err);
    if (!outcome && !(outcome = link_ping(link, 5, &pong, &err))) {
        if (arguments->json)
            put_json_line(pong);
        else
            print_pong(pong);
    }
    cJSON_Delete(pong);
    link_close(link);
    return give_up(outcome, &err);
}

const struct verb verb_ping = {
    .name = "ping",
    .synopsis = "",
    .doc = "whether a daemon answers, and what it says of itself",
    .help = "Exits with 69 if none does within 5 s.\n"
            "\n"
            "  scree ping && scree submit job.json\n",
    .run = ping_run,
};
