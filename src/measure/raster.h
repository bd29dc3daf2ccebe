/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What cameras far away see of bodies made of convex parts, in square pixels: of
 * each pixel the body that is seen, whose centre is the nearest to the camera. */
#ifndef SCREE_MEASURE_RASTER_H
#define SCREE_MEASURE_RASTER_H

#include "base/status.h"
#include "view.h"

/* A part's outline along two axes of space: the hull of its corners' projections, and their balls around it. */
enum { RASTER_CORNERS_MAX = 256 };
struct raster_outline {
    double point[RASTER_CORNERS_MAX][2]; // anticlockwise
    size_t count;
    double radius, low[2], high[2]; // bounds with the radius, m
};
void raster_outline(const struct view *view, uint32_t part, int axis0, int axis1, struct raster_outline *out);

/* Indices of the pixels, of `count` from 0 on, whose centres lie in [low, high). */
void raster_pixels(double low, double high, double pixel, size_t count, size_t *from, size_t *to);

enum raster_camera {
    RASTER_ABOVE, // sees x and y
    RASTER_ASIDE, // sees x and z, and looks along y
    RASTER_CAMERAS
};
#define RASTER_NOTHING UINT32_MAX

struct raster {
    size_t columns, lines; // along x, along the other axis
    double pixel;          // m
    uint32_t *body;        // column by column: the row in view.body, or RASTER_NOTHING; owned
};

/* Of the rectangle from the origin to `length` along x, to `across` along the other axis; INFINITY: as far as bodies reach. Pixels
 * are made larger where there would be more than RASTER_PIXELS_MAX of them. Release with raster_free, whatever came of it. */
enum { RASTER_PIXELS_MAX = 1 << 22 };
enum scree_status raster_draw(const struct view *view, enum raster_camera camera, double length, double across, double pixel,
                              struct raster *out, struct scree_error *err);
void raster_free(struct raster *raster);

#endif
