/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Jobs between JSON and structs: one walk over a table each way. */
#include "protocol/job_json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

static const char *kind_of(const cJSON *item)
{
    if (cJSON_IsNull(item))
        return "null";
    if (cJSON_IsBool(item))
        return "true or false";
    if (cJSON_IsNumber(item))
        return "a number";
    if (cJSON_IsString(item))
        return "a string";
    return cJSON_IsArray(item) ? "an array" : "an object";
}

static enum scree_status wrong_type(const char *path, const char *expected, const cJSON *item, struct scree_error *err)
{
    return scree_fail(err, SCREE_INVALID, path, "%s: expected %s, got %s", *path ? path : "the job", expected, kind_of(item));
}

static void join(char out[SCREE_PATH_MAX], const char *path, const char *name)
{
    snprintf(out, SCREE_PATH_MAX, "%s%s%s", path, *path ? "." : "", name);
}

static enum scree_status unknown_key(const char *path, const char *nearest, struct scree_error *err)
{
    scree_fail(err, SCREE_INVALID, path, "%s: unknown key%s%s%s", path, nearest ? "; did you mean \"" : "", nearest ? nearest : "",
               nearest ? "\"?" : "");
    return SCREE_INVALID;
}

static enum scree_status decode_integer(const struct field *row, const cJSON *item, const char *path, int64_t *out,
                                        struct scree_error *err)
{
    if (!cJSON_IsNumber(item))
        return wrong_type(path, "a whole number", item, err);
    double value = item->valuedouble;
    char text[TEXT_REAL_MAX], low[TEXT_REAL_MAX], high[TEXT_REAL_MAX];
    if (value != floor(value))
        return scree_fail(err, SCREE_INVALID, path, "%s: %s is not a whole number", path, text_real(value, text));
    if (fabs(value) > 9007199254740992.0) // the range check to come sees an int64_t, which this may not fit
        return scree_fail(err, SCREE_INVALID, path, "%s: %s is outside %s..%s%s%s", path, text_real(value, text),
                          text_real(row->min, low), text_real(row->max, high), *row->unit ? " " : "", row->unit);
    *out = (int64_t)value;
    return SCREE_OK;
}

static enum scree_status decode_text(const struct field *row, const cJSON *item, const char *path, char *out,
                                     struct scree_error *err)
{
    if (!cJSON_IsString(item))
        return wrong_type(path, "a string", item, err);
    if (strlen(item->valuestring) >= row->size)
        return scree_fail(err, SCREE_INVALID, path, "%s: %zu bytes are more than the %zu that are accepted", path,
                          strlen(item->valuestring), row->size - 1);
    char clean[row->size]; // a text given with --set has not been through json_read
    snprintf(clean, row->size, "%s", item->valuestring);
    text_clean(clean);
    if (strcmp(clean, item->valuestring) != 0)
        return scree_fail(err, SCREE_INVALID, path, "%s: control characters and bytes that are not UTF-8 are not accepted", path);
    snprintf(out, row->size, "%s", item->valuestring);
    return SCREE_OK;
}

/* Index of a word among the choices. */
static enum scree_status decode_choice(const struct field *row, const cJSON *item, const char *path, int *out,
                                       struct scree_error *err)
{
    if (!cJSON_IsString(item))
        return wrong_type(path, "a string", item, err);
    for (*out = 0; row->choices[*out]; ++*out)
        if (strcmp(row->choices[*out], item->valuestring) == 0)
            return SCREE_OK;
    char list[256] = "";
    for (int k = 0; row->choices[k]; k++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s\"%s\"", k ? ", " : "", row->choices[k]);
    return scree_fail(err, SCREE_INVALID, path, "%s: \"%.80s\" is none of %s", path, item->valuestring, list);
}

static enum scree_status decode_flags(const struct field *row, const cJSON *item, const char *path, unsigned *out,
                                      struct scree_error *err)
{
    if (!cJSON_IsArray(item))
        return wrong_type(path, "an array of strings", item, err);
    int index = 0;
    *out = 0;
    for (const cJSON *word = item->child; word; word = word->next, index++) {
        char full[SCREE_PATH_MAX];
        int choice;
        snprintf(full, sizeof full, "%s[%d]", path, index);
        enum scree_status status = decode_choice(row, word, full, &choice, err);
        if (status)
            return status;
        if (*out >> choice & 1)
            return scree_fail(err, SCREE_INVALID, full, "%s: \"%s\" stands twice", full, word->valuestring);
        *out |= 1u << choice;
    }
    return SCREE_OK;
}

