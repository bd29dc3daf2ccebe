/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Studies between JSON and what runs them: what they expand to, how each mistake
 * is refused, that the resolved study is the same study, schema and examples. */
#include "unit.h"

#include <stdio.h>

#include "protocol/study_json.h"
#include "schema.h"

#define FLOW   "\"job\":{\"scenario\":\"incline\"}"
#define SWEEP  "{\"study\":\"sweep\"," FLOW ","
#define BISECT "{\"study\":\"bisect\"," FLOW ",\"over\":\"material.mu_t\",\"low\":0,\"high\":1,"
#define HIT    "\"job\":{\"scenario\":\"collision\"}"
#define ROOT   "{\"study\":\"root\"," HIT ",\"over\":\"material.beta_s\",\"low\":1e-9,\"high\":1e-7,"

static enum scree_status decode(const char *text, struct study_plan *plan, struct scree_error *err)
{
    cJSON *json = NULL;
    memset(plan, 0, sizeof *plan);
    enum scree_status status = json_read(text, strlen(text), "t", &json, err);
    if (!status && !(status = study_decode(json, plan, err)))
        status = study_plan_check(plan, 1e9, NULL, NULL, NULL, err);
    cJSON_Delete(json);
    return status;
}

static void decoded(const char *text, struct study_plan *plan)
{
    struct scree_error err = {0};
    if (decode(text, plan, &err))
        fail_msg("%s: %s", text, err.message);
}

static double real_at(const struct job_spec *job, const char *path)
{
    const char *unit;
    cJSON *value = job_value_at(job, path, &unit);
    assert_non_null(value);
    double number = strtod(value->valuestring, NULL);
    cJSON_Delete(value);
    return number;
}

/* The last axis runs fastest but for the replicas; seeds follow the replica alone. */
static void a_grid_becomes_its_trials(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_spec job;
    decoded(SWEEP "\"grid\":{\"params.slope_deg\":{\"from\":22,\"to\":22.2,\"step\":0.1},\"params.nz\":[4,8]},\"replicas\":2}",
            &plan);
    assert_int_equal(plan.trials, 12);
    for (size_t k = 0; k < plan.trials; k++) {
        static const double slopes[] = {22, 22.1, 22.2};
        assert_int_equal(study_plan_trial(&plan, k, &job, NULL), SCREE_OK);
        assert_true(real_at(&job, "params.slope_deg") == slopes[k / 4]);
        assert_true(real_at(&job, "params.nz") == (k / 2 % 2 ? 8 : 4));
        assert_int_equal(job.seed, 1 + k % 2);
        assert_int_equal(study_plan_replica(&plan, k), k % 2);
        assert_true(real_at(&job, "params.base_seed") == 1);
    }
    study_plan_free(&plan);
}

static void cases_take_their_own_values(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_spec job;
    decoded("{\"study\":\"sweep\",\"job\":{\"scenario\":\"incline\",\"seed\":5,\"params\":{\"nz\":3}},\"replicas\":2,"
            "\"replica_seeds\":[\"seed\",\"params.base_seed\"],"
            "\"cases\":[{\"params.slope_deg\":21,\"params.nz\":6},{\"material.mu_t\":0.5},{}]}",
            &plan);
    assert_int_equal(plan.trials, 6);
    assert_int_equal(plan.column_count, 3);
    assert_int_equal(study_plan_trial(&plan, 0, &job, NULL), SCREE_OK);
    assert_true(real_at(&job, "params.slope_deg") == 21 && real_at(&job, "params.nz") == 6 && job.seed == 5);
    assert_int_equal(study_plan_trial(&plan, 3, &job, NULL), SCREE_OK);
    assert_true(real_at(&job, "params.slope_deg") == 23.5 && real_at(&job, "params.nz") == 3 && job.material.mu_t == 0.5);
    assert_true(job.seed == 6 && real_at(&job, "params.base_seed") == 2);
    assert_int_equal(study_plan_trial(&plan, 4, &job, NULL), SCREE_OK);
    assert_true(real_at(&job, "params.nz") == 3 && job.material.mu_t == 0.237 && job.seed == 5);
    study_plan_free(&plan);
}

/* A preset is what the other values of a material are read on top of: it must not be swept over resolved ones. */
static void a_swept_preset_brings_its_own_values(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_spec job;
    decoded("{\"study\":\"sweep\",\"job\":{\"scenario\":\"collision\",\"material\":{\"mu_t\":0.3}},"
            "\"grid\":{\"material.preset\":[\"glass-beads-2mm\",\"foerster-3mm\"]}}",
            &plan);
    assert_int_equal(study_plan_trial(&plan, 1, &job, NULL), SCREE_OK);
    assert_true(job.material.radius_m == 1.5e-3 && job.material.mu_t == 0.3);
    study_plan_free(&plan);
}

