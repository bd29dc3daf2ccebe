/* SPDX-License-Identifier: GPL-3.0-or-later */
/* result.h5: stored streams, spec, numbers and verdict as H5MD 1.1.
 *
 *     /h5md                      version, author, creator
 *     /particles/grains          box, id, radius, mass, position, velocity, spin {value, step, time}
 *     /observables/STREAM        basal_force: value [n][3] with a fixed interval; others a dataset a column, where
 *                                they are frames with frame_time and frame_rows
 *     /parameters                spec, journal and numbers as text and attributes, read from the field tables
 *
 * The file is made beside its place, flushed to disk and renamed, so that a
 * result is there whole or not at all. Streams are copied chunk by chunk. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "io/files.h"
#include "io/h5.h"
#include "scree.h"

/* Columns of a frame, found by name so that frames may grow. */
struct frame_columns {
    int id, x, radius, vx, wx, mass;
};

static int column_of(const struct scree_stream *stream, const char *name)
{
    for (size_t k = 0; k < stream->column_count; k++)
        if (strcmp(stream->columns[k].name, name) == 0)
            return (int)k;
    return -1;
}

static void write_header(struct h5 *h5, const struct scree_result *r)
{
    const int64_t version[2] = {1, 1};
    h5_group(h5, "/h5md/author");
    h5_group(h5, "/h5md/creator");
    h5_attribute_ints(h5, "/h5md", "version", version, 2);
    h5_attribute_text(h5, "/h5md/author", "name", "unknown");
    h5_attribute_text(h5, "/h5md/creator", "name", "scree");
    h5_attribute_text(h5, "/h5md/creator", "version", scree_build());
    h5_group(h5, "/parameters");
    h5_attribute_text(h5, "/parameters", "spec", r->spec_json);
    h5_attribute_text(h5, "/parameters", "journal", r->journal_json);
    h5_attribute_text(h5, "/parameters", "build", scree_build());
    h5_attribute_text(h5, "/parameters", "job", r->job_id);
    h5_attribute_text(h5, "/parameters", "title", r->title);
    h5_attribute_text(h5, "/parameters", "scenario", r->job->scenario->name);
    h5_attribute_int(h5, "/parameters", "seed", r->job->seed);
    h5_attribute_text(h5, "/parameters", "state", r->state);
    h5_attribute_text(h5, "/parameters", "verdict", r->verdict);
    h5_attribute_text(h5, "/parameters", "evidence", r->evidence);
    h5_attribute_int(h5, "/parameters", "steps", (int64_t)r->steps);
    h5_attribute_real(h5, "/parameters", "time", r->time_s);
    h5_group(h5, "/parameters/numbers");
    for (size_t k = 0; k < r->number_count; k++) {
        char at[96];
        snprintf(at, sizeof at, "/parameters/numbers/%s", r->numbers[k].name);
        h5_scalar(h5, at, r->numbers[k].value);
        h5_attribute_text(h5, at, "unit", r->numbers[k].unit);
        h5_attribute_text(h5, at, "doc", r->numbers[k].doc);
    }
}

/* One table's values as datasets with units below `at`. */
static void write_table(struct h5 *h5, const char *at, const struct field_table *table, const void *object)
{
    h5_group(h5, at);
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        const void *value = (const char *)object + row->offset;
        char path[256];
        snprintf(path, sizeof path, "%s/%s", at, row->name);
        switch (row->type) {
        case FIELD_REAL:
            h5_scalar(h5, path, *(const double *)value);
            break;
        case FIELD_INT:
            h5_scalar_int(h5, path, *(const int64_t *)value);
            break;
        case FIELD_BOOL:
            h5_scalar_int(h5, path, *(const bool *)value);
            break;
        case FIELD_VEC3:
            h5_vector(h5, path, value, 3);
            break;
        case FIELD_ROWS:
            h5_vector(h5, path, field_rows_numbers_const(value), (size_t)field_rows_count(value) * row->columns);
            break;
        case FIELD_ENUM:
            h5_scalar_int(h5, path, *(const int *)value);
            h5_attribute_text(h5, path, "choice", row->choices[*(const int *)value]);
            break;
        case FIELD_FLAGS:
            h5_scalar_int(h5, path, *(const unsigned *)value);
            break;
        case FIELD_TEXT: // an attribute, and the spec has it
            h5_attribute_text(h5, at, row->name, value);
            continue;
        case FIELD_SWITCH:
            if (!*(const bool *)value)
                continue;
            write_table(h5, path, row->table, value);
            continue;
        case FIELD_GROUP:
            write_table(h5, path, row->table, value);
            continue;
        }
        h5_attribute_text(h5, path, "unit", row->unit);
    }
}

/* ---- streams ---- */

static enum scree_status fetch(const struct scree_source *source, const char *stream, uint64_t seq, struct scree_chunk *chunk,
                               bool *more, struct scree_error *err)
{
    memset(chunk, 0, sizeof *chunk);
    return source->next(source->context, stream, seq, chunk, more, err);
}

