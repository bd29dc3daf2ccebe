/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From the descriptions that clients get (table_describe) to JSON Schema, draft
 * 2020-12, so that the schema can say nothing that the descriptions do not. */
#include "schema.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/study_json.h"

static void put_copy(cJSON *to, const char *key, const cJSON *from, const char *as)
{
    const cJSON *item = json_get(from, key);
    if (item)
        json_put(to, as, cJSON_Duplicate(item, true));
}

static cJSON *type_schema(const char *type)
{
    cJSON *schema = cJSON_CreateObject();
    json_put_text(schema, "type", type);
    return schema;
}

static cJSON *object_schema(bool nullable)
{
    cJSON *schema = type_schema("object");
    if (nullable) { // a switch: null is off
        const char *const types[] = {"object", "null"};
        cJSON_DeleteItemFromObjectCaseSensitive(schema, "type");
        json_put(schema, "type", cJSON_CreateStringArray(types, 2));
    }
    json_put_bool(schema, "additionalProperties", false);
    json_put(schema, "properties", cJSON_CreateObject());
    return schema;
}

static void add_fields(cJSON *schema, const cJSON *fields, bool defaults);

/* One row. `defaults` is false where they differ between scenarios. */
static cJSON *field_schema(const cJSON *row, bool defaults)
{
    const char *type = json_text(row, "type"), *unit = json_text(row, "unit"), *doc = json_text(row, "doc");
    cJSON *schema;
    if (strcmp(type, "number") == 0 || strcmp(type, "integer") == 0) {
        schema = type_schema(type);
        put_copy(schema, "min", row, "minimum");
        put_copy(schema, "max", row, "maximum");
    } else if (strcmp(type, "vector of three numbers") == 0) {
        cJSON *items = type_schema("number");
        schema = type_schema("array");
        put_copy(items, "min", row, "minimum");
        put_copy(items, "max", row, "maximum");
        json_put(schema, "items", items);
        json_put_int(schema, "minItems", 3);
        json_put_int(schema, "maxItems", 3);
    } else if (strcmp(type, "rows of numbers") == 0) {
        cJSON *items = type_schema("number"), *line = type_schema("array");
        schema = type_schema("array");
        put_copy(items, "min", row, "minimum");
        put_copy(items, "max", row, "maximum");
        json_put(line, "items", items);
        put_copy(line, "columns", row, "minItems");
        put_copy(line, "columns", row, "maxItems");
        json_put(schema, "items", line);
        put_copy(schema, "rows", row, "maxItems");
    } else if (strcmp(type, "choice") == 0) {
        schema = type_schema("string");
        put_copy(schema, "choices", row, "enum");
    } else if (strcmp(type, "choices") == 0) {
        cJSON *items = type_schema("string");
        schema = type_schema("array");
        put_copy(items, "choices", row, "enum");
        json_put(schema, "items", items);
        json_put_bool(schema, "uniqueItems", true);
    } else if (strcmp(type, "text") == 0) {
        schema = type_schema("string");
        put_copy(schema, "max_bytes", row, "maxLength");
    } else if (strcmp(type, "boolean") == 0) {
        schema = type_schema("boolean");
    } else {
        schema = object_schema(strcmp(type, "switch") == 0);
        add_fields(schema, json_get(row, "fields"), defaults);
    }
    if (*doc || *unit) {
        char text[512];
        snprintf(text, sizeof text, "%s%s%s%s", doc, *unit ? " (" : "", unit, *unit ? ")" : "");
        json_put_text(schema, "description", text);
    }
    if (defaults)
        put_copy(schema, "default", row, "default");
    return schema;
}

static void add_fields(cJSON *schema, const cJSON *fields, bool defaults)
{
    cJSON *properties = cJSON_GetObjectItemCaseSensitive(schema, "properties");
    for (const cJSON *row = fields ? fields->child : NULL; row; row = row->next)
        json_put(properties, json_text(row, "name"), field_schema(row, defaults));
}

static void add_table(cJSON *schema, const struct field_table *table, bool defaults)
{
    cJSON *fields = table_describe(table);
    add_fields(schema, fields, defaults);
    cJSON_Delete(fields);
}

/* Of one kind: its presets and its table. */
static cJSON *material_schema(const struct material_kind *kind)
{
    cJSON *schema = object_schema(false), *preset = type_schema("string"), *names = cJSON_CreateArray();
    for (size_t k = 0; k < material_preset_count; k++)
        if (material_preset_kind(&material_presets[k]) == kind)
            cJSON_AddItemToArray(names, cJSON_CreateString(material_presets[k].name));
    json_put(preset, "enum", names);
    json_put_text(preset, "description", "the published material that the other values start from");
    json_put_text(schema, "description", kind->table->doc);
    json_put(cJSON_GetObjectItemCaseSensitive(schema, "properties"), "preset", preset);
    add_table(schema, kind->table, false);
    return schema;
}

/* if scenario is this one, then params and material are its own and these are the defaults. */
static cJSON *scenario_branch(const struct scenario_fields *scenario)
{
    cJSON *branch = cJSON_CreateObject(), *when = cJSON_CreateObject(), *then = cJSON_CreateObject();
    cJSON *name = cJSON_CreateObject(), *is = cJSON_CreateObject(), *properties = cJSON_CreateObject();
    cJSON *params = object_schema(false);
    struct job_spec job;
    json_put_text(is, "const", scenario->name);
    json_put(name, "scenario", is);
    json_put(when, "properties", name);
    json_put(branch, "if", when);
    json_put_text(params, "description", scenario->doc);
    add_table(params, scenario->params, true);
    json_put(properties, "params", params);
    json_put(properties, "material", material_schema(scenario_material(scenario)));
    json_put(then, "properties", properties);
    job_defaults(&job, scenario);
    json_put(then, "default", job_encode(&job));
    json_put(branch, "then", then);
    return branch;
}

