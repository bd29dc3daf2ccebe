/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every material point at one instant, ordered by id: a frame, as frames.h has it for grains. */
#ifndef SCREE_MEASURE_POINTS_H
#define SCREE_MEASURE_POINTS_H

#include "continuum_view.h"
#include "scree.h"

enum { POINT_ID, POINT_X, POINT_VOLUME = 4, POINT_VX, POINT_COLUMNS = 8 };

extern const struct scree_stream point_snapshots_stream, points_stream;

/* Puts one frame as chunk `seq`. */
enum scree_status points_put(const struct continuum_view *view, const struct scree_stream *stream, uint64_t seq,
                             const struct scree_sink *sink, struct scree_error *err);

#endif
