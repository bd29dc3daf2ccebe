/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Filling space with grains that do not overlap. */
#ifndef SCREE_SCENARIO_PACKING_H
#define SCREE_SCENARIO_PACKING_H

#include <stddef.h>

#include "base/rng.h"
#include "dem/dem.h"

struct packing {
    double length[2];                  // extents along x and y, m, which are periodic
    bool between;                      // y is not: new grains lie wholly within it
    double floor_z;                    // new grains lie wholly above, m
    double first_ceiling;              // height above the floor below which the first grains are tried, m
    double rise;                       // of the ceiling per failed try, m
    double radius, spread, density;    // radii are uniform on radius (1 -+ spread)
    const struct dem_grain *obstacles; // grains that are there already
    size_t obstacle_count;
};

/* Random sequential insertion: each grain is tried at random places below a
 * ceiling that rises a little with every failure, until it overlaps nothing
 * (protocols 1.4). Takes time in proportion to `count`. Writes `count` grains
 * at rest. */
enum scree_status packing_insert(const struct packing *packing, struct rng *rng, size_t count, struct dem_grain *out,
                                 struct scree_error *err);

#endif
