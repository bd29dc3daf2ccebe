/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The jobs of a study: its base with a trial's values set, decoded like any other
 * job. Nothing of them is kept: a trial's spec follows from the study and the
 * trial's number. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibrate/digits.h"
#include "protocol/study_json.h"

enum scree_status job_value_set(cJSON *json, const char *path, const cJSON *value, struct scree_error *err)
{
    char *text = json_print(value, false), *assignment = NULL;
    enum scree_status status = SCREE_NO_MEMORY;
    if (text && asprintf(&assignment, "%s=%s", path, text) >= 0)
        status = job_json_set(json, assignment, err);
    else
        scree_fail(err, status, NULL, "no memory to set %s", path);
    free(text);
    free(assignment);
    return status;
}

static enum scree_status set_real(cJSON *json, const char *path, double number, struct scree_error *err)
{
    cJSON *value = json_real(number);
    enum scree_status status = value ? job_value_set(json, path, value, err) : SCREE_NO_MEMORY;
    cJSON_Delete(value);
    return status;
}

/* Raises the seeds of a replica above those that the trial has without it. */
static enum scree_status set_seeds(const struct study_plan *plan, cJSON *json, size_t replica, struct scree_error *err)
{
    struct job_spec job;
    enum scree_status status = replica ? job_decode(json, &job, err) : SCREE_OK;
    for (size_t k = 0; k < plan->seed_count && replica && !status; k++) {
        const char *unit;
        cJSON *seed = job_value_at(&job, plan->seeds[k], &unit);
        status = seed ? set_real(json, plan->seeds[k], strtod(seed->valuestring, NULL) + (double)replica, err) // encoded: text
                      : scree_fail(err, SCREE_INVALID, "replica_seeds", "replica_seeds: this trial has no %s", plan->seeds[k]);
        cJSON_Delete(seed);
    }
    return status;
}

size_t study_plan_replica(const struct study_plan *plan, size_t trial)
{
    return trial % plan->shape.replicas;
}

enum scree_status study_plan_trial(const struct study_plan *plan, size_t trial, struct job_spec *out, struct scree_error *err)
{
    size_t values[SWEEP_AXES_MAX], replica;
    enum scree_status status = SCREE_OK;
    cJSON *json = cJSON_Duplicate(plan->job, true);
    if (!json)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a trial");
    sweep_trial(&plan->shape, trial, values, &replica);
    if (plan->cases) {
        const cJSON *value = cJSON_GetArrayItem(plan->cases, (int)values[0]);
        for (value = value ? value->child : NULL; value && !status; value = value->next)
            status = job_value_set(json, value->string, value, err);
    }
    for (size_t k = 0; k < plan->axis_count && !status; k++)
        status = job_value_set(json, plan->axes[k].path, cJSON_GetArrayItem(plan->axes[k].values, (int)values[k]), err);
    if (!status && !(status = set_seeds(plan, json, replica, err)))
        status = job_decode(json, out, err);
    cJSON_Delete(json);
    return status;
}

enum scree_status study_plan_search(const struct study_plan *plan, double at, size_t replica, double end_s, struct job_spec *out,
                                    struct scree_error *err)
{
    cJSON *json = cJSON_Duplicate(plan->job, true);
    if (!json)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a trial");
    /* One that stops at any verdict has none at its end: it goes on at once as far as it would be extended to. */
    if (end_s == 0 && plan->spec.kind == STUDY_BISECT && plan->base.stop.when == STOP_ANY)
        end_s = study_plan_extension(plan);
    enum scree_status status = set_real(json, plan->spec.over, at, err);
    if (!status && end_s > 0)
        status = set_real(json, "time.end_s", end_s, err);
    if (!status && !(status = set_seeds(plan, json, replica, err)))
        status = job_decode(json, out, err);
    cJSON_Delete(json);
    return status;
}

