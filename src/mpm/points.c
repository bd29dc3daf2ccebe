/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Material points: made, carried, kept in the order of their cells.
 *
 * A point's velocity and affine part are those of the grid where the point was
 * (APIC, seed 002 A.2). One pass reads them there, moves the point and deposits
 * it, while the eight corner velocities of its cell are at hand; so points are
 * four numbers, and a step reads and writes each of them once. What a cell
 * gathers are volume times products of shape functions, two per axis: 27 sums of
 * positive terms, from which assemble.c takes mass and every coefficient of the
 * divergence operator without looking at points again; and the momenta of its corners.
 *
 * Order, hence every bit: a cell's sums take the points that stay in their order,
 * then arrivals in the order of the cells they come from. No thread shows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/rng.h"
#include "mpm/state.h"

void deposit_point(const struct grid *grid, const struct mover *mover, double moment[MOMENT_ROOM], double momentum[CORNER_ROOM])
{
    double x[3], pair[3][3], n[3][2], volume = mover->position[3];
    for (int a = 0; a < 3; a++) {
        double s = mover->position[a] * grid->inverse[a];
        x[a] = s - grid_cell_along(grid, a, mover->position[a]);
        n[a][0] = 1 - x[a];
        n[a][1] = x[a];
        pair[a][0] = n[a][0] * n[a][0];
        pair[a][1] = n[a][0] * n[a][1];
        pair[a][2] = n[a][1] * n[a][1];
    }
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            for (int c = 0; c < 3; c++)
                moment[9 * a + 3 * b + c] += volume * pair[0][a] * pair[1][b] * pair[2][c];
    for (int k = 0; k < CORNERS; k++) {
        int corner[3] = {k >> 2, k >> 1 & 1, k & 1};
        double weight = volume * n[0][corner[0]] * n[1][corner[1]] * n[2][corner[2]];
        for (int a = 0; a < 3; a++) {
            double u = mover->velocity[a];
            for (int b = 0; b < 3; b++)
                u += mover->rate[b][a] * (corner[b] - x[b]);
            momentum[3 * k + a] += weight * u;
        }
    }
}

/* ---- the first points ---- */

struct lattice {
    int count[3];
    double low[3], pitch[3], volume;
};

static struct lattice lattice_of(const struct grid *grid, const struct mpm_region *region, int per_cell)
{
    struct lattice l = {.volume = 1};
    for (int a = 0; a < 3; a++) {
        bool flat = grid->flat[a];
        double size = flat ? grid->length[a] : region->high[a] - region->low[a];
        l.count[a] = flat ? 1 : (int)fmax(1, round(size * grid->inverse[a] * per_cell));
        l.low[a] = flat ? 0 : region->low[a];
        l.pitch[a] = size / l.count[a];
        l.volume *= l.pitch[a];
    }
    return l;
}

static size_t lattice_points(const struct lattice *l)
{
    return (size_t)l->count[0] * (size_t)l->count[1] * (size_t)l->count[2];
}

/* The n-th point of a lattice, in its own share of space. */
static void lattice_point(const struct grid *grid, const struct lattice *l, size_t n, double jitter, struct rng *rng,
                          double position[4])
{
    size_t at[3] = {n / ((size_t)l->count[1] * (size_t)l->count[2]), n / (size_t)l->count[2] % (size_t)l->count[1],
                    n % (size_t)l->count[2]};
    for (int a = 0; a < 3; a++) {
        double off = 0.5 + jitter * rng_uniform(rng, -0.5, 0.5);
        position[a] = grid->flat[a] ? 0 : l->low[a] + ((double)at[a] + off) * l->pitch[a];
    }
    position[3] = l->volume;
}

static size_t cell_of(const struct grid *g, const double position[4])
{
    return grid_cell(g, grid_cell_along(g, 0, position[0]), grid_cell_along(g, 1, position[1]), grid_cell_along(g, 2, position[2]));
}

