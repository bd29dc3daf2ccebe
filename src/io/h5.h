/* SPDX-License-Identifier: GPL-3.0-or-later */
/* HDF5 in the few shapes that results need. A handle collects the first failure;
 * later calls then do nothing, so that writers read straight through. */
#ifndef SCREE_IO_H5_H
#define SCREE_IO_H5_H

#include <hdf5.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct h5 {
    hid_t file;
    const char *path;
    enum scree_status status;
    struct scree_error error;
};

/* Creates PATH anew; h5_close flushes and closes it and returns the status. */
void h5_create(struct h5 *h5, const char *path);
/* The same with a user block of so many bytes (a power of two from 512 on) at the head. */
void h5_create_after(struct h5 *h5, const char *path, size_t block);
enum scree_status h5_close(struct h5 *h5, struct scree_error *err);

/* Groups and attributes; `at` is a path within the file, parents are made. */
void h5_group(struct h5 *h5, const char *at);
void h5_attribute_text(struct h5 *h5, const char *at, const char *name, const char *text);
void h5_attribute_real(struct h5 *h5, const char *at, const char *name, double value);
void h5_attribute_int(struct h5 *h5, const char *at, const char *name, int64_t value);
void h5_attribute_ints(struct h5 *h5, const char *at, const char *name, const int64_t *values, size_t count);

/* A dataset of doubles, rows x columns (columns 0: one-dimensional), that grows by rows. */
void h5_table(struct h5 *h5, const char *at, size_t columns, size_t chunk_rows);
void h5_append(struct h5 *h5, const char *at, const double *values, size_t rows, size_t columns);
/* A whole one-dimensional dataset, and a scalar. */
void h5_vector(struct h5 *h5, const char *at, const double *values, size_t count);
void h5_integers(struct h5 *h5, const char *at, const int64_t *values, size_t count);
void h5_scalar(struct h5 *h5, const char *at, double value);
void h5_scalar_int(struct h5 *h5, const char *at, int64_t value);

/* A whole dataset of any type, contiguous. */
void h5_array(struct h5 *h5, const char *at, hid_t type, const void *values, size_t count);

/* A dataset frames x rows x columns (columns 0: frames x rows) that grows by frames. */
void h5_frames(struct h5 *h5, const char *at, size_t rows, size_t columns);
void h5_append_frame(struct h5 *h5, const char *at, const double *values, size_t rows, size_t columns);

#endif