static enum scree_status decode_vec3(const cJSON *item, const char *path, double out[3], struct scree_error *err)
{
    if (!cJSON_IsArray(item))
        return wrong_type(path, "an array of three numbers", item, err);
    if (cJSON_GetArraySize(item) != 3)
        return scree_fail(err, SCREE_INVALID, path, "%s: expected an array of three numbers, got %d", path,
                          cJSON_GetArraySize(item));
    int a = 0;
    for (const cJSON *part = item->child; part; part = part->next, a++) {
        if (!cJSON_IsNumber(part)) {
            char full[SCREE_PATH_MAX];
            snprintf(full, sizeof full, "%s[%d]", path, a);
            return wrong_type(full, "a number", part, err);
        }
        out[a] = part->valuedouble;
    }
    return SCREE_OK;
}

static enum scree_status decode_rows(const struct field *row, const cJSON *item, const char *path, void *out,
                                     struct scree_error *err)
{
    char full[SCREE_PATH_MAX];
    double *numbers = field_rows_numbers(out);
    int64_t count = 0;
    if (!cJSON_IsArray(item))
        return wrong_type(path, "an array of arrays of numbers", item, err);
    if ((size_t)cJSON_GetArraySize(item) > row->size)
        return scree_fail(err, SCREE_INVALID, path, "%s: %d rows are more than the %zu that are accepted", path,
                          cJSON_GetArraySize(item), row->size);
    memset(out, 0, field_value_size(row));
    for (const cJSON *line = item->child; line; line = line->next, count++) {
        snprintf(full, sizeof full, "%.200s[%lld]", path, (long long)count);
        if (!cJSON_IsArray(line) || (size_t)cJSON_GetArraySize(line) != row->columns)
            return scree_fail(err, SCREE_INVALID, full, "%s: expected an array of %zu numbers", full, row->columns);
        for (const cJSON *part = line->child; part; part = part->next) {
            if (!cJSON_IsNumber(part))
                return wrong_type(full, "numbers", part, err);
            *numbers++ = part->valuedouble;
        }
    }
    *(int64_t *)out = count;
    return SCREE_OK;
}

static enum scree_status decode_row(const struct field *row, const cJSON *item, const char *path, void *value,
                                    struct scree_error *err)
{
    switch (row->type) {
    case FIELD_REAL:
        if (!cJSON_IsNumber(item))
            return wrong_type(path, "a number", item, err);
        *(double *)value = item->valuedouble;
        return SCREE_OK;
    case FIELD_INT:
        return decode_integer(row, item, path, value, err);
    case FIELD_BOOL:
        if (!cJSON_IsBool(item))
            return wrong_type(path, "true or false", item, err);
        *(bool *)value = cJSON_IsTrue(item);
        return SCREE_OK;
    case FIELD_TEXT:
        return decode_text(row, item, path, value, err);
    case FIELD_VEC3:
        return decode_vec3(item, path, value, err);
    case FIELD_ROWS:
        return decode_rows(row, item, path, value, err);
    case FIELD_ENUM:
        return decode_choice(row, item, path, value, err);
    case FIELD_FLAGS:
        return decode_flags(row, item, path, value, err);
    case FIELD_GROUP:
        return table_decode(row->table, item, path, value, NULL, err);
    case FIELD_SWITCH:
        *(bool *)value = !cJSON_IsNull(item);
        return cJSON_IsNull(item) ? SCREE_OK : table_decode(row->table, item, path, value, NULL, err);
    }
    return SCREE_INTERNAL;
}

enum scree_status table_decode(const struct field_table *table, const cJSON *json, const char *path, void *object,
                               const char *const *others, struct scree_error *err)
{
    if (!cJSON_IsObject(json))
        return wrong_type(path, "an object", json, err);
    for (const cJSON *item = json->child; item; item = item->next) {
        char full[SCREE_PATH_MAX];
        bool elsewhere = false;
        for (const char *const *other = others; other && *other; other++)
            elsewhere |= strcmp(*other, item->string) == 0;
        if (elsewhere)
            continue;
        join(full, path, item->string);
        const struct field *row = field_find(table, item->string);
        if (!row) {
            const char *nearest = field_nearest(table, item->string);
            return unknown_key(full, nearest || !others ? nearest : word_nearest(others, item->string), err);
        }
        enum scree_status status = decode_row(row, item, full, (char *)object + row->offset, err);
        if (status)
            return status;
    }
    return SCREE_OK;
}

