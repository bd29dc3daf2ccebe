/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Everything that a world of grains is, as plain arrays: for checkpoints and
 * forks. Pair lists are left out, since they cannot show; memory order is in,
 * since it is part of the state. */
#ifndef SCREE_DEM_IMAGE_H
#define SCREE_DEM_IMAGE_H

#include "dem/dem.h"
#include "dem/law.h"

struct dem_scalars {
    uint64_t moving, grains, contacts, wall_contacts, walls, bodies, surfaces, vertices, triangles, mesh_contacts, step, base_steps,
        ledger;
    double step_s, gravity[3], length[3], floor_z, base_y[2], base_sum[3], lost[4], wrapped_work, start_potential;
};

struct dem_surface_head {
    uint64_t vertices, triangles, base;
    double velocity[3], from_s, until_s;
};

enum { DEM_BODY_ROWS = 7 };

struct dem_image {
    struct dem_scalars scalars;
    double (*position)[4], (*velocity)[4], (*spin)[4]; // rows as they lie in memory
    double *mass;
    uint32_t *id;
    struct dem_wall *walls;
    /* Walls of triangles: one after the other in each array. */
    struct dem_surface_head *surface;
    double (*vertex)[3];
    uint32_t (*corner)[3];
    uint8_t *partner;
    struct wall_pair *mesh_pair;
    /* Bodies, if any: DEM_BODY_ROWS rows a body, of position, velocity, momentum, orientation,
     * inverse inertia, force, torque, one kind after the other; offsets by row. */
    double (*body)[4], (*offset)[4];
    uint32_t *body_first, *body_id, *body_shape; // first has one more entry
    /* Contacts in the order of the step, with what they remember and what they exert. */
    uint64_t *keys;
    double (*contact)[CONTACT_SLOTS];
    struct contact_out *out;
    uint64_t *wall_keys;
    double (*wall_contact)[CONTACT_SLOTS];
    struct contact_out *wall_out;
    double *wall_overlap;
};

/* Fills an image; rows point into the world, contact arrays are owned by the
 * image until dem_image_free. The world must not be advanced meanwhile. */
enum scree_status dem_save(const struct dem *dem, struct dem_image *image, struct scree_error *err);
void dem_image_free(struct dem_image *image);

/* A world that goes on from the image, to the bit; copies what it needs. `law` and
 * `matter` as in struct dem_setup: NULL law is hertz-mindlin-rolling. */
enum scree_status dem_load(const struct dem_image *image, const struct law *law, const void *matter, const char *isa, int threads,
                           struct dem **out, struct scree_error *err);

#endif
