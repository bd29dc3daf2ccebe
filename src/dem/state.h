/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world of grains keeps in memory. Private to this folder.
 *
 * Velocities are those of leapfrog: between steps n and n+1 a row holds
 * v(n-1/2) plus the kicks of the contacts at x(n), but not yet gravity's; the
 * next step begins with gravity's kick and the drift. That is velocity Verlet,
 * written so that the step passes over the grains once. */
#ifndef SCREE_DEM_STATE_H
#define SCREE_DEM_STATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "dem/dem.h"
#include "dem/kernels.h"
#include "dem/law.h"

/* A touching pair, taken out of the lists so that it survives their rebuilding.
 * `key` orders contacts: first grain, then image and second grain. */
struct held_contact {
    uint64_t key; // first << 32 | second with its image code; or grain << 32 | wall
    double contact[CONTACT_SLOTS];
};
struct held_list {
    struct held_contact *items;
    size_t count, room;
};

/* Pairs that could touch before the next refresh. Capacity `room` in every array. */
struct near_list {
    uint32_t *first, *second; // row; row | image code << IMAGE_SHIFT
    double *reach2;           // (r1 + r2)^2, m2; -1 in the padding
    double (*contact)[CONTACT_SLOTS];
    uint64_t *touching; // a bit a pair
    size_t count, room;
};

/* Those of the near pairs that could touch within the next few steps: what a
 * step walks. Padded to a multiple of four like the near list. */
struct hot_list {
    uint32_t *first, *second, *near; // as in the near list, and the pair's place there
    double *reach2;
    uint64_t *touching; // a bit a pair; the near list's bits are as of the hot list's making
    size_t count, room;
    uint64_t age, horizon;
    double stray, strayed; // as of the near list
};

/* Contacts that formed. */
struct formed_list {
    struct view_formation *items;
    size_t count, room;
};

/* Grains [from, to) and every pair whose first grain is among them: one member
 * of the team owns each part. Parts are contiguous in memory, and memory follows
 * space, so few pairs have their second grain in another part. */
struct part {
    size_t from, to;
    uint32_t *outer_first, *outer_second; // pairs within reach + skin
    size_t outer_count, outer_room, outer_second_room;
    uint32_t *kept; // scratch of the refresh: which outer pairs are near
    size_t kept_room;
    struct near_list near;
    struct hot_list hot;
    struct wall_pair *walls;
    size_t wall_count, wall_room;
    struct held_list held, held_walls;
    uint32_t *active; // touching near pairs, ascending
    struct contact_out *out;
    struct contact_loss *loss; // NULL without a ledger
    size_t active_count, active_room, out_room, loss_room;
    uint32_t *exports; // touching pairs (index into out) whose second grain lies in a later part
    uint32_t *on_base; // touching pairs (index into out) whose force counts as force on the base
    size_t export_count, export_room, on_base_count, on_base_room;
    struct formed_list formed, formed_walls; // at this step; only where they are logged
    uint32_t *ended;                         // near pairs that stopped touching at this step; with a ledger only
    size_t ended_count, ended_room;
    _Alignas(32) double strayed2[4]; // largest squared change of velocity since the refresh, by component, m2/s2
    double stray;                    // how far grains may leave their straight paths until the refresh, m; the same in every part
    double strayed;             // bound on how far any grain of the world has left its straight path, m; the same in every part
    uint64_t age;               // steps since the refresh; the same in every part
    uint64_t horizon;           // steps that straight paths are followed for; the same in every part
    double change;              // fastest change of velocity seen in the last interval, m/s
    double speed;               // of the fastest grain of the world at the refresh, m/s
    double fastest;             // largest speed of own grains, m/s
    double displaced, off_wall; // their largest way since pairs, and triangles, were listed, m
    size_t lost;                // first own row that blew up; `to`: none did
    bool outside;               // an own grain has left the box by half its length along a periodic axis
    enum scree_status status;
    struct scree_error error;
};

/* How the pair lists are kept; none of it can change a result. */
struct near_plan {
    double skin;      // outer lists hold pairs with a gap below this, m
    double least;     // that it starts from, m
    uint64_t since;   // step of the last rebuild
    double stray;     // a grain may leave its straight path by this until the refresh, m
    uint64_t target;  // steps between refreshes to aim at
    bool stale;       // outer lists are to be rebuilt: positions were wrapped or rows reordered
    double wall_skin; // as of the last listing of triangles, m
    /* Written by member 0 at a refresh, read behind a barrier. */
    bool rebuild, ask_walls; // pairs, triangles are to be listed anew
    uint64_t horizon;        // steps that straight paths are followed for
    double fastest;          // speed of the world's fastest grain, m/s
    enum scree_status status;
    uint64_t refreshes, rebuilds;
    uint64_t near_pairs, outer_pairs; // summed over refreshes and rebuilds, for reports
};

