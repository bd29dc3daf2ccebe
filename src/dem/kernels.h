/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The loops of a step that do not depend on the law, compiled per instruction
 * set and chosen once at the start. */
#ifndef SCREE_DEM_KERNELS_H
#define SCREE_DEM_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/cpu.h"
#include "dem/law.h"

/* Rigid bodies [from, to) and their rows: see bodies.h for what the arrays are. */
struct body_batch {
    size_t from, to;
    const uint32_t *first;
    double (*centre)[4], (*velocity)[4], (*momentum)[4], (*orientation)[4], (*force)[4], (*torque)[4];
    const double (*inverse)[4], (*offset)[4], (*speed0)[4];
    double (*place)[4], (*speed)[4], (*spin)[4], (*arm)[4]; // of rows: position, velocity, ...
    double (*load)[4], (*twist)[4];
    double *strayed2;
    double kick[3], step; // gravity's, m/s; s
};

struct kernels {
    /* Gravity's kick and the drift of rows [from, to): v += kick, x += dt v. */
    void (*drift)(double (*position)[4], double (*velocity)[4], size_t from, size_t to, const double kick[3], double dt);
    /* Which pairs of the hot list touch now: updates the bits, clears the history
     * of new contacts, writes the near pairs that touch in ascending order and,
     * where `ended` is given, those that stopped. Returns how many touch. */
    size_t (*touch)(const struct pair_batch *pairs, const double *reach2, size_t count, uint64_t *touching, uint32_t *active,
                    uint32_t *ended, size_t *ended_count);
    /* Kicks both grains of each touching pair whose rows lie in [from, to);
     * grains keep what strays from velocity0 in strayed2. */
    void (*kick)(const struct pair_batch *pairs, double (*velocity)[4], double (*spin)[4], double (*velocity0)[4], size_t from,
                 size_t to, double strayed2[4]);
    /* Kick, drift and free turn of bodies, and what follows for their rows. */
    void (*bodies_drift)(const struct body_batch *bodies);
    /* Sums what members were loaded with, which is then unloaded; kicks velocity and angular momentum. */
    void (*bodies_gather)(const struct body_batch *bodies);
    /* Of outer pairs [0, count): those that come within reach + 2 stray during
     * `horizon` seconds of straight flight. Returns how many were written. */
    size_t (*approach)(const struct pair_batch *pairs, size_t count, double horizon, double stray, uint32_t *kept);
};

void bodies_drift_v2(const struct body_batch *bodies);
void bodies_drift_v3(const struct body_batch *bodies);
void bodies_drift_v4(const struct body_batch *bodies);
void bodies_gather_v2(const struct body_batch *bodies);
void bodies_gather_v3(const struct body_batch *bodies);
void bodies_gather_v4(const struct body_batch *bodies);

extern const struct kernels kernels_v2, kernels_v3, kernels_v4;
const struct kernels *kernels_for(enum cpu_isa isa);

#endif