/* Rows for the points, and room among the movers for a quarter of them: a step moves a point by a fraction of a cell. */
enum scree_status points_room(struct mpm *mpm, size_t count, struct scree_error *err)
{
    mpm->points = count;
    mpm->position = memory_rows(count, sizeof *mpm->position);
    mpm->spare_position = memory_rows(count, sizeof *mpm->spare_position);
    mpm->id = memory_rows(count, sizeof *mpm->id);
    mpm->spare_id = memory_rows(count, sizeof *mpm->spare_id);
    bool made = mpm->position && mpm->spare_position && mpm->id && mpm->spare_id;
    for (int k = 0; k < mpm->part_count && made; k++) {
        struct member_part *part = &mpm->parts[k];
        part->mover_room = count / (4 * (size_t)mpm->part_count) + 4096;
        part->movers = memory_rows(part->mover_room, sizeof *part->movers);
        made = part->movers != NULL;
    }
    return made ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu material points", count);
}

static void generate(struct mpm *mpm, const struct mpm_setup *setup, double (*position)[4])
{
    size_t p = 0;
    for (size_t r = 0; r < setup->region_count; r++) {
        struct lattice l = lattice_of(&mpm->grid, &setup->regions[r], setup->points_per_cell);
        struct rng rng = rng_start(setup->seed, r);
        for (size_t n = 0; n < lattice_points(&l); n++)
            lattice_point(&mpm->grid, &l, n, setup->jitter, &rng, position[p++]);
    }
}

static void deposit_first(struct mpm *mpm, const struct mpm_setup *setup)
{
    const struct grid *g = &mpm->grid;
    for (size_t cell = 0; cell < g->cell_count; cell++)
        for (size_t p = mpm->cell_start[cell]; p < mpm->cell_start[cell + 1]; p++) {
            struct mover m = {.cell = (uint32_t)cell};
            memcpy(m.position, mpm->position[p], sizeof m.position);
            for (int a = 0; a < 3; a++) {
                m.velocity[a] = setup->velocity[a];
                for (int b = 0; b < 3; b++) {
                    m.velocity[a] += setup->gradient[a][b] * m.position[b];
                    m.rate[b][a] = setup->gradient[a][b] * g->spacing[b];
                }
            }
            deposit_point(g, &m, mpm->moment[cell], mpm->momentum[cell]);
        }
}

enum scree_status points_fill(struct mpm *mpm, const struct mpm_setup *setup, struct scree_error *err)
{
    const struct grid *g = &mpm->grid;
    size_t count = 0;
    for (size_t r = 0; r < setup->region_count; r++) {
        struct lattice l = lattice_of(g, &setup->regions[r], setup->points_per_cell);
        count += lattice_points(&l);
    }
    if (count == 0 || count >= UINT32_MAX)
        return scree_fail(err, SCREE_INVALID, "regions", "%zu material points: a world holds 1 to %u", count, UINT32_MAX - 1);
    enum scree_status status = points_room(mpm, count, err);
    if (status)
        return status;
    generate(mpm, setup, mpm->spare_position);
    mpm->total_volume = 0;
    for (size_t p = 0; p < count; p++) {
        mpm->cell_start[cell_of(g, mpm->spare_position[p]) + 1]++;
        mpm->total_volume += mpm->spare_position[p][3];
    }
    for (size_t cell = 0; cell < g->cell_count; cell++) {
        mpm->cell_start[cell + 1] += mpm->cell_start[cell];
        mpm->cursor[cell] = mpm->cell_start[cell];
    }
    for (size_t p = 0; p < count; p++) {
        uint32_t to = mpm->cursor[cell_of(g, mpm->spare_position[p])]++;
        memcpy(mpm->position[to], mpm->spare_position[p], sizeof *mpm->position);
        mpm->id[to] = (uint32_t)p;
    }
    deposit_first(mpm, setup);
    points_share(mpm);
    return SCREE_OK;
}

/* ---- the pass ---- */

void points_share(struct mpm *mpm)
{
    size_t cell = 0;
    mpm->cell_cut[0] = 0;
    for (int k = 1; k < mpm->part_count; k++) {
        size_t first = member_share(mpm->points, k, mpm->part_count);
        while (cell < mpm->grid.cell_count && mpm->cell_start[cell] < first)
            cell++;
        mpm->cell_cut[k] = cell;
    }
    mpm->cell_cut[mpm->part_count] = mpm->grid.cell_count;
}

