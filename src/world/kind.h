/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world's body can be: grains (kind_dem.c), a continuum, rigid bodies, or nothing but a calculation. The world drives
 * it through this table alone, so that neither engine knows of the other and
 * world.c of none. One kind = one file = one line in kinds.c. */
#ifndef SCREE_WORLD_KIND_H
#define SCREE_WORLD_KIND_H

#include "measure/measure.h"
#include "scree.h"
#include "world/image.h"

/* How a body is made, beside its job. */
struct world_making {
    const char *isa; // NULL: the best there is
    int threads;
    const char *meshes; // folder of the meshes that jobs name, NULL: none
    unsigned needs;     // bits of enum measure_needs over all measurements
};

struct world_counts {
    double time_s;
    size_t moving, fixed; // grains, or points
    const char *isa;
};

struct world_kind {
    enum scenario_kind kind;
    /* Whether there is such a set-up; what the job's params say of it as they now stand. */
    bool (*knows)(const struct job_spec *job);
    void (*gravity)(const struct job_spec *job, double gravity[3]);
    /* Refuses what job_check cannot tell and building would, at the price of a few milliseconds. NULL: nothing. */
    enum scree_status (*check)(const struct job_spec *job, const struct world_making *making, struct scree_error *err);
    /* Where it is measured; site->fall.release is owned by the caller. */
    enum scree_status (*site)(const struct job_spec *job, struct measure_site *site, struct scree_error *err);

    enum scree_status (*build)(const struct job_spec *job, const struct world_making *making, void **body, struct scree_error *err);
    void (*free)(void *body); // NULL is none
    enum scree_status (*advance)(void *body, uint64_t steps, struct scree_error *err);
    struct world_counts (*counts)(const void *body);
    uint64_t (*hash)(const void *body);

    /* Sets now->grains or now->points; the view belongs to the body until it is advanced. */
    enum scree_status (*view)(void *body, struct measure_now *now, struct scree_error *err);
    /* Mean force on the base over the steps since the last call. */
    void (*take_base_force)(void *body, double mean[3]);
    /* Contacts that formed since the last call, in the order of steps; valid until the next. NULL: knows none. */
    size_t (*take_formations)(void *body, const struct view_formation **formations);

    /* Numbers for the summary beside those of measurements; returns how many, at most `room`. NULL: none. */
    size_t (*numbers)(const void *body, struct scree_number *out, size_t room);

    /* Takes over what differs between the jobs; true when forces change. */
    bool (*steer)(void *body, const struct job_spec *from, const struct job_spec *to);

    /* Adds the body's arrays to an image (world_image_add...), and makes it anew from one. */
    enum scree_status (*save)(const void *body, struct world_image *image, struct scree_error *err);
    enum scree_status (*load)(const struct world_image *image, const struct world_making *making, void **body,
                              struct scree_error *err);
};

extern const struct world_kind world_kind_dem, world_kind_mpm, world_kind_convex, world_kind_calculation;

/* What the options, or NULL, leave to the job is the job's. */
struct world_making world_making_of(const struct job_spec *job, const struct scree_options *options);

/* Whose scenario the job's is, or NULL. */
const struct world_kind *world_kind_find(const struct job_spec *job);

#endif
