/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See frames.h. */
#include "measure/frames.h"

#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/measure.h"

static const struct scree_column columns[FRAME_COLUMNS] = {
    {"id", "1"},   {"x", "m"},      {"y", "m"},      {"z", "m"},      {"radius", "m"}, {"vx", "m/s"},  {"vy", "m/s"},
    {"vz", "m/s"}, {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}, {"mass", "kg"},  {"fixed", "1"},
};
static const struct scree_stream snapshots_stream = {"snapshots", "every grain's state, a chunk an instant", columns, FRAME_COLUMNS,
                                                     true};
static const struct scree_stream grains_stream = {"grains", "every grain's state at the end", columns, FRAME_COLUMNS, true};

static enum scree_status frame_put(const struct view *view, struct series *series, const struct scree_sink *sink,
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
    enum scree_status status = series_put_frame(series, sink, view->time_s, rows[0], n, err);
    free(rows);
    return status;
}

static size_t chunk(const struct measure_context *context)
{
    (void)context;
    return 0;
}

static enum scree_status put(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    return frame_put(now->grains, state, context->sink, err);
}

static const struct scree_stream *const snapshots_streams[] = {&snapshots_stream};
const struct measurement measure_snapshots = {
    .name = "snapshots",
    .kind = SCENARIO_DEM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct series),
    .streams = snapshots_streams,
    .stream_count = 1,
    .chunk = chunk,
    .first = put,
    .sample = put,
};

static const struct scree_stream *const grains_streams[] = {&grains_stream};
const struct measurement measure_grains = {
    .kind = SCENARIO_DEM,
    .size = sizeof(struct series),
    .streams = grains_streams,
    .stream_count = 1,
    .chunk = chunk,
    .close = put,
};