static const char *const job_others[] = {"scenario", "params", "material", NULL};
static const char *const material_others[] = {"preset", NULL};

static enum scree_status decode_scenario(const cJSON *json, struct job_spec *out, struct scree_error *err)
{
    if (!cJSON_IsObject(json))
        return wrong_type("", "an object", json, err);
    const cJSON *item = json_get(json, "scenario");
    if (!item) {
        const char *near = NULL;
        for (const cJSON *other = json->child; other && !near; other = other->next)
            near = word_nearest(job_others, other->string) == job_others[0] ? other->string : NULL;
        if (near)
            return unknown_key(near, "scenario", err);
        return scree_fail(err, SCREE_INVALID, "scenario",
                          "scenario: is missing; it names the set-up, as `scree scenarios` lists them");
    }
    if (!cJSON_IsString(item))
        return wrong_type("scenario", "a string", item, err);
    const struct scenario_fields *scenario = scenario_find(item->valuestring);
    if (!scenario) {
        char list[256] = "";
        for (size_t k = 0; k < scenario_count; k++)
            snprintf(list + strlen(list), sizeof list - strlen(list), "%s\"%s\"", k ? ", " : "", scenario_list[k]->name);
        return scree_fail(err, SCREE_INVALID, "scenario", "scenario: \"%.80s\" is none of %s", item->valuestring, list);
    }
    job_defaults(out, scenario);
    return SCREE_OK;
}

static enum scree_status decode_material(const cJSON *material, struct job_spec *out, struct scree_error *err)
{
    const struct material_kind *kind = scenario_material(out->scenario);
    if (!cJSON_IsObject(material)) {
        wrong_type("material", "an object", material, err);
        scree_hint(err, "a published material is {\"preset\": NAME}; `scree materials` lists them");
        return SCREE_INVALID;
    }
    const cJSON *preset = json_get(material, "preset");
    if (preset) {
        if (!cJSON_IsString(preset))
            return wrong_type("material.preset", "a string", preset, err);
        const struct material_preset *found = material_preset_find(preset->valuestring);
        if (!found || material_preset_kind(found) != kind) {
            char list[256] = "";
            for (size_t k = 0; k < material_preset_count; k++)
                if (material_preset_kind(&material_presets[k]) == kind)
                    snprintf(list + strlen(list), sizeof list - strlen(list), "%s\"%s\"", *list ? ", " : "",
                             material_presets[k].name);
            return scree_fail(err, SCREE_INVALID, "material.preset", "material.preset: \"%.80s\" is none of %s",
                              preset->valuestring, list);
        }
        memcpy(&out->material, material_preset_values(found), kind->table->size);
    }
    return table_decode(kind->table, material, "material", &out->material, material_others, err);
}

/* A published run named in params: its values are where the other keys start from. */
static enum scree_status decode_adopted(const cJSON *json, struct job_spec *out, struct scree_error *err)
{
    const char *key = out->scenario->adopt_key;
    const cJSON *params = json_get(json, "params"), *item = key && cJSON_IsObject(params) ? json_get(params, key) : NULL;
    if (!item)
        return SCREE_OK;
    char path[SCREE_PATH_MAX];
    const struct field *row = field_find(out->scenario->params, key);
    join(path, "params", key);
    enum scree_status status = decode_row(row, item, path, out->params + row->offset, err);
    if (!status)
        out->scenario->adopt(out);
    return status;
}

enum scree_status job_decode(const cJSON *json, struct job_spec *out, struct scree_error *err)
{
    enum scree_status status = decode_scenario(json, out, err);
    if (status || (status = decode_adopted(json, out, err)) || (status = table_decode(&job_table, json, "", out, job_others, err)))
        return status;
    const cJSON *params = json_get(json, "params"), *material = json_get(json, "material");
    if (params && (status = table_decode(out->scenario->params, params, "params", out->params, NULL, err)))
        return status;
    if (material && (status = decode_material(material, out, err)))
        return status;
    if ((status = field_check(&job_table, out, "", err)) ||
        (status = field_check(out->scenario->params, out->params, "params", err)))
        return status;
    return field_check(scenario_material(out->scenario)->table, &out->material, "material", err);
}

