/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walls of triangles in a world: see mesh.c. Private to this folder. */
#ifndef SCREE_DEM_MESH_H
#define SCREE_DEM_MESH_H

#include "dem/image.h"
#include "dem/state.h"

struct surface {
    struct trimesh *mesh;
    double (*plane)[4]; // by triangle: unit normal, and its product with any point of the plane, m
    uint8_t *partner;   // by triangle
    double velocity[3], from_s, until_s;
    bool base, moves;
};

struct mesh_near {
    uint32_t grain, surface, triangle;
};
struct mesh_group { // triangles of one surface that are near one grain
    uint32_t grain, surface, from, count;
};

/* Of one part. Contacts in the order (grain, surface, depth), which is that of the walk. */
struct mesh_part {
    struct mesh_near *outer, *unit; // unit: scratch of the rebuild, what one unit is near
    struct mesh_group *group;
    uint32_t *triangle, *found;
    struct wall_pair *contact, *next;
    struct contact_loss *ended;
    size_t outer_count, unit_count, group_count, triangle_count, contact_count, next_count, ended_count;
    size_t outer_room, unit_room, group_room, triangle_room, found_room, contact_room, ended_room; // contact_room is of next too
};

struct mesh {
    struct surface *surface;
    size_t count;
    struct mesh_part *part;
    int part_count;
    double (*asked)[4]; // positions of rows when triangles were last listed
};

/* Copies the surfaces; dem->mesh stays NULL where there are none. */
enum scree_status mesh_create(struct dem *dem, const struct dem_surface *surfaces, size_t count, struct scree_error *err);
void mesh_free(struct mesh *mesh);

/* Refuses surfaces that stand inside grains at the start, by surface and triangle. */
enum scree_status mesh_check(const struct dem *dem, struct scree_error *err);

/* All contacts, in order, as a copy that the caller owns; and back, in any order. */
enum scree_status mesh_take(const struct dem *dem, struct wall_pair **out, size_t *count, struct scree_error *err);
enum scree_status mesh_give(struct dem *dem, const struct wall_pair *pairs, size_t count, struct scree_error *err);

/* mesh_image.c: into an image (arrays it then owns) and back, with the contacts. */
enum scree_status mesh_save(const struct dem *dem, struct dem_image *image, struct scree_error *err);
enum scree_status mesh_load(struct dem *dem, const struct dem_image *image, struct scree_error *err);

#endif
