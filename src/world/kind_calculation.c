/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calculations as worlds: nothing moves, the numbers are there at once, and an image holds none of them. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scenario/calculation.h"
#include "world/kind.h"

struct body {
    double time_s, step_s;
    struct calculation_result result;
};

static bool knows(const struct job_spec *job)
{
    return calculation_find(job->scenario->name) != NULL;
}

static void gravity(const struct job_spec *job, double out[3])
{
    (void)job;
    memset(out, 0, 3 * sizeof *out);
}

static enum scree_status site(const struct job_spec *job, struct measure_site *out, struct scree_error *err)
{
    (void)job;
    (void)err;
    *out = (struct measure_site){.diameter = 1};
    return SCREE_OK;
}

static enum scree_status build(const struct job_spec *job, const struct world_making *making, void **out, struct scree_error *err)
{
    (void)making;
    struct body *b = memory_rows(1, sizeof *b);
    if (!b)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a calculation");
    b->step_s = job->time.step_s;
    enum scree_status status = calculation_find(job->scenario->name)->run(job, &b->result, err);
    if (status)
        free(b);
    else
        *out = b;
    return status;
}

static enum scree_status advance(void *body, uint64_t steps, struct scree_error *err)
{
    struct body *b = body;
    (void)err;
    b->time_s += (double)steps * b->step_s;
    return SCREE_OK;
}

static struct world_counts counts(const void *body)
{
    return (struct world_counts){.time_s = ((const struct body *)body)->time_s, .isa = "x86-64"};
}

static uint64_t hash(const void *body)
{
    const struct body *b = body;
    uint64_t sum = 0xcbf29ce484222325u;
    for (size_t k = 0; k < b->result.count; k++) {
        uint64_t word;
        memcpy(&word, &b->result.numbers[k].value, sizeof word);
        sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
        sum ^= sum >> 31;
    }
    return sum;
}

static enum scree_status view(void *body, struct measure_now *now, struct scree_error *err)
{
    (void)body;
    (void)now;
    (void)err;
    return SCREE_OK;
}

static size_t numbers(const void *body, struct scree_number *out, size_t room)
{
    const struct body *b = body;
    return measure_numbers(out, room, b->result.numbers, b->result.count);
}

static bool steer(void *body, const struct job_spec *from, const struct job_spec *to)
{
    (void)body;
    (void)from;
    (void)to;
    return false;
}

static enum scree_status save(const void *body, struct world_image *image, struct scree_error *err)
{
    const struct body *b = body;
    return world_image_copy(image, "calculation", &b->time_s, sizeof b->time_s, err);
}

static enum scree_status load(const struct world_image *image, const struct world_making *making, void **out,
                              struct scree_error *err)
{
    const void *time_s = world_image_need(image, "calculation", ARRAY_BYTES, sizeof(double));
    if (!time_s)
        return world_image_damaged("calculation", err);
    enum scree_status status = build(&image->job, making, out, err);
    if (!status)
        memcpy(&((struct body *)*out)->time_s, time_s, sizeof(double));
    return status;
}

const struct world_kind world_kind_calculation = {
    .kind = SCENARIO_CALCULATION,
    .knows = knows,
    .gravity = gravity,
    .site = site,
    .build = build,
    .free = free,
    .advance = advance,
    .counts = counts,
    .hash = hash,
    .view = view,
    .numbers = numbers,
    .steer = steer,
    .save = save,
    .load = load,
};