char *schema_text(void)
{
    const char *const required[] = {"scenario"};
    cJSON *schema = cJSON_CreateObject(), *scenario = type_schema("string"), *names = cJSON_CreateArray();
    cJSON *branches = cJSON_CreateArray(), *properties = cJSON_CreateObject();
    json_put_text(schema, "$schema", "https://json-schema.org/draft/2020-12/schema");
    json_put_text(schema, "title", "scree job");
    json_put_text(schema, "description", "made from the tables of src/spec by the build target write_schema");
    json_put_text(schema, "type", "object");
    json_put(schema, "required", cJSON_CreateStringArray(required, 1));
    json_put_bool(schema, "additionalProperties", false);
    for (size_t k = 0; k < scenario_count; k++) {
        cJSON_AddItemToArray(names, cJSON_CreateString(scenario_list[k]->name));
        cJSON_AddItemToArray(branches, scenario_branch(scenario_list[k]));
    }
    json_put(scenario, "enum", names);
    json_put(properties, "scenario", scenario);
    json_put(properties, "params", type_schema("object"));
    json_put(properties, "material", type_schema("object"));
    json_put(schema, "properties", properties);
    add_table(schema, &job_table, false);
    json_put(schema, "allOf", branches);
    char *text = json_print(schema, true);
    cJSON_Delete(schema);
    return text;
}

/* ---- studies ---- */

static cJSON *described(cJSON *schema, const char *text)
{
    json_put_text(schema, "description", text);
    return schema;
}

static cJSON *list_of(cJSON *items, int least, int most)
{
    cJSON *schema = type_schema("array");
    json_put(schema, "items", items);
    json_put_int(schema, "minItems", least);
    json_put_int(schema, "maxItems", most);
    return schema;
}

static cJSON *any_of(cJSON *a, cJSON *b)
{
    cJSON *schema = cJSON_CreateObject(), *list = cJSON_CreateArray();
    cJSON_AddItemToArray(list, a);
    cJSON_AddItemToArray(list, b);
    json_put(schema, "anyOf", list);
    return schema;
}

static cJSON *range_schema(void)
{
    static const char *const numbers[] = {"from", "to", "step", "count"}, *const required[] = {"from", "to"};
    cJSON *schema = object_schema(false), *properties = cJSON_GetObjectItemCaseSensitive(schema, "properties");
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        json_put(properties, numbers[k], type_schema("number"));
    json_put(properties, "log", type_schema("boolean"));
    json_put(schema, "required", cJSON_CreateStringArray(required, 2));
    return described(schema, "values from `from` to `to`, by step or count; with log the step is a factor");
}

/* Dotted paths to values; which paths there are depends on the job's scenario. */
static cJSON *paths_schema(cJSON *values, const char *text)
{
    cJSON *schema = type_schema("object");
    json_put(schema, "additionalProperties", values);
    return described(schema, text);
}

static cJSON *study_branch(enum study_kind kind)
{
    cJSON *about = study_describe(kind), *schema = object_schema(false), *is = cJSON_CreateObject(), *job = cJSON_CreateObject();
    cJSON *properties = cJSON_GetObjectItemCaseSensitive(schema, "properties"), *required = cJSON_CreateArray(),
          *any = cJSON_CreateBool(true);
    json_put_text(is, "const", json_text(about, "name"));
    json_put(properties, "study", is);
    add_fields(schema, json_get(about, "fields"), false);
    json_put_text(job, "$ref", "job.json");
    json_put(properties, "job", described(job, "the job that trials start from"));
    json_put(
        properties, "replica_seeds",
        described(list_of(type_schema("string"), 0, STUDY_SEEDS_MAX), "dotted paths of the numbers that replicas raise by one"));
    if (kind == STUDY_SWEEP) {
        json_put(properties, "grid",
                 paths_schema(any_of(list_of(any, 1, SWEEP_TRIALS_MAX), range_schema()), "dotted paths and the values each takes"));
        json_put(properties, "cases",
                 list_of(paths_schema(cJSON_CreateBool(true), "dotted paths and values"), 1, SWEEP_TRIALS_MAX));
    } else {
        cJSON_Delete(any);
    }
    cJSON *raise = cJSON_DetachItemFromObjectCaseSensitive(properties, "raise_low_when");
    if (raise) { // one word stands for what it means
        cJSON *word = cJSON_Duplicate(json_get(raise, "items"), true);
        json_put(properties, "raise_low_when", any_of(raise, word));
    }
    cJSON_AddItemToArray(required, cJSON_CreateString("study"));
    cJSON_AddItemToArray(required, cJSON_CreateString("job"));
    for (const cJSON *name = json_get(about, "required")->child; name; name = name->next)
        cJSON_AddItemToArray(required, cJSON_Duplicate(name, true));
    json_put(schema, "required", required);
    json_put_text(schema, "description", json_text(about, "doc"));
    cJSON_Delete(about);
    return schema;
}

char *study_schema_text(void)
{
    cJSON *schema = cJSON_CreateObject(), *branches = cJSON_CreateArray();
    json_put_text(schema, "$schema", "https://json-schema.org/draft/2020-12/schema");
    json_put_text(schema, "title", "scree study");
    json_put_text(schema, "description", "made from the tables of src/spec by the build target write_schema");
    for (int kind = 0; kind < STUDY_KINDS; kind++)
        cJSON_AddItemToArray(branches, study_branch((enum study_kind)kind));
    json_put(schema, "oneOf", branches);
    char *text = json_print(schema, true);
    cJSON_Delete(schema);
    return text;
}
