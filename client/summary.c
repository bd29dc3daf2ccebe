/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See summary.h. Numbers are the scenario's own and come with name, unit and
 * doc; the force against the weight is put into one line because that is the
 * first thing one checks of a slidequake. */
#include "summary.h"

#include <math.h>
#include <string.h>

#include "output.h"
#include "table.h"

static void label(const char *name)
{
    printf("%s%-14s%s ", colour_on(stdout, COLOUR_DIM), name, colour_off(stdout, COLOUR_DIM));
}

static void line(const char *name, const char *text)
{
    label(name);
    put_clean(stdout, text);
    putchar('\n');
}

/* The value of a number by name, NaN if there is none. */
static double number_of(const cJSON *record, const char *name)
{
    const cJSON *row;
    cJSON_ArrayForEach(row, json_get(record, "numbers"))
    {
        const char *here = json_text(row, "name");
        if (here && strcmp(here, name) == 0)
            return json_number(row, "value", NAN);
    }
    return NAN;
}

static void print_state(const cJSON *record)
{
    const char *id = json_text(record, "id"), *scenario = json_text(record, "scenario"), *state = json_text(record, "state");
    const char *title = json_text(record, "title");
    enum colour colour = colour_of_state(state);
    put_clean(stdout, id ? id : "?");
    printf("  ");
    put_clean(stdout, scenario ? scenario : "?");
    printf("  %s", colour_on(stdout, colour));
    put_clean(stdout, state ? state : "?");
    printf("%s", colour_off(stdout, colour));
    if (title && *title) {
        printf("  ");
        put_clean(stdout, title);
    }
    putchar('\n');
}

static void print_run(const cJSON *record)
{
    char time[TEXT_MAX], end[TEXT_MAX], steps[TEXT_MAX], grains[TEXT_MAX], rate[TEXT_MAX], text[512];
    const char *isa = json_text(record, "isa");
    double threads = json_number(record, "threads", 1), grain_steps_per_s = json_number(record, "grain_steps_per_s", 0);
    snprintf(text, sizeof text, "%s s of at most %s s, %s steps, %s grains", text_number(json_number(record, "time_s", 0), time),
             text_number(json_number(record, "end_s", 0), end), text_count(json_number(record, "steps", 0), steps),
             text_count(json_number(record, "grains", 0), grains));
    line("simulated", text);
    if (grain_steps_per_s > 0) {
        snprintf(text, sizeof text, "%s (%.40s%s%.0f thread%s)", text_rate(grain_steps_per_s, rate), isa ? isa : "",
                 isa ? ", " : "", threads, threads == 1 ? "" : "s");
        line("rate", text);
    }
}

static void print_force(const cJSON *record)
{
    double force = number_of(record, "mean_force_z"), weight = number_of(record, "weight_normal");
    char text[256];
    if (!isfinite(force) || !isfinite(weight) || weight == 0)
        return;
    snprintf(text, sizeof text, "%.5g N into the base, %.5g of the weight across it (%.5g N)", -force, -force / weight, weight);
    line("mean force", text);
}

static void print_numbers(const cJSON *record)
{
    static const char *const headers[] = {"number", ">value", "unit", "meaning", NULL};
    const cJSON *numbers = json_get(record, "numbers"), *row;
    struct table table;
    if (cJSON_GetArraySize(numbers) == 0)
        return;
    table_start(&table, headers);
    cJSON_ArrayForEach(row, numbers)
    {
        char value[TEXT_MAX];
        const char *unit = json_text(row, "unit");
        const char *const cells[] = {json_text(row, "name"), text_number(json_number(row, "value", NAN), value),
                                     unit && strcmp(unit, "1") == 0 ? "" : unit, json_text(row, "doc")};
        table_row(&table, cells, COLOUR_NONE);
    }
    table_end(&table, 2);
}

const char *summary_error(const cJSON *record)
{
    const char *message = json_text(json_get(record, "error"), "message");
    return message ? message : "";
}

void summary_print(const cJSON *record, const char *file)
{
    const char *verdict = json_text(record, "verdict"), *evidence = json_text(record, "evidence"),
               *paper = json_text(record, "paper");
    bool calculated = json_number(record, "grains", 0) == 0 && json_number(record, "steps", 0) > 0; // no world, no verdict
    char text[1024];
    print_state(record);
    if (paper && *paper)
        line("paper", paper);
    if (!calculated) {
        snprintf(text, sizeof text, "%.40s%s%.900s", verdict ? verdict : "undecided", evidence && *evidence ? ": " : "",
                 evidence ? evidence : "");
        line("verdict", text);
    }
    if (*summary_error(record))
        line("error", summary_error(record));
    if (!calculated)
        print_run(record);
    print_force(record);
    print_numbers(record);
    if (file)
        line("result", file);
}
