/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From the cells' sums to the step's problem (seed 002, A.2).
 *
 * A row j needs, for each neighbour i, C_ij = sum_p V_p N_j(x_p) grad N_i(x_p):
 * its stress pushes node i with lambda C_ij and its strain rate is
 * sum_i sym(u_i (x) C_ij). In a cell both functions are products of one function
 * per axis, and the cell keeps sum_p V P_a(x) P_b(y) P_c(z) for the three
 * products P = N0 N0, N0 N1, N1 N1. Along an axis, N_s N_t = P_{s+t} and
 * N_s N_t' = +-(P_s + P_{s+1})/h: sums of positive numbers, no cancellation.
 *
 * Velocities are scaled, w = u sqrt(m/dt), so that c_ij = C_ij sqrt(dt/m_i)
 * serves both ways. Lumped mass; a node with hardly any material gets a trifle of
 * inertia more (MASS_FLOOR of a full cell's), or its velocity would have no bound. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "mpm/drucker_prager.h"
#include "mpm/state.h"

#define MASS_FLOOR  1e-7
#define BURIED      1e-3 // of a cell's volume
#define BLOCK_FLOOR 1e-9 // of the largest eigenvalue of K

/* The cells round a node: its corner number there is s. Calls for each that exists. */
struct corner {
    size_t cell;
    int s[3];
};
static int corners_of(const struct grid *g, const int place[3], struct corner corners[8])
{
    int count = 0;
    for (int k = 0; k < 8; k++) {
        int s[3] = {k >> 2, k >> 1 & 1, k & 1}, c[3];
        bool inside = true;
        for (int a = 0; a < 3; a++) {
            c[a] = place[a] - s[a];
            inside &= c[a] >= 0 && c[a] < g->cells[a];
        }
        if (!inside || (g->flat[0] && s[0]) || (g->flat[1] && s[1]))
            continue;
        corners[count++] = (struct corner){grid_cell(g, c[0], c[1], c[2]), {s[0], s[1], s[2]}};
    }
    return count;
}

/* sum_p V N_s of one cell: N_s = P_s + P_{s+1} along each axis. */
static double corner_volume(const double m[MOMENT_ROOM], const int s[3])
{
    double sum = 0;
    for (int a = s[0]; a <= s[0] + 1; a++)
        for (int b = s[1]; b <= s[1] + 1; b++)
            for (int c = s[2]; c <= s[2] + 1; c++)
                sum += m[9 * a + 3 * b + c];
    return sum;
}

/* Mass and velocity of one node before stresses act. */
static void node(struct mpm *mpm, const int place[3])
{
    const struct grid *g = &mpm->grid;
    size_t n = grid_node(g, place[0], place[1], place[2]);
    struct corner corners[8];
    int count = corners_of(g, place, corners);
    double volume = 0, u[3] = {0, 0, 0}, held[3];
    for (int k = 0; k < count; k++) {
        const double *m = mpm->momentum[corners[k].cell] + 3 * (4 * corners[k].s[0] + 2 * corners[k].s[1] + corners[k].s[2]);
        volume += corner_volume(mpm->moment[corners[k].cell], corners[k].s);
        for (int a = 0; a < 3; a++)
            u[a] += m[a];
    }
    bool sticks = rigid_sticks(mpm, place, held);
    mpm->volume[n] = volume;
    mpm->scale[n] = volume > 0 && !sticks ? sqrt(mpm->step_s / (mpm->density * (volume + MASS_FLOOR * g->cell_volume))) : 0;
    for (int a = 0; a < 3; a++) {
        double free = volume > 0 ? u[a] / volume + mpm->step_s * mpm->gravity[a] : 0;
        if (g->plane && a == 1)
            free = 0;
        mpm->w[n][a] = mpm->scale[n] > 0 ? free / mpm->scale[n] : 0;
        mpm->velocity[n][a] = sticks ? held[a] : free;
    }
}

static void nodes(struct mpm *mpm, int member)
{
    const struct grid *g = &mpm->grid;
    int layers = grid_layers(g, 0);
    int from = (int)member_share((size_t)layers, member, mpm->part_count);
    int to = (int)member_share((size_t)layers, member + 1, mpm->part_count);
    for (int x = from; x < to; x++)
        for (int y = 0; y < grid_layers(g, 1); y++)
            for (int z = 0; z < grid_layers(g, 2); z++)
                node(mpm, (int[3]){x, y, z});
}

/* Numbers the rows: every node with material, in memory's order; notes where slabs begin. */
static void number_rows(struct mpm *mpm)
{
    const struct grid *g = &mpm->grid;
    size_t row = 0;
    for (int x = 0; x < grid_layers(g, 0); x++) {
        if (x % SLAB_LAYERS == 0)
            mpm->slab_row[x / SLAB_LAYERS] = row;
        for (int y = 0; y < grid_layers(g, 1); y++)
            for (int z = 0; z < grid_layers(g, 2); z++) {
                size_t n = grid_node(g, x, y, z);
                if (mpm->volume[n] > 0)
                    mpm->rows[row++].node = (uint32_t)n;
            }
    }
    mpm->slab_row[mpm->slab_count] = row;
    mpm->row_count = row;
}

/* Each slab to the member that has the fewest rows of its kind so far: a column is a few slabs full of rows
 * beside many of a thin bed, which in contiguous halves would leave a member idle for a sixth of the time. */
static void share_slabs(struct mpm *mpm)
{
    for (size_t odd = 0; odd < 2; odd++) {
        for (int k = 0; k < mpm->part_count; k++)
            mpm->parts[k].rows = 0;
        for (size_t s = odd; s < mpm->slab_count; s += 2) {
            int least = 0;
            for (int k = 1; k < mpm->part_count; k++)
                if (mpm->parts[k].rows < mpm->parts[least].rows)
                    least = k;
            mpm->slab_owner[s] = least;
            mpm->parts[least].rows += mpm->slab_row[s + 1] - mpm->slab_row[s];
        }
    }
}

/* Adds one cell's share of C for the row at its corner s. */
static void couple_cell(const struct grid *g, const double m[MOMENT_ROOM], const int s[3], double *coupling)
{
    const double *p[3][3];
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            p[a][b] = m + 9 * a + 3 * b;
    int length = g->flat[0] ? 1 : 2, depth = g->flat[1] ? 1 : 2, width = g->flat[1] ? 1 : 3;
    for (int tx = 0; tx < length; tx++)
        for (int ty = 0; ty < depth; ty++)
            for (int tz = 0; tz < 2; tz++) {
                int dx = g->flat[0] ? 0 : tx - s[0] + 1, dy = g->flat[1] ? 0 : ty - s[1] + 1, dz = tz - s[2];
                double *c = coupling + 3 * (3 * (dx * width + dy) + dz + 1);
                int x = s[0] + tx, y = s[1] + ty, z = s[2] + tz;
                double cx = p[s[0]][y][z] + p[s[0] + 1][y][z];
                double cy = p[x][s[1]][z] + p[x][s[1] + 1][z];
                double cz = p[x][y][s[2]] + p[x][y][s[2] + 1];
                c[0] += g->flat[0] ? 0 : tx ? cx * g->inverse[0] : -cx * g->inverse[0];
                c[1] += g->flat[1] ? 0 : ty ? cy * g->inverse[1] : -cy * g->inverse[1];
                c[2] += tz ? cz * g->inverse[2] : -cz * g->inverse[2];
            }
}

/* C of a row into `coupling`, unscaled, m2. */
static void couple(const struct mpm *mpm, const int place[3], double *coupling)
{
    struct corner corners[8];
    int count = corners_of(&mpm->grid, place, corners);
    memset(coupling, 0, mpm->field.coupling_stride * sizeof *coupling);
    for (int k = 0; k < count; k++)
        couple_cell(&mpm->grid, mpm->moment[corners[k].cell], corners[k].s, coupling);
}

/* Strain rate that walls with a velocity of their own impose through nodes that stick to them. */
static void add_held(double offset[TENSOR], const double u[4], const double c[3])
{
    for (int a = 0; a < 3; a++)
        offset[a] += u[a] * c[a];
    offset[3] += 0.5 * (u[1] * c[2] + u[2] * c[1]);
    offset[4] += 0.5 * (u[2] * c[0] + u[0] * c[2]);
    offset[5] += 0.5 * (u[0] * c[1] + u[1] * c[0]);
}

/* Scales a row's coupling and takes what held nodes mean for it. */
static void scale_row(struct mpm *mpm, size_t r, double block[TENSOR], double offset[TENSOR])
{
    const struct field *f = &mpm->field;
    double *c = mpm->coupling + r * f->coupling_stride, *floor = mpm->floor_coupling[r];
    memset(block, 0, TENSOR * sizeof *block);
    memset(floor, 0, sizeof *mpm->floor_coupling);
    for (int run = 0; run < f->runs; run++)
        for (int k = 0; k < 3; k++, c += 3) {
            size_t n = (size_t)((ptrdiff_t)mpm->rows[r].node + f->run[run] + k);
            double s = mpm->scale[n];
            if (s == 0 && mpm->volume[n] > 0) {
                int place[3];
                grid_node_place(&mpm->grid, n, place);
                add_held(offset, mpm->velocity[n], c);
                for (int a = 0; a < 3 && rigid_floor(mpm, place); a++)
                    floor[a] += c[a];
            }
            c[0] *= s;
            c[1] *= s;
            c[2] *= s;
            block[0] += c[0] * c[0];
            block[1] += c[1] * c[1];
            block[2] += c[2] * c[2];
            block[3] += c[1] * c[2];
            block[4] += c[2] * c[0];
            block[5] += c[0] * c[1];
        }
}

/* Room to fill up, per time (eq. A13's k, with the sign of section 2.3 and over d): negative where there is too much. */
static double filling_rate(const struct mpm *mpm, const int place[3], double volume)
{
    double room = rigid_room(mpm, place);
    /* A node buried in a body: the few points that rounding or a corner brought there are the contacts' business. */
    if (room < BURIED * mpm->grid.cell_volume)
        room += mpm->grid.cell_volume;
    double missing = room - volume;
    if (missing >= 0)
        return missing / mpm->step_s;
    return mpm->recover_s > 0 ? missing / fmax(mpm->recover_s, mpm->step_s) : 0;
}

static void fill_row(struct mpm *mpm, size_t r)
{
    struct row *row = &mpm->rows[r];
    const size_t n = row->node;
    bool plane = mpm->grid.plane;
    int place[3];
    double block[TENSOR], offset[TENSOR] = {0}, q[3][3], k[3], turned[TENSOR];
    grid_node_place(&mpm->grid, n, place);
    couple(mpm, place, mpm->coupling + r * mpm->field.coupling_stride);
    scale_row(mpm, r, block, offset);
    double fill = filling_rate(mpm, place, mpm->volume[n]) / (plane ? 2 : 3);
    for (int a = 0; a < 3; a++)
        offset[a] += plane && a == 1 ? 0 : fill;
    tensor_eigen(block, q, k);
    double top = fmax(k[0], fmax(k[1], k[2]));
    for (int a = 0; a < 3; a++)
        k[a] = top > 0 ? fmax(k[a], BLOCK_FLOOR * top) : 1;
    row->trace = (plane ? 1.5 * (k[0] + k[2]) : 2 * (k[0] + k[1] + k[2]));
    if (plane)
        k[1] = 1;
    row->kd = v4_set(k[0], k[1], k[2], 1);
    row->ko = v4_set(0.5 * (k[1] + k[2]), 0.5 * (k[2] + k[0]), 0.5 * (k[0] + k[1]), 1);
    tensor_rotate(offset, (const double(*)[3])q, turned);
    row->offset_d = v4_set(turned[0], turned[1], turned[2], 0);
    row->offset_o = v4_set(turned[3], turned[4], turned[5], 0);
    tensor_rotate(mpm->stress[n], (const double(*)[3])q, turned);
    row->stress_d = v4_set(turned[0], turned[1], turned[2], 0);
    row->stress_o = v4_set(turned[3], turned[4], turned[5], 0);
    row->last_d = row->stress_d;
    row->last_o = row->stress_o;
    row->alpha = mpm->stress[n][6];
    row->mu = mpm->law->friction(&mpm->coefs, mpm->stress[n][7]);
    mpm->friction[n] = row->mu;
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            row->basis[a][b] = q[a][b];
}

void assemble(struct mpm *mpm, int member)
{
    nodes(mpm, member);
    team_barrier(mpm->team);
    if (member == 0) {
        number_rows(mpm);
        share_slabs(mpm);
    }
    team_barrier(mpm->team);
    size_t to = member_share(mpm->row_count, member + 1, mpm->part_count);
    for (size_t r = member_share(mpm->row_count, member, mpm->part_count); r < to; r++)
        fill_row(mpm, r);
    team_barrier(mpm->team);
    if (member == 0)
        rigid_contacts(mpm);
}

/* What reaches the floor in this step, N: stresses on nodes that stick to it, the
 * momentum that they stop and their weight; pushes where it is frictional or slippery. */
void assemble_floor_force(const struct mpm *mpm, double force[3])
{
    const struct grid *g = &mpm->grid;
    memset(force, 0, 3 * sizeof *force);
    for (size_t r = 0; r < mpm->row_count; r++) {
        const double *s = mpm->stress[mpm->rows[r].node], *c = mpm->floor_coupling[r];
        force[0] += s[0] * c[0] + s[5] * c[1] + s[4] * c[2];
        force[1] += s[5] * c[0] + s[1] * c[1] + s[3] * c[2];
        force[2] += s[4] * c[0] + s[3] * c[1] + s[2] * c[2];
    }
    for (size_t k = 0; k < mpm->contact_count; k++)
        for (int a = 0; a < 3 && mpm->contacts[k].owner == MPM_Z_LOW; a++)
            force[a] -= mpm->contacts[k].force[a];
    for (int x = 0; x < grid_layers(g, 0); x++)
        for (int y = 0; y < grid_layers(g, 1); y++) {
            size_t n = grid_node(g, x, y, 0);
            double held[3];
            if (!(mpm->volume[n] > 0) || !rigid_sticks(mpm, (int[3]){x, y, 0}, held))
                continue;
            struct corner corners[8];
            int count = corners_of(g, (int[3]){x, y, 0}, corners);
            for (int a = 0; a < 3; a++) {
                double momentum = 0;
                for (int k = 0; k < count; k++)
                    momentum +=
                        mpm->momentum[corners[k].cell][3 * (4 * corners[k].s[0] + 2 * corners[k].s[1] + corners[k].s[2]) + a];
                force[a] += mpm->density * ((momentum - mpm->volume[n] * held[a]) / mpm->step_s + mpm->volume[n] * mpm->gravity[a]);
            }
        }
}

double assemble_overfull(const struct mpm *mpm)
{
    double sum = 0;
    for (size_t r = 0; r < mpm->row_count; r++) {
        int place[3];
        grid_node_place(&mpm->grid, mpm->rows[r].node, place);
        sum += fmax(0, mpm->volume[mpm->rows[r].node] - rigid_room(mpm, place));
    }
    return sum;
}
