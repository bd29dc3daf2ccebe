/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See coarse.h. */
#include "measure/coarse.h"

#include <math.h>

#define CUT        3.0  // K of kinematic profiles
#define EVERYWHERE 18.6 // exp(-2 x^2) < 1e-300 beyond

struct coarse_grid coarse_grid_of(double base_z, double diameter, double area, size_t layers)
{
    return (struct coarse_grid){
        .first = base_z - 7.0 / 8.0 * diameter, .step = diameter / 4, .diameter = diameter, .area = area, .count = 16 * layers};
}

double coarse_height(const struct coarse_grid *grid, size_t k)
{
    return grid->first + (double)k * grid->step;
}

static void add_weighted(double weight, const double *values, size_t n, double *sums)
{
    for (size_t v = 0; v < n; v++)
        sums[v] += weight * values[v];
}

/* From one height to the next a Gaussian changes by a factor that itself changes by a constant one, so that its values at
 * all heights follow from that at the nearest: errors stay below 1e-12, and flows have thousands of collisions a grain and second.
 */
void coarse_add(const struct coarse_grid *grid, double z, bool cut, const double *values, size_t n, double *sums, size_t stride)
{
    double d = grid->diameter, reach = (cut ? CUT : EVERYWHERE) * d, place = (z - grid->first) / grid->step;
    double norm = sqrt(2 / M_PI) / (grid->area * d * (cut ? erf(CUT * M_SQRT2) : 1));
    double lowest = ceil((z - reach - grid->first) / grid->step), highest = floor((z + reach - grid->first) / grid->step);
    size_t from = lowest > 0 ? (size_t)fmin(lowest, (double)grid->count) : 0;
    size_t to = highest < 0 ? 0 : (size_t)fmin(highest + 1, (double)grid->count);
    if (from >= to)
        return;
    size_t nearest = (size_t)fmin(fmax(round(place), (double)from), (double)(to - 1));
    double s = grid->step / d, x = (place - (double)nearest) * s, at = norm * exp(-2 * x * x), ever = exp(-4 * s * s);
    double weight = at, ratio = exp(4 * x * s - 2 * s * s);
    for (size_t k = nearest; k < to; k++, weight *= ratio, ratio *= ever)
        add_weighted(weight, values, n, sums + k * stride);
    weight = at, ratio = exp(-4 * x * s - 2 * s * s);
    for (size_t k = nearest; k-- > from;) {
        weight *= ratio, ratio *= ever;
        add_weighted(weight, values, n, sums + k * stride);
    }
}
