/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Everything that a world of convex bodies is between two steps, as plain arrays:
 * for checkpoints and forks. Lists of pairs are in, with what each pair knows of
 * its gap: they were made when some body had moved far enough, which positions
 * alone do not tell. */
#ifndef SCREE_CONVEX_IMAGE_H
#define SCREE_CONVEX_IMAGE_H

#include "convex/convex.h"

enum { CONVEX_IMAGE_BODY = 21, CONVEX_IMAGE_WHO = 6, CONVEX_IMAGE_PAIR = 22 }; // numbers a body, a pair

struct convex_scalars {
    uint64_t bodies, near, wall; // wall: pairs with walls
    uint64_t step, queries, rebuilds, base_steps;
    double gravity[3], base[3], based[3], gravity_work;
};

/* Owned by whoever made it; pairs with walls follow those between bodies. */
struct convex_image {
    struct convex_scalars scalars;
    double (*body)[CONVEX_IMAGE_BODY];
    uint32_t *order; // bodies along x
    uint32_t (*who)[CONVEX_IMAGE_WHO];
    double (*pair)[CONVEX_IMAGE_PAIR];
};

/* Copies the world. */
enum scree_status convex_save(const struct convex *convex, struct convex_image *image, struct scree_error *err);
void convex_image_free(struct convex_image *image);

/* A world that goes on from the image, to the bit; copies what it needs. `setup` is the one that the imaged world was
 * made from (bodies' places and motions, and gravity, are not looked at). SCREE_CORRUPT when the two do not belong together. */
enum scree_status convex_load(const struct convex_image *image, const struct convex_setup *setup, struct convex **out,
                              struct scree_error *err);

#endif
