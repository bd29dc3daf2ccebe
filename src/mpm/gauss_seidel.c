/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The solve: sweeps over the rows until they agree (seed 002, A.3).
 *
 * Order. Two rows touch the same velocities when their nodes are at most two
 * layers apart. The grid is cut into slabs of SLAB_LAYERS >= 2 layers along x;
 * even slabs go first, then odd ones. Slabs of one kind share nothing, so threads
 * take them as they like, each to whoever has the fewest rows so far; within a slab rows go one after the other.
 * The slabs follow from the grid, hence the same bits on any number of threads,
 * and nearly the convergence of a plain sweep, which 27 colours would not have.
 *
 * Between sweeps the state is extrapolated along its last change (Nesterov).
 * Scaled velocities are linear in stresses and pushes, so all three take the same
 * weight and stay consistent. A stress may leave its cone by extrapolation: the
 * row's next visit does not look at it. The last sweep is a plain one. */
#include <math.h>
#include <string.h>

#include "mpm/drucker_prager.h"
#include "mpm/state.h"

/* Slabs of one kind that a member takes. */
static void each_slab(struct mpm *mpm, int member, size_t odd, void (*work)(struct mpm *, int, size_t))
{
    for (size_t s = odd; s < mpm->slab_count; s += 2)
        if (mpm->slab_owner[s] == member)
            work(mpm, member, s);
}

/* Both kinds in turn; a barrier after each. */
static void all_slabs(struct mpm *mpm, int member, void (*work)(struct mpm *, int, size_t))
{
    for (size_t odd = 0; odd < 2; odd++) {
        each_slab(mpm, member, odd, work);
        team_barrier(mpm->team);
    }
}

static void exert_slab(struct mpm *mpm, int member, size_t s)
{
    (void)member;
    mpm->kernels->exert(&mpm->field, mpm->slab_row[s], mpm->slab_row[s + 1]);
}

static void sweep_slab(struct mpm *mpm, int member, size_t s)
{
    mpm->parts[member].stalls += mpm->kernels->sweep(&mpm->field, mpm->slab_row[s], mpm->slab_row[s + 1], mpm->weight);
}

static bool held_moves(const struct mpm *mpm)
{
    bool moves = false;
    for (int face = 0; face < MPM_FACES; face++)
        for (int a = 0; a < 3; a++)
            moves |= mpm->walls[face].kind == MPM_STICK && mpm->walls[face].velocity[a] != 0;
    return moves;
}

static struct row_look look_at(const struct mpm *mpm, bool strain)
{
    const double *g = mpm->gravity;
    double weight = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), height = mpm->grid.spacing[2];
    double time = weight > 0 ? sqrt(height / weight) : mpm->step_s; // without gravity: strain a step
    return (struct row_look){.unit = time / mpm->grid.cell_volume,
                             .wall_unit = time / (height * mpm->grid.cell_volume),
                             .volume = mpm->volume,
                             .strain = strain ? mpm->strain : NULL,
                             .held = held_moves(mpm)};
}

static void look_slab(struct mpm *mpm, int member, size_t s)
{
    (void)member;
    struct row_look look = look_at(mpm, false);
    mpm->slab_sums[s] = mpm->kernels->look(&mpm->field, mpm->slab_row[s], mpm->slab_row[s + 1], &look);
}

/* Looking changes nothing, so slabs of both kinds go together. Every member adds up the same sums. */
static struct mpm_residual residual(struct mpm *mpm, int member)
{
    each_slab(mpm, member, 0, look_slab);
    each_slab(mpm, member, 1, look_slab);
    team_barrier(mpm->team);
    struct mpm_residual total = {0, 0};
    for (size_t s = 0; s < mpm->slab_count; s++)
        if (mpm->slab_row[s] < mpm->slab_row[s + 1]) {
            total.mean += mpm->slab_sums[s].sum;
            total.largest = fmax(total.largest, mpm->slab_sums[s].largest);
        }
    total.mean /= mpm->row_count ? (double)mpm->row_count : 1;
    return total;
}

/* ---- extrapolation ---- */

/* Velocities here, all at once; stresses and pushes when the sweep comes to them. */
static void extrapolate(struct mpm *mpm, int member, double weight)
{
    size_t from = member_share(mpm->row_count, member, mpm->part_count);
    size_t to = member_share(mpm->row_count, member + 1, mpm->part_count);
    mpm->kernels->extrapolate(&mpm->field, from, to, weight, mpm->w_last);
    if (member == 0)
        mpm->weight = weight;
    team_barrier(mpm->team);
}

