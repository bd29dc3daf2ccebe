/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Jobs between JSON and structs: round trips to the bit, and every refusal by its text. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "protocol/job_json.h"

static enum scree_status decode(const char *text, struct job_spec *job, struct scree_error *error)
{
    cJSON *json = NULL;
    enum scree_status status = json_read(text, strlen(text), "job.json", &json, error);
    if (!status)
        status = job_decode(json, job, error);
    if (!status)
        status = job_check(job, 1e9, error);
    cJSON_Delete(json);
    return status;
}

/* Each bad input of the list, its path and its whole message. */
static void refusals_name_path_value_range_and_unit(void **state)
{
    (void)state;
    static const struct {
        const char *text, *path, *message;
        enum scree_status status;
    } bad[] = {
        {"{\"scenario\":\"incline\",\"params\":{\"slope_deg\":123}}", "params.slope_deg",
         "params.slope_deg: 123 is outside 0..60 deg", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"slop_deg\":12}}", "params.slop_deg",
         "params.slop_deg: unknown key; did you mean \"slope_deg\"?", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"slope\":12}}", "params.slope",
         "params.slope: unknown key; did you mean \"slope_deg\"?", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"param\":{}}", "param", "param: unknown key; did you mean \"params\"?", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"slope_deg\":\"23\"}}", "params.slope_deg",
         "params.slope_deg: expected a number, got a string", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"nx\":2.5}}", "params.nx", "params.nx: 2.5 is not a whole number", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"nx\":1}}", "params.nx", "params.nx: 1 is outside 2..4000 grain diameters",
         SCREE_INVALID},
        {"{\"scenario\":\"inclin\"}", "scenario",
         "scenario: \"inclin\" is none of \"incline\", \"channel\", \"collision\", \"chute\", \"collapse\", \"tilt\", "
         "\"layer\", \"gas\", \"settle\", \"dam_break\", \"hopper\", \"rolling\", \"damping\", \"plastic_yield\", "
         "\"contact_parameters\"",
         SCREE_INVALID},
        {"{}", "scenario", "scenario: is missing; it names the set-up, as `scree scenarios` lists them", SCREE_INVALID},
        {"[1]", "", "the job: expected an object, got an array", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"material\":{\"preset\":\"steel\"}}", "material.preset",
         "material.preset: \"steel\" is none of \"glass-beads-2mm\", \"foerster-3mm\"", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"material\":{\"mu_t\":-1}}", "material.mu_t", "material.mu_t: -1 is outside 0..10",
         SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"stop\":{\"when\":[\"rest\",\"rest\"]}}", "stop.when[1]",
         "stop.when[1]: \"rest\" stands twice", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"stop\":{\"when\":[\"still\"]}}", "stop.when[0]",
         "stop.when[0]: \"still\" is none of \"rest\", \"steady\", \"accelerating\"", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"record\":{\"basal_force\":{\"every_s\":1e-9}}}", "record.basal_force.every_s",
         "record.basal_force.every_s: 1e-09 s is below the time step of 2.5e-07 s", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"title\":\"a\\u0007b\"}", "title",
         "title: control characters and bytes that are not UTF-8 are not accepted", SCREE_INVALID},
        {"{\"scenario\":\"collision\",\"params\":{\"gap_m\":-1e-6}}", "params.gap_m", "params.gap_m: -1e-06 is outside 0..1 m",
         SCREE_INVALID},
        {"{\"scenario\":\"collision\",\"params\":{\"spin1_rad_s\":[1,2]}}", "params.spin1_rad_s",
         "params.spin1_rad_s: expected an array of three numbers, got 2", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"nx\":400,\"ny\":400,\"nz\":100}}", "params",
         "this world needs 16.2 GB of memory and 1 GB are to be had", SCREE_NO_MEMORY},
        {"{\"scenario\":\"incline\",\"seed\":1,\"seed\":2}", "seed", "seed: the key \"seed\" stands twice", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"slope_deg\":1e400}}", "",
         "job.json:1:45: a number beyond the range of double precision", SCREE_INVALID},
        {"{\"scenario\":\"incline\",\"params\":{\"slope_deg\":NaN}}", "", "job.json:1:45: NaN and Infinity are not numbers in JSON",
         SCREE_INVALID},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        struct job_spec job;
        struct scree_error error = {0};
        assert_int_equal(decode(bad[k].text, &job, &error), bad[k].status);
        assert_string_equal(error.message, bad[k].message);
        assert_string_equal(error.path, bad[k].path);
    }
}

