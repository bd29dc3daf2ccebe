/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world of continuum: checked, made, freed, asked. What happens in between is in step.c. */
#include "mpm/mpm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "mpm/drucker_prager.h"
#include "mpm/state.h"

/* ---- refusals ---- */

#define NODES_MAX 2e8

static enum scree_status refuse(struct scree_error *err, const char *path, const char *what)
{
    return scree_fail(err, SCREE_INVALID, path, "%s: %s", path, what);
}

static enum scree_status check_numbers(const struct mpm_setup *s, struct scree_error *err)
{
    double nodes = 1;
    for (int a = 0; a < 3; a++) {
        if ((a == 1 && s->plane) || (a == 0 && s->endless))
            continue;
        if (!(s->length[a] > 0 && s->length[a] < 1e6))
            return refuse(err, "length", "a side of the box must lie within 0..1e6 m");
        if (s->cells[a] < 1)
            return refuse(err, "cells", "at least one cell along each axis");
        nodes *= s->cells[a] + 3.0;
    }
    if (nodes > NODES_MAX)
        return scree_fail(err, SCREE_INVALID, "cells", "cells: %.3g nodes are more than the %.3g that a world holds", nodes,
                          NODES_MAX);
    if (!(s->step_s > 0))
        return refuse(err, "step_s", "must be positive");
    if (!(s->density > 0))
        return refuse(err, "density", "must be positive");
    if (s->points_per_cell < 1 || s->points_per_cell > 32)
        return refuse(err, "points_per_cell", "1..32 along an axis");
    if (!(s->jitter >= 0 && s->jitter <= 1))
        return refuse(err, "jitter", "0..1");
    if (!s->law || !(s->coefs.mu >= 0))
        return refuse(err, "law", "a law with a friction coefficient of at least 0");
    if (!(s->solver.tolerance >= 0) || s->solver.sweeps < 1 || s->solver.check < 1)
        return refuse(err, "solver", "a tolerance of at least 0, at least one sweep, a check every sweep at most");
    if (s->body_count > MPM_BODIES_MAX)
        return refuse(err, "bodies", "at most 8 bodies");
    return SCREE_OK;
}

static enum scree_status check_shapes(const struct mpm_setup *s, const struct grid *g, struct scree_error *err)
{
    for (size_t r = 0; r < s->region_count; r++)
        for (int a = 0; a < 3; a++) {
            const struct mpm_region *region = &s->regions[r];
            double slack = 1e-9 * g->length[a];
            if (g->flat[a])
                continue;
            if (!(region->low[a] >= -slack && region->low[a] < region->high[a] && region->high[a] <= g->length[a] + slack))
                return refuse(err, "regions", "material must lie inside the box");
        }
    for (size_t k = 0; k < s->body_count; k++)
        for (int a = 0; a < 3; a++) {
            const struct mpm_body *body = &s->bodies[k];
            if (g->flat[a])
                continue;
            if (!(body->low[a] < body->high[a]))
                return refuse(err, "bodies", "a body's low corner must lie below its high one");
            bool crosses = body->low[a] > 0 && body->high[a] < g->length[a];
            if (crosses && body->high[a] - body->low[a] < 1.999 * g->spacing[a])
                return refuse(err, "bodies", "a body must be at least two cells thick");
        }
    return SCREE_OK;
}

/* ---- making ---- */

static enum scree_status no_memory(struct scree_error *err, const char *what, size_t count)
{
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu %s", count, what);
}

static enum scree_status make_cells(struct mpm *mpm, struct scree_error *err)
{
    size_t cells = mpm->grid.cell_count;
    mpm->cell_start = memory_rows(cells + 1, sizeof *mpm->cell_start);
    mpm->spare_start = memory_rows(cells + 1, sizeof *mpm->spare_start);
    mpm->stayed = memory_rows(cells, sizeof *mpm->stayed);
    mpm->cursor = memory_rows(cells, sizeof *mpm->cursor);
    mpm->moment = memory_rows(cells, sizeof *mpm->moment);
    mpm->momentum = memory_rows(cells, sizeof *mpm->momentum);
    return mpm->cell_start && mpm->spare_start && mpm->stayed && mpm->cursor && mpm->moment && mpm->momentum
               ? SCREE_OK
               : no_memory(err, "cells", cells);
}

static enum scree_status make_nodes(struct mpm *mpm, struct scree_error *err)
{
    size_t nodes = mpm->grid.node_count;
    mpm->volume = memory_rows(nodes, sizeof *mpm->volume);
    mpm->scale = memory_rows(nodes, sizeof *mpm->scale);
    mpm->w = memory_rows(nodes, sizeof *mpm->w);
    mpm->velocity = memory_rows(nodes, sizeof *mpm->velocity);
    mpm->stress = memory_rows(nodes, sizeof *mpm->stress);
    mpm->friction = memory_rows(nodes, sizeof *mpm->friction);
    mpm->w_last = memory_rows(nodes, sizeof *mpm->w_last);
    return mpm->volume && mpm->scale && mpm->w && mpm->velocity && mpm->stress && mpm->friction && mpm->w_last
               ? SCREE_OK
               : no_memory(err, "nodes", nodes);
}

