/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See spread.h.
 *
 * In a flow every grain goes far, but neighbours go together: what wears out a
 * list is not how far one goes, but how far apart the ways are of two that could
 * meet. Ways are boxed cell by cell, in cells twice as wide as those that pairs
 * are sought in. From the box of a cell to the box of it and its neighbours bounds
 * how much nearer a grain of the one can have come to a grain of the other.
 *
 * Grains of neighbouring cells had at least the skin between them, or they are
 * listed. Those of others are met where cells are joined two by two, over and
 * over, until all are neighbours: which is when there was a whole cell of the
 * level before between them. So much may their ways differ by then. */
#include "dem/spread.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/simd.h"

enum { WAY, RATE, FIELDS };

struct ways { // of the grains of a cell: what holds their displacements, and their velocities
    v4 low[FIELDS], high[FIELDS];
};

static const struct ways nobody = {
    .low = {{INFINITY, INFINITY, INFINITY, INFINITY}, {INFINITY, INFINITY, INFINITY, INFINITY}},
    .high = {{-INFINITY, -INFINITY, -INFINITY, -INFINITY}, {-INFINITY, -INFINITY, -INFINITY, -INFINITY}}};

static inline void add(struct ways *ways, const struct ways *other)
{
    for (int f = 0; f < FIELDS; f++) {
        ways->low[f] = v4_min(ways->low[f], other->low[f]);
        ways->high[f] = v4_max(ways->high[f], other->high[f]);
    }
}

/* Half as many, so that none is thinner than two: the last takes a third where one is left over. */
static int halves(int count)
{
    return count > 1 ? count / 2 : 1;
}
static int half_of(int cell, int count)
{
    int half = cell / 2, last = halves(count) - 1;
    return half < last ? half : last;
}

static size_t cells_of(const int count[3])
{
    return (size_t)count[0] * (size_t)count[1] * (size_t)count[2];
}

static struct ways ways_of(const struct dem *dem, size_t row)
{
    const m4 three = {-1, -1, -1, 0}; // what a row of velocities holds beside them says nothing here
    struct ways ways = {.low = {{0}}};
    if (row < dem->moving) {
        ways.low[WAY] = v4_load(dem->position[row]) - v4_load(dem->position0[row]);
        ways.low[RATE] = (v4)((m4)v4_load(dem->velocity[row]) & three);
    }
    for (int f = 0; f < FIELDS; f++)
        ways.high[f] = ways.low[f];
    return ways;
}

/* The ways of all grains, in `count` cells, each of two of the grid's along each axis. */
static void fill(const struct cells *cells, const struct dem *dem, const int count[3], struct ways *out)
{
    for (size_t c = 0; c < cells_of(count); c++)
        out[c] = nobody;
    size_t fine = 0;
    for (int z = 0; z < cells->count[2]; z++)
        for (int y = 0; y < cells->count[1]; y++)
            for (int x = 0; x < cells->count[0]; x++, fine++) {
                int at = half_of(z, cells->count[2]) * count[1] + half_of(y, cells->count[1]);
                struct ways *cell = &out[(size_t)at * (size_t)count[0] + (size_t)half_of(x, cells->count[0])];
                for (uint32_t k = cells->start[fine]; k < cells->start[fine + 1]; k++) {
                    struct ways ways = ways_of(dem, cells->row[k]);
                    add(cell, &ways);
                }
            }
}

/* Each cell takes in its two neighbours along an axis. */
static void widen(struct ways *cell, const int count[3], int axis, bool periodic)
{
    size_t stride = axis == 0 ? 1 : axis == 1 ? (size_t)count[0] : (size_t)count[0] * (size_t)count[1];
    size_t n = (size_t)count[axis], lines = cells_of(count) / n;
    for (size_t line = 0; line < lines; line++) {
        struct ways *first = cell + line / stride * stride * n + line % stride, *last = first + (n - 1) * stride;
        struct ways start = *first, before = periodic ? *last : nobody;
        for (struct ways *at = first;; at += stride) {
            struct ways now = *at;
            add(at, &before);
            if (at == last) {
                if (periodic)
                    add(at, &start);
                break;
            }
            add(at, at + stride);
            before = now;
        }
    }
}

/* Joins cells two by two, in place: a cell's new place is never behind those still to be read. */
static void join(struct ways *cell, int count[3])
{
    int half[3] = {halves(count[0]), halves(count[1]), halves(count[2])};
    struct ways *from = cell;
    size_t done = 0; // new cells that hold something
    for (int z = 0; z < count[2]; z++)
        for (int y = 0; y < count[1]; y++)
            for (int x = 0; x < count[0]; x++, from++) {
                struct ways ways = *from;
                size_t to = ((size_t)half_of(z, count[2]) * (size_t)half[1] + (size_t)half_of(y, count[1])) * (size_t)half[0] +
                            (size_t)half_of(x, count[0]);
                for (; done <= to; done++)
                    cell[done] = nobody;
                add(&cell[to], &ways);
            }
    for (int a = 0; a < 3; a++)
        count[a] = half[a];
}

/* How far apart, at most, the ways of a grain and of one in its cell or around it are. */
static double apart(const struct ways *cell, const struct ways *wide, size_t cells, int field)
{
    double most = 0;
    for (size_t c = 0; c < cells; c++) {
        v4 side = v4_max(wide[c].high[field] - cell[c].low[field], cell[c].high[field] - wide[c].low[field]), square = side * side;
        double sum = square[0] + square[1] + square[2];
        most = side[0] >= 0 && sum > most ? sum : most; // a cell without grains has sides of less than nothing
    }
    return sqrt(most);
}

enum scree_status spread_measure(struct cells *cells, const struct dem *dem, double skin, struct spread_bound *out,
                                 struct scree_error *err)
{
    int count[3] = {halves(cells->count[0]), halves(cells->count[1]), halves(cells->count[2])};
    size_t total = cells_of(count);
    enum scree_status status;
    if ((status = memory_grow((void **)&cells->ways, &cells->ways_room, total, sizeof *cells->ways, err)) ||
        (status = memory_grow((void **)&cells->wide, &cells->wide_room, total, sizeof *cells->wide, err)))
        return status;
    fill(cells, dem, count, cells->ways);
    *out = (struct spread_bound){0, 0};
    double gap = skin, width = 2 * cells->width; // of pairs that are met at this level; of its cells
    for (;; width *= 2) {
        total = cells_of(count);
        memcpy(cells->wide, cells->ways, total * sizeof *cells->wide);
        for (int a = 0; a < 3; a++)
            widen(cells->wide, count, a, dem->length[a] > 0);
        out->moved = fmax(out->moved, apart(cells->ways, cells->wide, total, WAY) * skin / gap);
        out->rate = fmax(out->rate, apart(cells->ways, cells->wide, total, RATE) * skin / gap);
        if (count[0] <= 3 && count[1] <= 3 && count[2] <= 3)
            return SCREE_OK; // each is everybody's neighbour, or the one in the middle is
        join(cells->ways, count);
        gap = width - 2 * dem->largest_radius;
    }
}