struct cells;
struct bodies;
struct mesh;
struct dem;

/* Where contacts put their kicks: rows whose fourth element turns a force, or a
 * torque, into what is added. Of free grains the rows of velocity and spin
 * themselves; of rigid bodies sums of force and torque by member. */
struct sink {
    double (*linear)[4], (*angular)[4];
    double (*linear0)[4]; // what strays is kept against
    double *strayed2;     // largest squared change by component
};

/* How rows move: by themselves, or as members of rigid bodies. Rows of one unit
 * (a grain, a body) lie side by side and in one part. */
struct motion {
    /* The part's rows: gravity's kick and the drift. */
    void (*drift)(struct dem *dem, struct part *part);
    /* The kicks of the step's contacts: fills a sink by `kick_rows` and does what follows from it. */
    void (*kick)(struct dem *dem, struct part *part);
    /* First row of the unit after the one that a row belongs to. */
    size_t (*next)(const struct dem *dem, size_t row);
    /* Where a row's unit is, for the order in memory, m. */
    const double *(*place)(const struct dem *dem, size_t row);
    /* By how many boxes a row's unit is outside the periodic box; moves what is kept by unit. */
    void (*wrap)(struct dem *dem, int8_t (*boxes)[4]);
    /* Adds the same change to every velocity, m/s. */
    void (*nudge)(struct dem *dem, const double change[3]);
    /* m g.x summed over what moves, J. */
    double (*potential)(const struct dem *dem);
    /* Rows have been permuted: new_row[old]. Whatever is kept by row or unit follows. */
    enum scree_status (*follow)(struct dem *dem, const uint32_t *new_row, struct scree_error *err);
};
extern const struct motion motion_free, motion_bodies;

struct dem {
    const struct law *law;
    const struct motion *motion;
    const struct kernels *kernels;
    enum cpu_isa isa;
    struct law_coefs coefs[LAW_PARTNERS]; // of grains with grains, then with kinds of wall
    double step_s;
    uint64_t step;
    double gravity[3], length[3], floor_z;
    double weight; // size of gravity, m/s2
    double largest_radius;

    size_t moving, grains;  // rows 0 .. moving-1 move, the rest is the base
    double (*position)[4];  // x, y, z, radius
    double (*velocity)[4];  // and dt / mass, 0 for the base
    double (*spin)[4];      // and dt / (smallest) moment of inertia
    double (*arm)[4];       // from the centre of mass of the row's body, m; 0 for free grains
    double (*velocity0)[4]; // of moving grains at the last refresh
    double (*position0)[4]; // of moving grains at the last rebuild of the outer lists
    uint32_t *id;
    double *mass;                              // by row
    _Alignas(32) double shift[IMAGE_CODES][4]; // by image code, read as rows

    struct dem_wall *walls;
    size_t wall_count;
    struct bodies *bodies; // NULL where grains are free
    struct mesh *mesh;     // NULL where no wall is of triangles

    struct team *team;
    struct part *parts;
    int part_count;
    struct near_plan plan;
    struct cells *cells;
    struct dem_profile *profile; // NULL but for a benchmark

    double base_y[2];   // y of contacts whose force counts as force on the base, m: [from, to)
    double base_sum[4]; // force on the base, summed over steps since it was taken, N
    uint64_t base_steps;
    double lost[4];         // dissipated since the start: normal, tangential, torsion, rolling, J
    double wrapped_work;    // m g.L of wraps, J: keeps the potential continuous
    double start_potential; // J
    bool ledger;
    bool logs_formations;
    struct formed_list formed; // since they were taken, in the order of steps

    /* The view's arrays. */
    double (*view_velocity)[4], (*view_spin)[4], (*view_position)[4];
    struct view_contact *view_contacts;
    size_t view_contact_room;
};

/* Steps between two looks at what needs no step-by-step care: blow-up, wrapping, order in memory. */
enum { DEM_HOUSEKEEPING = 64 };

/* dem.c: the steps of making a world. An empty one with zeroed rows; what follows
 * from its rows (`plan`); its first lists. */
enum scree_status dem_start(const struct dem_setup *setup, size_t moving, size_t grains, struct dem **out, struct scree_error *err);
void dem_plan(struct dem *dem);
enum scree_status dem_first_lists(struct dem *dem, struct scree_error *err);

/* near.c. Called by every member after the drift of a step, behind a barrier:
 * whether the lists still hold every pair that touches. */
bool near_complete(struct dem *dem, struct part *part);
/* Makes them so; every member calls it, with barriers inside. */
void near_refresh(struct dem *dem, int member);
/* Member 0 alone, before rows or images change: takes every touching contact out
 * of the lists into *pairs and *walls (owned by the caller) and marks the lists stale. */
