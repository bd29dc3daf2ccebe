/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See h5.h. */
#include "io/h5.h"

#include <stdio.h>
#include <string.h>

#include "scree.h"

static bool ready(const struct h5 *h5)
{
    return h5->status == SCREE_OK;
}

/* Notes the first failure. */
static void check(struct h5 *h5, int64_t result, const char *what, const char *at)
{
    if (result < 0 && h5->status == SCREE_OK)
        h5->status = scree_fail(&h5->error, SCREE_IO, "", "cannot write %s: %s %s failed (disk full, or no permission?)", h5->path,
                                what, at);
}

void h5_create_after(struct h5 *h5, const char *path, size_t block)
{
    *h5 = (struct h5){.path = path};
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL); // failures are reported by us
    hid_t list = H5Pcreate(H5P_FILE_CREATE);
    if (block)
        H5Pset_userblock(list, block);
    h5->file = H5Fcreate(path, H5F_ACC_TRUNC, list, H5P_DEFAULT);
    H5Pclose(list);
    check(h5, h5->file, "creating", "the file");
}

void h5_create(struct h5 *h5, const char *path)
{
    h5_create_after(h5, path, 0);
}

enum scree_status h5_close(struct h5 *h5, struct scree_error *err)
{
    if (h5->file >= 0) {
        if (ready(h5))
            check(h5, H5Fflush(h5->file, H5F_SCOPE_GLOBAL), "flushing", "the file");
        check(h5, H5Fclose(h5->file), "closing", "the file");
    }
    if (h5->status && err)
        *err = h5->error;
    return h5->status;
}

static hid_t with_parents(void)
{
    hid_t list = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(list, 1);
    return list;
}

void h5_group(struct h5 *h5, const char *at)
{
    if (!ready(h5))
        return;
    hid_t parents = with_parents(), group = H5Gcreate2(h5->file, at, parents, H5P_DEFAULT, H5P_DEFAULT);
    check(h5, group, "making group", at);
    check(h5, H5Gclose(group), "closing", at);
    H5Pclose(parents);
}

static void attribute(struct h5 *h5, const char *at, const char *name, hid_t type, hid_t space, const void *value)
{
    hid_t object = H5Oopen(h5->file, at, H5P_DEFAULT);
    hid_t made = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    check(h5, made, "making attribute", name);
    if (made >= 0)
        check(h5, H5Awrite(made, type, value), "writing attribute", name);
    check(h5, H5Aclose(made), "closing attribute", name);
    check(h5, H5Oclose(object), "closing", at);
    H5Sclose(space);
}

void h5_attribute_text(struct h5 *h5, const char *at, const char *name, const char *text)
{
    if (!ready(h5))
        return;
    hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, strlen(text) + 1);
    H5Tset_cset(type, H5T_CSET_UTF8);
    attribute(h5, at, name, type, H5Screate(H5S_SCALAR), text);
    H5Tclose(type);
}

void h5_attribute_real(struct h5 *h5, const char *at, const char *name, double value)
{
    if (ready(h5))
        attribute(h5, at, name, H5T_NATIVE_DOUBLE, H5Screate(H5S_SCALAR), &value);
}

void h5_attribute_int(struct h5 *h5, const char *at, const char *name, int64_t value)
{
    if (ready(h5))
        attribute(h5, at, name, H5T_NATIVE_INT64, H5Screate(H5S_SCALAR), &value);
}

void h5_attribute_ints(struct h5 *h5, const char *at, const char *name, const int64_t *values, size_t count)
{
    const hsize_t size = count;
    if (ready(h5))
        attribute(h5, at, name, H5T_NATIVE_INT64, H5Screate_simple(1, &size, NULL), values);
}

/* A dataset that grows along its first dimension, shuffled and lightly compressed (losslessly). */
static void growing(struct h5 *h5, const char *at, int rank, const hsize_t *size, const hsize_t *chunk)
{
    hsize_t most[3] = {H5S_UNLIMITED, rank > 1 ? size[1] : 0, rank > 2 ? size[2] : 0};
    hid_t space = H5Screate_simple(rank, size, most), list = H5Pcreate(H5P_DATASET_CREATE), parents = with_parents();
    H5Pset_chunk(list, rank, chunk);
    H5Pset_shuffle(list);
    H5Pset_deflate(list, 1);
    hid_t set = H5Dcreate2(h5->file, at, H5T_IEEE_F64LE, space, parents, list, H5P_DEFAULT);
    check(h5, set, "making", at);
    check(h5, H5Dclose(set), "closing", at);
    H5Pclose(parents);
    H5Pclose(list);
    H5Sclose(space);
}

