/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows of a job's picture: bodies from aside and from above, an instant a row. */
#ifndef SCREE_CLIENT_PLOT_VIEWS_H
#define SCREE_CLIENT_PLOT_VIEWS_H

#include <stdio.h>

#include "reader.h"

enum { PLOT_VIEWS_ROWS = 5, PLOT_VIEWS_CAMERAS = 2 };

struct plot_views {
    FILE *script;
    size_t rows;
    double time[PLOT_VIEWS_ROWS];
    double far, high;                   // how far bodies reach along x, and up, in any row, m
    double fast;                        // the fastest that is seen, m/s
    double pixel[PLOT_VIEWS_CAMERAS];   // smallest distance of two lines, m
    double nearest[PLOT_VIEWS_CAMERAS]; // depths between which they lie, m
    double farthest[PLOT_VIEWS_CAMERAS];
};

/* How many rows there will be, by the record of `show`: 0 where nobody looked. */
size_t plot_views_rows(const cJSON *record);

/* Reads the instants that are drawn: of a collapse from the gate on, in units of sqrt(H_0 / g) where it is known. */
enum outcome plot_views_read(struct link *link, const cJSON *record, struct plot_views *views, struct scree_error *err);

/* One row between `low` and `low + high` of the picture's height; the last with the run-out and the height as measured. */
void plot_views_draw(const struct plot_views *views, const cJSON *record, size_t row, double low, double high);

#endif
