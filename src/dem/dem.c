/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world of grains: made, looked at, freed. What happens in between is in step.c. */
#include "dem/dem.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "dem/bodies.h"
#include "dem/mesh.h"
#include "dem/state.h"

/* Measured: see README.md. */
#define SKIN_SHARE  0.3    // of a grain's diameter
#define STRAY_SHARE 0.0005 // of a grain's diameter, to begin with
enum { HORIZON_STEPS = 100 };

const struct kernels *kernels_for(enum cpu_isa isa)
{
    static const struct kernels *const all[CPU_ISA_COUNT] = {&kernels_v2, &kernels_v3, &kernels_v4};
    return all[isa];
}

static void set_gravity(struct dem *dem, const double gravity[3])
{
    struct vec3 g = vec3_load(gravity);
    memcpy(dem->gravity, gravity, sizeof dem->gravity);
    dem->weight = sqrt(vec3_dot(g, g));
}

static void fill_shifts(struct dem *dem)
{
    for (int code = 0; code < IMAGE_CODES; code++) {
        int rest = code;
        for (int a = 0; a < 3; a++) {
            dem->shift[code][a] = (rest % IMAGE_BASE - IMAGE_REACH) * dem->length[a];
            rest /= IMAGE_BASE;
        }
    }
}

static void fill_row(struct dem *dem, size_t row, uint32_t id, const struct dem_grain *grain)
{
    double r = grain->radius, mass = grain->density * (4.0 / 3.0) * M_PI * r * r * r;
    for (int a = 0; a < 3; a++) {
        dem->position[row][a] = grain->position[a];
        /* v(-1/2) without gravity's kick: see state.h. Contacts at t = 0 exert no force yet. */
        dem->velocity[row][a] = grain->fixed ? 0 : grain->velocity[a] - 0.5 * dem->gravity[a] * dem->step_s;
        dem->spin[row][a] = grain->fixed ? 0 : grain->spin[a];
    }
    dem->position[row][3] = r;
    dem->velocity[row][3] = grain->fixed ? 0 : dem->step_s / mass;
    dem->spin[row][3] = grain->fixed ? 0 : dem->step_s / (0.4 * mass * r * r);
    dem->id[row] = id;
    dem->mass[row] = mass;
}

/* Zeroed rows for so many grains. */
static enum scree_status make_rows(struct dem *dem, size_t moving, size_t grains, struct scree_error *err)
{
    dem->moving = moving;
    dem->grains = grains;
    dem->position = memory_rows(grains, sizeof *dem->position);
    dem->velocity = memory_rows(grains, sizeof *dem->velocity);
    dem->spin = memory_rows(grains, sizeof *dem->spin);
    dem->arm = memory_rows(grains, sizeof *dem->arm);
    dem->position0 = memory_rows(moving, sizeof *dem->position0);
    dem->velocity0 = memory_rows(moving, sizeof *dem->velocity0);
    dem->id = memory_rows(grains, sizeof *dem->id);
    dem->mass = memory_rows(grains, sizeof *dem->mass);
    if (dem->position && dem->velocity && dem->spin && dem->arm && dem->position0 && dem->velocity0 && dem->id && dem->mass)
        return SCREE_OK;
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu grains (%.3g MB)", grains, dem_bytes((double)grains, 0) / 1e6);
}

static void fill_rows(struct dem *dem, const struct dem_setup *setup)
{
    size_t moving = 0, fixed = dem->moving;
    for (size_t k = 0; k < setup->grain_count; k++)
        fill_row(dem, setup->grains[k].fixed ? fixed++ : moving++, (uint32_t)k, &setup->grains[k]);
}

static enum scree_status make_parts(struct dem *dem, int threads, struct scree_error *err)
{
    enum scree_status status = team_create(threads, &dem->team, err);
    if (status)
        return status;
    dem->parts = memory_rows((size_t)threads, sizeof *dem->parts);
    if (!dem->parts)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %d parts", threads);
    dem->part_count = threads;
    return cells_create(&dem->cells, err);
}

void dem_cut(struct dem *dem)
{
    size_t parts = (size_t)dem->part_count, from = 0;
    for (size_t k = 0; k < parts; k++) {
        size_t to = dem->moving * (k + 1) / parts;
        to = to > 0 ? dem->motion->next(dem, to - 1) : 0;
        dem->parts[k].from = from;
        dem->parts[k].to = from = to;
    }
}