/* ---- encoding ---- */

static cJSON *encode_table(const struct field_table *table, const void *object);

cJSON *field_encode(const struct field *row, const void *value)
{
    cJSON *array;
    switch (row->type) {
    case FIELD_REAL:
        return json_real(*(const double *)value);
    case FIELD_INT:
        return json_real((double)*(const int64_t *)value);
    case FIELD_BOOL:
        return cJSON_CreateBool(*(const bool *)value);
    case FIELD_TEXT:
        return cJSON_CreateString(value);
    case FIELD_VEC3:
        array = cJSON_CreateArray();
        for (int a = 0; a < 3 && array; a++)
            cJSON_AddItemToArray(array, json_real(((const double *)value)[a]));
        return array;
    case FIELD_ROWS:
        array = cJSON_CreateArray();
        for (size_t k = 0; array && k < (size_t)field_rows_count(value); k++) {
            cJSON *line = cJSON_CreateArray();
            for (size_t c = 0; line && c < row->columns; c++)
                cJSON_AddItemToArray(line, json_real(field_rows_numbers_const(value)[k * row->columns + c]));
            cJSON_AddItemToArray(array, line);
        }
        return array;
    case FIELD_ENUM:
        return cJSON_CreateString(row->choices[*(const int *)value]);
    case FIELD_FLAGS:
        array = cJSON_CreateArray();
        for (int k = 0; row->choices[k] && array; k++)
            if (*(const unsigned *)value >> k & 1)
                cJSON_AddItemToArray(array, cJSON_CreateString(row->choices[k]));
        return array;
    case FIELD_GROUP:
        return encode_table(row->table, value);
    case FIELD_SWITCH:
        return *(const bool *)value ? encode_table(row->table, value) : cJSON_CreateNull();
    }
    return NULL;
}

void table_encode_into(cJSON *json, const struct field_table *table, const void *object)
{
    for (size_t k = 0; k < table->count; k++)
        json_put(json, table->fields[k].name, field_encode(&table->fields[k], (const char *)object + table->fields[k].offset));
}

static cJSON *encode_table(const struct field_table *table, const void *object)
{
    cJSON *json = cJSON_CreateObject();
    if (json)
        table_encode_into(json, table, object);
    return json;
}

cJSON *job_encode(const struct job_spec *job)
{
    unsigned long before = json_lacked();
    cJSON *json = cJSON_CreateObject();
    if (!json)
        return NULL;
    json_put_text(json, "scenario", job->scenario->name);
    table_encode_into(json, &job_table, job);
    json_put(json, "params", encode_table(job->scenario->params, job->params));
    cJSON *material = cJSON_CreateObject();
    json_put_text(material, "preset", job->material.preset);
    table_encode_into(material, scenario_material(job->scenario)->table, &job->material);
    json_put(json, "material", material);
    return json_whole(json, before); // a key that is not there would be read as its default
}

enum scree_status job_json_set(cJSON *json, const char *assignment, struct scree_error *err)
{
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment)
        return scree_fail(err, SCREE_INVALID, "", "\"%s\" is not path=value", assignment);
    unsigned long before = json_lacked();
    cJSON *value = NULL, *object = json;
    const char *digits = equals + 1;
    if (strspn(digits, "+-.0123456789eE") == strlen(digits) && strpbrk(digits, "0123456789") && !isfinite(strtod(digits, NULL)))
        return scree_fail(err, SCREE_INVALID, "", "%s: a number beyond the range of double precision", assignment);
    if (json_read(equals + 1, strlen(equals + 1), "value", &value, NULL))
        value = cJSON_CreateString(equals + 1);
    for (const char *rest = assignment; value && object && json_lacked() == before;) {
        char name[64];
        size_t length = strcspn(rest, ".=");
        if (length == 0 || length >= sizeof name || !cJSON_IsObject(object)) {
            cJSON_Delete(value);
            return scree_fail(err, SCREE_INVALID, "", "\"%.*s\" does not name a value of the job", (int)(equals - assignment),
                              assignment);
        }
        snprintf(name, sizeof name, "%.*s", (int)length, rest);
        if (rest[length] == '=') {
            cJSON_DeleteItemFromObjectCaseSensitive(object, name);
            json_put(object, name, value);
            value = NULL;
            if (json_lacked() == before)
                return SCREE_OK;
            break;
        }
        cJSON *next = cJSON_GetObjectItemCaseSensitive(object, name);
        if (!next || cJSON_IsNull(next)) {
            cJSON_DeleteItemFromObjectCaseSensitive(object, name);
            next = cJSON_AddObjectToObject(object, name);
        }
        object = next;
        rest += length + 1;
    }
    cJSON_Delete(value);
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to set %s", assignment);
}