/* Room for a row at every node: rows come and go with the material, and a warm step asks for nothing. */
static enum scree_status make_rows(struct mpm *mpm, struct scree_error *err)
{
    const struct grid *g = &mpm->grid;
    struct field *f = &mpm->field;
    size_t most = 1, contacts = rigid_contacts_most(g, mpm->body_count);
    for (int a = 0; a < 3; a++)
        most *= (size_t)grid_layers(g, a);
    f->runs = 0;
    f->plane = g->plane;
    int reach[2] = {g->flat[0] ? 0 : 1, g->flat[1] ? 0 : 1};
    for (int x = -reach[0]; x <= reach[0]; x++)
        for (int y = -reach[1]; y <= reach[1]; y++)
            f->run[f->runs++] = x * (ptrdiff_t)g->stride[0] + y * (ptrdiff_t)g->stride[1] - 1;
    f->coupling_stride = (size_t)f->runs * 9;
    mpm->slab_count = (size_t)(grid_layers(g, 0) + SLAB_LAYERS - 1) / SLAB_LAYERS;
    mpm->rows = memory_rows(most, sizeof *mpm->rows);
    mpm->coupling = memory_rows(most, f->coupling_stride * sizeof *mpm->coupling);
    mpm->floor_coupling = memory_rows(most, sizeof *mpm->floor_coupling);
    mpm->strain = memory_rows(most, sizeof *mpm->strain);
    mpm->slab_row = memory_rows(mpm->slab_count + 1, sizeof *mpm->slab_row);
    mpm->slab_owner = memory_rows(mpm->slab_count, sizeof *mpm->slab_owner);
    mpm->slab_sums = memory_rows(mpm->slab_count, sizeof *mpm->slab_sums);
    mpm->contacts = memory_rows(contacts, sizeof *mpm->contacts);
    mpm->last_contacts = memory_rows(contacts, sizeof *mpm->last_contacts);
    if (!mpm->rows || !mpm->coupling || !mpm->floor_coupling || !mpm->strain || !mpm->slab_row || !mpm->slab_owner ||
        !mpm->slab_sums || !mpm->contacts || !mpm->last_contacts)
        return no_memory(err, "rows", most);
    f->rows = mpm->rows;
    f->coupling = mpm->coupling;
    f->w = mpm->w;
    f->scale = mpm->scale;
    f->contacts = mpm->contacts;
    return SCREE_OK;
}

static enum scree_status make_team(struct mpm *mpm, int threads, struct scree_error *err)
{
    enum scree_status status = team_create(threads, &mpm->team, err);
    if (status)
        return status;
    mpm->parts = memory_rows((size_t)threads, sizeof *mpm->parts);
    mpm->cell_cut = memory_rows((size_t)threads + 1, sizeof *mpm->cell_cut);
    if (!mpm->parts || !mpm->cell_cut)
        return no_memory(err, "threads", (size_t)threads);
    mpm->part_count = threads;
    return SCREE_OK;
}

/* The world of a set-up, without points. */
enum scree_status mpm_start(const struct mpm_setup *setup, struct mpm **out, struct scree_error *err)
{
    static const struct kernels *const kernels[CPU_ISA_COUNT] = {&mpm_kernels_v2, &mpm_kernels_v3, &mpm_kernels_v4};
    enum scree_status status = check_numbers(setup, err);
    if (status)
        return status;
    struct mpm *mpm = memory_rows(1, sizeof *mpm);
    if (!mpm)
        return no_memory(err, "worlds", 1);
    grid_start(&mpm->grid, setup->length, setup->cells, setup->plane, setup->endless);
    mpm->step_s = setup->step_s;
    memcpy(mpm->gravity, setup->gravity, sizeof mpm->gravity);
    mpm->tilt = setup->tilt;
    rigid_tilt(mpm);
    mpm->density = setup->density;
    memcpy(mpm->walls, setup->walls, sizeof mpm->walls);
    mpm->body_count = setup->body_count;
    for (size_t k = 0; k < setup->body_count; k++)
        mpm->bodies[k] = setup->bodies[k];
    mpm->law = setup->law;
    mpm->coefs = setup->coefs;
    mpm->grain_diameter = setup->grain_diameter;
    mpm->inertial_density = setup->inertial_density;
    mpm->recover_s = setup->recover_s;
    mpm->solver = setup->solver;
    status = check_shapes(setup, &mpm->grid, err);
    if (!status)
        status = cpu_choose(setup->isa, &mpm->isa, err);
    if (!status && !(status = make_cells(mpm, err)) && !(status = make_nodes(mpm, err)) && !(status = make_rows(mpm, err)))
        status = make_team(mpm, setup->threads, err);
    if (status) {
        mpm_free(mpm);
        return status;
    }
    mpm->kernels = kernels[mpm->isa];
    *out = mpm;
    return SCREE_OK;
}

