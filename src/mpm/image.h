/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Everything that a world of continuum is between two steps, as plain arrays: for
 * checkpoints and forks. Rows are left out, since the next step makes them anew.
 * The cells' sums are in: they hold what the points deposited, in an order that
 * positions alone do not tell. */
#ifndef SCREE_MPM_IMAGE_H
#define SCREE_MPM_IMAGE_H

#include "mpm/mpm.h"

enum { MPM_IMAGE_MOMENTS = 28, MPM_IMAGE_CORNERS = 24 }; // numbers a cell

struct mpm_image_contact {
    double push[3]; // N
    uint32_t node, owner;
};

struct mpm_scalars {
    uint64_t points, cells, nodes, contacts, step, base_steps;
    uint64_t rows, sweeps, sweeps_total, unconverged, stalls, moved; // of the report
    double gravity[3], base_sum[3], base_last[3], residual_mean, residual_largest, overfull, worst_courant;
};

struct mpm_image {
    struct mpm_scalars scalars;
    double (*position)[4]; // x, y, z, volume, in the order of cells
    uint32_t *id;
    uint32_t *cell_start; // cells + 1
    double (*moment)[MPM_IMAGE_MOMENTS], (*momentum)[MPM_IMAGE_CORNERS];
    double (*stress)[8]; // by node
    double *friction;
    struct mpm_image_contact *contact; // owned by the image
};

/* Fills an image; all arrays but the contacts point into the world, which must not be advanced meanwhile. */
enum scree_status mpm_save(const struct mpm *mpm, struct mpm_image *image, struct scree_error *err);
void mpm_image_free(struct mpm_image *image); // frees the contacts alone

/* A world that goes on from the image, to the bit; copies what it needs. `setup` is the one that the imaged world
 * was made from (regions, first velocities and gravity are not looked at). SCREE_CORRUPT when the two do not belong together. */
enum scree_status mpm_load(const struct mpm_image *image, const struct mpm_setup *setup, struct mpm **out, struct scree_error *err);

#endif