/* Refuses grains that overlap by more than rounding. */
static enum scree_status check_overlaps(const struct dem *dem, struct scree_error *err)
{
    for (int k = 0; k < dem->part_count; k++) {
        const struct near_list *near = &dem->parts[k].near;
        for (size_t p = 0; p < near->count; p++) {
            uint32_t i = near->first[p], j = near->second[p] & IMAGE_ROW;
            struct vec3 x = vec3_sub(vec3_load(dem->position[j]), vec3_load(dem->position[i]));
            x = vec3_add(x, vec3_load(dem->shift[near->second[p] >> IMAGE_SHIFT]));
            double reach = dem->position[i][3] + dem->position[j][3], overlap = reach - sqrt(vec3_dot(x, x));
            if (overlap > 1e-9 * reach)
                return scree_fail(err, SCREE_INVALID, "params", "grains %u and %u overlap by %.3g m at the start", dem->id[i],
                                  dem->id[j], overlap);
        }
    }
    return SCREE_OK;
}

static void first_lists(void *context, int member)
{
    near_refresh(context, member);
}

enum scree_status dem_first_lists(struct dem *dem, struct scree_error *err)
{
    team_run(dem->team, first_lists, dem);
    for (int k = 0; k < dem->part_count; k++)
        if (dem->parts[k].status) {
            if (err)
                *err = dem->parts[k].error;
            return dem->parts[k].status;
        }
    return SCREE_OK;
}

enum scree_status dem_start(const struct dem_setup *setup, size_t moving, size_t grains, struct dem **out, struct scree_error *err)
{
    enum scree_status status;
    struct dem *dem = memory_rows(1, sizeof *dem);
    if (!dem)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    dem->law = setup->law ? setup->law : &law_hertz_rolling;
    dem->motion = setup->body_count ? &motion_bodies : &motion_free;
    dem->step_s = setup->step_s;
    dem->floor_z = setup->floor_z;
    dem->ledger = setup->ledger;
    set_gravity(dem, setup->gravity);
    memcpy(dem->length, setup->length, sizeof dem->length);
    bool everywhere = setup->base_y[0] == setup->base_y[1];
    dem->base_y[0] = everywhere ? -INFINITY : setup->base_y[0];
    dem->base_y[1] = everywhere ? INFINITY : setup->base_y[1];
    fill_shifts(dem);
    for (int k = 0; k < LAW_PARTNERS; k++)
        dem->law->coefs(setup->matter ? setup->matter : &setup->material, k, setup->step_s, &dem->coefs[k]);
    dem->walls = memory_rows(setup->wall_count, sizeof *dem->walls);
    if (!dem->walls)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu walls", setup->wall_count);
    else if (!(status = cpu_choose(setup->isa, &dem->isa, err)) && !(status = make_rows(dem, moving, grains, err)) &&
             !(status = make_parts(dem, setup->threads, err)) &&
             !(status = mesh_create(dem, setup->surfaces, setup->surface_count, err)) && setup->body_count)
        status = bodies_create(dem, setup->body_count, err);
    if (status) {
        dem_free(dem);
        return status;
    }
    if (setup->wall_count)
        memcpy(dem->walls, setup->walls, setup->wall_count * sizeof *dem->walls);
    dem->wall_count = setup->wall_count;
    dem->kernels = kernels_for(dem->isa);
    *out = dem;
    return SCREE_OK;
}

void dem_plan(struct dem *dem)
{
    dem->largest_radius = 0;
    for (size_t i = 0; i < dem->grains; i++)
        dem->largest_radius = fmax(dem->largest_radius, dem->position[i][3]);
    double diameter = 2 * dem->largest_radius;
    dem->plan = (struct near_plan){.skin = SKIN_SHARE * diameter,
                                   .least = SKIN_SHARE * diameter,
                                   .since = dem->step,
                                   .stray = STRAY_SHARE * diameter,
                                   .target = HORIZON_STEPS,
                                   .stale = true};
}

enum scree_status dem_create(const struct dem_setup *setup, struct dem **out, struct scree_error *err)
{
    size_t moving = 0;
    struct dem *dem = NULL;
    for (size_t k = 0; k < setup->body_count; k++)
        moving += setup->shapes[setup->bodies[k].shape].spheres;
    size_t grains = setup->grain_count + moving;
    if (grains >= IMAGE_ROW)
        return scree_fail(err, SCREE_INVALID, "params", "%zu grains are more than the %d that a world holds", grains,
                          IMAGE_ROW - 1);
    for (size_t k = 0; k < setup->grain_count; k++) {
        assert(setup->grains[k].fixed || !setup->body_count);
        moving += !setup->grains[k].fixed;
    }
    enum scree_status status = dem_start(setup, moving, grains, &dem, err);
    if (status)
        return status;
    fill_rows(dem, setup);
    if (dem->bodies)
        bodies_fill(dem, setup);
    dem_cut(dem);
    dem_plan(dem);
    if (!(status = order_rows(dem, err))) {
        dem->start_potential = dem->motion->potential(dem);
        status = dem_first_lists(dem, err);
    }
    if (!status && !setup->overlaps && !(status = check_overlaps(dem, err)))
        status = mesh_check(dem, err);
    if (status)
        dem_free(dem);
    else
        *out = dem;
    return status;
}

