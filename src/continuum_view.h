/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world of continuum shows once a sample, read-only: its points and the
 * fields of its grid. Everything is valid until the world is advanced. */
#ifndef SCREE_CONTINUUM_VIEW_H
#define SCREE_CONTINUUM_VIEW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct continuum_view {
    double time_s, step_s;
    uint64_t step;
    double gravity[3], length[3], spacing[3], density;
    int cells[3];
    bool plane, endless; // nothing depends on y; on x
    size_t points;
    const uint32_t *id;
    const double (*position)[4]; // x, y, z, m; [3] volume, m3
    const double (*velocity)[4]; // m/s
    /* Nodes by place: field[node(x, y, z)] with z fastest, then y, then x, and grid layers (cells + 1) along each axis. */
    size_t nodes;
    const double *fraction;           // phi / phi_c: material over what the node can hold
    const double (*node_velocity)[4]; // m/s; [3] material volume, m3
    const double (*stress)[8];        // lambda = -sigma {xx, yy, zz, yz, zx, xy}, Pa; [6] inertial number, [7] friction coefficient
    double base_force[3];             // on the floor in the last step, N
    double kinetic, potential;        // J; potential -m g.x
    double volume;                    // of all material, m3
    /* How it was solved: rows and mean and largest squared residual of the last step; sweeps and steps whose sweeps ran
     * out, since the start. */
    uint64_t rows, sweeps, unconverged;
    double residual_mean, residual_largest;
};

static inline int continuum_layers(const struct continuum_view *view, int axis)
{
    return (axis == 1 && view->plane) || (axis == 0 && view->endless) ? 1 : view->cells[axis] + 1;
}
/* Index of a node's fields by its place. */
static inline size_t continuum_node(const struct continuum_view *view, int x, int y, int z)
{
    return ((size_t)x * (size_t)continuum_layers(view, 1) + (size_t)y) * (size_t)continuum_layers(view, 2) + (size_t)z;
}

#endif
