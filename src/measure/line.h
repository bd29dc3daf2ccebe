/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A straight line z = a + b x through weighted points, by least squares. Starts zeroed. */
#ifndef SCREE_MEASURE_LINE_H
#define SCREE_MEASURE_LINE_H

struct line {
    double w, x, z, xx, xz; // weighted sums over the points
};

static inline void line_add(struct line *line, double weight, double x, double z)
{
    line->w += weight;
    line->x += weight * x;
    line->z += weight * z;
    line->xx += weight * x * x;
    line->xz += weight * x * z;
}

/* b; 0 where all points have one x, to rounding. */
static inline double line_slope(const struct line *line)
{
    double spread = line->w * line->xx - line->x * line->x;
    return spread > 1e-12 * line->w * line->xx ? (line->w * line->xz - line->x * line->z) / spread : 0;
}

#endif
