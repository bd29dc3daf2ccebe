/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world of discrete grains.
 *
 * Rows of four doubles, moving grains first. Two-level pair lists find the
 * contacts, the law turns them into forces in blocks, each grain adds up its own
 * contacts in a fixed order. Lists, slices, threads and instruction set never
 * change a bit of the result: see README.md in this folder for why. */
#ifndef SCREE_DEM_DEM_H
#define SCREE_DEM_DEM_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "geom/clump.h"
#include "spec/spec.h"
#include "view.h"

struct dem;

/* Rows are sorted anew every so many steps, which takes memory for a moment; other steps take none once warm. */
enum { DEM_REORDER_STEPS = 1 << 14 };

struct dem_grain {
    double position[3], velocity[3], spin[3]; // m, m/s, rad/s, at t = 0
    double radius, density;                   // m, kg/m3
    bool fixed;
};

/* A rigid body of one of the setup's shapes. */
struct dem_body {
    double position[3], velocity[3], spin[3]; // of its centre of mass, m, m/s; in space, rad/s; at t = 0
    double orientation[4];                    // unit quaternion w, x, y, z: own axes into space
    uint32_t shape;
};

/* A plane that grains touch from the side its normal points to. */
struct dem_wall {
    double point[3], normal[3]; // normal of unit length
    bool base;                  // its force counts as force on the base
    int partner;                // kind of partner that it is to grains, below LAW_PARTNERS (law.h)
};

/* A wall of triangles, touched from both sides. It stands still, or slides at a
 * constant velocity from an instant on, and is gone after another. */
struct dem_surface {
    const struct trimesh *mesh; // copied
    const uint8_t *partner;     // by triangle, as in struct dem_wall; NULL: 0
    double velocity[3];         // m/s
    double from_s, until_s;     // INFINITY: stays
    bool base;
};

struct law;

struct dem_setup {
    const struct law *law; // NULL: hertz-mindlin-rolling
    const void *matter;    // the law's material; NULL: `material` below
    double step_s;
    double gravity[3];
    double length[3]; // periodic lengths from 0; 0: unbounded along that axis
    const struct dem_grain *grains;
    size_t grain_count;
    /* Rigid bodies: with any, every grain above must be fixed. Ids of their members
     * follow those of the grains, body by body. */
    const struct clump *shapes;
    size_t shape_count;
    const struct dem_body *bodies;
    size_t body_count;
    const struct dem_wall *walls;
    size_t wall_count;
    const struct dem_surface *surfaces; // only where nothing is periodic
    size_t surface_count;
    double base_y[2];              // the force on the base is of contacts whose y is in [from, to), m; {0, 0}: of all
    struct material_spec material; // of grains and walls
    double floor_z;                // a moving grain whose centre is below is through the base: blow-up; -INFINITY: no such limit
    int threads;                   // at least 1
    const char *isa;               // NULL: the best there is
    bool overlaps;                 // grains may overlap at the start (a state read from a file)
    bool ledger;                   // keep the dissipated energies (contacts cost a third more)
};

/* Builds the world and evaluates the forces at t = 0. Copies what it needs.
 * SCREE_INVALID when two grains overlap at the start. */
enum scree_status dem_create(const struct dem_setup *setup, struct dem **out, struct scree_error *err);
void dem_free(struct dem *dem);

/* Does exactly `steps` time steps, or fails with SCREE_BLOWUP (step, grain, last
 * good time) at the step examined; blow-up is looked for every 64 steps. */
enum scree_status dem_advance(struct dem *dem, uint64_t steps, struct scree_error *err);

uint64_t dem_step(const struct dem *dem);
double dem_time(const struct dem *dem);
size_t dem_moving(const struct dem *dem);
size_t dem_fixed(const struct dem *dem);
size_t dem_units(const struct dem *dem); // bodies where there are any, else moving grains
const char *dem_isa(const struct dem *dem);

/* Mean force of the flow on the base over the steps since the last call (or
 * since t = 0, the force at t = 0 excluded), N; each step counts once. */
void dem_take_base_force(struct dem *dem, double mean[3]);

/* Fills *view. Costs a pass over grains and contacts; the view's arrays belong to the world. */
enum scree_status dem_view(struct dem *dem, struct view *view, struct scree_error *err);

/* From now on contacts that form are logged: pairs and planes, in one order on any number of threads. The caller takes
 * them now and then; what it gets is valid until the world is advanced. An image does not hold them. */
void dem_log_formations(struct dem *dem, bool on);
size_t dem_take_formations(struct dem *dem, const struct view_formation **formations);

/* Steering: takes effect with the next step. */
void dem_set_gravity(struct dem *dem, const double gravity[3]);
/* The same for what the material says of contacts (not radii and densities: grains have theirs). */
void dem_set_material(struct dem *dem, const void *matter); // the struct that its law takes

/* Over positions, velocities, spins (at their half steps) and contact histories, by grain id. */
uint64_t dem_hash(const struct dem *dem);

/* What the lists and the last step hold, for reports: pairs, and how often lists were made. */
struct dem_counts {
    size_t contacts, hot, near, outer;
    uint64_t refreshes, rebuilds;
};
struct dem_counts dem_counts(const struct dem *dem);

/* Where the time of member 0 goes while a profile is taken, in processor ticks. */
enum dem_phase { DEM_INTEGRATE, DEM_LISTS, DEM_SEARCH, DEM_LAW, DEM_GATHER, DEM_MEASURE, DEM_PHASES };
struct dem_profile {
    uint64_t ticks[DEM_PHASES];
};
/* From now on ticks are added to *profile, which the caller keeps; NULL ends it. */
void dem_profile(struct dem *dem, struct dem_profile *profile);

/* Bytes a world of that size takes, for refusals before building it. */
double dem_bytes(double moving, double fixed);

#endif
