/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See study_json.h. */
#include "protocol/study_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const sweep_others[] = {"study", "job", "replica_seeds", "grid", "cases", NULL};
static const char *const search_others[] = {"study", "job", "replica_seeds", NULL};
static const char *const job_others[] = {"scenario", "params", "material", NULL};

/* ---- paths ---- */

/* Puts another name before what a message says behind its own path: "params.nx: 0 is ..." at "grid.params.nx[1]". */
static enum scree_status rename_error(struct scree_error *err, const char *own, const char *path)
{
    if (!err)
        return SCREE_INVALID;
    char text[SCREE_MESSAGE_MAX], hint[SCREE_HINT_MAX];
    size_t length = strlen(own);
    bool stands = length > 0 && strncmp(err->message, own, length) == 0 && strncmp(err->message + length, ": ", 2) == 0;
    enum scree_status status = err->status;
    snprintf(text, sizeof text, "%s", err->message + (stands ? length + 2 : 0));
    snprintf(hint, sizeof hint, "%s", err->hint);
    scree_fail(err, status, path, "%s: %s", path, text);
    if (*hint)
        scree_hint(err, "%s", hint);
    return status;
}

/* An unknown first part: "parms.nx" means "params", "mu_t" by itself "material.mu_t". */
static void guess_group(const struct job_spec *job, const char *dotted, struct scree_error *err)
{
    char first[64];
    snprintf(first, sizeof first, "%.*s", (int)strcspn(dotted, "."), dotted);
    const char *near = word_nearest(job_others, first), *group = NULL;
    if (field_find(job->scenario->params, dotted))
        group = "params";
    else if (field_find(scenario_material(job->scenario)->table, dotted))
        group = "material";
    if (group)
        scree_fail(err, SCREE_INVALID, dotted, "%s: unknown key; did you mean \"%s.%s\"?", dotted, group, dotted);
    else if (near && strstr(err->message, "unknown key") && !strstr(err->message, "did you mean"))
        scree_fail(err, SCREE_INVALID, dotted, "%s: unknown key; did you mean \"%s\"?", dotted, near);
}

/* The row and the place of a dotted path in a job; *row NULL: one of the two words that no table has. `path`
 * says in messages where the dotted path stands. */
static enum scree_status find_value(struct job_spec *job, const char *dotted, const char *path, const struct field **row,
                                    void **address, struct scree_error *err)
{
    struct scree_error inner = {0};
    enum scree_status status;
    const char *rest = dotted;
    *row = NULL;
    if (strcmp(dotted, "scenario") == 0 || strcmp(dotted, "material.preset") == 0)
        return SCREE_OK;
    if (strncmp(dotted, "params.", 7) == 0) {
        status = field_resolve(job->scenario->params, job->params, rest = dotted + 7, row, address, &inner);
    } else if (strncmp(dotted, "material.", 9) == 0) {
        status = field_resolve(scenario_material(job->scenario)->table, &job->material, rest = dotted + 9, row, address, &inner);
    } else {
        status = field_resolve(&job_table, job, dotted, row, address, &inner);
        if (status)
            guess_group(job, dotted, &inner);
    }
    if (!status && (*row)->table)
        status = scree_fail(&inner, SCREE_INVALID, rest, "%s: is a group of values; name one of them", rest);
    if (status && err) {
        *err = inner;
        rename_error(err, rest, path);
    }
    return status;
}

cJSON *job_value_at(const struct job_spec *job, const char *path, const char **unit)
{
    const struct field *row;
    void *address = NULL;
    struct job_spec copy = *job; // find_value hands out an address to write to
    *unit = "";
    if (find_value(&copy, path, path, &row, &address, NULL))
        return NULL;
    if (!row)
        return cJSON_CreateString(strcmp(path, "scenario") == 0 ? job->scenario->name : job->material.preset);
    *unit = row->unit;
    return field_encode(row, address);
}

