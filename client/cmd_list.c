/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree list`: the daemon's studies and jobs, newest first. */
#include <stdio.h>
#include <string.h>

#include "link.h"
#include "output.h"
#include "table.h"
#include "verbs.h"

static void add_job(struct table *table, const cJSON *job)
{
    char time[2 * TEXT_MAX], done[TEXT_MAX], end[TEXT_MAX], progress[TEXT_MAX], rate[TEXT_MAX], eta[TEXT_MAX];
    const char *state = json_text(job, "state");
    snprintf(time, sizeof time, "%s / %s s", text_number(json_number(job, "time_s", 0), done),
             text_number(json_number(job, "end_s", 0), end));
    snprintf(progress, sizeof progress, "%.0f %%", 100 * json_number(job, "progress", 0));
    const char *const cells[] = {json_text(job, "id"),
                                 state,
                                 json_text(job, "verdict"),
                                 json_text(job, "scenario"),
                                 time,
                                 progress,
                                 text_rate(json_number(job, "grain_steps_per_s", 0), rate),
                                 text_duration(json_number(job, "eta_s", -1), eta),
                                 json_text(job, "title")};
    table_row(table, cells, colour_of_state(state));
}

static void print_jobs(const cJSON *jobs)
{
    static const char *const headers[] = {"id",        "state", "verdict", "scenario", ">time",
                                          ">progress", ">rate", ">ETA",    "title",    NULL};
    const cJSON *job;
    struct table table;
    table_start(&table, headers);
    cJSON_ArrayForEach(job, jobs) add_job(&table, job);
    table_end(&table, 0);
}

static void print_studies(const cJSON *studies)
{
    static const char *const headers[] = {"id",      "state",     "study", "came to", "scenario",
                                          ">trials", ">progress", ">ETA",  "title",   NULL};
    const cJSON *study;
    struct table table;
    table_start(&table, headers);
    cJSON_ArrayForEach(study, studies)
    {
        char trials[2 * TEXT_MAX], progress[TEXT_MAX], eta[TEXT_MAX];
        double done = json_number(json_get(study, "jobs"), "done", 0), total = json_number(study, "total", 0);
        const char *state = json_text(study, "state");
        snprintf(trials, sizeof trials, total > 0 ? "%.0f / %.0f" : "%.0f", done, total);
        snprintf(progress, sizeof progress, "%.0f %%", 100 * json_number(study, "progress", 0));
        const char *const cells[] = {json_text(study, "id"),
                                     state,
                                     json_text(study, "kind"),
                                     json_text(study, "conclusion"),
                                     json_text(study, "scenario"),
                                     trials,
                                     progress,
                                     text_duration(json_number(study, "eta_s", -1), eta),
                                     json_text(study, "title")};
        table_row(&table, cells, colour_of_state(state));
    }
    table_end(&table, 0);
}

/* Takes the jobs out of a list that belong to a study. */
static void leave_trials_out(cJSON *jobs)
{
    for (cJSON *job = jobs ? jobs->child : NULL, *next; job; job = next) {
        next = job->next;
        if (json_text(job, "study"))
            cJSON_Delete(cJSON_DetachItemViaPointer(jobs, job));
    }
}

static void put_json_lines(cJSON *list)
{
    while (cJSON_GetArraySize(list) > 0) {
        cJSON *item = cJSON_DetachItemFromArray(list, 0);
        put_json_line(item);
        cJSON_Delete(item);
    }
}

static enum outcome list_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    long long limit;
    cJSON *result = NULL, *body = NULL;
    enum outcome outcome = arguments_integer(arguments, "--limit", 1, 2000, 200, &limit, &err);
    if (outcome || (outcome = link_open_for(arguments, &link, &err)))
        goto out;
    body = cJSON_CreateObject();
    cJSON *states = body ? cJSON_AddArrayToObject(body, "states") : NULL;
    for (int k = 0; k < arguments->option_count && states; k++)
        if (strcmp(arguments->options[k].name, "--state") == 0)
            cJSON_AddItemToArray(states, cJSON_CreateString(arguments->options[k].value));
    if (states && cJSON_GetArraySize(states) == 0)
        cJSON_DeleteItemFromObjectCaseSensitive(body, "states");
    if (body)
        json_put_int(body, "limit", limit);
    if ((outcome = link_request(link, "list", body, &result, &err)))
        goto out;
    cJSON *jobs = cJSON_DetachItemFromObjectCaseSensitive(result, "jobs");
    cJSON *studies = cJSON_DetachItemFromObjectCaseSensitive(result, "studies");
    if (!arguments_flag(arguments, "--trials"))
        leave_trials_out(jobs);
    if (arguments->json) {
        put_json_lines(studies);
        put_json_lines(jobs);
    } else {
        if (cJSON_GetArraySize(studies) > 0) {
            print_studies(studies);
            putchar('\n');
        }
        print_jobs(jobs);
    }
    cJSON_Delete(studies);
    cJSON_Delete(jobs);
out:
    cJSON_Delete(result);
    link_close(link);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--state=*", "--limit=", "--trials", NULL};

const struct verb verb_list = {
    .name = "list",
    .synopsis = "[--state STATE]... [--limit N] [--trials]",
    .doc = "the daemon's studies and jobs, newest first: state, verdict, progress, rate",
    .help = "States are queued, running, paused, done, failed, cancelled, held. At most N jobs are shown, 200 without\n"
            "--limit. With --json one object a job.\n"
            "Studies come first; their trials are listed with --trials.\n"
            "\n"
            "  scree list\n"
            "  scree list --state running --state queued --json\n",
    .options = options,
    .run = list_run,
};