/* Basal force: H5MD's observable with linear time, value [n][3]. */
static enum scree_status write_uniform(struct h5 *h5, const struct scree_stream *stream, const struct scree_source *source,
                                       double step_s, struct scree_error *err)
{
    char at[128], value[160];
    snprintf(at, sizeof at, "/observables/%s", stream->name);
    snprintf(value, sizeof value, "%s/value", at);
    h5_group(h5, at);
    h5_table(h5, value, stream->column_count, 4096);
    h5_attribute_text(h5, value, "unit", stream->columns[0].unit);
    char names[256] = "";
    for (size_t k = 0; k < stream->column_count; k++)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", k ? "," : "", stream->columns[k].name);
    h5_attribute_text(h5, at, "columns", names);
    h5_attribute_text(h5, at, "doc", stream->doc);
    struct scree_chunk chunk;
    for (uint64_t seq = 0;; seq++) {
        bool more = false;
        enum scree_status status = fetch(source, stream->name, seq, &chunk, &more, err);
        if (status || !more)
            return status;
        if (seq == 0) {
            char time[160], step[160];
            snprintf(time, sizeof time, "%s/time", at);
            snprintf(step, sizeof step, "%s/step", at);
            h5_scalar(h5, time, chunk.dt_s);
            h5_attribute_real(h5, time, "offset", chunk.t0_s);
            h5_attribute_text(h5, time, "unit", "s");
            int64_t every = (int64_t)(chunk.dt_s / step_s + 0.5);
            h5_scalar_int(h5, step, every);
            h5_attribute_int(h5, step, "offset", every);
        }
        h5_append(h5, value, chunk.values, chunk.rows, stream->column_count);
    }
}

/* A dataset a column. Of frames the rows of all follow each other; when each was and how many rows it has stand beside. */
static enum scree_status write_columns(struct h5 *h5, const struct scree_stream *stream, const struct scree_source *source,
                                       struct scree_error *err)
{
    char at[128];
    snprintf(at, sizeof at, "/observables/%s", stream->name);
    h5_group(h5, at);
    h5_attribute_text(h5, at, "doc", stream->doc);
    for (size_t c = 0; c < stream->column_count; c++) {
        char column[192];
        snprintf(column, sizeof column, "%s/%s", at, stream->columns[c].name);
        h5_table(h5, column, 0, 1024);
        h5_attribute_text(h5, column, "unit", stream->columns[c].unit);
    }
    char times[160], sizes[160];
    snprintf(times, sizeof times, "%s/frame_time", at);
    snprintf(sizes, sizeof sizes, "%s/frame_rows", at);
    if (stream->frames) {
        h5_table(h5, times, 0, 64);
        h5_attribute_text(h5, times, "unit", "s");
        h5_table(h5, sizes, 0, 64);
    }
    struct scree_chunk chunk;
    double *values = NULL;
    size_t room = 0;
    enum scree_status status;
    for (uint64_t seq = 0;; seq++) {
        bool more = false;
        if ((status = fetch(source, stream->name, seq, &chunk, &more, err)) || !more ||
            (status = memory_grow((void **)&values, &room, chunk.rows, sizeof *values, err)))
            break;
        for (size_t c = 0; c < stream->column_count; c++) {
            char column[192];
            snprintf(column, sizeof column, "%s/%s", at, stream->columns[c].name);
            for (size_t k = 0; k < chunk.rows; k++)
                values[k] = chunk.values[k * stream->column_count + c];
            h5_append(h5, column, values, chunk.rows, 0);
        }
        double rows = (double)chunk.rows;
        if (stream->frames) {
            h5_append(h5, times, &chunk.t0_s, 1, 0);
            h5_append(h5, sizes, &rows, 1, 0);
        }
    }
    free(values);
    return status;
}

/* ---- grains ---- */

#define GRAINS "/particles/grains"

static void write_box(struct h5 *h5, const struct scree_stream *stream, const struct scree_chunk *chunk)
{
    struct frame_columns c = {
        .id = column_of(stream, "id"), .radius = column_of(stream, "radius"), .mass = column_of(stream, "mass")};
    size_t n = chunk->rows, columns = stream->column_count;
    h5_group(h5, GRAINS "/box");
    h5_attribute_int(h5, GRAINS "/box", "dimension", 3);
    double *values = memory_rows(n, sizeof *values);
    int64_t *ids = memory_rows(n, sizeof *ids);
    if (values && ids) {
        for (size_t i = 0; i < n; i++)
            ids[i] = (int64_t)chunk->values[i * columns + (size_t)c.id];
        h5_integers(h5, GRAINS "/id", ids, n);
        for (size_t i = 0; i < n; i++)
            values[i] = chunk->values[i * columns + (size_t)c.radius];
        h5_vector(h5, GRAINS "/radius", values, n);
        h5_attribute_text(h5, GRAINS "/radius", "unit", "m");
        for (size_t i = 0; i < n; i++)
            values[i] = chunk->values[i * columns + (size_t)c.mass];
        h5_vector(h5, GRAINS "/mass", values, n);
        h5_attribute_text(h5, GRAINS "/mass", "unit", "kg");
    }
    free(values);
    free(ids);
}

