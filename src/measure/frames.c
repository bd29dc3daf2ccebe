/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See frames.h. */
#include "measure/frames.h"

#include <stdlib.h>

#include "base/memory.h"

static const struct scree_column columns[FRAME_COLUMNS] = {
    {"id", "1"},   {"x", "m"},      {"y", "m"},      {"z", "m"},      {"radius", "m"}, {"vx", "m/s"},  {"vy", "m/s"},
    {"vz", "m/s"}, {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}, {"mass", "kg"},  {"fixed", "1"},
};
const struct scree_stream snapshots_stream = {"snapshots", "every grain's state, a chunk an instant", columns, FRAME_COLUMNS, true};
const struct scree_stream grains_stream = {"grains", "every grain's state at the end", columns, FRAME_COLUMNS, true};

enum scree_status frame_put(const struct view *view, const struct scree_stream *stream, uint64_t seq, const struct scree_sink *sink,
                            struct scree_error *err)
{
    size_t n = view->moving + view->fixed;
    double(*rows)[FRAME_COLUMNS] = memory_rows(n, sizeof *rows);
    if (!rows)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a frame of %zu grains", n);
    for (size_t i = 0; i < n; i++) {
        double *row = rows[view->id[i]]; // ids are 0 .. n - 1
        row[FRAME_ID] = view->id[i];
        for (int a = 0; a < 3; a++) {
            row[FRAME_X + a] = view->position[i][a];
            row[FRAME_VX + a] = view->velocity[i][a];
            row[FRAME_WX + a] = view->spin[i][a];
        }
        row[FRAME_RADIUS] = view->position[i][3];
        row[FRAME_MASS] = view->velocity[i][3];
        row[FRAME_FIXED] = i >= view->moving;
    }
    const struct scree_chunk chunk = {.stream = stream, .seq = seq, .t0_s = view->time_s, .rows = n, .values = rows[0]};
    enum scree_status status = sink->put(sink->context, &chunk, err);
    free(rows);
    return status;
}
