/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checkpoints: a world's image as HDF5, one dataset an array.
 *
 * /checkpoint carries version, build and a hash of the job's fields, a seal the
 * checksum of the file; one that does not match in any of them is refused by
 * name, so that the caller can take the older one. Uncompressed: speed matters. */
#include "io/checkpoint.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/failpoint.h"
#include "base/memory.h"
#include "io/files.h"
#include "io/h5.h"
#include "io/seal.h"

enum { CHECKPOINT_VERSION = 1 };

/* ---- hashes ---- */

static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *p = data;
    for (; size >= 8; size -= 8, p += 8) {
        uint64_t word;
        memcpy(&word, p, sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    for (; size > 0; size--, p++)
        hash = (hash ^ *p) * 0x100000001b3u;
    return hash ^ hash >> 32;
}

/* Every value of the table, by its rows: padding and switched-off parts do not count. */
static uint64_t hash_table(uint64_t hash, const struct field_table *table, const void *object)
{
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        const char *value = (const char *)object + row->offset;
        if (row->type == FIELD_TEXT || row->aside)
            continue; // changes no bit of the world
        if (row->type == FIELD_SWITCH)
            hash = hash_bytes(hash, value, sizeof(bool));
        if (row->type == FIELD_GROUP || (row->type == FIELD_SWITCH && *(const bool *)(const void *)value))
            hash = hash_table(hash, row->table, value);
        else if (row->type != FIELD_SWITCH && row->type != FIELD_GROUP)
            hash = hash_bytes(hash, value, field_value_size(row));
    }
    return hash;
}

static uint64_t hash_job(const struct job_spec *job)
{
    uint64_t hash = hash_bytes(1, job->scenario->name, strlen(job->scenario->name));
    hash = hash_table(hash, &job_table, job);
    hash = hash_table(hash, job->scenario->params, job->params);
    return hash_table(hash, scenario_material(job->scenario)->table, &job->material);
}

/* ---- writing ---- */

static hid_t type_of(enum world_array_type type)
{
    switch (type) {
    case ARRAY_U32:
        return H5T_NATIVE_UINT32;
    case ARRAY_U64:
        return H5T_NATIVE_UINT64;
    case ARRAY_REAL:
        return H5T_NATIVE_DOUBLE;
    case ARRAY_BYTES:
        break;
    }
    return H5T_NATIVE_UINT8;
}

static enum scree_status write_image(const struct world_image *image, const char *path, struct scree_error *err)
{
    char part[4096];
    struct h5 h5;
    if (snprintf(part, sizeof part, "%s.part", path) >= (int)sizeof part)
        return scree_fail(err, SCREE_IO, "", "the path %s is too long", path);
    h5_create_after(&h5, part, SEAL_BYTES);
    h5_group(&h5, "/checkpoint");
    h5_attribute_int(&h5, "/checkpoint", "version", CHECKPOINT_VERSION);
    h5_attribute_text(&h5, "/checkpoint", "build", scree_build());
    h5_attribute_text(&h5, "/checkpoint", "scenario", image->job.scenario->name);
    h5_attribute_int(&h5, "/checkpoint", "job", (int64_t)hash_job(&image->job));
    for (size_t k = 0; k < image->count; k++) {
        char at[64];
        snprintf(at, sizeof at, "/arrays/%02zu.%s", k, image->arrays[k].name);
        h5_array(&h5, at, type_of(image->arrays[k].type), image->arrays[k].data, image->arrays[k].count);
    }
    enum scree_status status = h5_close(&h5, err);
    FAILPOINT("checkpoint-written");
    if (!status)
        status = seal_write(part, err);
    FAILPOINT("checkpoint-sealed");
    if (!status)
        status = files_into_place(part, path, err);
    FAILPOINT("checkpoint-in-place");
    if (status)
        remove(part);
    return status;
}

enum scree_status scree_image_write(const struct scree_image *image, const char *path, struct scree_error *err)
{
    return write_image(&image->image, path, err);
}

enum scree_status scree_checkpoint_write(const struct scree_world *world, const char *path, struct scree_error *err)
{
    struct world_image image;
    enum scree_status status = world_image_take(world, &image, err);
    if (status)
        return status;
    status = write_image(&image, path, err);
    world_image_free(&image);
    return status;
}

/* ---- reading ---- */

static enum scree_status refused(const char *path, const char *why, struct scree_error *err)
{
    return scree_fail(err, SCREE_CORRUPT, "", "checkpoint %s is not used: %s", path, why);
}

