/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See slope.h. Seed 000 does not print how the base is made; the recipe is that of
 * protocols 1.3, ours where marked.
 *
 * A horizontal mini-simulation: grains of the flow's own radii fall onto a plane
 * between the flow's own sides, without friction, strongly damped, with softened
 * stiffness (both ours: only the settled geometry is kept). Of the settled packing a
 * slice one grain diameter thick is kept, one radius below the highest centre, so
 * that the loose skin is left out. It is moved so that its top centre level is z = 0,
 * and fixed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scenario/slope.h"

enum { STREAM_BASE = 1 }; // of random numbers

/* Softening of the mini-simulation: E / 1e5, overlaps still below a percent of
 * d; contacts last 1e5^(2/5) = 100 times longer, and so may the step. */
#define BASE_SOFTENING  1e5
#define BASE_STIFFNESS  1e4 // E of the mini-simulation over rho g d, at least
#define BASE_STEP_RATIO 100.0
/* Layers dropped, and settling time in sqrt(d / g): the fall takes about 6, and damped collisions come to rest
 * within the rest. Protocols 1.3 pour 25 radii deep, some 14 layers; from 8 on the slice holds 1.2 grains a d^2
 * whatever the seed. Of 4 it holds 1.0 to 1.6: they still lie in the layers that the plane below gives them. */
#define BASE_LAYERS 8
#define BASE_SETTLE 18.0

struct base_softening {
    double modulus, steps; // what E is divided and the step multiplied by
};

/* Grains that are soft already are softened less, or their weight would press the base flat. */
static struct base_softening softening_of(const struct job_spec *job)
{
    double weight = job->material.density_kg_m3 * slope_params(job)->gravity_m_s2 * 2 * job->material.radius_m; // of a layer, Pa
    double most = fmax(1, job->material.young_Pa / (BASE_STIFFNESS * weight));
    if (most >= BASE_SOFTENING)
        return (struct base_softening){BASE_SOFTENING, BASE_STEP_RATIO};
    return (struct base_softening){most, pow(most, 0.4)};
}

/* The matter of the mini-simulation. Side walls, if any, are as hard as the grains. */
static void make_soft(const struct job_spec *job, const struct base_softening *soft, struct material_spec *m)
{
    double d = 2 * job->material.radius_m;
    m->young_Pa /= soft->modulus;
    m->mu_t = m->mu_r = m->kappa = 0;
    /* A restitution of about a third at 0.14 m/s: b = beta / tau of 1.0 in
     * x'' = -sqrt(x)(x + b x'), with tau about a third of the contact time. */
    m->beta_s = material_contact_time(m, sqrt(slope_params(job)->gravity_m_s2 * d)) / 3.218;
    m->wall = (struct material_wall){.young_Pa = m->young_Pa, .poisson = m->poisson, .beta_s = m->beta_s};
}

/* Drops `count` grains on a plane at z = 0 and leaves the settled ones in `grains`. */
static enum scree_status settle(const struct job_spec *job, const struct slope_sides *sides, const char *isa,
                                struct dem_grain *grains, size_t count, struct scree_error *err)
{
    const struct incline_params *p = slope_params(job);
    double d = 2 * job->material.radius_m;
    struct dem_wall walls[1 + SLOPE_SIDES_MAX] = {{.normal = {0, 0, 1}}};
    memcpy(walls + 1, sides->wall, sides->count * sizeof *walls);
    const struct base_softening soft = softening_of(job);
    struct dem_setup setup = {.step_s = job->time.step_s * soft.steps,
                              .gravity = {0, 0, -p->gravity_m_s2},
                              .grains = grains,
                              .grain_count = count,
                              .walls = walls,
                              .wall_count = 1 + sides->count,
                              .material = job->material,
                              .floor_z = -d,
                              .threads = 1,
                              .isa = isa};
    slope_box(job, sides, setup.length);
    make_soft(job, &soft, &setup.material);
    struct dem *dem = NULL;
    struct view view;
    enum scree_status status = dem_create(&setup, &dem, err);
    double steps = BASE_SETTLE * sqrt(d / p->gravity_m_s2) / setup.step_s;
    if (status)
        goto out;
    struct scree_error inner = {0};
    if ((status = dem_advance(dem, (uint64_t)steps, &inner))) {
        scree_fail(err, status, NULL, "while the base was made (step %.3g s): %s", setup.step_s, inner.message);
        goto out;
    }
    if ((status = dem_view(dem, &view, err)))
        goto out;
    for (size_t k = 0; k < count; k++) {
        struct dem_grain *grain = &grains[view.id[k]];
        memcpy(grain->position, view.position[k], sizeof grain->position);
    }
out:
    dem_free(dem);
    return status;
}

/* Keeps the slice of the settled grains that becomes the base; returns how many, moved to the front. */
static size_t slice(struct dem_grain *grains, size_t count, double radius)
{
    double highest = -INFINITY;
    for (size_t k = 0; k < count; k++)
        highest = fmax(highest, grains[k].position[2]);
    double top = highest - radius, bottom = top - 2 * radius;
    size_t kept = 0;
    for (size_t k = 0; k < count; k++) {
        if (grains[k].position[2] > top || grains[k].position[2] < bottom)
            continue;
        grains[kept] = grains[k];
        grains[kept].position[2] -= top;
        grains[kept++].fixed = true;
    }
    return kept;
}

enum scree_status slope_base(const struct job_spec *job, const struct slope_sides *sides, const char *isa, struct dem_grain **out,
                             size_t *count, struct scree_error *err)
{
    const struct incline_params *p = slope_params(job);
    size_t dropped = (size_t)(p->nx * p->ny) * BASE_LAYERS;
    struct rng rng = rng_start((uint64_t)p->base_seed, STREAM_BASE);
    struct packing packing = slope_packing(job, sides);
    struct dem_grain *grains = memory_rows(dropped, sizeof *grains);
    enum scree_status status = grains ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the base");
    if (status || (status = packing_insert(&packing, &rng, dropped, grains, err)) ||
        (status = settle(job, sides, isa, grains, dropped, err))) {
        free(grains);
        return status;
    }
    *count = slice(grains, dropped, job->material.radius_m);
    *out = grains;
    return SCREE_OK;
}
