/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Everything that a world of convex bodies is between two steps, as plain arrays:
 * for checkpoints and forks. Lists are in, with what each pair knows of its gap:
 * they were made when some body had moved far enough, which positions alone do
 * not tell. */
#ifndef SCREE_CONVEX_IMAGE_H
#define SCREE_CONVEX_IMAGE_H

#include "convex/convex.h"

enum { CONVEX_IMAGE_BODY = 24, CONVEX_IMAGE_WHO = 4, CONVEX_IMAGE_CONTACT = 23 }; // numbers a body, a pair, a contact

struct convex_scalars {
    uint64_t bodies, near, wall; // wall: bodies by walls
    uint64_t pairs, contacts;
    uint64_t step, queries, searches, rebuilds, listed_at, base_steps;
    double ease, gravity[3], base[3], based[3], gravity_work;
};

/* Owned by whoever made it; what is near walls follows what is near other bodies. */
struct convex_image {
    struct convex_scalars scalars;
    double (*body)[CONVEX_IMAGE_BODY];
    uint32_t (*group)[2]; // two bodies, or a body and a wall
    double *group_due;
    uint32_t (*who)[CONVEX_IMAGE_WHO]; // of all pairs of all groups: how many contacts, the cache's count and corners, faces
    double *pair_due;
    double (*contact)[CONVEX_IMAGE_CONTACT]; // in the order of pairs
};

/* Copies the world. */
enum scree_status convex_save(const struct convex *convex, struct convex_image *image, struct scree_error *err);
void convex_image_free(struct convex_image *image);

/* A world that goes on from the image, to the bit; copies what it needs. `setup` is the one that the imaged world was
 * made from (bodies' places and motions, and gravity, are not looked at). SCREE_CORRUPT when the two do not belong together. */
enum scree_status convex_load(const struct convex_image *image, const struct convex_setup *setup, struct convex **out,
                              struct scree_error *err);

#endif