/* Likewise a published run, which a scenario's other params start from. */
static void a_swept_run_brings_its_own_values(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_spec job;
    decoded("{\"study\":\"sweep\",\"job\":{\"scenario\":\"collapse\",\"params\":{\"width_m\":0.04}},"
            "\"grid\":{\"params.run\":[\"B00\",\"B15\"]}}",
            &plan);
    assert_int_equal(study_plan_trial(&plan, 1, &job, NULL), SCREE_OK);
    const struct collapse_params *p = (const struct collapse_params *)(const void *)job.params;
    assert_true(p->slope_deg == 15 && p->height_m == 0.1108 && p->width_m == 0.04);
    study_plan_free(&plan);
}

/* A case may name a scenario of its own; its other values are that one's. */
static void a_case_may_name_its_scenario(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_spec job;
    struct scree_error err;
    decoded("{\"study\":\"sweep\",\"job\":{\"scenario\":\"incline\",\"params\":{\"slope_deg\":21}},"
            "\"cases\":[{\"params.nz\":3},{\"params.depth_m\":0.03,\"scenario\":\"layer\"}]}",
            &plan);
    assert_int_equal(study_plan_trial(&plan, 1, &job, NULL), SCREE_OK);
    const struct layer_params *p = (const struct layer_params *)(const void *)job.params;
    assert_true(job.scenario->kind == SCENARIO_MPM && p->slope_deg == 21 && p->depth_m == 0.03);
    study_plan_free(&plan);
    assert_int_equal(decode("{\"study\":\"sweep\",\"job\":{\"scenario\":\"incline\"},"
                            "\"cases\":[{\"scenario\":\"layer\",\"params.nz\":3}]}",
                            &plan, &err),
                     SCREE_INVALID);
    assert_string_equal(err.path, "cases[0].params.nz");
    study_plan_free(&plan);
}

/* A flow that accelerates goes on all the more: one word means both, and both then end a trial early. */
static void steady_means_flowing(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_spec job;
    decoded(BISECT "\"raise_low_when\":\"steady\"}", &plan);
    assert_int_equal(plan.spec.raise_low_when, STOP_STEADY | STOP_ACCELERATING);
    assert_int_equal(plan.base.stop.when, STOP_REST | STOP_STEADY | STOP_ACCELERATING);
    assert_int_equal(study_plan_search(&plan, 0.25, 2, 0, &job, NULL), SCREE_OK);
    assert_true(job.material.mu_t == 0.25 && job.seed == 3 && job.time.end_s == 80); // stops at any verdict: as far as it may go
    assert_int_equal(study_plan_search(&plan, 0.25, 0, 40, &job, NULL), SCREE_OK);
    assert_true(job.time.end_s == 40 && study_plan_extension(&plan) == 80);
    study_plan_free(&plan);
    decoded(BISECT "\"raise_low_when\":[\"steady\"],\"extend_to_s\":30}", &plan);
    assert_int_equal(plan.spec.raise_low_when, STOP_STEADY);
    assert_int_equal(plan.base.stop.when, STOP_REST | STOP_STEADY); // accelerating would not be sound
    assert_true(study_plan_extension(&plan) == 30);
    study_plan_free(&plan);
    decoded("{\"study\":\"bisect\",\"job\":{\"scenario\":\"incline\",\"stop\":{\"when\":[\"rest\"]}},\"over\":\"params.slope_deg\","
            "\"low\":0,\"high\":60,\"raise_low_when\":\"rest\"}",
            &plan);
    assert_int_equal(plan.spec.raise_low_when, STOP_REST);
    assert_int_equal(plan.base.stop.when, STOP_REST); // what the job says stands
    study_plan_free(&plan);
}