static void append(struct h5 *h5, const char *at, int rank, const hsize_t *count, const double *values)
{
    hsize_t size[3] = {0}, start[3] = {0};
    hid_t set = H5Dopen2(h5->file, at, H5P_DEFAULT), space = H5Dget_space(set);
    check(h5, H5Sget_simple_extent_dims(space, size, NULL), "reading the size of", at);
    H5Sclose(space);
    start[0] = size[0];
    size[0] += count[0];
    check(h5, H5Dset_extent(set, size), "extending", at);
    space = H5Dget_space(set);
    hid_t memory = H5Screate_simple(rank, count, NULL);
    check(h5, H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL), "selecting in", at);
    check(h5, H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values), "writing", at);
    H5Sclose(memory);
    H5Sclose(space);
    check(h5, H5Dclose(set), "writing", at); // what it still held
}

void h5_table(struct h5 *h5, const char *at, size_t columns, size_t chunk_rows)
{
    const hsize_t size[2] = {0, columns}, chunk[2] = {chunk_rows, columns};
    if (ready(h5))
        growing(h5, at, columns ? 2 : 1, size, chunk);
}

void h5_append(struct h5 *h5, const char *at, const double *values, size_t rows, size_t columns)
{
    const hsize_t count[2] = {rows, columns};
    if (ready(h5))
        append(h5, at, columns ? 2 : 1, count, values);
}

void h5_frames(struct h5 *h5, const char *at, size_t rows, size_t columns)
{
    const hsize_t size[3] = {0, rows, columns}, chunk[3] = {1, rows, columns};
    if (ready(h5))
        growing(h5, at, columns ? 3 : 2, size, chunk);
}

void h5_append_frame(struct h5 *h5, const char *at, const double *values, size_t rows, size_t columns)
{
    const hsize_t count[3] = {1, rows, columns};
    if (ready(h5))
        append(h5, at, columns ? 3 : 2, count, values);
}

static void whole(struct h5 *h5, const char *at, hid_t file_type, hid_t type, hid_t space, const void *values)
{
    hid_t parents = with_parents(), set = H5Dcreate2(h5->file, at, file_type, space, parents, H5P_DEFAULT, H5P_DEFAULT);
    check(h5, set, "making", at);
    if (set >= 0)
        check(h5, H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "writing", at);
    check(h5, H5Dclose(set), "writing", at);
    H5Pclose(parents);
    H5Sclose(space);
}

void h5_vector(struct h5 *h5, const char *at, const double *values, size_t count)
{
    const hsize_t size = count;
    if (ready(h5))
        whole(h5, at, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, H5Screate_simple(1, &size, NULL), values);
}

void h5_integers(struct h5 *h5, const char *at, const int64_t *values, size_t count)
{
    const hsize_t size = count;
    if (ready(h5))
        whole(h5, at, H5T_STD_I64LE, H5T_NATIVE_INT64, H5Screate_simple(1, &size, NULL), values);
}

void h5_scalar(struct h5 *h5, const char *at, double value)
{
    if (ready(h5))
        whole(h5, at, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, H5Screate(H5S_SCALAR), &value);
}

void h5_scalar_int(struct h5 *h5, const char *at, int64_t value)
{
    if (ready(h5))
        whole(h5, at, H5T_STD_I64LE, H5T_NATIVE_INT64, H5Screate(H5S_SCALAR), &value);
}

void h5_array(struct h5 *h5, const char *at, hid_t type, const void *values, size_t count)
{
    const hsize_t size = count;
    if (ready(h5))
        whole(h5, at, type, type, H5Screate_simple(1, &size, NULL), values);
}

enum scree_status scree_prepare(struct scree_error *err)
{
    const double numbers[2] = {1, 2};
    const int64_t integers[2] = {1, 2};
    struct h5 h5 = {.path = "in memory"};
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fapl_core(access, 1 << 16, false);
    h5.file = H5Fcreate("scree", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    H5Pclose(access);
    check(&h5, h5.file, "creating", "a file");
    h5_attribute_text(&h5, "/", "text", "text");
    h5_table(&h5, "/group/numbers", 0, 2);
    h5_append(&h5, "/group/numbers", numbers, 2, 0);
    h5_integers(&h5, "/group/integers", integers, 2);
    if (h5_close(&h5, NULL))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "libhdf5 cannot be used: no memory for it?");
    return SCREE_OK;
}
