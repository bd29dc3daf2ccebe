/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What tests of whole worlds share: a job that runs to its end, and the numbers that it comes to. */
#ifndef TEST_SUPPORT_SUMMARY_H
#define TEST_SUPPORT_SUMMARY_H

#include "unit.h"

#include <stdio.h>

#include "scree.h"

struct summary {
    struct scree_number numbers[SCREE_SUMMARY_MAX];
    size_t count;
    enum scree_verdict verdict;
    double time_s;
    uint64_t steps;
    char evidence[256];
};

/* Checks and runs a job; what it records goes to `sink`. Any failure fails the test. */
static inline struct summary run(const struct job_spec *job, const struct scree_sink *sink)
{
    struct summary out = {.count = 0};
    struct scree_error error = {0};
    struct scree_world *world = NULL;
    if (job_check(job, 0, &error) || scree_world_create(job, NULL, sink, &world, &error) ||
        scree_world_advance(world, UINT64_MAX, &error) || scree_world_close(world, &error))
        fail_msg("%s", error.message);
    const struct scree_progress progress = scree_world_progress(world);
    out.verdict = progress.verdict;
    out.time_s = progress.time_s;
    out.steps = progress.step;
    snprintf(out.evidence, sizeof out.evidence, "%s", progress.evidence);
    out.count = scree_world_summary(world, out.numbers);
    scree_world_free(world);
    return out;
}

static inline enum scree_status sink_nowhere(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    (void)context, (void)chunk, (void)err;
    return SCREE_OK;
}

static inline double number(const struct summary *summary, const char *name)
{
    for (size_t k = 0; k < summary->count; k++)
        if (strcmp(summary->numbers[k].name, name) == 0)
            return summary->numbers[k].value;
    fail_msg("no number %s", name);
    return 0;
}

#endif