static void refusals_name_the_place(void **state)
{
    (void)state;
    const struct {
        const char *text, *path, *message;
    } cases[] = {
        {"[]", "", "the study: an object is expected"},
        {"{\"study\":3}", "study", "study: \"sweep\", \"bisect\" or \"root\" is expected"},
        {"{\"study\":\"bisekt\"}", "study",
         "study: \"bisekt\" is none of \"sweep\", \"bisect\", \"root\"; did you mean \"bisect\"?"},
        {"{\"study\":\"sweep\",\"grid\":{}}", "job", "job: is missing; it is the job that the trials start from"},
        {"{\"study\":\"sweep\",\"grid\":{},\"job\":{\"study\":\"sweep\"}}", "job", "job: a study cannot be the job of a study"},
        {"{\"study\":\"sweep\",\"grid\":{},\"job\":{\"scenario\":\"incline\",\"params\":{\"slope_deg\":123}}}",
         "job.params.slope_deg", "job.params.slope_deg: 123 is outside 0..60 deg"},
        {"{\"study\":\"sweep\",\"grid\":{},\"job\":[]}", "job", "job: the job: expected an object, got an array"},
        {SWEEP "\"gird\":{}}", "gird", "gird: unknown key; did you mean \"grid\"?"},
        {SWEEP "\"replicas\":0,\"grid\":{}}", "replicas", "replicas: 0 is outside 1..64"},
        {SWEEP "\"replicas\":2.5,\"grid\":{}}", "replicas", "replicas: 2.5 is not a whole number"},
        {SWEEP "\"replicas\":2}", "grid", "grid: one of \"grid\" and \"cases\" says what the trials are"},
        {SWEEP "\"grid\":{},\"cases\":[{}]}", "grid", "grid: one of \"grid\" and \"cases\" says what the trials are"},
        {SWEEP "\"grid\":{\"params.slop_deg\":[1]}}", "grid.params.slop_deg",
         "grid.params.slop_deg: unknown key; did you mean \"slope_deg\"?"},
        {SWEEP "\"grid\":{\"parms.nx\":[1]}}", "grid.parms.nx", "grid.parms.nx: unknown key; did you mean \"params\"?"},
        {SWEEP "\"grid\":{\"time\":[1]}}", "grid.time", "grid.time: is a group of values; name one of them"},
        {SWEEP "\"grid\":{\"seed.x\":[1]}}", "grid.seed.x", "grid.seed.x: \"seed\" has no parts"},
        {SWEEP "\"grid\":{\"params.nx\":[]}}", "grid.params.nx",
         "grid.params.nx: a list of values or {\"from\", \"to\", \"step\" or \"count\"} is expected"},
        {SWEEP "\"grid\":{\"params.nx\":3}}", "grid.params.nx",
         "grid.params.nx: a list of values or {\"from\", \"to\", \"step\" or \"count\"} is expected"},
        {SWEEP "\"grid\":{\"params.nx\":[3,\"four\"]}}", "grid.params.nx[1]",
         "grid.params.nx[1]: expected a whole number, got a string"},
        {SWEEP "\"grid\":{\"params.nx\":[3,4.5]}}", "grid.params.nx[1]", "grid.params.nx[1]: 4.5 is not a whole number"},
        {SWEEP "\"grid\":{\"params.slope_deg\":{\"from\":50,\"to\":70,\"step\":10}}}", "grid.params.slope_deg[2]",
         "grid.params.slope_deg[2]: 70 is outside 0..60 deg"},
        {SWEEP "\"grid\":{\"params.nx\":{\"from\":3,\"two\":4,\"step\":1}}}", "grid.params.nx.two",
         "grid.params.nx.two: unknown key; did you mean \"to\"?"},
        {SWEEP "\"grid\":{\"params.nx\":{\"to\":4,\"step\":1}}}", "grid.params.nx",
         "grid.params.nx: a range has \"from\" and \"to\", and \"step\" or \"count\""},
        {SWEEP "\"grid\":{\"params.nx\":{\"from\":3,\"to\":4,\"step\":true}}}", "grid.params.nx.step",
         "grid.params.nx.step: expected a number"},
        {SWEEP "\"grid\":{\"seed\":[1,2]},\"replicas\":2}", "grid.seed",
         "grid.seed: replicas change this, too: take one of the two"},
        {SWEEP "\"grid\":{\"seed\":{\"from\":1,\"to\":5000,\"step\":1}}}", "grid.seed",
         "grid.seed: 5000 values are more than the 4096 trials that a sweep may have"},
        {SWEEP "\"grid\":{\"seed\":{\"from\":1,\"to\":100,\"step\":1},\"params.nx\":{\"from\":2,\"to\":101,\"step\":1}}}", "grid",
         "grid: 10000 trials are more than the 4096 that a sweep may have"},
        {SWEEP "\"cases\":[{\"params.nx\":4},{\"params.nx\":1}]}", "cases[1].params.nx",
         "cases[1].params.nx: 1 is outside 2..4000 grain diameters"},
        {SWEEP "\"cases\":[3]}", "cases[0]", "cases[0]: an object of dotted paths and values is expected"},
        {SWEEP "\"cases\":{}}", "cases", "cases: a list of objects of dotted paths and values is expected"},
        {SWEEP "\"cases\":[{}],\"replica_seeds\":[\"title\"]}", "replica_seeds[0]",
         "replica_seeds[0]: title is not a whole number that replicas could raise"},
        {SWEEP "\"cases\":[{}],\"replicas\":2,\"replica_seeds\":[]}", "replica_seeds",
         "replica_seeds: is empty, and replicas would all be the same"},
        {SWEEP "\"cases\":[{\"time.step_s\":2.5e-7},{\"time.step_s\":1e-3}]}", "time.step_s", NULL},
        {BISECT "\"digits\":3}", "raise_low_when",
         "raise_low_when: is missing: verdicts that move the low end up; any other one moves the high end down"},
        {BISECT "\"raise_low_when\":\"flowing\"}", "raise_low_when[0]",
         "raise_low_when[0]: \"flowing\" is none of \"rest\", \"steady\", \"accelerating\""},
        {BISECT "\"raise_low_when\":[]}", "raise_low_when",
         "raise_low_when: no verdict moves the low end, so that the bracket could never close"},
        {BISECT "\"raise_low_when\":[\"rest\",\"steady\",\"accelerating\"]}", "raise_low_when",
         "raise_low_when: every verdict moves the low end, so that the bracket could never close"},
        {BISECT "\"raise_low_when\":\"rest\",\"grid\":{}}", "grid", "grid: unknown key"},
        {BISECT "\"raise_low_when\":\"rest\",\"digits\":10}", "digits", "digits: 10 is outside 1..9 significant digits"},
        {"{\"study\":\"bisect\"," FLOW ",\"over\":\"material.mu_t\",\"low\":1,\"high\":1,\"raise_low_when\":\"rest\"}", "low",
         "low: 1 is not below high, 1"},
        {"{\"study\":\"bisect\"," FLOW ",\"over\":\"material.mu_t\",\"low\":-1,\"high\":1,\"raise_low_when\":\"rest\"}", "low",
         NULL},
        {"{\"study\":\"bisect\"," FLOW ",\"over\":\"params.nx\",\"low\":2,\"high\":5,\"raise_low_when\":\"rest\"}", "over",
         "over: params.nx is not a real number, which alone can be searched"},
        {"{\"study\":\"bisect\"," FLOW ",\"over\":\"mu_t\",\"low\":0,\"high\":5,\"raise_low_when\":\"rest\"}", "over",
         "over: unknown key; did you mean \"material.mu_t\"?"},
        {"{\"study\":\"bisect\"," FLOW ",\"over\":7,\"low\":0,\"high\":5,\"raise_low_when\":\"rest\"}", "over",
         "over: expected a string, got a number"},
        {ROOT "\"number\":\"restitution\"}", "target", "target: is missing: what the number is to be, in its own unit"},
        {ROOT "\"number\":\"\",\"target\":1}", "number", "number: is empty; it names a number of the summary"},
    };
    for (size_t k = 0; k < COUNT(cases); k++) {
        struct study_plan plan;
        struct scree_error err = {0};
        if (decode(cases[k].text, &plan, &err) != SCREE_INVALID)
            fail_msg("%s: is not refused (%s)", cases[k].text, err.message);
        assert_string_equal(err.path, cases[k].path);
        if (cases[k].message)
            assert_string_equal(err.message, cases[k].message);
        study_plan_free(&plan);
    }
}

