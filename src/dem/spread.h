/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How far grains that the outer lists do not hold have come towards each other. */
#ifndef SCREE_DEM_SPREAD_H
#define SCREE_DEM_SPREAD_H

#include "dem/cells.h"
#include "dem/state.h"

struct spread_bound {
    double moved; // no two such grains have come nearer than by this since the lists were made, m
    double rate;  // nor do they come nearer faster than this, m/s
};

/* Bounds over all pairs that lists of `skin` from this grid do not hold, for grains that are still in the rows they had
 * then. Pairs that were farther apart then than the skin count for less: for the skin's share of their distance. */
enum scree_status spread_measure(struct cells *cells, const struct dem *dem, double skin, struct spread_bound *out,
                                 struct scree_error *err);

#endif