/* Three columns from `first` of one frame into the element's value, and its time. */
static void append_element(struct h5 *h5, const char *name, const struct scree_stream *stream, const struct scree_chunk *chunk,
                           int first, double step_s)
{
    char value[96], time[96], step[96];
    double *packed = memory_rows(chunk->rows * 3, sizeof *packed), steps = (double)(int64_t)(chunk->t0_s / step_s + 0.5);
    snprintf(value, sizeof value, GRAINS "/%s/value", name);
    snprintf(time, sizeof time, GRAINS "/%s/time", name);
    snprintf(step, sizeof step, GRAINS "/%s/step", name);
    if (!packed)
        return;
    for (size_t i = 0; i < chunk->rows; i++)
        for (size_t a = 0; a < 3; a++)
            packed[3 * i + a] = chunk->values[i * stream->column_count + (size_t)first + a];
    h5_append_frame(h5, value, packed, chunk->rows, 3);
    h5_append(h5, time, &chunk->t0_s, 1, 0);
    h5_append(h5, step, &steps, 1, 0);
    free(packed);
}

static void make_element(struct h5 *h5, const char *name, const char *unit, size_t rows)
{
    char path[96];
    snprintf(path, sizeof path, GRAINS "/%s/value", name);
    h5_frames(h5, path, rows, 3);
    h5_attribute_text(h5, path, "unit", unit);
    snprintf(path, sizeof path, GRAINS "/%s/time", name);
    h5_table(h5, path, 0, 64);
    h5_attribute_text(h5, path, "unit", "s");
    snprintf(path, sizeof path, GRAINS "/%s/step", name);
    h5_table(h5, path, 0, 64);
}

/* Frames of `snapshots`, then the last one of `grains`. */
static enum scree_status write_grains(struct h5 *h5, const struct scree_result *r, const struct scree_source *source,
                                      struct scree_error *err)
{
    static const char *const order[] = {"snapshots", "grains"};
    bool made = false;
    for (size_t o = 0; o < 2; o++)
        for (size_t s = 0; s < r->stream_count; s++) {
            const struct scree_stream *stream = r->streams[s];
            if (strcmp(stream->name, order[o]) != 0)
                continue;
            struct scree_chunk chunk;
            for (uint64_t seq = 0;; seq++) {
                bool more = false;
                enum scree_status status = fetch(source, stream->name, seq, &chunk, &more, err);
                if (status)
                    return status;
                if (!more)
                    break;
                if (!made) {
                    write_box(h5, stream, &chunk);
                    make_element(h5, "position", "m", chunk.rows);
                    make_element(h5, "velocity", "m s-1", chunk.rows);
                    make_element(h5, "spin", "rad s-1", chunk.rows);
                    made = true;
                }
                append_element(h5, "position", stream, &chunk, column_of(stream, "x"), r->job->time.step_s);
                append_element(h5, "velocity", stream, &chunk, column_of(stream, "vx"), r->job->time.step_s);
                append_element(h5, "spin", stream, &chunk, column_of(stream, "wx"), r->job->time.step_s);
            }
        }
    return SCREE_OK;
}

/* ---- the file ---- */

static enum scree_status write_streams(struct h5 *h5, const struct scree_result *r, const struct scree_source *source,
                                       struct scree_error *err)
{
    h5_group(h5, "/observables");
    for (size_t s = 0; s < r->stream_count; s++) {
        const struct scree_stream *stream = r->streams[s];
        enum scree_status status = SCREE_OK;
        bool grains = strcmp(stream->name, "snapshots") == 0 || strcmp(stream->name, "grains") == 0; // see write_grains
        if (stream->frames ? !grains : strcmp(stream->columns[0].name, "time") == 0)
            status = write_columns(h5, stream, source, err);
        else if (!stream->frames)
            status = write_uniform(h5, stream, source, r->job->time.step_s, err);
        if (status)
            return status;
    }
    return write_grains(h5, r, source, err);
}

enum scree_status scree_result_write(const struct scree_result *r, const struct scree_source *source, struct scree_error *err)
{
    char part[4096];
    struct h5 h5;
    if (snprintf(part, sizeof part, "%s.part", r->path) >= (int)sizeof part)
        return scree_fail(err, SCREE_IO, "", "the path %s is too long", r->path);
    h5_create(&h5, part);
    write_header(&h5, r);
    write_table(&h5, "/parameters/params", r->job->scenario->params, r->job->params);
    write_table(&h5, "/parameters/material", scenario_material(r->job->scenario)->table, &r->job->material);
    write_table(&h5, "/parameters/job", &job_table, r->job);
    enum scree_status status = h5.status ? SCREE_OK : write_streams(&h5, r, source, err);
    enum scree_status closed = h5_close(&h5, status ? NULL : err); // which tells of any failure before
    if (!status)
        status = closed;
    if (!status)
        status = files_into_place(part, r->path, err);
    if (status)
        unlink(part);
    return status;
}
