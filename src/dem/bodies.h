/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rigid bodies of rows. Private to this folder.
 *
 * A row stays a sphere: lists, kernels of pairs and walls see nothing else. A
 * body owns the rows [first[b], first[b + 1]); their places, velocities and
 * spins follow from its own, and what contacts do to them is summed over the
 * members in order. */
#ifndef SCREE_DEM_BODIES_H
#define SCREE_DEM_BODIES_H

#include "dem/image.h"
#include "dem/state.h"

struct bodies {
    size_t count;
    /* By body. Like those of free grains, velocity and momentum are of the last half
     * step plus the kicks of contacts, without gravity's. */
    double (*position)[4];    // centre of mass, m; [3] mass, kg
    double (*velocity)[4];    // m/s; [3] step / mass, s/kg
    double (*momentum)[4];    // angular, about the centre of mass, in space, N m s
    double (*orientation)[4]; // w, x, y, z: own principal axes into space
    double (*inverse)[4];     // 1 / moments of inertia, 1/(kg m2); [3] volume, m3
    double (*force)[4];       // of the last step's contacts, N
    double (*torque)[4];      // about the centre of mass, N m
    uint32_t *first;          // count + 1 entries
    uint32_t *id, *shape;
    /* By row. */
    double (*offset)[4]; // of a member in its body's axes, m
    uint32_t *of;        // its body
    double (*load)[4];   // force on the member from this step's contacts, N, nothing between steps; [3] is 1
    double (*twist)[4];  // and torque about its centre, N m; [3] is 1
    struct view_body *view;
};

enum scree_status bodies_create(struct dem *dem, size_t count, struct scree_error *err);
void bodies_free(struct bodies *bodies);

/* Fills bodies and their rows, from row 0 on, from a setup. */
void bodies_fill(struct dem *dem, const struct dem_setup *setup);

/* Of a body's members: arms and places from its orientation and place. */
void bodies_place(struct dem *dem, size_t body);

/* bodies_view.c: into an image and back; whether an image's bodies own its moving rows one after the other. */
enum scree_status bodies_save(const struct dem *dem, struct dem_image *image, struct scree_error *err);
bool bodies_are_sound(const struct dem_image *image);
void bodies_load(struct dem *dem, const struct dem_image *image);

/* Fills view->body, and the rows' velocities and spins at the step's time. */
enum scree_status bodies_view(struct dem *dem, struct view *view, struct scree_error *err);
uint64_t bodies_hash(const struct dem *dem, uint64_t sum);

#endif
