/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rough slopes of seed 000: a fixed base, grains poured over it at random, gravity
 * tilted. Scenarios differ in what bounds them across the slope. */
#ifndef SCREE_SCENARIO_SLOPE_H
#define SCREE_SCENARIO_SLOPE_H

#include "scenario/packing.h"
#include "scenario/scenario.h"

/* Planes at both sides; none: the slope is periodic across. */
enum { SLOPE_SIDES_MAX = 2 };
struct slope_sides {
    struct dem_wall wall[SLOPE_SIDES_MAX];
    size_t count;
    double measured_y[2]; // [from, to) of the force on the base, m; {0, 0}: everywhere
};

static inline const struct incline_params *slope_params(const struct job_spec *job)
{
    return (const struct incline_params *)(const void *)job->params;
}

/* What struct scenario asks for. */
void slope_gravity(const struct job_spec *job, double gravity[3]);
void slope_top(const struct job_spec *job, double *z, double *area_m2);

/* Extents of the base along x and y, m; the box, periodic where its length is not 0; how it is filled from z = 0. */
void slope_lengths(const struct job_spec *job, double length[2]);
void slope_box(const struct job_spec *job, const struct slope_sides *sides, double length[3]);
struct packing slope_packing(const struct job_spec *job, const struct slope_sides *sides);

/* rough_base.c: the fixed base between those sides, its top level at z = 0. *out is owned by the caller. */
enum scree_status slope_base(const struct job_spec *job, const struct slope_sides *sides, const char *isa, struct dem_grain **out,
                             size_t *count, struct scree_error *err);

/* The whole world, closed from below by a plane of the grains' matter at z = -d. */
enum scree_status slope_build(const struct job_spec *job, const struct slope_sides *sides, const struct scenario_means *means,
                              struct dem **out, struct scree_error *err);

#endif
