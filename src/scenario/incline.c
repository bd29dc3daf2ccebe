/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `incline`: steady flow down a rough base, periodic in x and y.
 *
 * Seed 000 S5 and S8 name the geometry; how base and filling are made is not
 * printed. The recipe here is that of protocols 1.3 and 1.4, ours where marked.
 *
 * Base. A horizontal mini-simulation: grains of the flow's own radii fall onto a
 * plane, without friction, strongly damped, with softened stiffness (both ours:
 * only the settled geometry is kept). Of the settled packing a slice one grain
 * diameter thick is kept, one radius below the highest centre, so that the loose
 * skin is left out. It is moved so that its top centre level is z = 0, fixed,
 * and closed from below by a plane of the same material at z = -d.
 *
 * Filling. Random insertion without overlap, at rest, above the base, with
 * gravity tilted from the start. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scenario/packing.h"
#include "scenario/scenario.h"

enum { STREAM_BASE = 1, STREAM_FLOW = 2 }; // of random numbers

/* Softening of the mini-simulation: E / 1e5, overlaps still below a percent of
 * d; contacts last 1e5^(2/5) = 100 times longer, and so may the step. */
#define BASE_SOFTENING  1e5
#define BASE_STIFFNESS  1e4 // E of the mini-simulation over rho g d, at least
#define BASE_STEP_RATIO 100.0
/* Layers dropped, and settling time in sqrt(d / g): the fall takes about 3, and
 * damped collisions come to rest within the rest. */
#define BASE_LAYERS 4
#define BASE_SETTLE 15.0

static const struct incline_params *params_of(const struct job_spec *job)
{
    return (const struct incline_params *)(const void *)job->params;
}

static void incline_gravity(const struct job_spec *job, double gravity[3])
{
    const struct incline_params *p = params_of(job);
    double slope = p->slope_deg * (M_PI / 180.0);
    gravity[0] = p->gravity_m_s2 * sin(slope);
    gravity[1] = 0;
    gravity[2] = -p->gravity_m_s2 * cos(slope);
}

static void incline_lengths(const struct job_spec *job, double length[2])
{
    const struct incline_params *p = params_of(job);
    double d = 2 * job->material.radius_m;
    length[0] = (double)p->nx * d;
    length[1] = (double)p->ny * d;
}

static void incline_base(const struct job_spec *job, double *z, double *area_m2)
{
    double length[2];
    incline_lengths(job, length);
    *z = 0;
    *area_m2 = length[0] * length[1];
}

static void incline_profile(const struct job_spec *job, size_t *layers, double *area_m2, double region[2])
{
    (void)area_m2;
    (void)region;
    *layers = (size_t)params_of(job)->nz;
}

static struct packing packing_of(const struct job_spec *job, double floor_z)
{
    const struct incline_params *p = params_of(job);
    double r = job->material.radius_m;
    struct packing packing = {.floor_z = floor_z,
                              .radius = r,
                              .spread = job->material.radius_spread,
                              .density = job->material.density_kg_m3,
                              .first_ceiling = 2 * r,
                              /* 1e-4 r a failed try on 200 d^2 in the recipe: the same per area here. */
                              .rise = 1e-4 * r * 200.0 / (double)(p->nx * p->ny)};
    incline_lengths(job, packing.length);
    return packing;
}

struct base_softening {
    double modulus, steps; // what E is divided and the step multiplied by
};

/* Grains that are soft already are softened less, or their weight would press the base flat. */
static struct base_softening softening_of(const struct job_spec *job)
{
    double weight = job->material.density_kg_m3 * params_of(job)->gravity_m_s2 * 2 * job->material.radius_m; // of a layer, Pa
    double most = fmax(1, job->material.young_Pa / (BASE_STIFFNESS * weight));
    if (most >= BASE_SOFTENING)
        return (struct base_softening){BASE_SOFTENING, BASE_STEP_RATIO};
    return (struct base_softening){most, pow(most, 0.4)};
}

