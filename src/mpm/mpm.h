/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world of granular material as a continuum (seed 002, sections 2.1-2.3, appendix A).
 *
 * Material points carry volume through a regular grid. Each step solves, on the
 * grid, momentum and the Drucker-Prager law together: a complementarity problem,
 * without regularisation, by Gauss-Seidel. README.md in this folder says how.
 * Threads, slices and instruction set never change a bit of the result. */
#ifndef SCREE_MPM_MPM_H
#define SCREE_MPM_MPM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "continuum_view.h"
#include "mpm/law.h"

struct mpm;

/* ---- what bounds the material ---- */

enum mpm_wall_kind { MPM_SLIP, MPM_FRICTION, MPM_STICK };
/* A face of the box. Slip and friction push and never pull (Signorini, Coulomb);
 * stick holds the material (u = the wall's velocity), as the published code's bed. */
struct mpm_wall {
    enum mpm_wall_kind kind;
    double mu;          // MPM_FRICTION
    double velocity[3]; // of the wall in its own plane, m/s
};
enum mpm_face { MPM_X_LOW, MPM_X_HIGH, MPM_Y_LOW, MPM_Y_HIGH, MPM_Z_LOW, MPM_Z_HIGH, MPM_FACES };

/* A rigid box, its sides along the axes, at least two cells thick in each direction in which material may
 * meet it. It starts at start_s and moves with U(t) = velocity (1 - exp(-(t - start_s) / tau_s)). */
struct mpm_body {
    double low[3], high[3]; // m, at t = 0
    double velocity[3];     // m/s, reached after a few tau_s
    double start_s, tau_s;  // tau_s = 0: at once
    double mu;
};
enum { MPM_BODIES_MAX = 8 };

/* A box that is full of material at t = 0; regions must not overlap. */
struct mpm_region {
    double low[3], high[3]; // m
};

/* A box that is turned about y by steps, which is gravity turned the other way: from, from + step, ... up to `to`,
 * each held for hold_s. hold_s = 0: gravity stays as it is given. */
struct mpm_tilt {
    double from, to, step; // rad
    double hold_s;
    double weight; // size of gravity, m/s2
};

/* ---- the set-up ---- */

struct mpm_solver {
    double tolerance; // mean squared residual of the rows (struct mpm_residual) at which sweeps end
    int sweeps;       // at most
    int check;        // sweeps between two looks at the residual
    bool accelerate;  // Nesterov's extrapolation between sweeps
};

struct mpm_setup {
    double step_s;
    double gravity[3]; // m/s2; not looked at when the box is tilted
    struct mpm_tilt tilt;
    double length[3]; // of the box [0, length], m
    int cells[3];
    bool plane;     // two dimensions, x and z: cells[1] and length[1] are not looked at, sums are per metre of depth
    bool endless;   // the same all along x: one column of cells, whose sums are per metre of length
    double density; // of the material where it is densest, rho_g phi_c, kg/m3
    struct mpm_wall walls[MPM_FACES];
    const struct mpm_body *bodies;
    size_t body_count;
    const struct mpm_region *regions;
    size_t region_count;
    int points_per_cell; // along an axis
    double jitter;       // 0: points on a lattice; 1: anywhere in their share of the cell
    uint64_t seed;
    double velocity[3], gradient[3][3]; // of the material at t = 0: v + gradient x, m/s, 1/s
    const struct mpm_law *law;
    struct mpm_law_coefs coefs;
    double grain_diameter, inertial_density; // in the inertial number (law.h), m, kg/m3
    double recover_s; // over-full nodes expand again over this time; 0: never (published code), see README.md
    struct mpm_solver solver;
    int threads;
    const char *isa; // NULL: the best there is
};

/* Copies what it needs. SCREE_INVALID names the field of the set-up at fault. */
enum scree_status mpm_create(const struct mpm_setup *setup, struct mpm **out, struct scree_error *err);
void mpm_free(struct mpm *mpm);

/* Does exactly `steps` time steps, or fails with SCREE_BLOWUP (step, last good
 * time) when a velocity is no longer finite or crosses a cell in one step. */
enum scree_status mpm_advance(struct mpm *mpm, uint64_t steps, struct scree_error *err);

uint64_t mpm_step(const struct mpm *mpm);
double mpm_time(const struct mpm *mpm);
size_t mpm_points(const struct mpm *mpm);
const char *mpm_isa(const struct mpm *mpm);

/* Steering: takes effect with the next step; a tilted box turns it back with the step after. */
void mpm_set_gravity(struct mpm *mpm, const double gravity[3]);

/* Mean force of the material on the box's floor (face z low) over the steps since
 * the last call, N; zero if there were none. */
void mpm_take_base_force(struct mpm *mpm, double mean[3]);

/* Over points, grid momenta, stresses and step. */
uint64_t mpm_hash(const struct mpm *mpm);

/* ---- how well the last step was solved ---- */

/* |f_MFB|^2 of a row, stress scaled by the row's own block (its trace) and all
 * made a number by the rate sqrt(g / dz) times the node's share of the box. Walls count by
 * the change of velocity that one more visit would make, over dz, in the same unit. */
struct mpm_residual {
    double mean, largest;
};
struct mpm_report {
    uint64_t rows, contacts; // of the last step
    uint64_t sweeps;         // of the last step
    struct mpm_residual residual;
    uint64_t sweeps_total;
    uint64_t unconverged; // steps whose sweeps ran out, since the start
    uint64_t stalls;      // rows whose own root was not found, since the start
    uint64_t moved;       // points that changed cell in the last step
    double overfull;      // material volume beyond what nodes can hold, m3
    double worst_courant; // largest |u| dt / spacing of the last step
};
struct mpm_report mpm_report(const struct mpm *mpm);

/* Calls `see` after every check of the residual in every step, from the thread that advances. */
void mpm_watch(struct mpm *mpm, void (*see)(void *context, uint64_t sweeps, struct mpm_residual residual), void *context);

/* ---- what the world shows ---- */

/* Fills *view; arrays belong to the world and hold until it is advanced. */
enum scree_status mpm_view(struct mpm *mpm, struct continuum_view *view, struct scree_error *err);

/* ---- where the time goes ---- */

enum mpm_phase { MPM_ASSEMBLE, MPM_PREPARE, MPM_SWEEP, MPM_RESIDUAL, MPM_EXTRAPOLATE, MPM_MOVE, MPM_SORT, MPM_PHASES };
struct mpm_profile {
    double seconds[MPM_PHASES]; // of member 0's processor time
};
/* From now on seconds are added to *profile, which the caller keeps; NULL ends it. */
void mpm_profile(struct mpm *mpm, struct mpm_profile *profile);

/* Bytes a world of that many points and nodes takes. */
double mpm_bytes(double points, double nodes);

#endif
