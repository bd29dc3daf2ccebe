/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree check`: what a spec comes to, without running it and without a daemon. */
#include <stdio.h>

#include "output.h"
#include "spec_file.h"
#include "verbs.h"

static void print_cost(const struct job_cost *cost)
{
    char moving[TEXT_MAX], fixed[TEXT_MAX], steps[TEXT_MAX], time[TEXT_MAX], rate[TEXT_MAX], bytes[TEXT_MAX];
    fflush(stdout);
    say("%s moving and %s fixed grains, %s steps: %.3g grain-steps", text_count(cost->moving, moving),
        text_count(cost->fixed, fixed), text_count(cost->steps, steps), cost->moving * cost->steps);
    say("at most about %s at an assumed %s, %s of memory", text_duration(job_cost_seconds(cost), time), text_rate(cost->rate, rate),
        text_bytes(cost->bytes, bytes));
}

static void print_trials(const struct study_plan *study)
{
    fflush(stdout);
    if (study->trials)
        say("%zu trials; the steps below are of all together, in worlds as large as the largest", study->trials);
    else
        say("a search: trials follow from one another; below is an estimate for all together");
}

static enum outcome check_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct spec_file spec;
    enum outcome outcome = spec_file_read(arguments->words[0], arguments, memory_available(), &spec, &err);
    if (!outcome) {
        struct job_cost cost = job_cost(&spec.job);
        if (spec.is_study)
            study_plan_check(&spec.study, 0, NULL, NULL, &cost, &err);
        cJSON *resolved = spec.is_study ? study_encode(&spec.study) : job_encode(&spec.job);
        cJSON *line = arguments->json ? cJSON_CreateObject() : NULL;
        if (line) {
            json_put(line, "spec", resolved);
            json_put(line, "cost", job_cost_encode(&cost));
            if (spec.is_study)
                json_put(line, "trials", spec.study.trials ? json_real((double)spec.study.trials) : cJSON_CreateNull());
            put_json_line(line);
            cJSON_Delete(line);
        } else if (resolved) {
            put_json_pretty(resolved);
            cJSON_Delete(resolved);
            if (spec.is_study)
                print_trials(&spec.study);
            print_cost(&cost);
        }
    }
    spec_file_free(&spec);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--set=*", NULL};

const struct verb verb_check = {
    .name = "check",
    .synopsis = "FILE [--set path=value]...",
    .doc = "validate a spec, print it with every value spelled out and what it costs",
    .help = "FILE is the JSON of a job or a study, \"-\" is stdin. Needs no daemon. The resolved spec goes to stdout and can be "
            "run as\n"
            "it is; the estimate of cost goes to stderr, with --json into the same object. The time is an upper bound\n"
            "at a stated rate: a job may stop earlier, when it has its verdict.\n"
            "\n"
            "  scree check job.json\n"
            "  scree check job.json --set params.nz=40 --json\n",
    .options = options,
    .words_min = 1,
    .words_max = 1,
    .run = check_run,
};
