/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See image.h. The body adds its own arrays (kind.h), each measurement's state
 * goes as its descriptor says. Small structs (clocks, verdict) go as they are;
 * a checkpoint says which build wrote it, and another build's is refused. */
#include "world/image.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "world/state.h"

size_t world_array_size(enum world_array_type type)
{
    static const size_t sizes[] = {1, sizeof(uint32_t), sizeof(uint64_t), sizeof(double)};
    return sizes[type];
}

/* What a world keeps beside body and measurements. */
struct world_head {
    uint64_t step, stopped;
    struct bulk last, here;
    double start_energy;
    struct verdict verdict;
};
struct series_head {
    uint64_t seq, rows;
    double t0_s;
};

/* ---- taking ---- */

void world_image_add(struct world_image *image, const char *name, enum world_array_type type, size_t count, const void *data)
{
    assert(image->count < WORLD_ARRAYS_MAX);
    struct world_array *array = &image->arrays[image->count++];
    snprintf(array->name, sizeof array->name, "%s", name);
    array->type = type;
    array->count = count;
    array->data = data;
}

enum scree_status world_image_copy(struct world_image *image, const char *name, const void *data, size_t bytes,
                                   struct scree_error *err)
{
    assert(image->owned_count < WORLD_ARRAYS_MAX);
    void *copy = memory_rows(bytes, 1);
    if (!copy)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image");
    memcpy(copy, data, bytes);
    image->owned[image->owned_count++] = copy;
    world_image_add(image, name, ARRAY_BYTES, bytes, copy);
    return SCREE_OK;
}

/* Names of arrays. */
struct array_name {
    char text[sizeof((struct world_array *)0)->name];
};

static struct array_name state_name(const struct measurement *what)
{
    struct array_name name;
    snprintf(name.text, sizeof name.text, "measure.%s", what->name ? what->name : what->streams[0]->name);
    return name;
}

static struct array_name buffer_name(const struct measurement *what, size_t buffer)
{
    struct array_name name;
    snprintf(name.text, sizeof name.text, "measure.%s.%zu", what->name, buffer);
    return name;
}

static struct array_name series_name(const struct scree_stream *stream, bool values)
{
    struct array_name name;
    snprintf(name.text, sizeof name.text, "series.%s%s", stream->name, values ? ".values" : "");
    return name;
}

static enum scree_status take_series(struct world_image *image, const struct series *series, struct scree_error *err)
{
    const struct series_head head = {series->seq, series->rows, series->t0_s};
    if (series->rows > 0)
        world_image_add(image, series_name(series->stream, true).text, ARRAY_REAL, series->rows * series->stream->column_count,
                        series->values);
    return world_image_copy(image, series_name(series->stream, false).text, &head, sizeof head, err);
}

static enum scree_status take_measured(struct world_image *image, const struct measured *m, struct scree_error *err)
{
    const struct measurement *what = m->what;
    enum scree_status status = SCREE_OK;
    if (what->plain > 0)
        status = world_image_copy(image, state_name(what).text, m->state, what->used ? what->used(m->state) : what->plain, err);
    for (size_t s = 0; s < what->stream_count && m->recorded && !status; s++)
        status = take_series(image, &measure_series(what, m->state)[s], err);
    for (size_t b = 0; b < what->buffer_count && !status; b++) {
        const struct measure_buffer *buffer = &measure_buffers(what, m->state)[b];
        static const double none;
        world_image_add(image, buffer_name(what, b).text, ARRAY_REAL, buffer->count, buffer->values ? buffer->values : &none);
    }
    return status;
}

enum scree_status world_image_take(const struct scree_world *w, struct world_image *image, struct scree_error *err)
{
    const struct measure_context *context = &w->context;
    const struct world_head head = {.step = w->step,
                                    .stopped = context->stop,
                                    .last = context->last,
                                    .here = context->here,
                                    .start_energy = context->start_energy,
                                    .verdict = context->verdict};
    memset(image, 0, sizeof *image);
    image->job = w->job;
    enum scree_status status = w->kind->save(w->body, image, err);
    if (!status)
        status = world_image_copy(image, "world", &head, sizeof head, err);
    for (size_t k = 0; k < w->measured_count && !status; k++)
        status = take_measured(image, &w->measured[k], err);
    if (status)
        world_image_free(image);
    return status;
}

void world_image_free(struct world_image *image)
{
    for (size_t k = 0; k < image->owned_count; k++)
        free(image->owned[k]);
    image->owned_count = image->count = 0;
}

/* ---- restoring ---- */

const struct world_array *world_image_find(const struct world_image *image, const char *name)
{
    for (size_t k = 0; k < image->count; k++)
        if (strcmp(image->arrays[k].name, name) == 0)
            return &image->arrays[k];
    return NULL;
}

void *world_image_need(const struct world_image *image, const char *name, enum world_array_type type, size_t count)
{
    const struct world_array *array = world_image_find(image, name);
    return array && array->type == type && array->count == count ? (void *)(uintptr_t)array->data : NULL;
}

