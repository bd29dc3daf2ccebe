/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The grid of cells.c as it stood when the outer lists were made, for whoever looks at grains by cell. */
#ifndef SCREE_DEM_CELLS_H
#define SCREE_DEM_CELLS_H

#include <stddef.h>
#include <stdint.h>

struct cells {
    int count[3];
    double width;              // no cell is thinner, m
    double low[3], inverse[3]; // cell = (x - low) * inverse
    uint32_t *start;           // count + 1 entries
    size_t start_room;
    double (*point)[4]; // position inside the box and radius, sorted by cell
    uint32_t *row;
    int8_t (*image)[4]; // boxes to subtract from the row's position to get the point
    uint32_t *cell;     // by row
    size_t point_room, row_room, image_room, cell_room;
    struct ways *ways, *wide; // of spread.c alone
    size_t ways_room, wide_room;
};

#endif