static void carry(struct mpm *mpm, int member)
{
    struct member_part *part = &mpm->parts[member];
    struct move move = {.grid = &mpm->grid,
                        .step_s = mpm->step_s,
                        .position = mpm->position,
                        .id = mpm->id,
                        .cell_start = mpm->cell_start,
                        .stayed = mpm->stayed,
                        .velocity = (const double(*)[4])mpm->velocity,
                        .moment = mpm->moment,
                        .momentum = mpm->momentum,
                        .movers = part->movers,
                        .mover_room = part->mover_room};
    for (size_t cell = mpm->cell_cut[member], end = mpm->cell_cut[member + 1]; cell < end;) {
        cell = mpm->kernels->move(&move, cell, end);
        if (cell == end)
            break;
        size_t need = move.mover_count + (mpm->cell_start[cell + 1] - mpm->cell_start[cell]);
        part->status = memory_grow((void **)&part->movers, &part->mover_room, need, sizeof *part->movers, &part->error);
        if (part->status)
            return;
        move.movers = part->movers;
        move.mover_room = part->mover_room;
    }
    part->mover_count = move.mover_count;
    part->courant = move.courant;
}

/* Where each cell's points will lie: those that stayed, then arrivals. */
static void plan(struct mpm *mpm)
{
    size_t cells = mpm->grid.cell_count;
    memcpy(mpm->cursor, mpm->stayed, cells * sizeof *mpm->cursor);
    mpm->report.moved = 0;
    for (int k = 0; k < mpm->part_count; k++) {
        for (size_t m = 0; m < mpm->parts[k].mover_count; m++)
            mpm->cursor[mpm->parts[k].movers[m].cell]++;
        mpm->report.moved += mpm->parts[k].mover_count;
    }
    mpm->spare_start[0] = 0;
    for (size_t cell = 0; cell < cells; cell++)
        mpm->spare_start[cell + 1] = mpm->spare_start[cell] + mpm->cursor[cell];
}

static void settle(struct mpm *mpm, int member)
{
    size_t from = mpm->cell_cut[member], to = mpm->cell_cut[member + 1];
    for (size_t cell = from; cell < to; cell++) {
        size_t old = mpm->cell_start[cell], new = mpm->spare_start[cell], count = mpm->stayed[cell];
        memcpy(mpm->spare_position[new], mpm->position[old], count * sizeof *mpm->position);
        memcpy(&mpm->spare_id[new], &mpm->id[old], count * sizeof *mpm->id);
        mpm->cursor[cell] = (uint32_t)(new + count);
    }
    for (int k = 0; k < mpm->part_count; k++)
        for (size_t m = 0; m < mpm->parts[k].mover_count; m++) {
            const struct mover *mover = &mpm->parts[k].movers[m];
            if (mover->cell < from || mover->cell >= to)
                continue;
            uint32_t at = mpm->cursor[mover->cell]++;
            memcpy(mpm->spare_position[at], mover->position, sizeof mover->position);
            mpm->spare_id[at] = mover->id;
            deposit_point(&mpm->grid, mover, mpm->moment[mover->cell], mpm->momentum[mover->cell]);
        }
}

#define SWAP(a, b)                                                                                                                 \
    do {                                                                                                                           \
        __typeof__(a) swap_ = (a);                                                                                                 \
        (a) = (b);                                                                                                                 \
        (b) = swap_;                                                                                                               \
    } while (0)

void points_move(struct mpm *mpm, int member)
{
    carry(mpm, member);
    mpm_clock(mpm, member, MPM_MOVE);
    team_barrier(mpm->team);
    if (member == 0)
        plan(mpm);
    team_barrier(mpm->team);
    settle(mpm, member);
    team_barrier(mpm->team);
    if (member == 0) {
        SWAP(mpm->position, mpm->spare_position);
        SWAP(mpm->id, mpm->spare_id);
        SWAP(mpm->cell_start, mpm->spare_start);
        points_share(mpm);
    }
    mpm_clock(mpm, member, MPM_SORT);
}
