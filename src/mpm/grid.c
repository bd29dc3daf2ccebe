/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See grid.h. */
#include "mpm/grid.h"

#include <math.h>

void grid_start(struct grid *grid, const double length[3], const int cells[3], bool plane, bool endless)
{
    grid->plane = plane;
    grid->flat[0] = endless;
    grid->flat[1] = plane;
    grid->flat[2] = false;
    for (int a = 0; a < 3; a++) {
        bool flat = grid->flat[a];
        grid->cells[a] = flat ? 1 : cells[a];
        grid->length[a] = flat ? 1 : length[a];
        grid->spacing[a] = grid->length[a] / grid->cells[a];
        grid->inverse[a] = grid->cells[a] / grid->length[a];
    }
    grid->stride[2] = 1;
    grid->stride[1] = (size_t)grid->cells[2] + 3;
    grid->stride[0] = grid->stride[1] * ((size_t)grid->cells[1] + 3);
    grid->node_count = grid->stride[0] * ((size_t)grid->cells[0] + 3);
    grid->cell_count = (size_t)grid->cells[0] * (size_t)grid->cells[1] * (size_t)grid->cells[2];
    grid->cell_volume = grid->spacing[0] * grid->spacing[1] * grid->spacing[2];
}

/* Integral of the hat 1 - |s| over s from -infinity, in cells. */
static double hat_below(double s)
{
    if (s <= -1)
        return 0;
    if (s <= 0)
        return 0.5 * (1 + s) * (1 + s);
    return s < 1 ? 1 - 0.5 * (1 - s) * (1 - s) : 1;
}

double grid_hat_integral(const struct grid *grid, int axis, int layer, double low, double high)
{
    if (grid->flat[axis])
        return low < high ? grid->length[axis] : 0;
    low = fmax(low, 0);
    high = fmin(high, grid->length[axis]);
    if (!(low < high))
        return 0;
    return grid->spacing[axis] * (hat_below(high * grid->inverse[axis] - layer) - hat_below(low * grid->inverse[axis] - layer));
}

double grid_node_volume(const struct grid *grid, const int place[3], const double low[3], const double high[3])
{
    double volume = 1;
    for (int a = 0; a < 3; a++)
        volume *= grid_hat_integral(grid, a, place[a], low[a], high[a]);
    return volume;
}