enum scree_status world_image_damaged(const char *what, struct scree_error *err)
{
    return scree_fail(err, SCREE_CORRUPT, NULL, "%s is missing from the image, or not of the right size", what);
}

static enum scree_status restore_series(const struct world_image *image, struct series *series, struct scree_error *err)
{
    struct series_head head;
    const struct array_name name = series_name(series->stream, false);
    const void *stored = world_image_need(image, name.text, ARRAY_BYTES, sizeof head);
    if (!stored)
        return world_image_damaged(name.text, err);
    memcpy(&head, stored, sizeof head);
    if (head.rows > 0) {
        size_t count = head.rows < series->capacity ? head.rows * series->stream->column_count : SIZE_MAX;
        const void *data = world_image_need(image, series_name(series->stream, true).text, ARRAY_REAL, count);
        if (!data)
            return world_image_damaged(name.text, err);
        memcpy(series->values, data, count * sizeof(double));
    }
    series->seq = head.seq;
    series->rows = head.rows;
    series->t0_s = head.t0_s;
    return SCREE_OK;
}

static enum scree_status restore_state(const struct world_image *image, const struct scree_world *w, const struct measured *m,
                                       struct scree_error *err)
{
    const struct measurement *what = m->what;
    const struct array_name name = state_name(what);
    const struct world_array *array = world_image_find(image, name.text);
    if (!array || array->type != ARRAY_BYTES || array->count > what->plain)
        return world_image_damaged(name.text, err);
    memcpy(m->state, array->data, array->count);
    /* What is not in use is not stored: the state says how much is. */
    bool whole = array->count == (what->used ? what->used(m->state) : what->plain);
    return whole && (!what->sound || what->sound(m->state, &w->context)) ? SCREE_OK : world_image_damaged(name.text, err);
}

static enum scree_status restore_buffer(const struct world_image *image, const struct measurement *what, size_t b,
                                        struct measure_buffer *buffer, struct scree_error *err)
{
    const struct array_name name = buffer_name(what, b);
    const struct world_array *array = world_image_find(image, name.text);
    if (!array || array->type != ARRAY_REAL || array->count > buffer->most)
        return world_image_damaged(name.text, err);
    enum scree_status status = measure_buffer_resize(buffer, array->count, err);
    if (!status && array->count > 0)
        memcpy(buffer->values, array->data, array->count * sizeof *buffer->values);
    return status;
}

/* Buffers before the state, whose check may look at their size. */
static enum scree_status restore_measured(const struct world_image *image, const struct scree_world *w, const struct measured *m,
                                          struct scree_error *err)
{
    const struct measurement *what = m->what;
    enum scree_status status = SCREE_OK;
    for (size_t b = 0; b < what->buffer_count && !status; b++)
        status = restore_buffer(image, what, b, &measure_buffers(what, m->state)[b], err);
    for (size_t s = 0; s < what->stream_count && m->recorded && !status; s++)
        status = restore_series(image, &measure_series(what, m->state)[s], err);
    return !status && what->plain > 0 ? restore_state(image, w, m, err) : status;
}

static enum scree_status restore_head(struct scree_world *w, const struct world_image *image, struct scree_error *err)
{
    struct world_head head;
    struct measure_context *context = &w->context;
    const void *stored = world_image_need(image, "world", ARRAY_BYTES, sizeof head);
    if (!stored)
        return world_image_damaged("world", err);
    memcpy(&head, stored, sizeof head);
    w->step = head.step;
    context->stop = head.stopped != 0;
    context->last = head.last;
    context->here = head.here;
    context->start_energy = head.start_energy;
    context->verdict = head.verdict;
    context->verdict.evidence[sizeof context->verdict.evidence - 1] = 0;
    return head.verdict.current <= VERDICT_ACCELERATING ? SCREE_OK : world_image_damaged("world", err);
}

enum scree_status world_image_restore(const struct world_image *image, const struct scree_options *options,
                                      const struct scree_sink *sink, struct scree_world **out, struct scree_error *err)
{
    struct scree_world *w = NULL;
    enum scree_status status = world_prepare(&image->job, options, sink, &w, err);
    if (status)
        return status;
    if (!(status = w->kind->load(image, &w->making, &w->body, err)))
        status = restore_head(w, image, err);
    if (!status)
        world_look(w);
    for (size_t k = 0; k < w->measured_count && !status; k++)
        status = restore_measured(image, w, &w->measured[k], err);
    if (status)
        scree_world_free(w);
    else
        *out = w;
    return status;
}

enum scree_status scree_world_fork(const struct scree_world *world, const struct scree_options *options,
                                   const struct scree_sink *sink, struct scree_world **out, struct scree_error *err)
{
    struct world_image image;
    enum scree_status status = world_image_take(world, &image, err);
    if (status)
        return status;
    status = world_image_restore(&image, options, sink, out, err);
    world_image_free(&image);
    return status;
}
