/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Studies between JSON and what runs them: reading, expanding, resolving.
 *
 * The `job` inside is a job's JSON; `over` and the keys of `grid` and `cases` are
 * dotted paths that the field tables resolve. A trial's spec is the job with its
 * values set and then decoded as any job, so that a study can ask for nothing
 * that a job could not. */
#ifndef SCREE_PROTOCOL_STUDY_JSON_H
#define SCREE_PROTOCOL_STUDY_JSON_H

#include "calibrate/sweep.h"
#include "protocol/job_json.h"
#include "spec/study.h"

enum { STUDY_SEEDS_MAX = 4 };

struct study_axis {
    char path[SCREE_PATH_MAX];
    cJSON *values; // array, ranges expanded
};

/* A study that has been read. Owns its JSON. */
struct study_plan {
    struct study_spec spec;
    struct job_spec base; // the job as it stands
    cJSON *job;           // what trials start from: resolved, unless an axis changes what the rest is read from (scenario, preset)
    struct study_axis axes[SWEEP_AXES_MAX];
    size_t axis_count;
    cJSON *cases; // array of {path: value}, NULL for a grid
    struct sweep shape;
    size_t trials;                                // of a sweep; 0 for a search
    char columns[SWEEP_AXES_MAX][SCREE_PATH_MAX]; // paths in which trials differ
    size_t column_count;
    char seeds[STUDY_SEEDS_MAX][SCREE_PATH_MAX]; // raised by one from replica to replica
    size_t seed_count;
};

/* Whether the JSON is meant to be a study. */
bool study_is(const cJSON *json);

/* Decodes and checks everything but what study_plan_check does. Errors carry path, value,
 * range, unit and the nearest known key. Release with study_plan_free, whatever came of it. */
enum scree_status study_decode(const cJSON *json, struct study_plan *out, struct scree_error *err);
void study_plan_free(struct study_plan *plan);

/* The resolved study: every value spelled out, ranges as lists. Reads back to the same study. */
cJSON *study_encode(const struct study_plan *plan);

/* job_check of every trial of a sweep, of both ends of a search; then `also` (NULL: nothing) with `context`, for those who know
 * worlds. `cost` (may be NULL) is the sum over the trials; for a search an estimate, of the rounds it may take. */
enum scree_status study_plan_check(const struct study_plan *plan, double memory_limit,
                                   enum scree_status (*also)(const struct job_spec *, const void *, struct scree_error *),
                                   const void *context, struct job_cost *cost, struct scree_error *err);

/* The spec of one trial of a sweep. */
enum scree_status study_plan_trial(const struct study_plan *plan, size_t trial, struct job_spec *out, struct scree_error *err);

/* The replica of that trial. */
size_t study_plan_replica(const struct study_plan *plan, size_t trial);

/* The spec of a search's trial at a value; `end_s` takes the place of time.end_s; 0: the first one, whose end is
 * time.end_s, or that of the extension at once if the trial stops at any verdict. */
enum scree_status study_plan_search(const struct study_plan *plan, double at, size_t replica, double end_s, struct job_spec *out,
                                    struct scree_error *err);

/* How long an undecided trial of a bisection may become, s. */
double study_plan_extension(const struct study_plan *plan);

/* The value of a job at a dotted path as JSON, and its unit ("" if none). NULL if there is no such path. */
cJSON *job_value_at(const struct job_spec *job, const char *path, const char **unit);

/* Sets one value of a job's JSON by its dotted path, as `--set` does. */
enum scree_status job_value_set(cJSON *json, const char *path, const cJSON *value, struct scree_error *err);

/* Everything about a kind of study, as JSON. */
cJSON *study_describe(enum study_kind kind);

#endif
