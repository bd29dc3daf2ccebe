/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See study_print.h. */
#include "study_print.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "summary.h"
#include "table.h"

static void line(const char *name, const char *text)
{
    printf("%s%-14s%s ", colour_on(stdout, COLOUR_DIM), name, colour_off(stdout, COLOUR_DIM));
    put_clean(stdout, text);
    putchar('\n');
}

static void print_state(const cJSON *record)
{
    const char *words[] = {json_text(record, "id"), json_text(record, "kind"), json_text(record, "scenario")};
    const char *state = json_text(record, "state"), *title = json_text(record, "title");
    for (int k = 0; k < 3; k++) {
        put_clean(stdout, words[k] ? words[k] : "?");
        printf("  ");
    }
    printf("%s", colour_on(stdout, colour_of_state(state)));
    put_clean(stdout, state ? state : "?");
    printf("%s", colour_off(stdout, colour_of_state(state)));
    if (title && *title) {
        printf("  ");
        put_clean(stdout, title);
    }
    putchar('\n');
}

static void print_counts(const cJSON *record)
{
    char text[512], ended[TEXT_MAX];
    const cJSON *jobs = json_get(record, "jobs"), *count;
    size_t length = 0;
    double started = json_number(record, "started", 0), end = json_number(record, "ended", 0);
    text[0] = 0;
    cJSON_ArrayForEach(count, jobs) if (count->valuedouble > 0 && length < sizeof text) length += (size_t)snprintf(
        text + length, sizeof text - length, "%s%.0f %.20s", length ? ", " : "", count->valuedouble, count->string);
    if (json_number(record, "total", 0) > 0 && length < sizeof text)
        length += (size_t)snprintf(text + length, sizeof text - length, " of %.0f", json_number(record, "total", 0));
    if (started > 0 && end > 0 && length < sizeof text)
        snprintf(text + length, sizeof text - length, " in %s", text_duration(end - started, ended));
    line("trials", text);
}

static void print_answers(const cJSON *record)
{
    const char *over = json_text(record, "over"), *unit = json_text(record, "unit");
    const cJSON *answer, *spread = json_get(record, "spread");
    char text[1024], value[TEXT_MAX], low[TEXT_MAX], high[TEXT_MAX], most[TEXT_MAX];
    cJSON_ArrayForEach(answer, json_get(record, "answers"))
    {
        const char *conclusion = json_text(answer, "conclusion"), *note = json_text(answer, "note");
        text_number(json_number(answer, "value", NAN), value);
        text_number(json_number(answer, "low", NAN), low);
        text_number(json_number(answer, "high", NAN), high);
        bool found = cJSON_IsNumber(json_get(answer, "value"));
        int length = found ? snprintf(text, sizeof text, "%.160s = %s %.20s within %s..%s", over ? over : "?", value,
                                      unit ? unit : "", low, high)
                           : snprintf(text, sizeof text, "%.160s not found (%.20s), so far within %s..%s", over ? over : "?",
                                      conclusion ? conclusion : "?", low, high);
        if (cJSON_GetArraySize(json_get(record, "answers")) > 1)
            snprintf(text + length, sizeof text - (size_t)length, ", replica %.0f", json_number(answer, "replica", 0));
        line("answer", text);
        if (note && *note)
            line("note", note);
    }
    if (json_number(spread, "replicas", 0) > 1) {
        snprintf(text, sizeof text, "mean %s, standard deviation %s, %s..%s over %.0f replicas",
                 text_number(json_number(spread, "mean", NAN), value), text_number(json_number(spread, "deviation", NAN), low),
                 text_number(json_number(spread, "least", NAN), high), text_number(json_number(spread, "most", NAN), most),
                 json_number(spread, "replicas", 0));
        line("spread", text);
    }
}

