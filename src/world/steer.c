/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Changing a world while it runs, and copies that outlive it.
 *
 * A change takes effect between two steps and depends on nothing but the step and
 * the new values, so that replaying the same commands gives the same bits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "measure/frames.h"
#include "world/image.h"
#include "world/state.h"

static struct schedule new_schedule(bool on, double every_s, double step_s)
{
    return (struct schedule){.on = on, .every = (uint64_t)fmax(1, round(every_s / step_s))};
}

/* A chunk has one interval: what was gathered goes out as a shorter one. The block
 * of force that is being averaged ends with the next instant of the new interval. */
static enum scree_status steer_series(struct scree_world *w, struct schedule *schedule, struct series *series, double every_s,
                                      struct scree_error *err)
{
    const struct schedule next = new_schedule(schedule->on, every_s, w->job.time.step_s);
    if (next.every == schedule->every)
        return SCREE_OK;
    *schedule = next;
    if (!series || !series->values)
        return SCREE_OK;
    enum scree_status status = series_flush(series, &w->sink, err);
    series->dt_s = (double)next.every * w->job.time.step_s;
    return status;
}

static enum scree_status steer_records(struct scree_world *w, const struct record_spec *r, struct scree_error *err)
{
    enum scree_status status;
    if ((status = steer_series(w, &w->force, &w->force_series, r->basal_force.every_s, err)) ||
        (status = steer_series(w, &w->bulk, &w->bulk_series, r->bulk.every_s, err)) ||
        (status = steer_series(w, &w->energy, &w->energy_series, r->energy.every_s, err)))
        return status;
    return steer_series(w, &w->snapshots, NULL, r->snapshots.every_s, err);
}

enum scree_status scree_world_steer(struct scree_world *w, const struct job_spec *job, struct scree_error *err)
{
    double before[3], after[3];
    enum scree_status status = job_steer_check(&w->job, job, err);
    if (status || (status = steer_records(w, &job->record, err)))
        return status;
    w->scenario->gravity(&w->job, before);
    w->scenario->gravity(job, after);
    bool pulled = memcmp(before, after, sizeof before) != 0;
    bool rubbed = w->job.material.mu_t != job->material.mu_t;
    if (pulled)
        dem_set_gravity(w->dem, after);
    if (rubbed)
        dem_set_material(w->dem, &job->material);
    w->job = *job;
    w->end_step = (uint64_t)fmax(1, round(job->time.end_s / job->time.step_s));
    if (pulled || rubbed) {
        double g = sqrt(after[0] * after[0] + after[1] * after[1] + after[2] * after[2]);
        verdict_restart(&w->verdict, dem_time(w->dem), g > 0 ? g : 1);
    }
    return SCREE_OK;
}

void scree_world_branch(struct scree_world *w)
{
    struct series *const all[] = {&w->force_series, &w->bulk_series, &w->energy_series, &w->contact_series};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        all[k]->seq = all[k]->rows = 0;
    w->snapshot_seq = 0;
}

uint64_t scree_world_next_chunk(const struct scree_world *w, size_t stream)
{
    const struct series *const all[] = {&w->force_series, &w->bulk_series, &w->energy_series, &w->contact_series};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (all[k]->values && all[k]->stream == w->streams[stream])
            return all[k]->seq;
    return w->streams[stream] == &snapshots_stream ? w->snapshot_seq : w->closed;
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