static void too_long_a_step_says_the_largest_and_why(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error error = {0};
    assert_int_equal(decode("{\"scenario\":\"incline\",\"time\":{\"step_s\":1e-5}}", &job, &error), SCREE_INVALID);
    assert_string_equal(error.path, "time.step_s");
    assert_non_null(strstr(error.message, "1e-05 s is above the largest stable step"));
    /* The step that is named is accepted; softer grains take a longer one, by the power -2/5. */
    double stable = 0.9 * material_stable_step(&job.material, 1.0); // the smallest grains are a little stiffer
    char text[192];
    snprintf(text, sizeof text, "{\"scenario\":\"incline\",\"time\":{\"step_s\":%.17g}}", stable);
    assert_int_equal(decode(text, &job, &error), SCREE_OK);
    snprintf(
        text, sizeof text,
        "{\"scenario\":\"incline\",\"material\":{\"young_Pa\":74e6},\"record\":{\"basal_force\":null},\"time\":{\"step_s\":%.17g}}",
        stable * 15.8);
    assert_int_equal(decode(text, &job, &error), SCREE_OK);
}

/* ---- random specs ---- */

static double random_real(struct rng *rng, double low, double high)
{
    if (rng_next(rng) % 4 == 0)
        return rng_next(rng) % 2 ? low : high;
    if (low > 0 && high / low > 100)
        return fmin(high, fmax(low, low * pow(high / low, rng_uniform(rng, 0, 1))));
    return rng_uniform(rng, low, high);
}

static void randomise(struct rng *rng, const struct field_table *table, void *object)
{
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        void *value = (char *)object + row->offset;
        size_t choices = 0, length;
        for (; row->choices && row->choices[choices]; choices++)
            ;
        switch (row->type) {
        case FIELD_REAL:
            *(double *)value = random_real(rng, row->min, row->max);
            break;
        case FIELD_INT:
            *(int64_t *)value = (int64_t)floor(random_real(rng, row->min, row->max));
            break;
        case FIELD_BOOL:
            *(bool *)value = rng_next(rng) % 2;
            break;
        case FIELD_VEC3:
            for (int a = 0; a < 3; a++)
                ((double *)value)[a] = random_real(rng, row->min, row->max);
            break;
        case FIELD_ROWS:
            length = rng_next(rng) % (row->size + 1);
            *(int64_t *)value = (int64_t)length;
            for (size_t c = 0; c < length * row->columns; c++)
                field_rows_numbers(value)[c] = random_real(rng, row->min, row->max);
            break;
        case FIELD_ENUM:
            *(int *)value = (int)(rng_next(rng) % choices);
            break;
        case FIELD_FLAGS:
            *(unsigned *)value = (unsigned)(rng_next(rng) % (1u << choices));
            break;
        case FIELD_TEXT:
            length = rng_next(rng) % row->size;
            memset(value, 0, row->size);
            for (size_t c = 0; c < length; c++)
                ((char *)value)[c] = (char)(0x20 + rng_next(rng) % 0x5f);
            break;
        case FIELD_GROUP:
            randomise(rng, row->table, value);
            break;
        case FIELD_SWITCH:
            field_defaults(row->table, value);
            *(bool *)value = rng_next(rng) % 2;
            if (*(bool *)value)
                randomise(rng, row->table, value);
            break;
        }
    }
}

