/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows of the picture of a flow down a chute: the apparatus with its grains, the
 * deposit from above, and what the flow did on the way. */
#ifndef SCREE_CLIENT_PLOT_CHUTE_H
#define SCREE_CLIENT_PLOT_CHUTE_H

#include <stdbool.h>
#include <stdio.h>

#include "reader.h"

enum { PLOT_CHUTE_FRAMES = 4, PLOT_CHUTE_ROWS = 4 };

struct plot_chute {
    FILE *script;
    size_t walls, flow, layers, bodies, frames; // blocks or rows of data written
    double floor;                               // half the floor's width, m
    double time[PLOT_CHUTE_FRAMES];             // of each, s
    double layers_s;                            // of the layers drawn
};

/* One for each stream: a chunk as data of the script; `context` is a struct plot_chute. */
void plot_chute_take_walls(void *context, const struct reader_chunk *chunk);
void plot_chute_take_snapshot(void *context, const struct reader_chunk *chunk);
void plot_chute_take_bodies(void *context, const struct reader_chunk *chunk);
void plot_chute_take_flow(void *context, const struct reader_chunk *chunk); // chunks of one stream, all of them
void plot_chute_take_layers(void *context, const struct reader_chunk *chunk);

/* Row 0..PLOT_CHUTE_ROWS-1 between `low` and `low + high` of the picture's height. */
void plot_chute_draw(const struct plot_chute *plot, int row, double low, double high);

#endif
