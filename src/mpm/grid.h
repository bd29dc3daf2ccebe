/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The regular grid: cells of the box [0, length], nodes at their corners.
 *
 * Node arrays have a layer of ghosts all round, so that the 27 neighbours of any
 * node exist at fixed distances in memory; z runs fastest. A plane world is one
 * cell of unit depth in y with all material on its layer y = 0: the hat function
 * there is one and nothing depends on y. An endless world is flat along x in the
 * same way: material may flow along x, and every place downstream is the same. */
#ifndef SCREE_MPM_GRID_H
#define SCREE_MPM_GRID_H

#include <stdbool.h>
#include <stddef.h>

struct grid {
    int cells[3];
    double length[3], spacing[3], inverse[3]; // m, m, 1/m
    bool plane;                               // two dimensions, x and z
    bool flat[3];                             // nothing depends on this axis: y in a plane, x in an endless world
    size_t stride[3];                         // of nodes
    size_t node_count, cell_count;
    double cell_volume; // m3
};

/* Fills *grid; along flat axes cells and length are taken as 1. */
void grid_start(struct grid *grid, const double length[3], const int cells[3], bool plane, bool endless);

static inline size_t grid_node(const struct grid *g, int x, int y, int z)
{
    return (size_t)(x + 1) * g->stride[0] + (size_t)(y + 1) * g->stride[1] + (size_t)(z + 1);
}
static inline size_t grid_cell(const struct grid *g, int x, int y, int z)
{
    return ((size_t)x * (size_t)g->cells[1] + (size_t)y) * (size_t)g->cells[2] + (size_t)z;
}
static inline void grid_cell_place(const struct grid *g, size_t cell, int place[3])
{
    place[2] = (int)(cell % (size_t)g->cells[2]);
    size_t rest = cell / (size_t)g->cells[2];
    place[1] = (int)(rest % (size_t)g->cells[1]);
    place[0] = (int)(rest / (size_t)g->cells[1]);
}
static inline void grid_node_place(const struct grid *g, size_t node, int place[3])
{
    place[0] = (int)(node / g->stride[0]) - 1;
    place[1] = (int)(node % g->stride[0] / g->stride[1]) - 1;
    place[2] = (int)(node % g->stride[1]) - 1;
}
/* Layers of nodes that material can touch along an axis. */
static inline int grid_layers(const struct grid *g, int axis)
{
    return g->flat[axis] ? 1 : g->cells[axis] + 1;
}

/* The cell along one axis that holds a coordinate inside the box. */
static inline int grid_cell_along(const struct grid *g, int axis, double x)
{
    int cell = (int)(x * g->inverse[axis]);
    return cell < 0 ? 0 : cell >= g->cells[axis] ? g->cells[axis] - 1 : cell;
}

/* Integral over [low, high] of the hat function of layer `layer` along an axis, m. */
double grid_hat_integral(const struct grid *grid, int axis, int layer, double low, double high);

/* Integral over the box part [low, high] of a node's shape function, m3. */
double grid_node_volume(const struct grid *grid, const int place[3], const double low[3], const double high[3]);

#endif
