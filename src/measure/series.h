/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows of numbers on their way into a stream: gathers them into chunks. Where a
 * stream is cut depends on the number of rows alone. */
#ifndef SCREE_MEASURE_SERIES_H
#define SCREE_MEASURE_SERIES_H

#include "scree.h"

struct series {
    const struct scree_stream *stream;
    uint64_t seq;    // of the chunk being gathered
    size_t rows;     // in it
    size_t capacity; // rows of a whole chunk; 0: chunks are frames
    double t0_s, dt_s;
    double *values;
};

/* `capacity` rows a chunk. Owns memory until series_end. */
enum scree_status series_start(struct series *series, const struct scree_stream *stream, size_t capacity, double dt_s,
                               struct scree_error *err);
void series_end(struct series *series);

/* Adds a row of stream->column_count numbers at time t_s; puts the chunk when it is whole. */
enum scree_status series_add(struct series *series, const struct scree_sink *sink, double t_s, const double *row,
                             struct scree_error *err);

/* Puts what has been gathered, if anything. */
enum scree_status series_flush(struct series *series, const struct scree_sink *sink, struct scree_error *err);

/* Puts `rows` rows at one instant as a chunk of their own. */
enum scree_status series_put_frame(struct series *series, const struct scree_sink *sink, double t_s, const double *rows,
                                   size_t count, struct scree_error *err);

#endif
