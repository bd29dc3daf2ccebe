/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Distance of two convex sets of points (Gilbert, Johnson and Keerthi 1988), and
 * their separation or penetration when each has a crust around it.
 *
 * Every tolerance is a share of the bodies' own size: absolute ones declare false
 * contacts between millimetre grains. */
#ifndef SCREE_GEOM_GJK_H
#define SCREE_GEOM_GJK_H

#include <stddef.h>
#include <stdint.h>

#include "base/quat.h"

/* A core of at most 255 points in its own frame, and where that frame is. */
struct gjk_core {
    const double (*vertex)[3];
    size_t vertices;
    struct turn turn;
    struct vec3 centre;
};

/* The simplex that the last query ended with, by the numbers of its vertices: a start for the next. Zeroed: none. */
struct gjk_cache {
    uint8_t count, a[4], b[4];
};

enum gjk_state {
    GJK_APART,  // distance > 0, points and normal are set
    GJK_INSIDE, // the cores overlap or touch: depth is another matter
    GJK_UNSURE, // the cap on iterations was met: distance is an upper bound, the caller reports it; never a contact by itself
};

struct gjk_result {
    double distance;        // of the cores, m
    struct vec3 on_a, on_b; // the nearest points, in space, m
    struct vec3 normal;     // from a to b, unit length
    int iterations;
};

enum { GJK_ITERATIONS = 64 };

enum gjk_state gjk_distance(const struct gjk_core *a, const struct gjk_core *b, struct gjk_cache *cache, struct gjk_result *out);

#endif
