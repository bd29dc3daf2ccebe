/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The picture of a sweep of flows down the chute of seed 003: mobility against
 * beta with its uncertainty bars, beside the published lines (Figs 8, 9, 10). */
#ifndef SCREE_CLIENT_PLOT_MOBILITY_H
#define SCREE_CLIENT_PLOT_MOBILITY_H

#include <stdbool.h>

#include "picture.h"
#include "protocol/json.h"

enum { PLOT_MOBILITY_WIDTH = 1500, PLOT_MOBILITY_HEIGHT = 620 };

/* Whether two trials or more of the table have both numbers. */
bool plot_mobility_fit(const cJSON *table);
/* `heading` (for gnuplot's multiplot) is in the script already. */
void plot_mobility_draw(struct picture *picture, const cJSON *table);

#endif