static bool read_integer(hid_t file, const char *name, int64_t *value)
{
    hid_t attribute = H5Aopen_by_name(file, "/checkpoint", name, H5P_DEFAULT, H5P_DEFAULT);
    bool good = attribute >= 0 && H5Aread(attribute, H5T_NATIVE_INT64, value) >= 0;
    if (attribute >= 0)
        H5Aclose(attribute);
    return good;
}

static bool read_text(hid_t file, const char *name, char *out, size_t size)
{
    hid_t attribute = H5Aopen_by_name(file, "/checkpoint", name, H5P_DEFAULT, H5P_DEFAULT);
    bool good = false;
    memset(out, 0, size);
    if (attribute >= 0) {
        hid_t type = H5Aget_type(attribute);
        good = H5Tget_class(type) == H5T_STRING && !H5Tis_variable_str(type) && H5Tget_size(type) < size &&
               H5Aread(attribute, type, out) >= 0;
        H5Tclose(type);
        H5Aclose(attribute);
    }
    return good;
}

/* One dataset into the image; its name says order and array. */
static bool read_array(hid_t group, hsize_t index, struct world_image *image)
{
    char name[64] = "";
    struct world_array *array = &image->arrays[image->count];
    if (image->count >= WORLD_ARRAYS_MAX ||
        H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, index, name, sizeof name, H5P_DEFAULT) < 4)
        return false;
    hid_t set = H5Dopen2(group, name, H5P_DEFAULT);
    if (set < 0)
        return false;
    hid_t space = H5Dget_space(set), type = H5Dget_type(set);
    hssize_t count = H5Sget_simple_extent_npoints(space);
    size_t size = H5Tget_size(type);
    array->type = H5Tget_class(type) == H5T_FLOAT ? ARRAY_REAL : size == 1 ? ARRAY_BYTES : size == 4 ? ARRAY_U32 : ARRAY_U64;
    snprintf(array->name, sizeof array->name, "%s", name + 3);
    void *data = count >= 0 && count < 1000000000 ? memory_rows((size_t)count, world_array_size(array->type)) : NULL;
    bool good = data && size == world_array_size(array->type) &&
                H5Dread(set, type_of(array->type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
    array->count = (size_t)count;
    array->data = data;
    if (data)
        image->owned[image->owned_count++] = data;
    image->count += good;
    H5Tclose(type);
    H5Sclose(space);
    H5Dclose(set);
    return good;
}

enum scree_status checkpoint_read_image(hid_t file, const char *path, const struct job_spec *job, struct world_image *image,
                                        struct scree_error *err)
{
    int64_t version = 0, job_hash = 0;
    char build[128];
    if (!read_integer(file, "version", &version) || !read_text(file, "build", build, sizeof build) ||
        !read_integer(file, "job", &job_hash))
        return refused(path, "its header is damaged", err);
    if (version != CHECKPOINT_VERSION || strcmp(build, scree_build()) != 0)
        return refused(path, "another build wrote it", err);
    if ((uint64_t)job_hash != hash_job(job))
        return refused(path, "it belongs to another job", err);
    hid_t group = H5Gopen2(file, "/arrays", H5P_DEFAULT);
    H5G_info_t info = {.nlinks = 0};
    bool good = group >= 0 && H5Gget_info(group, &info) >= 0;
    for (hsize_t k = 0; good && k < info.nlinks; k++)
        good = read_array(group, k, image);
    if (group >= 0)
        H5Gclose(group);
    if (!good)
        return refused(path, "an array is damaged", err);
    return SCREE_OK;
}

enum scree_status scree_checkpoint_read(const char *path, const struct job_spec *job, const struct scree_options *options,
                                        const struct scree_sink *sink, struct scree_world **out, struct scree_error *err)
{
    struct world_image image = {.job = *job};
    enum scree_status status = seal_check(path, err);
    if (status)
        return status;
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        return refused(path, "it cannot be opened as HDF5", err);
    status = checkpoint_read_image(file, path, job, &image, err);
    if (H5Fclose(file) < 0 && !status)
        status = refused(path, "it cannot be closed", err);
    if (!status) {
        struct scree_error inner = {0};
        status = world_image_restore(&image, options, sink, out, &inner);
        if (status == SCREE_CORRUPT)
            refused(path, inner.message, err);
        else if (status && err)
            *err = inner;
    }
    world_image_free(&image);
    return status;
}
