/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See points.h. Memory order changes as points move, ids do not: a row a point, at its id's place. */
#include "measure/points.h"

#include <stdlib.h>

#include "base/memory.h"

static const struct scree_column columns[POINT_COLUMNS] = {{"id", "1"},      {"x", "m"},    {"y", "m"},    {"z", "m"},
                                                           {"volume", "m3"}, {"vx", "m/s"}, {"vy", "m/s"}, {"vz", "m/s"}};
const struct scree_stream point_snapshots_stream = {"snapshots", "material points along time", columns, POINT_COLUMNS, true};
const struct scree_stream points_stream = {"points", "the last state of every material point", columns, POINT_COLUMNS, true};

enum scree_status points_put(const struct continuum_view *view, const struct scree_stream *stream, uint64_t seq,
                             const struct scree_sink *sink, struct scree_error *err)
{
    double *rows = memory_rows(view->points, POINT_COLUMNS * sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu points", view->points);
    for (size_t p = 0; p < view->points; p++) {
        double *row = rows + POINT_COLUMNS * (size_t)view->id[p];
        row[POINT_ID] = view->id[p];
        for (int a = 0; a < 4; a++)
            row[POINT_X + a] = view->position[p][a];
        for (int a = 0; a < 3; a++)
            row[POINT_VX + a] = view->velocity[p][a];
    }
    const struct scree_chunk chunk = {.stream = stream, .seq = seq, .t0_s = view->time_s, .rows = view->points, .values = rows};
    enum scree_status status = sink->put(sink->context, &chunk, err);
    free(rows);
    return status;
}
