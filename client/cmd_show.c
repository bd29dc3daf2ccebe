/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree show`: everything the daemon knows of a job. */
#include <stdio.h>

#include "follow.h"
#include "output.h"
#include "study_print.h"
#include "summary.h"
#include "table.h"
#include "verbs.h"

static void print_streams(const cJSON *streams)
{
    static const char *const headers[] = {"stream", ">chunks", ">samples", "columns", NULL};
    const cJSON *stream, *column;
    struct table table;
    if (cJSON_GetArraySize(streams) == 0)
        return;
    table_start(&table, headers);
    cJSON_ArrayForEach(stream, streams)
    {
        char chunks[TEXT_MAX], samples[TEXT_MAX], names[256] = "";
        size_t at = 0;
        int index = 0;
        cJSON_ArrayForEach(column, json_get(stream, "columns"))
        {
            const char *name = cJSON_GetStringValue(column);
            const char *unit = cJSON_GetStringValue(cJSON_GetArrayItem(json_get(stream, "units"), index++));
            int length = snprintf(names + at, sizeof names - at, "%s%s (%s)", at ? ", " : "", name ? name : "?", unit ? unit : "");
            at += length > 0 && (size_t)length < sizeof names - at ? (size_t)length : 0;
        }
        const char *const cells[] = {stream->string, text_count(json_number(stream, "chunks", 0), chunks),
                                     text_count(json_number(stream, "samples", 0), samples), names};
        table_row(&table, cells, COLOUR_NONE);
    }
    table_end(&table, 2);
}

/* "step 12345  set params.slope_deg=24", a line each. */
static void print_steering(const cJSON *record)
{
    const cJSON *command, *assignment;
    cJSON_ArrayForEach(command, json_get(record, "steering"))
    {
        const char *op = json_text(command, "op"), *child = json_text(command, "fork");
        double step = json_number(command, "step", -1);
        if (step >= 0)
            printf("step %-10.0f", step);
        else
            printf("%-15s", json_bool(command, "void", false) ? "too late" : "waits");
        put_clean(stdout, op ? op : "?");
        cJSON_ArrayForEach(assignment, json_get(command, "set"))
        {
            putchar(' ');
            put_clean(stdout, cJSON_IsString(assignment) ? assignment->valuestring : "?");
        }
        if (child)
            printf(" (%s)", child);
        putchar('\n');
    }
}

static void print_record(cJSON *record)
{
    const char *build = json_text(record, "build"), *why = json_text(record, "why"),
               *hint = json_text(json_get(record, "error"), "hint");
    summary_print(record, json_text(record, "result"));
    if (hint && *hint) {
        printf("hint           ");
        put_clean(stdout, hint);
        putchar('\n');
    }
    if (why && *why) {
        printf("why            ");
        put_clean(stdout, why);
        putchar('\n');
    }
    if (build) {
        printf("build          ");
        put_clean(stdout, build);
        putchar('\n');
    }
    if (json_text(record, "hash")) {
        printf("state hash     ");
        put_clean(stdout, json_text(record, "hash"));
        putchar('\n');
    }
    print_steering(record);
    print_streams(json_get(record, "streams"));
    cJSON *spec = cJSON_DetachItemFromObjectCaseSensitive(record, "spec");
    if (spec)
        put_json_pretty(spec);
    cJSON_Delete(spec);
}

static enum outcome show_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    enum outcome outcome = link_open_for(arguments, &link, &err);
    for (int k = 0; k < arguments->word_count && !outcome; k++) {
        cJSON *record = NULL;
        if ((outcome = link_job(link, "show", arguments->words[k], &record, &err)))
            break;
        if (arguments->json)
            put_json_line(record);
        else if (is_study_id(arguments->words[k]))
            study_print(record, NULL, NULL);
        else
            print_record(record);
        cJSON_Delete(record);
    }
    link_close(link);
    return give_up(outcome, &err);
}

const struct verb verb_show = {
    .name = "show",
    .synopsis = "ID...",
    .doc = "everything about a job or a study: verdict and evidence, numbers, streams, spec",
    .help = "Of a study its answers, its bracket round by round and every trial with what it came to.\n"
            "With --json one object a job, with id, state, scenario, verdict, time_s, end_s, steps, grains,\n"
            "grain_steps_per_s, streams {name: {chunks, samples, ...}}, spec, build, error and more.\n"
            "\n"
            "  scree show j17\n"
            "  scree show j17 --json | python3 -m json.tool\n",
    .words_min = 1,
    .words_max = -1,
    .run = show_run,
};
