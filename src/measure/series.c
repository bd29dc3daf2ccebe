/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See series.h. */
#include "measure/series.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum scree_status series_start(struct series *series, const struct scree_stream *stream, size_t capacity, double dt_s,
                               struct scree_error *err)
{
    *series = (struct series){.stream = stream, .capacity = capacity, .dt_s = dt_s};
    series->values = memory_rows(capacity * stream->column_count, sizeof *series->values);
    return series->values ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the stream %s", stream->name);
}

void series_end(struct series *series)
{
    free(series->values);
    series->values = NULL;
}

enum scree_status series_flush(struct series *series, const struct scree_sink *sink, struct scree_error *err)
{
    if (series->rows == 0)
        return SCREE_OK;
    const struct scree_chunk chunk = {.stream = series->stream,
                                      .seq = series->seq,
                                      .t0_s = series->t0_s,
                                      .dt_s = series->dt_s,
                                      .rows = series->rows,
                                      .values = series->values};
    enum scree_status status = sink->put(sink->context, &chunk, err);
    series->seq++;
    series->rows = 0;
    return status;
}

enum scree_status series_add(struct series *series, const struct scree_sink *sink, double t_s, const double *row,
                             struct scree_error *err)
{
    size_t columns = series->stream->column_count;
    if (series->rows == 0)
        series->t0_s = t_s;
    memcpy(series->values + series->rows * columns, row, columns * sizeof *row);
    return ++series->rows == series->capacity ? series_flush(series, sink, err) : SCREE_OK;
}

enum scree_status series_put_frame(struct series *series, const struct scree_sink *sink, double t_s, const double *rows,
                                   size_t count, struct scree_error *err)
{
    const struct scree_chunk chunk = {.stream = series->stream, .seq = series->seq, .t0_s = t_s, .rows = count, .values = rows};
    enum scree_status status = sink->put(sink->context, &chunk, err);
    series->seq++;
    return status;
}