double study_plan_extension(const struct study_plan *plan)
{
    double end = plan->base.time.end_s;
    if (plan->spec.kind != STUDY_BISECT)
        return end;
    return fmax(end, plan->spec.extend_to_s > 0 ? plan->spec.extend_to_s : fmin(4 * end, 1e6));
}

/* Says which trial an error is about. */
static enum scree_status blame_trial(const char *trial, struct scree_error *err)
{
    if (!err)
        return SCREE_INVALID;
    struct scree_error plain = *err;
    scree_fail(err, plain.status, plain.path, "%s: %s", trial, plain.message);
    if (*plain.hint)
        scree_hint(err, "%s", plain.hint);
    return plain.status;
}

static void add_cost(struct job_cost *sum, const struct job_spec *job, double times)
{
    struct job_cost cost = job_cost(job);
    const double seconds = job_cost_seconds(sum) + times * job_cost_seconds(&cost);
    /* Of sums, what counts is the work: steps are those that as many grains as the largest trial has would need. */
    double work = sum->moving * sum->steps + cost.moving * cost.steps * times;
    sum->moving = fmax(sum->moving, cost.moving);
    sum->fixed = fmax(sum->fixed, cost.fixed);
    sum->bytes = fmax(sum->bytes, cost.bytes);
    sum->steps = sum->moving > 0 ? work / sum->moving : 0;
    sum->rate = seconds > 0 ? work / seconds : cost.rate;
}

/* What every trial must pass. */
struct trial_check {
    double memory_limit;
    enum scree_status (*also)(const struct job_spec *, const void *, struct scree_error *);
    const void *context;
};

static enum scree_status check_trial(const struct trial_check *check, const struct job_spec *job, struct scree_error *err)
{
    enum scree_status status = job_check(job, check->memory_limit, err);
    return status || !check->also ? status : check->also(job, check->context, err);
}

static enum scree_status check_sweep(const struct study_plan *plan, const struct trial_check *check, struct job_cost *cost,
                                     struct scree_error *err)
{
    for (size_t k = 0; k < plan->trials; k++) {
        char name[32];
        struct job_spec job;
        enum scree_status status = study_plan_trial(plan, k, &job, err);
        snprintf(name, sizeof name, "trial %zu", k);
        if (status || (status = check_trial(check, &job, err)))
            return blame_trial(name, err);
        add_cost(cost, &job, 1);
    }
    return SCREE_OK;
}

/* Rounds that a search may take, its ends counted as one. */
static double rounds_of(const struct study_plan *plan, double sections)
{
    const struct study_spec *s = &plan->spec;
    double unit = 0.5 * digits_unit(s->low, s->high, (int)s->digits);
    return 1 + ceil(fmax(0, log((s->high - s->low) / unit) / log(sections + 1)));
}

static enum scree_status check_search(const struct study_plan *plan, const struct trial_check *check, struct job_cost *cost,
                                      struct scree_error *err)
{
    const struct study_spec *s = &plan->spec;
    for (int k = 0; k < 2; k++) {
        struct job_spec job;
        /* The last replica has the largest seeds. */
        enum scree_status status = study_plan_search(plan, k ? s->high : s->low, (size_t)s->replicas - 1, 0, &job, err);
        if (status || (status = check_trial(check, &job, err)))
            return blame_trial(k ? "the trial at the high end" : "the trial at the low end", err);
        add_cost(cost, &job, 0.5 * (double)s->replicas * (rounds_of(plan, 1) + 1));
    }
    return SCREE_OK;
}

enum scree_status study_plan_check(const struct study_plan *plan, double memory_limit,
                                   enum scree_status (*also)(const struct job_spec *, const void *, struct scree_error *),
                                   const void *context, struct job_cost *cost, struct scree_error *err)
{
    const struct trial_check check = {memory_limit, also, context};
    struct job_cost sum = {0};
    enum scree_status status =
        plan->spec.kind == STUDY_SWEEP ? check_sweep(plan, &check, &sum, err) : check_search(plan, &check, &sum, err);
    if (cost)
        *cost = sum;
    return status;
}
