/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See image.h. Small structs (clocks, verdict, windows' heads) go as they are;
 * a checkpoint says which build wrote it, and another build's is refused. */
#include "world/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/image.h"
#include "world/state.h"

size_t world_array_size(enum world_array_type type)
{
    static const size_t sizes[] = {1, sizeof(uint32_t), sizeof(uint64_t), sizeof(double)};
    return sizes[type];
}

/* What a world keeps beside grains, series and windows. */
struct world_head {
    uint64_t step, stopped, snapshot_seq;
    struct bulk last;
    double start_energy;
    struct verdict verdict;
    struct contact_trace trace;
};
struct series_head {
    uint64_t seq, rows;
    double t0_s;
};

static void add(struct world_image *image, const char *name, enum world_array_type type, size_t count, const void *data)
{
    struct world_array *array = &image->arrays[image->count++];
    snprintf(array->name, sizeof array->name, "%s", name);
    array->type = type;
    array->count = count;
    array->data = data;
}

/* Adds a copy that the image owns. */
static enum scree_status add_copy(struct world_image *image, const char *name, const void *data, size_t bytes,
                                  struct scree_error *err)
{
    void *copy = memory_rows(bytes, 1);
    if (!copy)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image");
    memcpy(copy, data, bytes);
    image->owned[image->owned_count++] = copy;
    add(image, name, ARRAY_BYTES, bytes, copy);
    return SCREE_OK;
}

static enum scree_status add_series(struct world_image *image, const char *name, const struct series *series,
                                    struct scree_error *err)
{
    char values[40];
    const struct series_head head = {series->seq, series->rows, series->t0_s};
    if (!series->values)
        return SCREE_OK;
    snprintf(values, sizeof values, "%s.values", name);
    add(image, values, ARRAY_REAL, series->rows * series->stream->column_count, series->values);
    return add_copy(image, name, &head, sizeof head, err);
}

/* The head of a window and the instants in use. */
static size_t window_bytes(const struct window *window)
{
    return offsetof(struct window, instants) + window->count * sizeof *window->instants;
}

static enum scree_status take_dem(const struct scree_world *w, struct world_image *image, struct scree_error *err)
{
    struct dem_image d;
    enum scree_status status = dem_save(w->dem, &d, err);
    if (status)
        return status;
    const struct dem_scalars *s = &d.scalars;
    /* The contact arrays are handed over. */
    void *const arrays[] = {d.keys,    d.contact, d.out,    d.wall_keys, d.wall_contact, d.wall_out, d.wall_overlap,
                            d.surface, d.vertex,  d.corner, d.partner,   d.mesh_pair,    d.body};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        image->owned[image->owned_count++] = arrays[k];
    add(image, "position", ARRAY_REAL, 4 * s->grains, d.position);
    add(image, "velocity", ARRAY_REAL, 4 * s->grains, d.velocity);
    add(image, "spin", ARRAY_REAL, 4 * s->grains, d.spin);
    add(image, "mass", ARRAY_REAL, s->grains, d.mass);
    add(image, "id", ARRAY_U32, s->grains, d.id);
    add(image, "walls", ARRAY_BYTES, s->walls * sizeof *d.walls, d.walls);
    add(image, "contact.key", ARRAY_U64, s->contacts, d.keys);
    add(image, "contact.memory", ARRAY_REAL, s->contacts * CONTACT_SLOTS, d.contact);
    add(image, "contact.force", ARRAY_REAL, s->contacts * sizeof *d.out / sizeof(double), d.out);
    add(image, "wall.key", ARRAY_U64, s->wall_contacts, d.wall_keys);
    add(image, "wall.memory", ARRAY_REAL, s->wall_contacts * CONTACT_SLOTS, d.wall_contact);
    add(image, "wall.force", ARRAY_REAL, s->wall_contacts * sizeof *d.wall_out / sizeof(double), d.wall_out);
    add(image, "wall.overlap", ARRAY_REAL, s->wall_contacts, d.wall_overlap);
    add(image, "surfaces", ARRAY_BYTES, s->surfaces * sizeof *d.surface, d.surface);
    add(image, "surface.vertex", ARRAY_REAL, 3 * s->vertices, d.vertex);
    add(image, "surface.corner", ARRAY_U32, 3 * s->triangles, d.corner);
    add(image, "surface.partner", ARRAY_BYTES, s->triangles, d.partner);
    add(image, "surface.contact", ARRAY_BYTES, s->mesh_contacts * sizeof *d.mesh_pair, d.mesh_pair);
    if (s->bodies) {
        add(image, "body", ARRAY_REAL, 4 * DEM_BODY_ROWS * s->bodies, d.body);
        add(image, "body.offset", ARRAY_REAL, 4 * s->moving, d.offset);
        add(image, "body.first", ARRAY_U32, s->bodies + 1, d.body_first);
        add(image, "body.id", ARRAY_U32, s->bodies, d.body_id);
        add(image, "body.shape", ARRAY_U32, s->bodies, d.body_shape);
    }
    return add_copy(image, "grains", s, sizeof *s, err);
}

enum scree_status world_image_take(const struct scree_world *w, struct world_image *image, struct scree_error *err)
{
    const struct world_head head = {.step = w->step,
                                    .stopped = w->stopped,
                                    .snapshot_seq = w->snapshot_seq,
                                    .last = w->last,
                                    .start_energy = w->start_energy,
                                    .verdict = w->verdict,
                                    .trace = w->trace};
    memset(image, 0, sizeof *image);
    image->job = w->job;
    enum scree_status status;
    if ((status = take_dem(w, image, err)) || (status = add_copy(image, "world", &head, sizeof head, err)) ||
        (status = add_copy(image, "window.force", &w->force_window, window_bytes(&w->force_window), err)) ||
        (status = add_copy(image, "window.bulk", &w->bulk_window, window_bytes(&w->bulk_window), err)) ||
        (status = add_series(image, "series.force", &w->force_series, err)) ||
        (status = add_series(image, "series.bulk", &w->bulk_series, err)) ||
        (status = add_series(image, "series.energy", &w->energy_series, err)) ||
        (status = add_series(image, "series.contact", &w->contact_series, err)) ||
        (status = add_series(image, "series.flow", &w->flow_series, err)))
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

static const struct world_array *find(const struct world_image *image, const char *name)
{
    for (size_t k = 0; k < image->count; k++)
        if (strcmp(image->arrays[k].name, name) == 0)
            return &image->arrays[k];
    return NULL;
}

/* The array of that name with so many elements, or NULL. */
static void *need(const struct world_image *image, const char *name, enum world_array_type type, size_t count)
{
    const struct world_array *array = find(image, name);
    return array && array->type == type && array->count == count ? (void *)(uintptr_t)array->data : NULL;
}

static enum scree_status damaged(const char *what, struct scree_error *err)
{
    return scree_fail(err, SCREE_CORRUPT, NULL, "%s is missing from the image, or not of the right size", what);
}

static enum scree_status restore_dem(struct scree_world *w, const struct world_image *image, const struct scree_options *options,
                                     struct scree_error *err)
{
    struct dem_image d = {.scalars = {0}};
    const void *scalars = need(image, "grains", ARRAY_BYTES, sizeof d.scalars);
    if (!scalars)
        return damaged("grains", err);
    memcpy(&d.scalars, scalars, sizeof d.scalars);
    const struct dem_scalars *s = &d.scalars;
    if (s->grains > SPEC_GRAINS_MAX || s->contacts > 64 * s->grains || s->wall_contacts > 64 * s->grains || s->walls > 1000 ||
        s->bodies > s->moving || s->surfaces > 1000 || s->vertices > TRIMESH_VERTICES_MAX || s->triangles > TRIMESH_TRIANGLES_MAX ||
        s->mesh_contacts > 64 * s->grains)
        return damaged("grains", err);
    d.position = need(image, "position", ARRAY_REAL, 4 * s->grains);
    d.velocity = need(image, "velocity", ARRAY_REAL, 4 * s->grains);
    d.spin = need(image, "spin", ARRAY_REAL, 4 * s->grains);
    d.mass = need(image, "mass", ARRAY_REAL, s->grains);
    d.id = need(image, "id", ARRAY_U32, s->grains);
    d.walls = need(image, "walls", ARRAY_BYTES, s->walls * sizeof *d.walls);
    d.keys = need(image, "contact.key", ARRAY_U64, s->contacts);
    d.contact = need(image, "contact.memory", ARRAY_REAL, s->contacts * CONTACT_SLOTS);
    d.out = need(image, "contact.force", ARRAY_REAL, s->contacts * sizeof *d.out / sizeof(double));
    d.wall_keys = need(image, "wall.key", ARRAY_U64, s->wall_contacts);
    d.wall_contact = need(image, "wall.memory", ARRAY_REAL, s->wall_contacts * CONTACT_SLOTS);
    d.wall_out = need(image, "wall.force", ARRAY_REAL, s->wall_contacts * sizeof *d.wall_out / sizeof(double));
    d.wall_overlap = need(image, "wall.overlap", ARRAY_REAL, s->wall_contacts);
    if (!d.position || !d.velocity || !d.spin || !d.mass || !d.id || !d.walls || !d.keys || !d.contact || !d.out || !d.wall_keys ||
        !d.wall_contact || !d.wall_out || !d.wall_overlap)
        return damaged("an array of grains or contacts", err);
    d.surface = need(image, "surfaces", ARRAY_BYTES, s->surfaces * sizeof *d.surface);
    d.vertex = need(image, "surface.vertex", ARRAY_REAL, 3 * s->vertices);
    d.corner = need(image, "surface.corner", ARRAY_U32, 3 * s->triangles);
    d.partner = need(image, "surface.partner", ARRAY_BYTES, s->triangles);
    d.mesh_pair = need(image, "surface.contact", ARRAY_BYTES, s->mesh_contacts * sizeof *d.mesh_pair);
    if (!d.surface || !d.vertex || !d.corner || !d.partner || !d.mesh_pair)
        return damaged("an array of the walls", err);
    if (s->bodies) {
        d.body = need(image, "body", ARRAY_REAL, 4 * DEM_BODY_ROWS * s->bodies);
        d.offset = need(image, "body.offset", ARRAY_REAL, 4 * s->moving);
        d.body_first = need(image, "body.first", ARRAY_U32, s->bodies + 1);
        d.body_id = need(image, "body.id", ARRAY_U32, s->bodies);
        d.body_shape = need(image, "body.shape", ARRAY_U32, s->bodies);
        if (!d.body || !d.offset || !d.body_first || !d.body_id || !d.body_shape)
            return damaged("an array of the bodies", err);
    }
    return dem_load(&d, w->scenario->law, &w->job.material, options ? options->isa : NULL, w->threads, &w->dem, err);
}

static enum scree_status restore_series(const struct world_image *image, const char *name, struct series *series,
                                        struct scree_error *err)
{
    char values[40];
    struct series_head head;
    if (!series->values)
        return SCREE_OK;
    const void *stored = need(image, name, ARRAY_BYTES, sizeof head);
    if (!stored)
        return damaged(name, err);
    memcpy(&head, stored, sizeof head);
    snprintf(values, sizeof values, "%s.values", name);
    size_t count = head.rows < series->capacity ? head.rows * series->stream->column_count : SIZE_MAX;
    const void *data = need(image, values, ARRAY_REAL, count);
    if (!data)
        return damaged(values, err);
    series->seq = head.seq;
    series->rows = head.rows;
    series->t0_s = head.t0_s;
    memcpy(series->values, data, count * sizeof(double));
    return SCREE_OK;
}

static enum scree_status restore_window(const struct world_image *image, const char *name, struct window *window,
                                        struct scree_error *err)
{
    const struct world_array *array = find(image, name);
    size_t head = offsetof(struct window, instants);
    if (!array || array->type != ARRAY_BYTES || array->count < head || array->count > sizeof *window)
        return damaged(name, err);
    memcpy(window, array->data, array->count);
    return window->count <= WINDOW_INSTANTS && window_bytes(window) == array->count && window->every > 0 ? SCREE_OK
                                                                                                         : damaged(name, err);
}

static enum scree_status restore_head(struct scree_world *w, const struct world_image *image, struct scree_error *err)
{
    struct world_head head;
    const void *stored = need(image, "world", ARRAY_BYTES, sizeof head);
    if (!stored)
        return damaged("world", err);
    memcpy(&head, stored, sizeof head);
    w->step = head.step;
    w->stopped = head.stopped != 0;
    w->snapshot_seq = head.snapshot_seq;
    w->last = head.last;
    w->start_energy = head.start_energy;
    w->verdict = head.verdict;
    w->verdict.evidence[sizeof w->verdict.evidence - 1] = 0;
    w->trace = head.trace;
    return head.verdict.current <= VERDICT_ACCELERATING ? SCREE_OK : damaged("world", err);
}

enum scree_status world_image_restore(const struct world_image *image, const struct scree_options *options,
                                      const struct scree_sink *sink, struct scree_world **out, struct scree_error *err)
{
    struct scree_world *w = NULL;
    enum scree_status status = world_prepare(&image->job, options, sink, &w, err);
    if (status)
        return status;
    if ((status = restore_dem(w, image, options, err)) || (status = restore_head(w, image, err)) ||
        (status = restore_window(image, "window.force", &w->force_window, err)) ||
        (status = restore_window(image, "window.bulk", &w->bulk_window, err)) ||
        (status = restore_series(image, "series.force", &w->force_series, err)) ||
        (status = restore_series(image, "series.bulk", &w->bulk_series, err)) ||
        (status = restore_series(image, "series.energy", &w->energy_series, err)) ||
        (status = restore_series(image, "series.contact", &w->contact_series, err)) ||
        (status = restore_series(image, "series.flow", &w->flow_series, err))) {
        scree_world_free(w);
        return status;
    }
    *out = w;
    return SCREE_OK;
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