/* What is stored and echoed is the whole study: it reads back to the same trials, and to the same text. */
static void the_resolved_study_is_the_same_one(void **state)
{
    (void)state;
    const char *const texts[] = {
        SWEEP
        "\"grid\":{\"params.slope_deg\":{\"from\":20,\"to\":30,\"count\":7},\"record.energy.every_s\":[0.1,1e-3]},\"replicas\":3}",
        "{\"study\":\"sweep\"," HIT ",\"cases\":[{\"material.preset\":\"foerster-3mm\"},{\"params.partner\":\"plane\"}]}",
        SWEEP "\"grid\":{},\"at_once\":7,\"title\":\"one\"}",
        BISECT "\"raise_low_when\":\"steady\",\"digits\":4,\"undecided\":\"raise\"}",
        ROOT "\"number\":\"restitution\",\"target\":0.97}",
    };
    for (size_t k = 0; k < COUNT(texts); k++) {
        struct study_plan plan, again;
        decoded(texts[k], &plan);
        cJSON *json = study_encode(&plan);
        char *text = json_print(json, false);
        decoded(text, &again);
        cJSON *twice = study_encode(&again);
        char *second = json_print(twice, false);
        assert_string_equal(text, second);
        assert_memory_equal(&again.spec, &plan.spec, sizeof plan.spec);
        assert_int_equal(again.trials, plan.trials);
        for (size_t t = 0; t < plan.trials; t++) {
            struct job_spec a, b;
            assert_int_equal(study_plan_trial(&plan, t, &a, NULL), SCREE_OK);
            assert_int_equal(study_plan_trial(&again, t, &b, NULL), SCREE_OK);
            assert_memory_equal(&a, &b, sizeof a);
        }
        free(text);
        free(second);
        cJSON_Delete(json);
        cJSON_Delete(twice);
        study_plan_free(&plan);
        study_plan_free(&again);
    }
}

