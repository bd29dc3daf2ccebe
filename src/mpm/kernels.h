/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The loops that take the time of a step, compiled per instruction set and chosen
 * once at the start; all give the same bits (base/simd.h). */
#ifndef SCREE_MPM_KERNELS_H
#define SCREE_MPM_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/cpu.h"
#include "base/simd.h"
#include "mpm/grid.h"

/* ---- rows of the sweep ---- */

/* One node's stress. Tensors are in the eigenbasis of the row's K (local.h):
 * diagonal parts in x, y, z lanes, off-diagonal ones as yz, zx, xy. */
struct row {
    v4 kd, ko;                        // k_a and (k_b + k_c)/2, m3/(Pa s)
    v4 offset_d, offset_o;            // what gamma has without any velocity: room to fill up, moving walls, m3/s
    v4 stress_d, stress_o;            // lambda, Pa
    v4 last_d, last_o;                // lambda after the sweep before the last, for extrapolation
    double basis[3][4];               // eigenvectors, basis[grid axis][number]
    double mu, alpha, trace;          // friction coefficient; last root of the row; trace of the block
    uint32_t node, contact, contacts; // contact rows of the same node
    uint32_t phase;                   // enum phase, as last solved
};

/* A node held by a wall or a body with Coulomb friction. */
struct contact {
    v4 normal;   // into the material
    v4 velocity; // of the wall, over the node's scale
    v4 push;     // what the contact has added to the node's w
    v4 last;     // push after the sweep before the last
    v4 force;    // N: push over scale, kept from the end of one step to the start of the next
    double mu, scale;
    uint32_t node, owner; // owner: face or MPM_FACES + body
};

/* The grid's problem in scaled velocities w = u sqrt(m/dt): the stress of row j
 * pushes node i by w += lambda c_ij and gamma_j = offset + sum sym(w_i (x) c_ij). */
struct field {
    struct row *rows;
    const double *coupling; // c, `coupling_stride` a row: for each run of three nodes along z, three times three numbers
    size_t coupling_stride;
    ptrdiff_t run[9]; // from a row's node to the first node of each run
    int runs, plane;
    double (*w)[4];
    struct contact *contacts;
    const double *scale; // u = scale w, by node
};

/* What a look at rows [from, to) adds up. */
struct row_sums {
    double sum, largest; // of squared residuals
};

/* What measuring a row needs and leaves. */
struct row_look {
    double unit;          // a residual of gamma, m3/s, times this is a number
    double wall_unit;     // a change of velocity, m/s, likewise
    const double *volume; // material volume by node, m3
    double (*strain)[2];  // by row: ||Dev strain rate||, 1/s, and pressure, Pa; NULL: not wanted
    bool held;            // do walls that hold material move? Then offsets are more than room to fill, which has no deviator
};

/* ---- points ---- */

enum { MOMENTS = 27, MOMENT_ROOM = 28, CORNERS = 8, CORNER_ROOM = 24 };

/* A point that left its cell, with what it carries to the next. */
struct mover {
    double position[4];
    double velocity[3], rate[3][3]; // u and its derivatives by cell coordinate, rate[axis][component], m/s
    uint32_t id, cell;
};

struct move {
    const struct grid *grid;
    double step_s;
    double (*position)[4];
    uint32_t *id;
    const uint32_t *cell_start;
    uint32_t *stayed;            // by cell
    const double (*velocity)[4]; // by node, m/s
    double (*moment)[MOMENT_ROOM];
    double (*momentum)[CORNER_ROOM];
    struct mover *movers;
    size_t mover_count, mover_room;
    double courant; // largest way of a point over the spacing; NaN once a velocity is not finite
};

struct kernels {
    /* Visits rows [from, to) in order: extrapolates what the row and its node's contacts exert by `weight` of their last
     * change (w has been already), then solves contacts and row. Returns roots not found. */
    unsigned (*sweep)(const struct field *field, size_t from, size_t to, double weight);
    /* w += weight (w - last), and last = w as it was, at the nodes of rows [from, to). */
    void (*extrapolate)(const struct field *field, size_t from, size_t to, double weight, double (*last)[4]);
    /* Adds what rows [from, to) and their contacts now exert to w. */
    void (*exert)(const struct field *field, size_t from, size_t to);
    struct row_sums (*look)(const struct field *field, size_t from, size_t to, const struct row_look *look);
    /* Carries the points of cells [from, to) with the grid's velocity and deposits those that stay; stops before a
     * cell whose points might not find room among the movers. Returns the cell it came to. */
    size_t (*move)(struct move *move, size_t from, size_t to);
};

/* One point's share of a cell's moments and corner momenta (plain; movers and first points). */
void deposit_point(const struct grid *grid, const struct mover *mover, double moment[MOMENT_ROOM], double momentum[CORNER_ROOM]);

extern const struct kernels mpm_kernels_v2, mpm_kernels_v3, mpm_kernels_v4;

#endif