enum scree_status mpm_create(const struct mpm_setup *setup, struct mpm **out, struct scree_error *err)
{
    struct mpm *mpm;
    enum scree_status status = mpm_start(setup, &mpm, err);
    if (status)
        return status;
    if ((status = points_fill(mpm, setup, err)))
        mpm_free(mpm);
    else
        *out = mpm;
    return status;
}

static void free_nodes(struct mpm *mpm)
{
    free(mpm->volume);
    free(mpm->scale);
    free(mpm->w);
    free(mpm->velocity);
    free(mpm->stress);
    free(mpm->friction);
    free(mpm->w_last);
    free(mpm->rows);
    free(mpm->coupling);
    free(mpm->floor_coupling);
    free(mpm->strain);
    free(mpm->slab_row);
    free(mpm->slab_owner);
    free(mpm->slab_sums);
    free(mpm->contacts);
    free(mpm->last_contacts);
}

void mpm_free(struct mpm *mpm)
{
    if (!mpm)
        return;
    team_free(mpm->team);
    for (int k = 0; k < mpm->part_count; k++)
        free(mpm->parts[k].movers);
    free(mpm->parts);
    free(mpm->cell_cut);
    free(mpm->position);
    free(mpm->spare_position);
    free(mpm->id);
    free(mpm->spare_id);
    free(mpm->cell_start);
    free(mpm->spare_start);
    free(mpm->stayed);
    free(mpm->cursor);
    free(mpm->moment);
    free(mpm->momentum);
    free_nodes(mpm);
    free(mpm->view_velocity);
    free(mpm->view_fraction);
    free(mpm->view_node_velocity);
    free(mpm->view_stress);
    free(mpm);
}

/* ---- asking ---- */

uint64_t mpm_step(const struct mpm *mpm)
{
    return mpm->step;
}

double mpm_time(const struct mpm *mpm)
{
    return (double)mpm->step * mpm->step_s;
}

size_t mpm_points(const struct mpm *mpm)
{
    return mpm->points;
}

const char *mpm_isa(const struct mpm *mpm)
{
    return cpu_isa_name(mpm->isa);
}

void mpm_set_gravity(struct mpm *mpm, const double gravity[3])
{
    memcpy(mpm->gravity, gravity, sizeof mpm->gravity);
}

void mpm_take_base_force(struct mpm *mpm, double mean[3])
{
    for (int a = 0; a < 3; a++) {
        mean[a] = mpm->base_steps ? mpm->base_sum[a] / (double)mpm->base_steps : 0;
        mpm->base_sum[a] = 0;
    }
    mpm->base_steps = 0;
}

struct mpm_report mpm_report(const struct mpm *mpm)
{
    return mpm->report;
}

void mpm_watch(struct mpm *mpm, void (*see)(void *context, uint64_t sweeps, struct mpm_residual residual), void *context)
{
    mpm->see = see;
    mpm->see_context = context;
}

void mpm_profile(struct mpm *mpm, struct mpm_profile *profile)
{
    mpm->profile = profile;
}

double mpm_bytes(double points, double nodes)
{
    /* Points twice with their ids; a node's fields, a row with its coupling, a cell's sums. */
    return points * 72 + nodes * (sizeof(struct row) + 81 * sizeof(double) + 600) +
           nodes * (MOMENT_ROOM + CORNER_ROOM) * sizeof(double);
}

/* FNV-1a over 64-bit words, then bytes. */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t bytes)
{
    const unsigned char *at = data;
    for (; bytes >= 8; bytes -= 8, at += 8) {
        uint64_t word;
        memcpy(&word, at, 8);
        hash = (hash ^ word) * 0x100000001b3u;
        hash ^= hash >> 29;
    }
    for (size_t k = 0; k < bytes; k++)
        hash = (hash ^ at[k]) * 0x100000001b3u;
    return hash;
}

uint64_t mpm_hash(const struct mpm *mpm)
{
    uint64_t hash = hash_bytes(0xcbf29ce484222325u, &mpm->step, sizeof mpm->step);
    hash = hash_bytes(hash, mpm->position, mpm->points * sizeof *mpm->position);
    hash = hash_bytes(hash, mpm->id, mpm->points * sizeof *mpm->id);
    hash = hash_bytes(hash, mpm->moment, mpm->grid.cell_count * sizeof *mpm->moment);
    hash = hash_bytes(hash, mpm->momentum, mpm->grid.cell_count * sizeof *mpm->momentum);
    hash = hash_bytes(hash, mpm->stress, mpm->grid.node_count * sizeof *mpm->stress);
    return hash_bytes(hash, mpm->base_last, sizeof mpm->base_last);
}
