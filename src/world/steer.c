/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Changing a world while it runs, and copies that outlive it.
 *
 * A change takes effect between two steps and depends on nothing but the step and
 * the new values, so that replaying the same commands gives the same bits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "world/image.h"
#include "world/state.h"

/* A chunk has one interval: what was gathered goes out as a shorter one. The block
 * of force that is being averaged ends with the next instant of the new interval. */
static enum scree_status steer_measured(struct scree_world *w, struct measured *m, const struct job_spec *job,
                                        struct scree_error *err)
{
    uint64_t every = world_every(m->what, job);
    if (every == m->every)
        return SCREE_OK;
    m->every = every;
    enum scree_status status = SCREE_OK;
    for (size_t s = 0; s < m->what->stream_count && m->recorded && !status; s++) {
        struct series *series = &measure_series(m->what, m->state)[s];
        status = series_flush(series, &w->sink, err);
        series->dt_s = (double)every * w->job.time.step_s;
    }
    return status;
}

enum scree_status scree_world_steer(struct scree_world *w, const struct job_spec *job, struct scree_error *err)
{
    enum scree_status status = job_steer_check(&w->job, job, err);
    for (size_t k = 0; k < w->measured_count && !status; k++)
        status = steer_measured(w, &w->measured[k], job, err);
    if (status)
        return status;
    bool forced = w->kind->steer(w->body, &w->job, job);
    w->job = *job;
    w->end_step = (uint64_t)fmax(1, round(job->time.end_s / job->time.step_s));
    if (!forced)
        return SCREE_OK;
    double *gravity = w->context.gravity;
    w->kind->gravity(job, gravity);
    double g = sqrt(gravity[0] * gravity[0] + gravity[1] * gravity[1] + gravity[2] * gravity[2]);
    verdict_restart(&w->context.verdict, w->context.time_s, g > 0 ? g : 1);
    for (size_t k = 0; k < w->measured_count; k++)
        if (w->measured[k].what->steered)
            w->measured[k].what->steered(w->measured[k].state, &w->context);
    return SCREE_OK;
}

void scree_world_branch(struct scree_world *w)
{
    for (size_t k = 0; k < w->measured_count; k++) {
        const struct measured *m = &w->measured[k];
        for (size_t s = 0; s < m->what->stream_count; s++) {
            struct series *series = &measure_series(m->what, m->state)[s];
            series->seq = series->rows = 0;
        }
    }
}

uint64_t scree_world_next_chunk(const struct scree_world *w, size_t stream)
{
    for (size_t k = 0; k < w->measured_count; k++) {
        const struct measured *m = &w->measured[k];
        for (size_t s = 0; s < m->what->stream_count && m->recorded; s++)
            if (m->what->streams[s] == w->streams[stream])
                return measure_series(m->what, m->state)[s].seq;
    }
    return 0;
}

/* ---- copies ---- */

static bool owned(const struct world_image *image, const void *data)
{
    for (size_t k = 0; k < image->owned_count; k++)
        if (image->owned[k] == data)
            return true;
    return false;
}

enum scree_status scree_image_take(const struct scree_world *w, struct scree_image **out, struct scree_error *err)
{
    struct scree_image *copy = calloc(1, sizeof *copy);
    if (!copy)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image");
    struct world_image *image = &copy->image;
    enum scree_status status = world_image_take(w, image, err);
    for (size_t k = 0; k < image->count && !status; k++) {
        struct world_array *array = &image->arrays[k];
        size_t size = world_array_size(array->type);
        if (owned(image, array->data))
            continue;
        void *data = memory_rows(array->count, size);
        if (!data) {
            status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image");
            break;
        }
        memcpy(data, array->data, array->count * size);
        image->owned[image->owned_count++] = data;
        array->data = data;
    }
    if (status)
        scree_image_free(copy);
    else
        *out = copy;
    return status;
}

void scree_image_free(struct scree_image *image)
{
    if (image)
        world_image_free(&image->image);
    free(image);
}
