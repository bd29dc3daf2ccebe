/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The trials of a study as a table: what they differ in, how each ended, what it
 * measured. See study_view.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study_view.h"

/* The names of all numbers that trials have, in the order in which they first come. */
struct numbers {
    const struct scree_number *all[4 * SCREE_SUMMARY_MAX];
    size_t count;
};

static size_t find_number(const struct numbers *n, const char *name)
{
    size_t k = 0;
    while (k < n->count && strcmp(n->all[k]->name, name) != 0)
        k++;
    return k;
}

static void collect(const struct study *study, struct numbers *n)
{
    n->count = 0;
    for (size_t t = 0; t < study->trial_count; t++) {
        const struct job *job = study->trials[t].job;
        for (size_t k = 0; job && k < job->report.number_count; k++)
            if (find_number(n, job->report.numbers[k].name) == n->count && n->count < sizeof n->all / sizeof *n->all)
                n->all[n->count++] = &job->report.numbers[k];
    }
}

static void column(cJSON *columns, const char *name, const char *unit)
{
    cJSON *c = cJSON_CreateObject();
    json_put_text(c, "name", name);
    json_put_text(c, "unit", unit);
    cJSON_AddItemToArray(columns, c);
}

/* The seed stands in a column of its own, unless the trials are told apart by it. */
static bool seed_is_extra(const struct study *study)
{
    for (size_t k = 0; k < study->plan.column_count; k++)
        if (strcmp(study->plan.columns[k], "seed") == 0)
            return false;
    return true;
}

/* A number of the summary; where it is called as a column of every table is, it says that it is one. */
static void number_column(cJSON *columns, const struct scree_number *number)
{
    char name[96];
    const cJSON *other;
    bool taken = false;
    cJSON_ArrayForEach(other, columns) taken |= strcmp(json_text(other, "name"), number->name) == 0;
    snprintf(name, sizeof name, "%s%.60s", taken ? "number." : "", number->name);
    column(columns, name, strcmp(number->unit, "1") == 0 ? "" : number->unit);
}

static void put_columns(cJSON *columns, const struct study *study, const struct numbers *n)
{
    column(columns, "trial", "");
    column(columns, "replica", "");
    for (size_t k = 0; k < study->plan.column_count; k++) {
        const char *unit;
        cJSON_Delete(job_value_at(&study->plan.base, study->plan.columns[k], &unit));
        column(columns, study->plan.columns[k], unit);
    }
    if (study_is_search(study)) {
        column(columns, "round", "");
        column(columns, "answer", "");
        column(columns, "bracket_low", "");
        column(columns, "bracket_high", "");
    }
    if (seed_is_extra(study))
        column(columns, "seed", "");
    column(columns, "job", "");
    column(columns, "state", "");
    column(columns, "verdict", "");
    column(columns, "steered", ""); // 1: parameters were changed with `set` while it ran
    column(columns, "time", "s");
    column(columns, "steps", "");
    column(columns, "wall", "s");
    for (size_t k = 0; k < n->count; k++)
        number_column(columns, n->all[k]);
}

static void real(cJSON *row, double value)
{
    cJSON_AddItemToArray(row, isfinite(value) ? json_real(value) : cJSON_CreateNull());
}

static void word(cJSON *row, const char *text)
{
    cJSON_AddItemToArray(row, cJSON_CreateString(text));
}

/* The bracket after a trial's round, NaN while the round is open. */
static void put_bracket(cJSON *row, const struct study *study, const struct study_trial *t)
{
    double low = NAN, high = NAN;
    int round = 0;
    if (study->bisects) {
        const struct bisect *b = &study->bisects[t->replica];
        round = t->point < b->point_count ? b->points[t->point].round : 0;
        if (round < b->round_count) {
            low = b->rounds[round].low;
            high = b->rounds[round].high;
        }
    } else {
        const struct root *r = &study->roots[t->replica];
        round = t->point < 2 ? 0 : t->point - 1;
        if (t->point < r->point_count && r->points[t->point].answered) {
            low = r->points[t->point].low;
            high = r->points[t->point].high;
        }
    }
    real(row, round);
    word(row, study_answer_word(study, t));
    real(row, low);
    real(row, high);
}

