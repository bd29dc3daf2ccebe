/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See slope.h. Filling (protocols 1.4): random insertion without overlap, at rest,
 * above the base, with gravity tilted from the start. */
#include "scenario/slope.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { STREAM_FLOW = 2 }; // of random numbers

void slope_gravity(const struct job_spec *job, double gravity[3])
{
    const struct incline_params *p = slope_params(job);
    double slope = p->slope_deg * (M_PI / 180.0);
    gravity[0] = p->gravity_m_s2 * sin(slope);
    gravity[1] = 0;
    gravity[2] = -p->gravity_m_s2 * cos(slope);
}

void slope_lengths(const struct job_spec *job, double length[2])
{
    const struct incline_params *p = slope_params(job);
    double d = 2 * job->material.radius_m;
    length[0] = (double)p->nx * d;
    length[1] = (double)p->ny * d;
}

void slope_top(const struct job_spec *job, double *z, double *area_m2)
{
    double length[2];
    slope_lengths(job, length);
    *z = 0;
    *area_m2 = length[0] * length[1];
}

void slope_box(const struct job_spec *job, const struct slope_sides *sides, double length[3])
{
    slope_lengths(job, length);
    if (sides->count > 0)
        length[1] = 0;
    length[2] = 0;
}

struct packing slope_packing(const struct job_spec *job, const struct slope_sides *sides)
{
    const struct incline_params *p = slope_params(job);
    double r = job->material.radius_m;
    struct packing packing = {.between = sides->count > 0,
                              .radius = r,
                              .spread = job->material.radius_spread,
                              .density = job->material.density_kg_m3,
                              .first_ceiling = 2 * r,
                              /* 1e-4 r a failed try on 200 d^2 in the recipe: the same per area here. */
                              .rise = 1e-4 * r * 200.0 / (double)(p->nx * p->ny)};
    slope_lengths(job, packing.length);
    return packing;
}

enum scree_status slope_build(const struct job_spec *job, const struct slope_sides *sides, const struct scenario_means *means,
                              struct dem **out, struct scree_error *err)
{
    const struct incline_params *p = slope_params(job);
    double d = 2 * job->material.radius_m;
    struct dem_grain *base = NULL, *grains = NULL;
    size_t fixed = 0, flowing = (size_t)(p->nx * p->ny * p->nz);
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_FLOW);
    enum scree_status status = slope_base(job, sides, means->isa, &base, &fixed, err);
    if (status)
        goto out;
    grains = memory_rows(flowing + fixed, sizeof *grains);
    if (!grains) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu grains", flowing + fixed);
        goto out;
    }
    memcpy(grains + flowing, base, fixed * sizeof *base);
    struct packing packing = slope_packing(job, sides);
    packing.obstacles = base;
    packing.obstacle_count = fixed;
    if ((status = packing_insert(&packing, &rng, flowing, grains, err)))
        goto out;
    struct dem_wall walls[1 + SLOPE_SIDES_MAX] = {{.point = {0, 0, -d}, .normal = {0, 0, 1}, .base = true}};
    memcpy(walls + 1, sides->wall, sides->count * sizeof *walls);
    struct dem_setup setup = {.step_s = job->time.step_s,
                              .grains = grains,
                              .grain_count = flowing + fixed,
                              .walls = walls,
                              .wall_count = 1 + sides->count,
                              .base_y = {sides->measured_y[0], sides->measured_y[1]},
                              .material = job->material,
                              .floor_z = -d,
                              .threads = means->threads,
                              .isa = means->isa,
                              .ledger = job->record.energy.on};
    slope_box(job, sides, setup.length);
    slope_gravity(job, setup.gravity);
    status = dem_create(&setup, out, err);
out:
    free(base);
    free(grains);
    return status;
}
