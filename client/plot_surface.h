/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A row of a continuum's picture: its free surface and the line below which nothing
 * flows, at three times (seed 002, Figs 8 and 10). */
#ifndef SCREE_CLIENT_PLOT_SURFACE_H
#define SCREE_CLIENT_PLOT_SURFACE_H

#include "picture.h"
#include "reader.h"

enum { PLOT_SURFACE_FRAMES = 1000 };

struct plot_surface {
    FILE *script;
    size_t frames;
    double time[PLOT_SURFACE_FRAMES]; // s; later frames than these are not looked at, but for the last
};

/* A frame of the stream `surface` as data of the script; `context` is a struct plot_surface. */
void plot_surface_take(void *context, const struct reader_chunk *chunk);

/* The plot, where the script now is: the start, two moments 0.2 s and 0.6 s after the gate began to lift at `gate_s`
 * or thirds of a shorter run, and the last frame. */
void plot_surface_draw(struct picture *picture, const struct plot_surface *surface, double gate_s);

#endif
