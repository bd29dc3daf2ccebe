/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every grain at one instant, ordered by id: a frame of `snapshots`, and the
 * last state of every job, `grains`. */
#ifndef SCREE_MEASURE_FRAMES_H
#define SCREE_MEASURE_FRAMES_H

enum { FRAME_ID, FRAME_X, FRAME_RADIUS = 4, FRAME_VX, FRAME_WX = 8, FRAME_MASS = 11, FRAME_FIXED, FRAME_COLUMNS };

#endif