static void free_part(struct part *part)
{
    free(part->outer_first);
    free(part->outer_second);
    free(part->kept);
    free(part->near.first);
    free(part->near.second);
    free(part->near.reach2);
    free(part->near.contact);
    free(part->near.touching);
    free(part->hot.first);
    free(part->hot.second);
    free(part->hot.near);
    free(part->hot.reach2);
    free(part->hot.touching);
    free(part->walls);
    free(part->formed.items);
    free(part->formed_walls.items);
    free(part->held.items);
    free(part->held_walls.items);
    free(part->active);
    free(part->out);
    free(part->loss);
    free(part->exports);
    free(part->on_base);
    free(part->ended);
}

void dem_free(struct dem *dem)
{
    if (!dem)
        return;
    team_free(dem->team);
    for (int k = 0; k < dem->part_count; k++)
        free_part(&dem->parts[k]);
    free(dem->parts);
    cells_free(dem->cells);
    free(dem->position);
    free(dem->velocity);
    free(dem->spin);
    free(dem->arm);
    free(dem->position0);
    free(dem->velocity0);
    free(dem->id);
    free(dem->mass);
    free(dem->formed.items);
    free(dem->walls);
    bodies_free(dem->bodies);
    mesh_free(dem->mesh);
    free(dem->view_position);
    free(dem->view_velocity);
    free(dem->view_spin);
    free(dem->view_contacts);
    free(dem);
}

uint64_t dem_step(const struct dem *dem)
{
    return dem->step;
}

double dem_time(const struct dem *dem)
{
    return (double)dem->step * dem->step_s;
}

size_t dem_moving(const struct dem *dem)
{
    return dem->moving;
}

size_t dem_fixed(const struct dem *dem)
{
    return dem->grains - dem->moving;
}

size_t dem_units(const struct dem *dem)
{
    return dem->bodies ? dem->bodies->count : dem->moving;
}

const char *dem_isa(const struct dem *dem)
{
    return cpu_isa_name(dem->isa);
}

void dem_take_base_force(struct dem *dem, double mean[3])
{
    for (int a = 0; a < 3; a++) {
        mean[a] = dem->base_steps ? dem->base_sum[a] / (double)dem->base_steps : 0;
        dem->base_sum[a] = 0;
    }
    dem->base_steps = 0;
}

void dem_set_gravity(struct dem *dem, const double gravity[3])
{
    /* The work of the old field so far is kept; the potential restarts with the new one. */
    double before = dem->motion->potential(dem) - dem->start_potential + dem->wrapped_work, change[3];
    /* Rows hold v(n-1/2); v(n) = v(n-1/2) + g dt/2 must not jump with the field. */
    for (int a = 0; a < 3; a++)
        change[a] = 0.5 * dem->step_s * (dem->gravity[a] - gravity[a]);
    dem->motion->nudge(dem, change);
    double weight = sqrt(dem->gravity[0] * dem->gravity[0] + dem->gravity[1] * dem->gravity[1] + dem->gravity[2] * dem->gravity[2]);
    set_gravity(dem, gravity);
    dem->weight = weight + 2 * dem->weight; // lists that are in use have to bear both fields and the change
    dem->start_potential = dem->motion->potential(dem) + dem->wrapped_work - before;
}

void dem_set_material(struct dem *dem, const void *matter)
{
    for (int k = 0; k < LAW_PARTNERS; k++)
        dem->law->coefs(matter, k, dem->step_s, &dem->coefs[k]);
}

struct dem_counts dem_counts(const struct dem *dem)
{
    struct dem_counts counts = {.refreshes = dem->plan.refreshes, .rebuilds = dem->plan.rebuilds};
    for (int k = 0; k < dem->part_count; k++) {
        counts.contacts += dem->parts[k].active_count;
        counts.near += dem->parts[k].near.count;
        counts.hot += dem->parts[k].hot.count;
        counts.outer += dem->parts[k].outer_count;
    }
    return counts;
}

void dem_profile(struct dem *dem, struct dem_profile *profile)
{
    dem->profile = profile;
}

double dem_bytes(double moving, double fixed)
{
    return (moving + fixed) * SPEC_BYTES_PER_GRAIN;
}
