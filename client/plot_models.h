/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The picture of a sweep of flows over a base: the high-frequency power of its
 * force against the inertial number, and what models predict against it. */
#ifndef SCREE_CLIENT_PLOT_MODELS_H
#define SCREE_CLIENT_PLOT_MODELS_H

#include <stdbool.h>

#include "picture.h"
#include "protocol/json.h"

/* Writes the plots if two trials or more of the table have both numbers; false: nothing was written. `heading`
 * (for gnuplot's multiplot) is in the script already. */
bool plot_models_fit(const cJSON *table);
void plot_models_draw(struct picture *picture, const cJSON *table);

#endif