static cJSON *trial_row(const struct study *study, size_t index, const struct numbers *n)
{
    const struct study_trial *t = &study->trials[index];
    const struct job *job = t->job;
    bool search = study_is_search(study);
    cJSON *row = cJSON_CreateArray();
    real(row, (double)index);
    real(row, search ? t->replica : (double)study_plan_replica(&study->plan, (size_t)t->point));
    for (size_t k = 0; k < study->plan.column_count; k++) {
        const char *unit;
        cJSON *value = job ? job_value_at(&job->spec, study->plan.columns[k], &unit) : NULL;
        cJSON_AddItemToArray(row, value ? value : cJSON_CreateNull());
    }
    if (search)
        put_bracket(row, study, t);
    if (seed_is_extra(study))
        real(row, job ? (double)job->spec.seed : NAN);
    word(row, job ? job->id : "");
    word(row, job ? job_state_word(job->state) : "lost");
    word(row, job ? scree_verdict_word(job->report.verdict) : "");
    real(row, job ? job->altered : NAN);
    real(row, job ? job->report.time_s : NAN);
    real(row, job ? (double)job->report.steps : NAN);
    real(row, job ? job->report.wall_s : NAN);
    for (size_t k = 0; k < n->count; k++) {
        double value = NAN;
        for (size_t i = 0; job && i < job->report.number_count; i++)
            if (strcmp(job->report.numbers[i].name, n->all[k]->name) == 0)
                value = job->report.numbers[i].value;
        real(row, value);
    }
    return row;
}

cJSON *study_table(const struct study *study)
{
    struct numbers numbers;
    cJSON *json = cJSON_CreateObject(), *columns = cJSON_CreateArray(), *rows = cJSON_CreateArray();
    collect(study, &numbers);
    put_columns(columns, study, &numbers);
    for (size_t k = 0; k < study->trial_count; k++)
        cJSON_AddItemToArray(rows, trial_row(study, k, &numbers));
    json_put(json, "columns", columns);
    json_put(json, "rows", rows);
    return json;
}

/* ---- as text ---- */

/* A field of RFC 4180: quoted where it holds a comma, a quote or a line's end. */
static void put_field(FILE *file, const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, file);
        return;
    }
    putc('"', file);
    for (; *text; text++) {
        if (*text == '"')
            putc('"', file);
        putc(*text, file);
    }
    putc('"', file);
}

static void put_cell(FILE *file, const cJSON *cell)
{
    if (cJSON_IsNull(cell))
        return;
    if (cJSON_IsString(cell)) {
        put_field(file, cell->valuestring);
        return;
    }
    char *text = json_print(cell, false);
    put_field(file, text ? text : "");
    free(text);
}

char *study_csv(const cJSON *table)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    const cJSON *item, *row;
    if (!file)
        return NULL;
    cJSON_ArrayForEach(item, json_get(table, "columns"))
    {
        char name[SCREE_PATH_MAX + 40];
        const char *unit = json_text(item, "unit");
        snprintf(name, sizeof name, "%s%s%s%s", json_text(item, "name"), unit && *unit ? " (" : "", unit ? unit : "",
                 unit && *unit ? ")" : "");
        if (item != json_get(table, "columns")->child)
            putc(',', file);
        put_field(file, name);
    }
    putc('\n', file);
    cJSON_ArrayForEach(row, json_get(table, "rows"))
    {
        cJSON_ArrayForEach(item, row)
        {
            if (item != row->child)
                putc(',', file);
            put_cell(file, item);
        }
        putc('\n', file);
    }
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}