/* ---- descriptions ---- */

static const char *const type_words[] = {"number",          "integer", "boolean", "text",   "vector of three numbers",
                                         "rows of numbers", "choice",  "choices", "object", "switch"};

cJSON *table_describe(const struct field_table *table)
{
    cJSON *list = cJSON_CreateArray();
    unsigned char *defaults = calloc(1, table->size);
    if (!list || !defaults)
        goto out;
    field_defaults(table, defaults);
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        cJSON *item = cJSON_CreateObject();
        if (!item)
            break;
        json_put_text(item, "name", row->name);
        json_put_text(item, "type", type_words[row->type]);
        if (row->type == FIELD_REAL || row->type == FIELD_INT || row->type == FIELD_VEC3 || row->type == FIELD_ROWS) {
            json_put_real(item, "min", row->min);
            json_put_real(item, "max", row->max);
        }
        if (row->type == FIELD_ROWS) {
            json_put_int(item, "rows", (long long)row->size);
            json_put_int(item, "columns", (long long)row->columns);
        }
        if (row->type != FIELD_GROUP)
            json_put(item, "default", field_encode(row, defaults + row->offset));
        if (row->choices) {
            cJSON *choices = cJSON_CreateArray();
            for (int c = 0; choices && row->choices[c]; c++)
                cJSON_AddItemToArray(choices, cJSON_CreateString(row->choices[c]));
            json_put(item, "choices", choices);
        }
        if (row->type == FIELD_TEXT)
            json_put_int(item, "max_bytes", (long long)row->size - 1);
        json_put_text(item, "unit", row->unit);
        json_put_text(item, "doc", row->doc);
        json_put_text(item, "source", row->source);
        json_put_bool(item, "steerable", row->steerable);
        if (row->table)
            json_put(item, "fields", table_describe(row->table));
        cJSON_AddItemToArray(list, item);
    }
out:
    free(defaults);
    return list;
}

cJSON *scenario_describe(const struct scenario_fields *scenario)
{
    cJSON *json = cJSON_CreateObject();
    if (!json)
        return NULL;
    json_put_text(json, "name", scenario->name);
    json_put_text(json, "doc", scenario->doc);
    json_put_text(json, "source", scenario->source);
    json_put_text(json, "material", scenario->material);
    json_put(json, "params", table_describe(scenario->params));
    json_put(json, "job", table_describe(&job_table));
    struct job_spec job;
    job_defaults(&job, scenario);
    json_put(json, "defaults", job_encode(&job));
    return json;
}

cJSON *material_describe(const struct material_preset *preset)
{
    cJSON *json = cJSON_CreateObject();
    if (!json)
        return NULL;
    json_put_text(json, "name", preset->name);
    json_put_text(json, "doc", preset->doc);
    json_put_text(json, "source", preset->source);
    json_put_text(json, "note", preset->note);
    json_put_text(json, "law", material_preset_kind(preset)->law);
    json_put(json, "values", encode_table(material_preset_kind(preset)->table, material_preset_values(preset)));
    if (material_preset_kind(preset) != &material_beads)
        return json;
    json_put_real(json, "shear_modulus_Pa", material_shear_modulus(&preset->values));
    json_put_real(json, "torsion_friction", material_torsion_friction(&preset->values));
    json_put_real(json, "contact_time_at_0.14_m_s_s", material_contact_time(&preset->values, 0.14));
    return json;
}

cJSON *job_cost_encode(const struct job_cost *cost)
{
    unsigned long before = json_lacked();
    cJSON *json = cJSON_CreateObject();
    json_put_real(json, "moving", cost->moving);
    json_put_real(json, "fixed", cost->fixed);
    json_put_real(json, "steps", cost->steps);
    json_put_real(json, "grain_steps", cost->moving * cost->steps);
    json_put_real(json, "bytes", cost->bytes);
    json_put_real(json, "seconds", job_cost_seconds(cost));
    json_put_real(json, "assumed_grain_steps_per_s", cost->rate);
    return json_whole(json, before);
}