/* decode(encode(job)) is the job, to the bit, for every value that the tables allow. */
static void random_specs_survive_the_round_trip(void **state)
{
    (void)state;
    struct rng rng = rng_start(17, 1);
    for (int k = 0; k < 10000; k++) {
        struct job_spec job, back;
        struct scree_error error = {0};
        cJSON *again = NULL;
        job_defaults(&job, scenario_list[rng_next(&rng) % scenario_count]);
        randomise(&rng, &job_table, &job);
        randomise(&rng, job.scenario->params, job.params);
        randomise(&rng, scenario_material(job.scenario)->table, &job.material);
        cJSON *json = job_encode(&job);
        char *text = json_print(json, false);
        assert_int_equal(json_read(text, strlen(text), "t", &again, &error), SCREE_OK);
        if (job_decode(again, &back, &error))
            fail_msg("%s\n%s", error.message, text);
        /* What is switched off keeps no values; compare what JSON says and the values of what is on. */
        cJSON *second = job_encode(&back);
        char *text2 = json_print(second, false);
        assert_string_equal(text, text2);
        assert_memory_equal(job.params, back.params, job.scenario->params->size);
        size_t name = sizeof job.material.preset; // every kind's struct begins with it
        assert_memory_equal((char *)&job.material + name, (char *)&back.material + name,
                            scenario_material(job.scenario)->table->size - name);
        assert_memory_equal(&job.time, &back.time, sizeof job.time);
        assert_int_equal(job.seed, back.seed);
        assert_string_equal(job.title, back.title);
        free(text);
        free(text2);
        cJSON_Delete(json);
        cJSON_Delete(again);
        cJSON_Delete(second);
    }
}

/* Table S1 is what an empty job means. */
static void defaults_reproduce_the_paper(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error error = {0};
    assert_int_equal(decode("{\"scenario\":\"incline\"}", &job, &error), SCREE_OK);
    const struct incline_params *p = (const struct incline_params *)(const void *)job.params;
    assert_true(job.material.beta_s == 45.1e-9 && job.material.mu_t == 0.237 && job.material.kappa == 0.742);
    assert_true(job.material.beta_r_s == 2e-3 && job.material.mu_r == 0.0175 && job.material.young_Pa == 74e9);
    assert_true(job.time.step_s == 2.5e-7 && p->nx == 10 && p->ny == 10 && p->nz == 10);
}

static void set_writes_into_the_tree(void **state)
{
    (void)state;
    cJSON *json = NULL;
    struct scree_error error;
    struct job_spec job;
    assert_int_equal(json_read("{\"scenario\":\"incline\"}", 22, "t", &json, NULL), SCREE_OK);
    assert_int_equal(job_json_set(json, "params.slope_deg=21.9", &error), SCREE_OK);
    assert_int_equal(job_json_set(json, "material.preset=foerster-3mm", &error), SCREE_OK);
    assert_int_equal(job_json_set(json, "record.energy={}", &error), SCREE_OK);
    assert_int_equal(job_json_set(json, "stop.when=[]", &error), SCREE_OK);
    assert_int_equal(job_decode(json, &job, &error), SCREE_OK);
    assert_true(((const struct incline_params *)(const void *)job.params)->slope_deg == 21.9);
    assert_true(job.material.radius_m == 1.5e-3 && job.record.energy.on && job.stop.when == 0);
    assert_int_equal(job_json_set(json, "params.slope_deg", &error), SCREE_INVALID);
    assert_int_equal(job_json_set(json, "=3", &error), SCREE_INVALID);
    assert_int_equal(job_json_set(json, "scenario.x=3", &error), SCREE_INVALID);
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refusals_name_path_value_range_and_unit),
        cmocka_unit_test(too_long_a_step_says_the_largest_and_why),
        cmocka_unit_test(random_specs_survive_the_round_trip),
        cmocka_unit_test(defaults_reproduce_the_paper),
        cmocka_unit_test(set_writes_into_the_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