/* What a study costs is the sum over its trials. */
static void cost_is_the_sum_of_the_trials(void **state)
{
    (void)state;
    struct study_plan plan;
    struct job_cost cost;
    decoded(SWEEP "\"grid\":{\"params.nz\":[4,8],\"time.end_s\":[1,3]},\"replicas\":2}", &plan);
    assert_int_equal(study_plan_check(&plan, 0, NULL, NULL, &cost, NULL), SCREE_OK);
    assert_true(cost.moving == 800);
    double work = cost.moving * cost.steps / (2 * 4e6 * (400 + 1200 + 800 + 2400));
    assert_true(work > 1 - 1e-12 && work < 1 + 1e-12);
    assert_true(cost.rate == 3e7);
    study_plan_free(&plan);
    /* Of kinds of different speed it is the time that is summed: 400 beads for a second, 100 bodies for one in 1e5 steps. */
    decoded("{\"study\":\"sweep\",\"job\":{\"scenario\":\"incline\",\"time\":{\"end_s\":1}},\"cases\":["
            "{\"params.nx\":10,\"params.ny\":10,\"params.nz\":4},"
            "{\"scenario\":\"settle\",\"params.count\":100,\"time.step_s\":2.5e-6}]}",
            &plan);
    assert_int_equal(study_plan_check(&plan, 0, NULL, NULL, &cost, NULL), SCREE_OK);
    double seconds = job_cost_seconds(&cost) / (400 * 4e6 / 3e7 + 100 * 4e5 / 1e6);
    assert_true(seconds > 1 - 1e-9 && seconds < 1 + 1e-9);
    study_plan_free(&plan);
}

static void the_schema_is_up_to_date(void **state)
{
    (void)state;
    char path[512], *made = study_schema_text(), *kept = calloc(1, JSON_BYTES_MAX);
    snprintf(path, sizeof path, "%s/protocol/schema/study.json", source_folder());
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_true(fread(kept, 1, JSON_BYTES_MAX - 1, file) > 0);
    fclose(file);
    size_t size = strlen(made);
    if (strncmp(kept, made, size) != 0 || strcmp(kept + size, "\n") != 0)
        fail_msg("protocol/schema/study.json differs from the tables: build write_schema and run `write_schema study`");
    free(made);
    free(kept);
}

static void examples_are_accepted(void **state)
{
    (void)state;
    const char *const names[] = {"bisect-mu_t",         "slidequakes",           "calibrate-beta",
                                 "calibrate-beta-slip", "calibrate-restitution", "calibrate-kappa",
                                 "calibrate-beta_r",    "calibrate-mu_r",        "calibrate-step"};
    for (size_t k = 0; k < COUNT(names); k++) {
        char path[512];
        cJSON *json = NULL;
        struct study_plan plan = {0};
        struct scree_error err = {0};
        snprintf(path, sizeof path, "%s/client/examples/%s.json", source_folder(), names[k]);
        enum scree_status status = json_read_file(path, &json, &err);
        status = status ? status : study_decode(json, &plan, &err);
        status = status ? status : study_plan_check(&plan, 1e9, NULL, NULL, NULL, &err);
        cJSON_Delete(json);
        if (status)
            fail_msg("%s: %s", names[k], err.message);
        if (k == 1)
            assert_int_equal(plan.trials, 30);
        study_plan_free(&plan);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_grid_becomes_its_trials),
        cmocka_unit_test(cases_take_their_own_values),
        cmocka_unit_test(a_swept_preset_brings_its_own_values),
        cmocka_unit_test(a_swept_run_brings_its_own_values),
        cmocka_unit_test(a_case_may_name_its_scenario),
        cmocka_unit_test(steady_means_flowing),
        cmocka_unit_test(refusals_name_the_place),
        cmocka_unit_test(the_resolved_study_is_the_same_one),
        cmocka_unit_test(cost_is_the_sum_of_the_trials),
        cmocka_unit_test(the_schema_is_up_to_date),
        cmocka_unit_test(examples_are_accepted),
    };
    return cmocka_run_group_tests_name("study_json", tests, NULL, NULL);
}
