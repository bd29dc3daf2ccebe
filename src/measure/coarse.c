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

void coarse_add(const struct coarse_grid *grid, double z, bool cut, const double *values, size_t n, double *sums, size_t stride)
{
    double d = grid->diameter, reach = (cut ? CUT : EVERYWHERE) * d;
    double norm = sqrt(2 / M_PI) / (grid->area * d * (cut ? erf(CUT * M_SQRT2) : 1));
    double lowest = ceil((z - reach - grid->first) / grid->step), highest = floor((z + reach - grid->first) / grid->step);
    size_t from = lowest > 0 ? (size_t)fmin(lowest, (double)grid->count) : 0;
    size_t to = highest < 0 ? 0 : (size_t)fmin(highest + 1, (double)grid->count);
    for (size_t k = from; k < to; k++) {
        double x = (z - coarse_height(grid, k)) / d;
        if (cut && !(fabs(x) < CUT))
            continue;
        double weight = norm * exp(-2 * x * x);
        for (size_t v = 0; v < n; v++)
            sums[k * stride + v] += weight * values[v];
    }
}
