/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Jobs between JSON and structs, beyond round trips and the list of refusals:
 * what overrides what, switches, --set, descriptions, the schema, the examples. */
#include "unit.h"

#include <math.h>
#include <stdio.h>

#include "base/text.h"
#include "protocol/job_json.h"
#include "schema.h"

static enum scree_status decode(const char *text, struct job_spec *job, struct scree_error *err)
{
    cJSON *json = NULL;
    enum scree_status status = json_read(text, strlen(text), "t", &json, err);
    status = status ? status : job_decode(json, job, err);
    cJSON_Delete(json);
    return status;
}

static void decoded(const char *text, struct job_spec *job)
{
    struct scree_error err = {0};
    if (decode(text, job, &err))
        fail_msg("%s: %s", text, err.message);
}

/* A single value beats the preset in whatever order the keys stand. */
static void overrides_beat_the_preset(void **state)
{
    (void)state;
    struct job_spec job;
    decoded("{\"scenario\":\"incline\",\"material\":{\"mu_t\":0.5,\"preset\":\"foerster-3mm\",\"kappa\":0}}", &job);
    assert_true(job.material.mu_t == 0.5 && job.material.kappa == 0 && job.material.radius_m == 1.5e-3);
    assert_string_equal(job.material.preset, "foerster-3mm");
    decoded("{\"material\":{\"beta_s\":7.12e-8},\"scenario\":\"collision\"}", &job);
    assert_true(job.material.beta_s == 7.12e-8 && job.material.radius_m == 1e-3);
    assert_string_equal(job.material.preset, "glass-beads-2mm");
}

/* A scenario's own defaults come before what the user says, also when "scenario" stands last. */
static void scenario_defaults_come_first(void **state)
{
    (void)state;
    struct job_spec job;
    decoded("{\"time\":{\"end_s\":0.5},\"scenario\":\"collision\"}", &job);
    assert_true(job.time.end_s == 0.5 && job.time.step_s == 5e-8 && job.stop.when == 0);
    assert_true(job.record.contact.on && !job.record.basal_force.on && !job.record.bulk.on);
}