/* The job with one value set, decoded: what is wrong with the value is said at `path`. */
static enum scree_status try_value(const cJSON *base, const char *dotted, const cJSON *value, const char *path,
                                   struct scree_error *err)
{
    struct job_spec job;
    struct scree_error inner = {0};
    cJSON *json = cJSON_Duplicate(base, true);
    enum scree_status status = json ? job_value_set(json, dotted, value, &inner) : SCREE_NO_MEMORY;
    if (!status)
        status = job_decode(json, &job, &inner);
    cJSON_Delete(json);
    if (status && err) {
        *err = inner;
        rename_error(err, dotted, path);
    }
    return status;
}

/* ---- decoding ---- */

bool study_is(const cJSON *json)
{
    return cJSON_IsObject(json) && json_get(json, "study");
}

static enum scree_status decode_kind(const cJSON *json, enum study_kind *kind, struct scree_error *err)
{
    const cJSON *item = json_get(json, "study");
    const char *names[STUDY_KINDS + 1] = {0};
    for (int k = 0; k < STUDY_KINDS; k++)
        names[k] = study_kinds[k].name;
    if (!cJSON_IsString(item))
        return scree_fail(err, SCREE_INVALID, "study", "study: \"sweep\", \"bisect\" or \"root\" is expected");
    for (int k = 0; k < STUDY_KINDS; k++)
        if (strcmp(names[k], item->valuestring) == 0) {
            *kind = (enum study_kind)k;
            return SCREE_OK;
        }
    const char *near = word_nearest(names, item->valuestring);
    return scree_fail(err, SCREE_INVALID, "study", "study: \"%.80s\" is none of \"sweep\", \"bisect\", \"root\"%s%s%s",
                      item->valuestring, near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
}

/* "steady" alone means a flow that goes on: see study_verdicts_meant. */
static void widen_verdict(cJSON *json)
{
    const cJSON *word = json_get(json, "raise_low_when");
    const struct field *row = field_find(study_kinds[STUDY_BISECT].table, "raise_low_when");
    if (!cJSON_IsString(word))
        return;
    cJSON *list = cJSON_CreateArray();
    unsigned bits = 0;
    for (int k = 0; row->choices[k]; k++)
        if (strcmp(row->choices[k], word->valuestring) == 0)
            bits = study_verdicts_meant(1u << k);
    for (int k = 0; row->choices[k]; k++)
        if (bits >> k & 1)
            cJSON_AddItemToArray(list, cJSON_CreateString(row->choices[k]));
    if (bits == 0) // table_decode says what is wrong with it
        cJSON_AddItemToArray(list, cJSON_CreateString(word->valuestring));
    cJSON_DeleteItemFromObjectCaseSensitive(json, "raise_low_when");
    json_put(json, "raise_low_when", list);
}

static enum scree_status decode_fields(const cJSON *json, struct study_spec *spec, struct scree_error *err)
{
    const struct study_fields *kind = &study_kinds[spec->kind];
    enum scree_status status;
    for (const char *const *name = kind->required; *name; name++)
        if (!json_get(json, *name))
            return scree_fail(err, SCREE_INVALID, *name, "%s: is missing: %s", *name, field_find(kind->table, *name)->doc);
    if ((status = table_decode(kind->table, json, "", spec, spec->kind == STUDY_SWEEP ? sweep_others : search_others, err)) ||
        (status = field_check(kind->table, spec, "", err)))
        return status;
    return study_check(spec, err);
}

/* The base job. A bisection whose job does not say when to stop stops at every verdict that is sound for it. */
static enum scree_status decode_job(const cJSON *json, struct study_plan *plan, struct scree_error *err)
{
    const cJSON *job = json_get(json, "job");
    if (!job)
        return scree_fail(err, SCREE_INVALID, "job", "job: is missing; it is the job that the trials start from");
    if (study_is(job))
        return scree_fail(err, SCREE_INVALID, "job", "job: a study cannot be the job of a study");
    if (!(plan->job = cJSON_Duplicate(job, true)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    struct scree_error inner = {0};
    enum scree_status status = job_decode(plan->job, &plan->base, &inner);
    if (status) {
        char path[SCREE_PATH_MAX + 8];
        snprintf(path, sizeof path, "job%s%s", *inner.path ? "." : "", inner.path);
        if (err) {
            *err = inner;
            rename_error(err, inner.path, path);
        }
        return status;
    }
    const unsigned flows = STOP_STEADY | STOP_ACCELERATING, split = plan->spec.raise_low_when & flows;
    if (plan->spec.kind == STUDY_BISECT && !json_get(json_get(job, "stop"), "when") && (split == 0 || split == flows)) {
        cJSON *when = field_encode(field_find(study_kinds[STUDY_BISECT].table, "raise_low_when"), &(unsigned){STOP_ANY});
        status = when ? job_value_set(plan->job, "stop.when", when, err) : SCREE_NO_MEMORY;
        cJSON_Delete(when);
        if (!status)
            status = job_decode(plan->job, &plan->base, err);
    }
    return status;
}

static enum scree_status decode_seeds(const cJSON *json, struct study_plan *plan, struct scree_error *err)
{
    const cJSON *list = json_get(json, "replica_seeds"), *item;
    if (!list) {
        snprintf(plan->seeds[plan->seed_count++], SCREE_PATH_MAX, "seed");
        return SCREE_OK;
    }
    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) > STUDY_SEEDS_MAX)
        return scree_fail(err, SCREE_INVALID, "replica_seeds", "replica_seeds: an array of at most %d dotted paths is expected",
                          STUDY_SEEDS_MAX);
    cJSON_ArrayForEach(item, list)
    {
        char path[64];
        const struct field *row;
        void *address;
        snprintf(path, sizeof path, "replica_seeds[%zu]", plan->seed_count);
        if (!cJSON_IsString(item))
            return scree_fail(err, SCREE_INVALID, path, "%s: a dotted path is expected", path);
        enum scree_status status = find_value(&plan->base, item->valuestring, path, &row, &address, err);
        if (status)
            return status;
        if (!row || row->type != FIELD_INT)
            return scree_fail(err, SCREE_INVALID, path, "%s: %.80s is not a whole number that replicas could raise", path,
                              item->valuestring);
        snprintf(plan->seeds[plan->seed_count++], SCREE_PATH_MAX, "%s", item->valuestring);
    }
    if (plan->seed_count == 0 && plan->spec.replicas > 1)
        return scree_fail(err, SCREE_INVALID, "replica_seeds", "replica_seeds: is empty, and replicas would all be the same");
    return SCREE_OK;
}

static bool is_seed(const struct study_plan *plan, const char *path)
{
    for (size_t k = 0; k < plan->seed_count; k++)
        if (strcmp(plan->seeds[k], path) == 0)
            return true;
    return false;
}

/* Takes note that trials differ at a path; `where` says where the path stands. */
static enum scree_status add_column(struct study_plan *plan, struct job_spec *base, const char *dotted, const char *where,
                                    struct scree_error *err)
{
    const struct field *row;
    void *address;
    for (size_t k = 0; k < plan->column_count; k++)
        if (strcmp(plan->columns[k], dotted) == 0)
            return SCREE_OK;
    enum scree_status status = find_value(base, dotted, where, &row, &address, err);
    if (status)
        return status;
    if (plan->spec.replicas > 1 && is_seed(plan, dotted))
        return scree_fail(err, SCREE_INVALID, where, "%s: replicas change this, too: take one of the two", where);
    if (plan->column_count == SWEEP_AXES_MAX)
        return scree_fail(err, SCREE_INVALID, where, "%s: more than %d values that differ are not accepted", where, SWEEP_AXES_MAX);
    snprintf(plan->columns[plan->column_count++], SCREE_PATH_MAX, "%s", dotted);
    return SCREE_OK;
}

/* {"from", "to", "step" | "count", "log"} into the list of its values. */
static enum scree_status expand_range(const cJSON *json, const char *path, cJSON *values, struct scree_error *err)
{
    static const char *const known[] = {"from", "to", "step", "count", "log", NULL};
    struct sweep_range range = {0};
    for (const cJSON *item = json->child; item; item = item->next) {
        char full[SCREE_PATH_MAX];
        int k = 0;
        while (known[k] && strcmp(known[k], item->string) != 0)
            k++;
        snprintf(full, sizeof full, "%s.%s", path, item->string);
        if (!known[k]) {
            const char *near = word_nearest(known, item->string);
            return scree_fail(err, SCREE_INVALID, full, "%s: unknown key%s%s%s", full, near ? "; did you mean \"" : "",
                              near ? near : "", near ? "\"?" : "");
        }
        if (k < 4 ? !cJSON_IsNumber(item) : !cJSON_IsBool(item))
            return scree_fail(err, SCREE_INVALID, full, "%s: expected %s", full, k < 4 ? "a number" : "true or false");
        double *const places[] = {&range.from, &range.to, &range.step, &range.count};
        if (k < 4)
            *places[k] = item->valuedouble;
        else
            range.log = cJSON_IsTrue(item);
    }
    if (!json_get(json, "from") || !json_get(json, "to"))
        return scree_fail(err, SCREE_INVALID, path, "%s: a range has \"from\" and \"to\", and \"step\" or \"count\"", path);
    size_t count;
    enum scree_status status = sweep_range_count(&range, path, &count, err);
    for (size_t k = 0; k < count && !status; k++)
        if (!cJSON_AddItemToArray(values, json_real(sweep_range_at(&range, count, k))))
            status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    return status;
}

static enum scree_status decode_axis(const cJSON *item, struct study_plan *plan, struct scree_error *err)
{
    struct study_axis *axis = &plan->axes[plan->axis_count];
    char path[SCREE_PATH_MAX];
    snprintf(path, sizeof path, "grid.%s", item->string);
    enum scree_status status = add_column(plan, &plan->base, item->string, path, err);
    if (status)
        return status;
    snprintf(axis->path, sizeof axis->path, "%s", item->string);
    axis->values = cJSON_IsArray(item) ? cJSON_Duplicate(item, true) : cJSON_CreateArray();
    plan->axis_count++; // from here on the plan frees it
    if (!axis->values)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    if (cJSON_IsObject(item))
        status = expand_range(item, path, axis->values, err);
    else if (!cJSON_IsArray(item) || !item->child)
        status = scree_fail(err, SCREE_INVALID, path,
                            "%s: a list of values or {\"from\", \"to\", \"step\" or \"count\"} is expected", path);
    int index = 0;
    for (const cJSON *value = axis->values->child; value && !status; value = value->next, index++) {
        char at[SCREE_PATH_MAX];
        snprintf(at, sizeof at, "%s[%d]", path, index);
        if (index >= SWEEP_TRIALS_MAX)
            return scree_fail(err, SCREE_INVALID, path, "%s: more than the %d trials that a sweep may have", path,
                              SWEEP_TRIALS_MAX);
        status = try_value(plan->job, axis->path, value, at, err);
    }
    plan->shape.counts[plan->axis_count - 1] = (size_t)index;
    return status;
}

static enum scree_status decode_grid(const cJSON *grid, struct study_plan *plan, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    if (!cJSON_IsObject(grid))
        return scree_fail(err, SCREE_INVALID, "grid", "grid: an object of dotted paths and their values is expected");
    for (const cJSON *item = grid->child; item && !status; item = item->next)
        status = decode_axis(item, plan, err);
    plan->shape.axes = plan->axis_count;
    return status;
}

/* One case: its values are of its own scenario where it names one. */
static enum scree_status decode_case(const cJSON *item, const char *name, struct study_plan *plan, struct scree_error *err)
{
    const cJSON *value, *scenario = json_get(item, "scenario");
    struct job_spec base = plan->base;
    cJSON *json = cJSON_Duplicate(plan->job, true);
    enum scree_status status = json ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    if (scenario && !status && !(status = job_value_set(json, "scenario", scenario, err)))
        status = job_decode(json, &base, err);
    if (status && err && err->status == SCREE_INVALID)
        rename_error(err, "scenario", name);
    cJSON_ArrayForEach(value, item)
    {
        char path[SCREE_PATH_MAX];
        snprintf(path, sizeof path, "%s.%s", name, value->string);
        if (!status && !(status = add_column(plan, &base, value->string, path, err)))
            status = try_value(json, value->string, value, path, err);
    }
    cJSON_Delete(json);
    return status;
}

static enum scree_status decode_cases(const cJSON *cases, struct study_plan *plan, struct scree_error *err)
{
    const cJSON *item;
    int index = 0;
    if (!cJSON_IsArray(cases) || !cases->child)
        return scree_fail(err, SCREE_INVALID, "cases", "cases: a list of objects of dotted paths and values is expected");
    if (!(plan->cases = cJSON_Duplicate(cases, true)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    cJSON_ArrayForEach(item, cases)
    {
        char name[32];
        snprintf(name, sizeof name, "cases[%d]", index++);
        if (!cJSON_IsObject(item))
            return scree_fail(err, SCREE_INVALID, name, "%s: an object of dotted paths and values is expected", name);
        enum scree_status status = decode_case(item, name, plan, err);
        if (status)
            return status;
    }
    plan->shape.axes = 1;
    plan->shape.counts[0] = (size_t)index;
    return SCREE_OK;
}

static enum scree_status decode_sweep(const cJSON *json, struct study_plan *plan, struct scree_error *err)
{
    const cJSON *grid = json_get(json, "grid"), *cases = json_get(json, "cases");
    if (!grid == !cases)
        return scree_fail(err, SCREE_INVALID, "grid", "grid: one of \"grid\" and \"cases\" says what the trials are");
    plan->shape.replicas = (size_t)plan->spec.replicas;
    enum scree_status status = grid ? decode_grid(grid, plan, err) : decode_cases(cases, plan, err);
    return status ? status : sweep_trials(&plan->shape, &plan->trials, err);
}

static enum scree_status decode_search(struct study_plan *plan, struct scree_error *err)
{
    const struct field *row;
    void *address;
    char path[SCREE_PATH_MAX + 8];
    enum scree_status status = find_value(&plan->base, plan->spec.over, "over", &row, &address, err);
    if (status)
        return status;
    if (!row || row->type != FIELD_REAL)
        return scree_fail(err, SCREE_INVALID, "over", "over: %s is not a real number, which alone can be searched",
                          plan->spec.over);
    snprintf(plan->columns[plan->column_count++], SCREE_PATH_MAX, "%s", plan->spec.over);
    for (int k = 0; k < 2 && !status; k++) {
        cJSON *value = json_real(k ? plan->spec.high : plan->spec.low);
        snprintf(path, sizeof path, "%s", k ? "high" : "low");
        status = value ? try_value(plan->job, plan->spec.over, value, path, err) : SCREE_NO_MEMORY;
        cJSON_Delete(value);
    }
    return status;
}

/* Spells the job out, unless a trial changes a word that the rest of the job is read by. */
static enum scree_status resolve_job(struct study_plan *plan, struct scree_error *err)
{
    char adopt[64] = "";
    if (plan->base.scenario->adopt_key)
        snprintf(adopt, sizeof adopt, "params.%s", plan->base.scenario->adopt_key);
    for (size_t k = 0; k < plan->column_count; k++)
        if (strcmp(plan->columns[k], "scenario") == 0 || strcmp(plan->columns[k], "material.preset") == 0 ||
            strcmp(plan->columns[k], adopt) == 0)
            return SCREE_OK;
    cJSON *resolved = job_encode(&plan->base), *read = NULL;
    char *text = resolved ? json_print(resolved, false) : NULL; // read again, for what is encoded holds its numbers as text
    enum scree_status status =
        text ? json_read(text, strlen(text), "job", &read, err) : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    free(text);
    cJSON_Delete(resolved);
    if (status)
        return status;
    cJSON_Delete(plan->job);
    plan->job = read;
    return SCREE_OK;
}

enum scree_status study_decode(const cJSON *json, struct study_plan *plan, struct scree_error *err)
{
    enum study_kind kind = STUDY_SWEEP;
    memset(plan, 0, sizeof *plan);
    if (!cJSON_IsObject(json))
        return scree_fail(err, SCREE_INVALID, "", "the study: an object is expected");
    enum scree_status status = decode_kind(json, &kind, err);
    if (status)
        return status;
    study_defaults(&plan->spec, kind);
    cJSON *copy = cJSON_Duplicate(json, true);
    if (!copy)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the study");
    widen_verdict(copy);
    if (!(status = decode_fields(copy, &plan->spec, err)) && !(status = decode_job(copy, plan, err)) &&
        !(status = decode_seeds(copy, plan, err)))
        status = kind == STUDY_SWEEP ? decode_sweep(copy, plan, err) : decode_search(plan, err);
    cJSON_Delete(copy);
    return status ? status : resolve_job(plan, err);
}

void study_plan_free(struct study_plan *plan)
{
    cJSON_Delete(plan->job);
    cJSON_Delete(plan->cases);
    for (size_t k = 0; k < plan->axis_count; k++)
        cJSON_Delete(plan->axes[k].values);
    plan->job = plan->cases = NULL;
    plan->axis_count = 0;
}

/* ---- encoding ---- */

cJSON *study_encode(const struct study_plan *plan)
{
    unsigned long before = json_lacked();
    cJSON *json = cJSON_CreateObject(), *seeds = cJSON_CreateArray();
    if (!json || !seeds) {
        cJSON_Delete(json);
        cJSON_Delete(seeds);
        return NULL;
    }
    json_put_text(json, "study", study_kinds[plan->spec.kind].name);
    table_encode_into(json, study_kinds[plan->spec.kind].table, &plan->spec);
    for (size_t k = 0; k < plan->seed_count; k++)
        cJSON_AddItemToArray(seeds, cJSON_CreateString(plan->seeds[k]));
    json_put(json, "replica_seeds", seeds);
    if (plan->cases) {
        json_put(json, "cases", cJSON_Duplicate(plan->cases, true));
    } else if (plan->spec.kind == STUDY_SWEEP) {
        cJSON *grid = cJSON_CreateObject();
        for (size_t k = 0; k < plan->axis_count && grid; k++)
            json_put(grid, plan->axes[k].path, cJSON_Duplicate(plan->axes[k].values, true));
        json_put(json, "grid", grid);
    }
    json_put(json, "job", cJSON_Duplicate(plan->job, true));
    return json_whole(json, before);
}

cJSON *study_describe(enum study_kind kind)
{
    const struct study_fields *fields = &study_kinds[kind];
    cJSON *json = cJSON_CreateObject();
    if (!json)
        return NULL;
    json_put_text(json, "name", fields->name);
    json_put_text(json, "doc", fields->doc);
    json_put_text(json, "source", fields->source);
    json_put(json, "fields", table_describe(fields->table));
    cJSON *required = cJSON_CreateArray();
    for (const char *const *name = fields->required; *name && required; name++)
        cJSON_AddItemToArray(required, cJSON_CreateString(*name));
    json_put(json, "required", required);
    return json;
}
