/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Free surface and static line of a continuum along its channel, under `record.surface`. */
#include "measure/deposit.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/measure.h"

static size_t frames(const struct measure_context *context)
{
    (void)context;
    return 0;
}

static enum scree_status put(void *state, struct measure_context *context, const struct measure_now *now, struct scree_error *err)
{
    const struct continuum_view *view = now->points;
    struct deposit_lines lines;
    enum scree_status status = deposit_lines_start(&lines, view, err);
    if (status)
        return status;
    double(*rows)[SURFACE_COLUMNS] = memory_rows(lines.layers, sizeof *rows);
    if (rows) {
        deposit_trace(view, 0, &lines);
        deposit_surface(view, &lines, rows);
        status = series_put_frame(state, context->sink, view->time_s, rows[0], lines.layers, err);
    } else {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a surface of %zu places", lines.layers);
    }
    free(rows);
    deposit_lines_free(&lines);
    return status;
}

/* The end, where no frame is due: a collapse is at rest there. */
static enum scree_status put_last(void *state, struct measure_context *context, const struct measure_now *now,
                                  struct scree_error *err)
{
    uint64_t every = (uint64_t)fmax(1, round(context->job->record.surface.every_s / context->job->time.step_s));
    return context->step % every == 0 ? SCREE_OK : put(state, context, now, err);
}

static const struct scree_stream *const streams[] = {&surface_stream};
const struct measurement measure_surface = {
    .name = "surface",
    .kind = SCENARIO_MPM,
    .needs = MEASURE_VIEW,
    .size = sizeof(struct series),
    .streams = streams,
    .stream_count = 1,
    .chunk = frames,
    .first = put,
    .sample = put,
    .close = put_last,
};