enum scree_status near_take(struct dem *dem, struct held_list *pairs, struct held_list *walls, struct scree_error *err);
/* And gives them back, keys already those of the new rows. Sorts them. */
enum scree_status near_give(struct dem *dem, struct held_list *pairs, struct held_list *walls, struct scree_error *err);

/* hot.c. Makes the part's hot list anew if it may have become incomplete. */
void near_heat(struct dem *dem, struct part *part);
/* Room for `need` pairs; brings the near list's bits up to date; fills it from the near list. */
enum scree_status hot_room(struct hot_list *hot, size_t need, struct scree_error *err);
void hot_sync(struct part *part);
void hot_fill(struct dem *dem, struct part *part);

/* order.c. At multiples of DEM_HOUSEKEEPING each member looks at its own grains, then, behind
 * a barrier, member 0 alone does what is needed: blow-up, wrapping, order in memory. */
void order_look(const struct dem *dem, struct part *part);
enum scree_status order_housekeeping(struct dem *dem, struct scree_error *err);
/* Sorts the rows along a space-filling curve. */
enum scree_status order_rows(struct dem *dem, struct scree_error *err);

/* cells.c: the grid that outer lists are built from. */
enum scree_status cells_create(struct cells **out, struct scree_error *err);
void cells_free(struct cells *cells);
/* Sorts all grains into cells at least `width` wide (member 0 alone). */
enum scree_status cells_fill(struct cells *cells, const struct dem *dem, double width, struct scree_error *err);
/* Fills the part's outer lists with pairs whose gap is below `skin`. */
enum scree_status cells_pairs(const struct cells *cells, const struct dem *dem, struct part *part, double skin,
                              struct scree_error *err);

/* formed.c: notes pairs of the part that formed at this step, between search and law; a wall's pair,
 * likewise; member 0 gathers them after the step. */
void formed_pairs(struct dem *dem, struct part *part);
void formed_wall(struct dem *dem, struct part *part, const struct wall_pair *pair);
void formed_gather(struct dem *dem);

/* walls.c */
/* Grains of the part that could touch a wall within `horizon` seconds; carries the part's held walls over. */
enum scree_status walls_near(struct dem *dem, struct part *part, double horizon, double stray, struct scree_error *err);
/* Which of them touch now and with what force; kicks wait for walls_kick. */
void walls_contacts(struct dem *dem, struct part *part);
void walls_kick(struct part *part, const struct sink *sink);

void wall_pair_kick(const struct wall_pair *pair, const struct sink *sink);

/* mesh.c: the same for walls of triangles; nothing where there are none. Triangles within the
 * skin of the part's grains; those that could be touched; contacts; kicks. */
enum scree_status mesh_outer(struct dem *dem, struct part *part, double skin, struct scree_error *err);
enum scree_status mesh_near(struct dem *dem, struct part *part, double horizon, double stray, struct scree_error *err);
void mesh_contacts(struct dem *dem, struct part *part);
void mesh_kick(struct dem *dem, struct part *part, const struct sink *sink);
/* Member 0: force on the base, dissipated energy. */
void mesh_account(struct dem *dem);
/* Member 0: rows have been permuted, and parts cut anew. */
enum scree_status mesh_follow(struct dem *dem, const uint32_t *new_row, struct scree_error *err);

/* Whether a contact at that y counts in the force on the base. */
static inline bool counts_on_base(const struct dem *dem, double y)
{
    return y >= dem->base_y[0] && y < dem->base_y[1];
}
/* Between the centres of grains i and j, where the ratio of their radii puts it. Not across a periodic side: where some y
 * does not count, none is. */
static inline double touch_y(const struct dem *dem, size_t i, size_t j)
{
    const double *a = dem->position[i], *b = dem->position[j];
    return a[1] + (b[1] - a[1]) * a[3] / (a[3] + b[3]);
}

static inline void add_loss(double lost[4], const struct contact_loss *loss)
{
    lost[0] += loss->normal;
    lost[1] += loss->tangential;
    lost[2] += loss->torsion;
    lost[3] += loss->rolling;
}

/* step.c: all kicks of the step's contacts on the part's rows, in their fixed order. */
void kick_rows(struct dem *dem, struct part *part, const struct sink *sink);
/* dem.c: cuts the rows into parts between units. */
void dem_cut(struct dem *dem);
/* view.c: goes on with a hash. */
uint64_t hash_double(uint64_t hash, double value);
/* order.c: by how many boxes a place is outside the periodic box. */
void order_boxes(const struct dem *dem, const double place[3], int8_t boxes[4]);

#endif
