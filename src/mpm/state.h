/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world of continuum keeps in memory. Private to this folder.
 *
 * Between steps the state is: the points' positions in cell order; the moments
 * and momenta that they have deposited in their cells; the stresses and contact
 * pushes that the next solve starts from. Points carry no velocity of their own:
 * it is read from the grid and deposited again in one pass (points.c). */
#ifndef SCREE_MPM_STATE_H
#define SCREE_MPM_STATE_H

#include "base/parallel.h"
#include "mpm/kernels.h"
#include "mpm/local.h"
#include "mpm/mpm.h"

enum { SLAB_LAYERS = 3 }; // layers of nodes in a slab: at least two, see gauss_seidel.c

/* By member of the team. */
struct member_part {
    struct mover *movers;
    size_t mover_count, mover_room;
    double courant;
    uint64_t stalls;
    size_t rows; // of slabs of one kind, while they are shared out
    enum scree_status status;
    struct scree_error error;
};

struct mpm {
    struct grid grid;
    double step_s, gravity[3], density;
    struct mpm_tilt tilt;
    uint64_t step;
    struct mpm_wall walls[MPM_FACES];
    struct mpm_body bodies[MPM_BODIES_MAX];
    size_t body_count;
    const struct mpm_law *law;
    struct mpm_law_coefs coefs;
    double grain_diameter, inertial_density, recover_s;
    struct mpm_solver solver;
    const struct kernels *kernels;
    enum cpu_isa isa;

    /* Points, in the order of their cells. */
    size_t points;
    double (*position)[4], (*spare_position)[4]; // x, y, z, m; volume, m3
    uint32_t *id, *spare_id;
    uint32_t *cell_start, *spare_start; // cell_count + 1
    uint32_t *stayed, *cursor;          // scratch by cell
    double total_volume;

    /* By cell: sums over its points of volume times products of shape functions, and of volume, shape function and velocity. */
    double (*moment)[MOMENT_ROOM];
    double (*momentum)[CORNER_ROOM];

    /* By node. */
    double *volume;        // of material, m3
    double *scale;         // sqrt(dt / mass); 0 where nothing moves
    double (*w)[4];        // u / scale
    double (*velocity)[4]; // u, m/s, as points see it
    double (*stress)[8];   // {xx, yy, zz, yz, zx, xy} in the grid's axes, Pa; [6] last root; [7] inertial number
    double *friction;      // coefficient of the last step

    /* Rows of this step. */
    size_t row_count;
    struct row *rows;
    double *coupling;
    double (*floor_coupling)[4]; // by row: its unscaled coupling to nodes that stick to the floor, m2
    double (*strain)[2];         // by row: see row_look
    size_t *slab_row;            // first row of each slab, slab_count + 1
    int *slab_owner;             // member that sweeps it
    size_t slab_count;
    struct row_sums *slab_sums;
    struct field field;

    struct contact *contacts, *last_contacts;
    size_t contact_count, last_contact_count;

    /* Extrapolation between sweeps. */
    double (*w_last)[4]; // by node, after the sweep before the last
    double weight;       // of this sweep's extrapolation

    struct team *team;
    struct member_part *parts;
    int part_count;
    size_t *cell_cut; // first cell of each member's share, part_count + 1

    double base_sum[3], base_last[3]; // N
    uint64_t base_steps;
    struct mpm_report report;
    void (*see)(void *context, uint64_t sweeps, struct mpm_residual residual);
    void *see_context;
    struct mpm_profile *profile;
    double phase_began;

    /* The view's arrays. */
    double (*view_velocity)[4], *view_fraction, (*view_node_velocity)[4], (*view_stress)[8];
};

/* points.c: first points of the regions; the pass that carries and deposits all of
 * them (every member calls it; meets at barriers inside). */
enum scree_status points_fill(struct mpm *mpm, const struct mpm_setup *setup, struct scree_error *err);
enum scree_status points_room(struct mpm *mpm, size_t count, struct scree_error *err);
void points_move(struct mpm *mpm, int member);
void points_share(struct mpm *mpm); // cuts the cells into the members' shares

/* assemble.c: nodes and rows of this step from the cells' sums. Member 0 alone
 * numbers rows; the others wait at a barrier. */
void assemble(struct mpm *mpm, int member);
void assemble_floor_force(const struct mpm *mpm, double force[3]); // on the floor, N, once the step is solved
double assemble_overfull(const struct mpm *mpm);                   // material beyond what nodes can hold, m3

/* rigid.c */
double rigid_way(const struct mpm_body *body, double time, int axis); // how far it has moved, m
bool rigid_sticks(const struct mpm *mpm, const int place[3],
                  double velocity[3]);                              // is the node held by a wall, and how does that move?
bool rigid_floor(const struct mpm *mpm, const int place[3]);        // is it on the floor?
double rigid_room(const struct mpm *mpm, const int place[3]);       // what material may take at a node, m3
void rigid_contacts(struct mpm *mpm);                               // lists the contacts of this step's rows, warm
size_t rigid_contacts_most(const struct grid *grid, size_t bodies); // how many there can ever be

/* mpm.c: the world of a set-up, without points. */
enum scree_status mpm_start(const struct mpm_setup *setup, struct mpm **out, struct scree_error *err);

/* gauss_seidel.c: solves the field; every member calls it. */
void gauss_seidel(struct mpm *mpm, int member);

/* rigid.c: gravity of the next step where the box is tilted. */
void rigid_tilt(struct mpm *mpm);

/* step.c */
void mpm_clock(struct mpm *mpm, int member, enum mpm_phase phase); // adds the time since the last call
size_t member_share(size_t count, int member, int members);        // first of `count` things that a member takes

#endif
