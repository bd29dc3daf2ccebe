/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A table of numbers and words as HDF5: the trials of a study. */
#ifndef SCREE_IO_TABLE_H
#define SCREE_IO_TABLE_H

#include <stddef.h>

#include "base/status.h"

struct io_column {
    const char *name, *unit;  // "material.mu_t"; no '/'
    const double *values;     // one a row, NaN where there is none; or
    const char *const *words; // one a row, never NULL
};

struct io_table {
    const char *path;
    /* Of the study: written as attributes of /study, the spec as a dataset for it may be long. */
    const char *id, *kind, *title, *state, *conclusion, *build, *spec_json;
    const struct io_column *columns;
    size_t column_count, rows;
};

/* Writes PATH beside, flushed to disk, then renamed: /study/spec, and /trials/COLUMN with its unit for
 * every column. All HDF5 calls of a process must come from one thread. */
enum scree_status io_table_write(const struct io_table *table, struct scree_error *err);

#endif