/* Nesterov's weights: t grows, beta = (t - 1) / t', up to a limit: friction is not
 * the gradient of an energy, and weights near one make the sweeps run away. Where
 * the residual has grown between two looks the limit comes down. */
struct weights {
    double t, limit, last; // last: residual at the last look
};
#define WEIGHT_LIMIT 0.8 // measured on columns at rest and flowing: 0.9 runs away, 0.7 takes a fifth more sweeps
static double weights_next(struct weights *w)
{
    double next = 0.5 * (1 + sqrt(1 + 4 * w->t * w->t)), beta = (w->t - 1) / next;
    w->t = next;
    return fmin(beta, w->limit);
}

static void weights_see(struct weights *w, double mean)
{
    if (mean > w->last) {
        w->limit *= 0.75;
        w->t = 1;
    }
    w->last = mean;
}

/* ---- the solve ---- */

/* Stresses back to the grid's axes, strains for the law, velocities for the points. */
static void finish(struct mpm *mpm, int member)
{
    size_t from = member_share(mpm->row_count, member, mpm->part_count);
    size_t to = member_share(mpm->row_count, member + 1, mpm->part_count);
    struct row_look look = look_at(mpm, true);
    mpm->kernels->look(&mpm->field, from, to, &look);
    const double *g = mpm->gravity;
    double weight = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    double floor = 1e-6 * mpm->density * fmax(weight * mpm->grid.spacing[2], 1e-12); // below, there is no pressure to speak of
    for (size_t r = from; r < to; r++) {
        const struct row *row = &mpm->rows[r];
        double q[3][3], parts[TENSOR];
        for (int a = 0; a < 3; a++) {
            parts[a] = row->stress_d[a];
            parts[3 + a] = row->stress_o[a];
            for (int b = 0; b < 3; b++)
                q[a][b] = row->basis[a][b];
        }
        double *stress = mpm->stress[row->node];
        tensor_rotate_back(parts, (const double(*)[3])q, stress);
        stress[6] = row->alpha;
        stress[7] = mpm->grain_diameter * mpm->strain[r][0] * sqrt(mpm->inertial_density / fmax(mpm->strain[r][1], floor));
        for (uint32_t k = row->contact; k < row->contact + row->contacts; k++)
            mpm->contacts[k].force = mpm->contacts[k].push / v4_all(mpm->contacts[k].scale);
        double scale = mpm->scale[row->node];
        if (scale > 0)
            for (int a = 0; a < 3; a++)
                mpm->velocity[row->node][a] = scale * mpm->w[row->node][a];
    }
    team_barrier(mpm->team);
}

void gauss_seidel(struct mpm *mpm, int member)
{
    const struct mpm_solver *how = &mpm->solver;
    struct mpm_residual left = {INFINITY, INFINITY};
    int sweeps = 0;
    struct weights weights = {1, WEIGHT_LIMIT, INFINITY};
    all_slabs(mpm, member, exert_slab);
    mpm_clock(mpm, member, MPM_PREPARE);
    extrapolate(mpm, member, 0); // notes where the first sweep starts
    while (sweeps < how->sweeps) {
        all_slabs(mpm, member, sweep_slab);
        sweeps++;
        mpm_clock(mpm, member, MPM_SWEEP);
        if (sweeps % how->check == 0 || sweeps == how->sweeps) {
            left = residual(mpm, member);
            if (member == 0 && mpm->see)
                mpm->see(mpm->see_context, (uint64_t)sweeps, left);
            mpm_clock(mpm, member, MPM_RESIDUAL);
            if (!(left.mean > how->tolerance) || sweeps == how->sweeps)
                break;
            weights_see(&weights, left.mean);
            team_barrier(mpm->team); // nobody sweeps while others still look
        }
        if (how->accelerate)
            extrapolate(mpm, member, weights_next(&weights));
        mpm_clock(mpm, member, MPM_EXTRAPOLATE);
    }
    team_barrier(mpm->team);
    finish(mpm, member);
    if (member == 0) {
        mpm->report.rows = mpm->row_count;
        mpm->report.contacts = mpm->contact_count;
        mpm->report.sweeps = (uint64_t)sweeps;
        mpm->report.sweeps_total += (uint64_t)sweeps;
        mpm->report.residual = left;
        mpm->report.unconverged += left.mean > how->tolerance;
    }
    mpm_clock(mpm, member, MPM_RESIDUAL);
}