/* Drops `count` grains on a plane at z = 0 and leaves the settled ones in `grains`. */
static enum scree_status settle(const struct job_spec *job, const char *isa, struct dem_grain *grains, size_t count,
                                struct scree_error *err)
{
    const struct incline_params *p = params_of(job);
    double d = 2 * job->material.radius_m, length[2];
    incline_lengths(job, length);
    const struct dem_wall floor = {.normal = {0, 0, 1}};
    const struct base_softening soft = softening_of(job);
    struct dem_setup setup = {.step_s = job->time.step_s * soft.steps,
                              .gravity = {0, 0, -p->gravity_m_s2},
                              .length = {length[0], length[1], 0},
                              .grains = grains,
                              .grain_count = count,
                              .walls = &floor,
                              .wall_count = 1,
                              .material = job->material,
                              .floor_z = -d,
                              .threads = 1,
                              .isa = isa};
    setup.material.young_Pa /= soft.modulus;
    setup.material.mu_t = setup.material.mu_r = setup.material.kappa = 0;
    /* A restitution of about a third at 0.14 m/s: b = beta / tau of 1.0 in
     * x'' = -sqrt(x)(x + b x'), with tau about a third of the contact time. */
    setup.material.beta_s = material_contact_time(&setup.material, sqrt(p->gravity_m_s2 * d)) / 3.218;
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

/* The fixed base. *out is owned by the caller. */
static enum scree_status make_base(const struct job_spec *job, const char *isa, struct dem_grain **out, size_t *count,
                                   struct scree_error *err)
{
    const struct incline_params *p = params_of(job);
    size_t dropped = (size_t)(p->nx * p->ny) * BASE_LAYERS;
    struct rng rng = rng_start((uint64_t)p->base_seed, STREAM_BASE);
    struct packing packing = packing_of(job, 0);
    struct dem_grain *grains = memory_rows(dropped, sizeof *grains);
    enum scree_status status = grains ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the base");
    if (status || (status = packing_insert(&packing, &rng, dropped, grains, err)) ||
        (status = settle(job, isa, grains, dropped, err))) {
        free(grains);
        return status;
    }
    *count = slice(grains, dropped, job->material.radius_m);
    *out = grains;
    return SCREE_OK;
}

static enum scree_status incline_build(const struct job_spec *job, const char *isa, int threads, struct dem **out,
                                       struct scree_error *err)
{
    const struct incline_params *p = params_of(job);
    double d = 2 * job->material.radius_m, length[2];
    struct dem_grain *base = NULL, *grains = NULL;
    size_t fixed = 0, flowing = (size_t)(p->nx * p->ny * p->nz);
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_FLOW);
    incline_lengths(job, length);
    enum scree_status status = make_base(job, isa, &base, &fixed, err);
    if (status)
        goto out;
    grains = memory_rows(flowing + fixed, sizeof *grains);
    if (!grains) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu grains", flowing + fixed);
        goto out;
    }
    memcpy(grains + flowing, base, fixed * sizeof *base);
    struct packing packing = packing_of(job, 0);
    packing.obstacles = base;
    packing.obstacle_count = fixed;
    if ((status = packing_insert(&packing, &rng, flowing, grains, err)))
        goto out;
    const struct dem_wall floor = {.point = {0, 0, -d}, .normal = {0, 0, 1}, .base = true};
    struct dem_setup setup = {.step_s = job->time.step_s,
                              .length = {length[0], length[1], 0},
                              .grains = grains,
                              .grain_count = flowing + fixed,
                              .walls = &floor,
                              .wall_count = 1,
                              .material = job->material,
                              .floor_z = -d,
                              .threads = threads,
                              .isa = isa,
                              .ledger = job->record.energy.on};
    incline_gravity(job, setup.gravity);
    status = dem_create(&setup, out, err);
out:
    free(base);
    free(grains);
    return status;
}

const struct scenario scenario_incline = {
    .name = "incline", .build = incline_build, .gravity = incline_gravity, .base = incline_base, .profile = incline_profile};
