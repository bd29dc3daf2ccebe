/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree scenarios`: what can be asked for, printed from the tables that decode it. */
#include <stdio.h>
#include <string.h>

#include "describe.h"
#include "protocol/study_json.h"
#include "table.h"
#include "verbs.h"

static void print_list(void)
{
    static const char *const headers[] = {"scenario", "what it is", "source", NULL};
    struct table table;
    table_start(&table, headers);
    for (size_t k = 0; k < scenario_count; k++) {
        const char *const cells[] = {scenario_list[k]->name, scenario_list[k]->doc, scenario_list[k]->source};
        table_row(&table, cells, COLOUR_NONE);
    }
    table_end(&table, 0);
    static const char *const study_headers[] = {"study", "what it is", "source", NULL};
    putchar('\n');
    table_start(&table, study_headers);
    for (size_t k = 0; k < STUDY_KINDS; k++) {
        const char *const cells[] = {study_kinds[k].name, study_kinds[k].doc, study_kinds[k].source};
        table_row(&table, cells, COLOUR_NONE);
    }
    table_end(&table, 0);
    printf("\n`scree scenarios NAME` shows its fields, units, ranges and defaults.\n");
}

static void print_one(const struct scenario_fields *scenario)
{
    struct job_spec job;
    job_defaults(&job, scenario);
    printf("%s%s%s: %s\nsource: %s\n\nparams\n", colour_on(stdout, COLOUR_BOLD), scenario->name, colour_off(stdout, COLOUR_BOLD),
           scenario->doc, scenario->source);
    describe_fields(scenario->params, job.params, "params");
    printf("\njob\n");
    describe_fields(&job_table, &job, "");
    printf("\nmaterial (preset \"%s\"; `scree materials` shows others)\n", scenario->material);
    describe_fields(scenario_material(scenario)->table, &job.material, "material");
    printf("\nFields marked * are steerable. Every field has a default; the smallest job is {\"scenario\": \"%s\"}.\n",
           scenario->name);
}

static enum outcome print_study(const struct study_fields *kind, bool json)
{
    struct study_spec spec;
    if (json) {
        cJSON *about = study_describe((enum study_kind)(kind - study_kinds));
        if (about)
            put_json_line(about);
        cJSON_Delete(about);
        return OUTCOME_DONE;
    }
    study_defaults(&spec, (enum study_kind)(kind - study_kinds));
    printf("%s%s%s: %s\n\n", colour_on(stdout, COLOUR_BOLD), kind->name, colour_off(stdout, COLOUR_BOLD), kind->doc);
    describe_fields(kind->table, &spec, "");
    printf("\nBeside these: \"job\", the job that trials start from; \"replica_seeds\", dotted paths of what replicas raise by\n"
           "one (default [\"seed\"])%s.\n",
           kind == &study_kinds[STUDY_SWEEP]
               ? "; and either \"grid\", dotted paths with lists or ranges {\"from\", \"to\", \"step\" or\n"
                 "\"count\", \"log\"}, or \"cases\", a list of objects of dotted paths and values"
               : "");
    if (*kind->required)
        printf("Required: ");
    for (const char *const *name = kind->required; *name; name++)
        printf("%s%s", *name, name[1] ? ", " : ".\n");
    return OUTCOME_DONE;
}

static enum outcome not_found(const char *name)
{
    struct scree_error err;
    const char *words[65], *near;
    size_t count = 0;
    for (; count < scenario_count && count < 64; count++)
        words[count] = scenario_list[count]->name;
    words[count] = NULL;
    near = word_nearest(words, name);
    outcome_fail(&err, OUTCOME_REFUSED, "there is no scenario \"%.60s\"%s%s%s", name, near ? "; did you mean \"" : "",
                 near ? near : "", near ? "\"?" : "");
    scree_hint(&err, "`scree scenarios` lists them");
    return give_up(OUTCOME_REFUSED, &err);
}

static void print_json(const struct scenario_fields *scenario)
{
    cJSON *json = scenario_describe(scenario);
    if (json)
        put_json_line(json);
    cJSON_Delete(json);
}

static enum outcome scenarios_run(const struct arguments *arguments)
{
    if (arguments->word_count == 0) {
        if (!arguments->json)
            print_list();
        for (size_t k = 0; arguments->json && k < scenario_count; k++)
            print_json(scenario_list[k]);
        return OUTCOME_DONE;
    }
    for (size_t k = 0; k < STUDY_KINDS; k++)
        if (strcmp(study_kinds[k].name, arguments->words[0]) == 0)
            return print_study(&study_kinds[k], arguments->json);
    const struct scenario_fields *scenario = scenario_find(arguments->words[0]);
    if (!scenario)
        return not_found(arguments->words[0]);
    if (arguments->json)
        print_json(scenario);
    else
        print_one(scenario);
    return OUTCOME_DONE;
}

const struct verb verb_scenarios = {
    .name = "scenarios",
    .synopsis = "[NAME]",
    .doc = "the set-ups and studies there are; with NAME all their fields",
    .help = "Needs no daemon. With --json one object a scenario, with fields, defaults, ranges, units and sources.\n"
            "\n"
            "  scree scenarios\n"
            "  scree scenarios incline\n"
            "  scree scenarios bisect\n",
    .words_max = 1,
    .run = scenarios_run,
};
