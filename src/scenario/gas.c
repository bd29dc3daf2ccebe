/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `gas`: spheres at a given solid fraction and temperature, no gravity.
 *
 * They start on a cubic lattice, each somewhere within its own cell, which is
 * forgotten within a collision time; velocities are Maxwell's. The mean velocity is taken
 * out, weighted by mass, and the rest scaled, so that momentum is zero and the
 * temperature the one asked for, in any realisation. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/rng.h"
#include "scenario/scenario.h"

enum { STREAM_PLACES = 3, STREAM_VELOCITIES = 4 }; // of random numbers

static const struct gas_params *params_of(const struct job_spec *job)
{
    return (const struct gas_params *)(const void *)job->params;
}

static void gas_gravity(const struct job_spec *job, double gravity[3])
{
    (void)job;
    memset(gravity, 0, 3 * sizeof *gravity);
}

static void gas_base(const struct job_spec *job, double *z, double *area_m2)
{
    (void)job;
    *z = 0;
    *area_m2 = 0; // nothing flows
}

static void place(const struct job_spec *job, struct dem_grain *grains, size_t n)
{
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_PLACES);
    double cell = gas_edge(job) / (double)n, spread = job->material.radius_spread;
    for (size_t k = 0; k < n * n * n; k++) {
        struct dem_grain *grain = &grains[k];
        grain->radius = job->material.radius_m * rng_uniform(&rng, 1 - spread, 1 + spread);
        grain->density = job->material.density_kg_m3;
        const size_t at[3] = {k % n, k / n % n, k / n / n};
        double room = 0.5 * cell - grain->radius;
        for (int a = 0; a < 3; a++)
            grain->position[a] = ((double)at[a] + 0.5) * cell + rng_uniform(&rng, -room, room);
    }
}

/* One number of the normal distribution (Box and Muller 1958). */
static double normal(struct rng *rng)
{
    double u = rng_uniform(rng, 0, 1), v = rng_uniform(rng, 0, 1);
    return sqrt(-2 * log(1 - u)) * cos(2 * M_PI * v);
}

static void heat(const struct job_spec *job, struct dem_grain *grains, size_t count)
{
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_VELOCITIES);
    double momentum[3] = {0}, mass = 0, square = 0;
    for (size_t k = 0; k < count; k++) {
        double m = pow(grains[k].radius, 3);
        mass += m;
        for (int a = 0; a < 3; a++)
            momentum[a] += m * (grains[k].velocity[a] = normal(&rng));
    }
    for (size_t k = 0; k < count; k++)
        for (int a = 0; a < 3; a++) {
            grains[k].velocity[a] -= momentum[a] / mass;
            square += grains[k].velocity[a] * grains[k].velocity[a];
        }
    double scale = sqrt(params_of(job)->temperature_m2_s2 * 3 * (double)count / square);
    for (size_t k = 0; k < count; k++)
        for (int a = 0; a < 3; a++)
            grains[k].velocity[a] *= scale;
}

static enum scree_status gas_build(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                                   struct scree_error *err)
{
    const struct gas_params *p = params_of(job);
    size_t n = (size_t)p->n, count = n * n * n;
    double edge = gas_edge(job);
    struct dem_grain *grains = memory_rows(count, sizeof *grains);
    if (!grains)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu grains", count);
    place(job, grains, n);
    heat(job, grains, count);
    bool walled = p->box == GAS_WALLED;
    const struct dem_wall walls[2] = {{.normal = {0, 0, 1}, .base = true}, {.point = {0, 0, edge}, .normal = {0, 0, -1}}};
    struct dem_setup setup = {.step_s = job->time.step_s,
                              .length = {edge, edge, walled ? 0 : edge},
                              .grains = grains,
                              .grain_count = count,
                              .walls = walls,
                              .wall_count = walled ? 2 : 0,
                              .material = job->material,
                              .floor_z = -INFINITY,
                              .threads = means->threads,
                              .isa = means->isa,
                              .ledger = job->record.energy.on};
    enum scree_status status = dem_create(&setup, out, err);
    free(grains);
    return status;
}

const struct scenario scenario_gas = {.name = "gas", .build = gas_build, .gravity = gas_gravity, .base = gas_base};
