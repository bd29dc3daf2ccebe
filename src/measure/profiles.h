/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Profiles along the base's normal (seed 000 S5): from sums over time to numbers.
 *
 * T (eq. 37) is about the mean velocity at the height sampled, so the shear within
 * the kernel counts as agitation: where u_x = g z, T is too large by g^2 d^2 / 12
 * (the kernel's variance d^2/4, a third of it). It stays in, as published. */
#ifndef SCREE_MEASURE_PROFILES_H
#define SCREE_MEASURE_PROFILES_H

#include "measure/coarse.h"
#include "view.h"

/* Sums: how many samples, over how long, then for each height these. */
enum { PROFILES_SAMPLES, PROFILES_TIME, PROFILES_HEAD };
enum {
    PROFILES_VOLUME,     // w V, K = 3, moving grains
    PROFILES_VX,         // w V u
    PROFILES_SPEED2 = 4, // w V |u|^2
    PROFILES_ALL,        // w, K infinite, grains of the base too
    PROFILES_JOINED,     // w of those joined to the base
    PROFILES_IMPACTS,    // w, K infinite, collisions
    PROFILES_NORMAL2,    // w dn^2
    PROFILES_TANGENTIAL2,
    PROFILES_SUMS
};

/* One height; 0 where there is nothing. */
struct profile {
    double z;                    // m
    double fraction;             // phi
    double velocity[3];          // u, m/s
    double temperature;          // T, m2/s2
    double impacts;              // n_I, 1/(m3 s)
    double normal2, tangential2; // <dn^2>, <|dt|^2>, m2/s2
    double joined;               // P_C
};
enum { PROFILE_COLUMNS = 10 };

static inline size_t profiles_width(const struct coarse_grid *grid)
{
    return PROFILES_HEAD + PROFILES_SUMS * grid->count;
}

/* One sample: grains whose y is in [region[0], region[1]); root as of connect_base. */
void profiles_add_view(const struct coarse_grid *grid, const double region[2], const struct view *view, const uint32_t *root,
                       double *sums);
/* Collisions; the time that they happened in is the caller's to add. */
void profiles_add_formations(const struct coarse_grid *grid, const double region[2], const struct view_formation *formations,
                             size_t count, double *sums);

/* What the sums amount to at every height. */
void profiles_of(const struct coarse_grid *grid, const double *sums, struct profile *out);

/* What a flow's profiles amount to over its depth (protocols 1.11). */
struct profile_bulk {
    double h1;          // twice the height of the centre of mass over the base, m
    double h2;          // height over the base where phi falls to half its value at h1 / 2, m
    double fraction;    // means over 0 < z - base < h1: phi
    double velocity;    // u_x, m/s
    double temperature; // T, m2/s2
    double pressure;    // on the base, of all the weight above it, Pa
    double inertial;    // from the mean velocity, as if the profile were Bagnold's
    double local;       // u' d sqrt(rho / p) at h1 / 2
    double shear;       // g_T: sqrt(T) over |u'| d, least squares over the depth
};
/* `gravity_normal` is its size along the base's normal, m/s2. All zero where nothing flows. */
void profiles_bulk(const struct coarse_grid *grid, const struct profile *profile, double base_z, double density,
                   double gravity_normal, struct profile_bulk *out);

/* Value of a field at height z, linear between heights; `offset` of a double in struct profile. */
double profiles_at(const struct coarse_grid *grid, const struct profile *profile, size_t offset, double z);

#endif