static void print_bracket(const cJSON *record)
{
    static const char *const headers[] = {">replica", ">round", ">low", ">high", NULL};
    const cJSON *row;
    struct table table;
    if (cJSON_GetArraySize(json_get(record, "bracket")) == 0)
        return;
    table_start(&table, headers);
    cJSON_ArrayForEach(row, json_get(record, "bracket"))
    {
        char replica[TEXT_MAX], round[TEXT_MAX], low[TEXT_MAX], high[TEXT_MAX];
        const char *const cells[] = {
            text_count(json_number(row, "replica", 0), replica), text_count(json_number(row, "round", 0), round),
            text_number(json_number(row, "low", NAN), low), text_number(json_number(row, "high", NAN), high)};
        table_row(&table, cells, COLOUR_NONE);
    }
    putchar('\n');
    table_end(&table, 2);
}

/* "slope_deg 22, nz 8": the values without the groups they lie in. */
static void describe_values(const cJSON *values, char *out, size_t size)
{
    const cJSON *value;
    size_t length = 0;
    *out = 0;
    cJSON_ArrayForEach(value, values)
    {
        if (strcmp(value->string, "paper") == 0)
            continue; // has lines of its own
        const char *dot = strrchr(value->string, '.');
        char number[TEXT_MAX],
            *text = cJSON_IsNumber(value) ? strdup(text_number(value->valuedouble, number)) : json_print(value, false);
        int wrote = snprintf(out + length, size - length, "%s%s %.60s", length ? ", " : "", dot ? dot + 1 : value->string,
                             text ? text : "?");
        free(text);
        if (wrote < 0 || length + (size_t)wrote >= size)
            return;
        length += (size_t)wrote;
    }
}

static void print_trials(const cJSON *record)
{
    static const char *const headers[] = {"job", "state", ">replica", "values", "verdict", ">time", "answer", "evidence", NULL};
    const cJSON *trial;
    struct table table;
    if (cJSON_GetArraySize(json_get(record, "trials")) == 0)
        return;
    table_start(&table, headers);
    cJSON_ArrayForEach(trial, json_get(record, "trials"))
    {
        char replica[TEXT_MAX], values[512], time[TEXT_MAX], number[TEXT_MAX];
        const char *state = json_text(trial, "state"), *answer = json_text(trial, "answer"), *error = json_text(trial, "error");
        describe_values(json_get(trial, "values"), values, sizeof values);
        snprintf(time, sizeof time, "%.4g s", json_number(trial, "time_s", 0));
        if (json_get(trial, "number"))
            answer = text_number(json_number(trial, "number", NAN), number);
        const char *const cells[] = {json_text(trial, "job"),
                                     state,
                                     text_count(json_number(trial, "replica", 0), replica),
                                     values,
                                     json_text(trial, "verdict"),
                                     time,
                                     answer,
                                     error ? error : json_text(trial, "evidence")};
        table_row(&table, cells, colour_of_state(state));
    }
    putchar('\n');
    table_end(&table, 2);
}

/* What the paper says of single trials. */
static void print_papers(const cJSON *record)
{
    const cJSON *trial;
    cJSON_ArrayForEach(trial, json_get(record, "trials"))
    {
        const char *job = json_text(trial, "job"), *paper = json_text(trial, "paper");
        if (job && paper && *paper && json_get(json_get(trial, "values"), "paper"))
            line(job, paper);
    }
}

void study_print(const cJSON *record, const char *file, const char *text_file)
{
    const char *hint = json_text(json_get(record, "error"), "hint"), *why = json_text(record, "why");
    const char *paper = json_text(record, "paper");
    print_state(record);
    if (paper && *paper)
        line("paper", paper);
    print_counts(record);
    if (*summary_error(record))
        line("error", summary_error(record));
    if (hint && *hint)
        line("hint", hint);
    if (why && *why)
        line("why", why);
    print_answers(record);
    print_bracket(record);
    print_trials(record);
    print_papers(record);
    if (file)
        line("result", file);
    if (text_file)
        line("table", text_file);
}