/* null is off, {} is on, and what is off keeps no values from before. */
static void switches_are_null_or_an_object(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    decoded("{\"scenario\":\"incline\",\"record\":{\"basal_force\":null,\"energy\":{},\"snapshots\":{\"every_s\":0.5}}}", &job);
    assert_false(job.record.basal_force.on);
    assert_true(job.record.basal_force.every_s == 2.5e-6);
    assert_true(job.record.energy.on && job.record.energy.every_s == 1e-3);
    assert_true(job.record.snapshots.on && job.record.snapshots.every_s == 0.5);
    assert_int_equal(decode("{\"scenario\":\"incline\",\"record\":{\"energy\":true}}", &job, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "record.energy", "record.energy: expected an object, got true or false");
    assert_int_equal(decode("{\"scenario\":\"incline\",\"record\":null}", &job, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "record", "record: expected an object, got null");
}

/* Each kind of value by its own refusal. */
/* Rows of numbers go in and out as they are; rows too many, too short, or of something else are refused by number. */
static void rows_of_numbers_are_read_row_by_row(void **state)
{
    (void)state;
    struct job_spec job, again;
    struct scree_error err;
    decoded("{\"scenario\":\"chute\",\"params\":{\"clast\":{\"spheres\":[[0,0,1e-4,2e-4],[0,0,-1e-4,3e-4]],\"mass_kg\":1e-6}}}",
            &job);
    const struct chute_params *p = (const struct chute_params *)(const void *)job.params;
    assert_true(p->clast.on && p->clast.spheres.count == 2 && p->clast.faces.count == 0);
    assert_true(p->clast.spheres.row[1][2] == -1e-4 && p->clast.spheres.row[1][3] == 3e-4 && p->clast.spheres.row[2][3] == 0);
    cJSON *json = job_encode(&job);
    char *printed = cJSON_PrintUnformatted(json); // numbers are raw text until then
    decoded(printed, &again);
    free(printed);
    cJSON_Delete(json);
    assert_true(field_same(job.scenario->params, job.params, again.params));
    const struct {
        const char *rows, *message;
    } refused[] = {{"[[0,0,1]]", "params.clast.spheres[0]: expected an array of 4 numbers"},
                   {"[[0,0,1,1],[0,0,1,\"x\"]]", "params.clast.spheres[1]: expected numbers"},
                   {"[[0,0,0,1e-3],[0,7,0,1e-3]]", "params.clast.spheres[1][1]: 7 is outside -1..1 m"},
                   {"7", "params.clast.spheres: expected an array of arrays of numbers"}};
    for (size_t k = 0; k < COUNT(refused); k++) {
        char text[256];
        snprintf(text, sizeof text, "{\"scenario\":\"chute\",\"params\":{\"clast\":{\"spheres\":%s}}}", refused[k].rows);
        assert_int_equal(decode(text, &job, &err), SCREE_INVALID);
        if (!strstr(err.message, refused[k].message))
            fail_msg("\"%s\"", err.message);
    }
}

static void refusals_name_what_was_expected(void **state)
{
    (void)state;
    const struct {
        const char *rest, *path, *message;
    } cases[] = {
        {"\"seed\":-1", "seed", "seed: -1 is outside 0..9007199254740992"},
        {"\"seed\":9007199254740994", "seed", "seed: 9007199254740994 is outside 0..9007199254740992"},
        {"\"seed\":1e300", "seed", "seed: 1e+300 is outside 0..9007199254740992"},
        {"\"seed\":1.1", "seed", "seed: 1.1 is not a whole number"},
        {"\"seed\":null", "seed", "seed: expected a whole number, got null"},
        {"\"threads\":0", "threads", "threads: 0 is outside 1..256"},
        {"\"time\":{\"step_s\":0}", "time.step_s", "time.step_s: 0 is outside 1e-12..1 s"},
        {"\"time\":[]", "time", "time: expected an object, got an array"},
        {"\"title\":7", "title", "title: expected a string, got a number"},
        {"\"stop\":{\"when\":\"rest\"}", "stop.when", "stop.when: expected an array of strings, got a string"},
        {"\"stop\":{\"when\":[\"rest\",3]}", "stop.when[1]", "stop.when[1]: expected a string, got a number"},
        {"\"record\":{\"basal_force\":{\"chunk\":15}}", "record.basal_force.chunk",
         "record.basal_force.chunk: 15 is outside 16..65536 samples"},
        {"\"params\":{\"partner\":\"ball\"}", "params.partner",
         "params.partner: \"ball\" is none of \"sphere\", \"fixed_sphere\", \"plane\", \"wall\", \"mirror\""},
        {"\"params\":{\"spin1_rad_s\":[0,\"x\",0]}", "params.spin1_rad_s[1]",
         "params.spin1_rad_s[1]: expected a number, got a string"},
        {"\"params\":{\"spin1_rad_s\":[0,0,1e7]}", "params.spin1_rad_s[2]",
         "params.spin1_rad_s[2]: 1e+07 is outside -1e+06..1e+06 rad/s"},
        {"\"params\":{\"spin1_rad_s\":3}", "params.spin1_rad_s",
         "params.spin1_rad_s: expected an array of three numbers, got a number"},
        {"\"material\":{\"preset\":3}", "material.preset", "material.preset: expected a string, got a number"},
        {"\"material\":{\"pre_set\":\"x\"}", "material.pre_set", "material.pre_set: unknown key; did you mean \"preset\"?"},
        {"\"colour\":1", "colour", "colour: unknown key"},
        {"\"\":1", "", ": unknown key"},
        {"\"a\\u001b[2J\":1", "a?[2J", "a?[2J: unknown key"},
    };
    for (size_t k = 0; k < COUNT(cases); k++) {
        char text[256];
        struct job_spec job;
        struct scree_error err = {0};
        snprintf(text, sizeof text, "{\"scenario\":\"collision\",%s}", cases[k].rest);
        assert_int_equal(decode(text, &job, &err), SCREE_INVALID);
        assert_error(&err, SCREE_INVALID, cases[k].path, cases[k].message);
    }
}

/* A bare name is the likeliest slip: the hint says how to write it. */
static void a_bare_material_name_gets_a_hint(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    assert_int_equal(decode("{\"scenario\":\"incline\",\"material\":\"glass-beads-2mm\"}", &job, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "material", "material: expected an object, got a string");
    assert_string_equal(err.hint, "a published material is {\"preset\": NAME}; `scree materials` lists them");
}

/* A misspelt "scenario" is told as such, not as a missing one. */
static void a_misspelt_scenario_key_is_recognised(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    assert_int_equal(decode("{\"senario\":\"incline\"}", &job, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "senario", "senario: unknown key; did you mean \"scenario\"?");
    assert_int_equal(decode("{\"scenario\":3}", &job, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "scenario", "scenario: expected a string, got a number");
}

/* A title has 127 bytes; the last is accepted, one more is refused, none is cut. */
static void texts_are_bounded_in_bytes(void **state)
{
    (void)state;
    for (size_t size = 127; size <= 128; size++) {
        char title[160], text[256];
        struct job_spec job;
        struct scree_error err;
        memset(title, 't', size);
        title[size] = 0;
        snprintf(text, sizeof text, "{\"scenario\":\"incline\",\"title\":\"%s\"}", title);
        assert_int_equal(decode(text, &job, &err), size == 127 ? SCREE_OK : SCREE_INVALID);
        if (size == 127)
            assert_string_equal(job.title, title);
        else
            assert_error(&err, SCREE_INVALID, "title", "title: 128 bytes are more than the 127 that are accepted");
    }
}

static enum scree_status set(const char *assignment, struct job_spec *job, struct scree_error *err)
{
    cJSON *json = NULL;
    const char *text = "{\"scenario\":\"incline\",\"params\":{\"nx\":3},\"record\":{\"energy\":null}}";
    assert_int_equal(json_read(text, strlen(text), "t", &json, NULL), SCREE_OK);
    enum scree_status status = job_json_set(json, assignment, err);
    status = status ? status : job_decode(json, job, err);
    cJSON_Delete(json);
    return status;
}

/* --set takes JSON where it is JSON and text where it is not. */
static void set_reads_values(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    const struct incline_params *p = (const void *)job.params;
    assert_int_equal(set("params.nx=30", &job, &err), SCREE_OK);
    assert_int_equal(p->nx, 30);
    assert_int_equal(set("title=a = b, c", &job, &err), SCREE_OK);
    assert_string_equal(job.title, "a = b, c");
    assert_int_equal(set("title=\"12\"", &job, &err), SCREE_OK);
    assert_string_equal(job.title, "12");
    assert_int_equal(set("title=", &job, &err), SCREE_OK);
    assert_string_equal(job.title, "");
    assert_int_equal(set("record.energy.every_s=0.25", &job, &err), SCREE_OK); // null becomes an object on the way
    assert_true(job.record.energy.on && job.record.energy.every_s == 0.25);
    assert_int_equal(set("record.basal_force=null", &job, &err), SCREE_OK);
    assert_false(job.record.basal_force.on);
    assert_int_equal(set("scenario=collision", &job, &err), SCREE_INVALID); // nx is not a collision's
    assert_string_equal(err.path, "params.nx");
}

/* What --set cannot do it says, before anything is sent. */
static void set_refuses(void **state)
{
    (void)state;
    struct job_spec job;
    const struct {
        const char *assignment, *path, *message;
    } cases[] = {
        {"params.nx", "", "\"params.nx\" is not path=value"},
        {"=3", "", "\"=3\" is not path=value"},
        {"params.=3", "", "\"params.\" does not name a value of the job"},
        {".nx=3", "", "\".nx\" does not name a value of the job"},
        {"params.nx.y=3", "", "\"params.nx.y\" does not name a value of the job"},
        {"params.slope_deg=1e400", "", "params.slope_deg=1e400: a number beyond the range of double precision"},
        {"params.slope_deg=NaN", "params.slope_deg", "params.slope_deg: expected a number, got a string"},
        {"params.nx=01", "params.nx", "params.nx: expected a whole number, got a string"},
        {"params.slop_deg=3", "params.slop_deg", "params.slop_deg: unknown key; did you mean \"slope_deg\"?"},
        {"title=a\xc3", "title", "title: control characters and bytes that are not UTF-8 are not accepted"},
    };
    for (size_t k = 0; k < COUNT(cases); k++) {
        struct scree_error err = {0};
        assert_int_equal(set(cases[k].assignment, &job, &err), SCREE_INVALID);
        assert_error(&err, SCREE_INVALID, cases[k].path, cases[k].message);
    }
}

/* Help is made from the tables: nothing a user can say may be missing from it. */
static void descriptions_are_complete(void **state)
{
    (void)state;
    for (size_t k = 0; k < scenario_count; k++) {
        cJSON *json = scenario_describe(scenario_list[k]);
        assert_string_equal(json_text(json, "name"), scenario_list[k]->name);
        const cJSON *rows = json_get(json, "params");
        assert_int_equal(cJSON_GetArraySize(rows), scenario_list[k]->params->count);
        for (size_t r = 0; r < scenario_list[k]->params->count; r++) {
            const struct field *field = &scenario_list[k]->params->fields[r];
            const cJSON *row = cJSON_GetArrayItem(rows, (int)r);
            assert_string_equal(json_text(row, "name"), field->name);
            assert_string_equal(json_text(row, "unit"), field->unit);
            assert_string_equal(json_text(row, "doc"), field->doc);
            assert_int_equal(json_bool(row, "steerable", !field->steerable), field->steerable);
            assert_non_null(json_get(row, field->type == FIELD_GROUP ? "fields" : "default"));
        }
        struct job_spec job;
        char *text = json_print(json_get(json, "defaults"), false); // numbers are text in a tree that was made
        decoded(text, &job);
        free(text);
        cJSON_Delete(json);
    }
    cJSON *glass = material_describe(material_preset_find("glass-beads-2mm"));
    assert_non_null(strstr(json_text(glass, "note"), "71.2 ns"));
    cJSON_Delete(glass);
}

static char *file_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("cannot read %s", path);
    char *text = calloc(1, JSON_BYTES_MAX + 1);
    assert_non_null(text);
    assert_true(fread(text, 1, JSON_BYTES_MAX, file) > 0);
    fclose(file);
    return text;
}

/* The schema that others read is the one the tables make. */
static void the_schema_is_up_to_date(void **state)
{
    (void)state;
    char path[512], *made = schema_text();
    snprintf(path, sizeof path, "%s/protocol/schema/job.json", source_folder());
    char *kept = file_text(path);
    size_t size = strlen(made);
    if (strncmp(kept, made, size) != 0 || strcmp(kept + size, "\n") != 0)
        fail_msg("protocol/schema/job.json differs from the tables: build write_schema and write it anew");
    cJSON *schema = NULL;
    assert_int_equal(json_read(made, size, "schema", &schema, NULL), SCREE_OK);
    const cJSON *nx = json_get(schema, "allOf")->child;
    for (const char *const *step = (const char *const[]){"then", "properties", "params", "properties", "nx", NULL}; *step; step++)
        nx = json_get(nx, *step);
    assert_true(json_number(nx, "minimum", 0) == 2 && json_number(nx, "maximum", 0) == 4000);
    cJSON_Delete(schema);
    free(made);
    free(kept);
}

/* The examples are the first thing a user runs. */
static void examples_are_accepted(void **state)
{
    (void)state;
    const char *const names[] = {"slidequake",      "collision",         "foerster",          "rest",
                                 "calibrate-yield", "calibrate-rocking", "contact-parameters"};
    for (size_t k = 0; k < COUNT(names); k++) {
        char path[512];
        cJSON *json = NULL;
        struct job_spec job;
        struct scree_error err = {0};
        snprintf(path, sizeof path, "%s/client/examples/%s.json", source_folder(), names[k]);
        enum scree_status status = json_read_file(path, &json, &err);
        status = status ? status : job_decode(json, &job, &err);
        status = status ? status : job_check(&job, 1e9, &err);
        cJSON_Delete(json);
        if (status)
            fail_msg("%s: %s", names[k], err.message);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(overrides_beat_the_preset),
        cmocka_unit_test(scenario_defaults_come_first),
        cmocka_unit_test(switches_are_null_or_an_object),
        cmocka_unit_test(rows_of_numbers_are_read_row_by_row),
        cmocka_unit_test(refusals_name_what_was_expected),
        cmocka_unit_test(a_bare_material_name_gets_a_hint),
        cmocka_unit_test(a_misspelt_scenario_key_is_recognised),
        cmocka_unit_test(texts_are_bounded_in_bytes),
        cmocka_unit_test(set_reads_values),
        cmocka_unit_test(set_refuses),
        cmocka_unit_test(descriptions_are_complete),
        cmocka_unit_test(the_schema_is_up_to_date),
        cmocka_unit_test(examples_are_accepted),
    };
    return cmocka_run_group_tests_name("job_json", tests, NULL, NULL);
}
