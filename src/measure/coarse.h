/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Coarse-graining along the base's normal (seed 000 S5, eqs 34-41): weighted sums
 * over grains or collisions at equally spaced heights. The weight is a Gaussian of
 * standard deviation d/2,
 *     w_z(z_j) = sqrt(2/pi) exp(-2 (z_j - z)^2 / d^2) / (A d erf(K sqrt 2)),  |z_j - z| < K d,
 * whose integral over z is 1/A. Eq. 34 as printed lacks the 1/d (and holds the
 * 1/Dt that belongs to the sums over time: callers divide). K is 3 for what moves
 * and infinite for collisions and connectivity. */
#ifndef SCREE_MEASURE_COARSE_H
#define SCREE_MEASURE_COARSE_H

#include <stdbool.h>
#include <stddef.h>

struct coarse_grid {
    double first, step; // lowest height and spacing, m
    double diameter;    // d, m
    double area;        // A, m2
    size_t count;       // heights
};

/* The heights of S5: 16 a grain of depth, d/4 apart, from 7/8 d below the base's top. */
struct coarse_grid coarse_grid_of(double base_z, double diameter, double area, size_t layers);

double coarse_height(const struct coarse_grid *grid, size_t k);

/* Adds w(z) * values[0..n) to sums[height * stride ..] at all heights: with K = 3 (`cut`), or with K infinite (to where
 * the weight is below 1e-300). 1/m3 times the values' unit. */
void coarse_add(const struct coarse_grid *grid, double z, bool cut, const double *values, size_t n, double *sums, size_t stride);

#endif
