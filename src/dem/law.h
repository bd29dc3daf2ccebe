/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a contact law is to the step: a descriptor and, per instruction set, one
 * function that takes a list of touching pairs and writes their forces.
 *
 * Bodies are called 1 and 2; the normal points from 1 to 2; forces are of 1 on
 * 2. A law is called per list, never per contact. To add one: a file with its
 * coefficients, its lanes and its plain reference, and a line in law_list. */
#ifndef SCREE_DEM_LAW_H
#define SCREE_DEM_LAW_H

#include <stddef.h>
#include <stdint.h>

#include "base/cpu.h"
#include "spec/spec.h"

/* One row per near pair: what the contact remembers, and what about the pair
 * never changes. All zero history is a fresh contact. */
enum contact_slot {
    CONTACT_FT_X, // elastic tangential force F_te of 1 on 2, N
    CONTACT_FT_Y,
    CONTACT_FT_Z,
    CONTACT_MN,   // elastic torsional torque M_ne, N m
    CONTACT_MR_X, // elastic rolling torque M_re, N m
    CONTACT_MR_Y,
    CONTACT_MR_Z,
    CONTACT_FN, // |F_n| of the last step, N
    CONTACT_A,  // sqrt(r overlap) of the last step: the radius of the contact area, m
    CONTACT_R,  // effective radius (eq. 3), m
    CONTACT_R1, // radius of body 1, m
    CONTACT_R2, // radius of body 2, m; 0 for a wall
    CONTACT_SLOTS
};
enum { CONTACT_HISTORY = CONTACT_R }; // slots before this one are history

/* What the law says of one contact at one step. */
struct contact_out {
    double force[4];   // of 1 on 2, N; [3] is 0
    double torque1[4]; // on 1, N m; [3] is 0
    double torque2[4]; // on 2, N m; [3] is 0
};

/* Energy lost in one contact during one step, J. */
struct contact_loss {
    double normal, tangential, torsion, rolling;
};

/* Coefficients of the law for one kind of contact, derived from a material. What
 * they are is each law's business; these are those of hertz-mindlin-rolling. */
struct law_coefs {
    double normal;     // 2 E / 3 (1 - nu^2) of eq. 5, Pa
    double tangential; // 4 G / (2 - nu) of eq. 7, Pa
    double torsion;    // 16 G / 3 of eq. 14, Pa
    double rolling;    // 2 kappa of eq. 22
    double beta;       // s
    double beta_r;     // s
    double mu_t, mu_n, mu_r;
    double step;  // s
    double least; // no normal force below this, N: 0 or -INFINITY
};

/* Everything a kernel reads and writes about pairs of grains. */
struct pair_batch {
    const double (*position)[4];
    const double (*velocity)[4];
    const double (*spin)[4];
    const double (*arm)[4];   // from the centre of mass of a grain's body to its own centre, m; 0 for a free grain
    const double (*shift)[4]; // by image code
    const uint32_t *first;    // per near pair: row of grain 1
    const uint32_t *second;   // row of grain 2 and image code
    const uint32_t *near;     // of a sub-list: where its pairs are in the list that owns `contact`
    double (*contact)[CONTACT_SLOTS];
    const uint32_t *active; // touching pairs, ascending
    size_t active_count;
    struct contact_out *out;   // one a touching pair
    struct contact_loss *loss; // likewise, or NULL where no ledger is kept
};

/* A grain and a wall that are near. */
struct wall_pair {
    uint32_t grain, wall; // for walls of triangles: the surface
    int touching;
    int partner;
    double normal[3]; // out of the grain, into the wall
    double overlap;   // at this step, m; meaningful while touching
    double approach;  // rate of overlap, m/s
    double contact[CONTACT_SLOTS];
    struct contact_out out;
    struct contact_loss loss;
};

struct law {
    const char *name, *doc, *source;
    /* Coefficients of a grain's contact with a partner: 0 is another grain, others are
     * kinds of wall that the material names. `material` is the struct of the law's own table. */
    void (*coefs)(const void *material, int partner, double step_s, struct law_coefs *out);
    /* Forces of all touching pairs, one kernel per instruction set. */
    void (*pairs[CPU_ISA_COUNT])(const struct law_coefs *coefs, const struct pair_batch *batch);
    /* The same in plain scalar C: what the kernels must equal to the bit. */
    void (*pairs_reference)(const struct law_coefs *coefs, const struct pair_batch *batch);
    /* One touching wall pair; velocity (over the wall's), spin and arm are the grain's rows. Few, so scalar. */
    void (*wall)(const struct law_coefs *coefs, const double velocity[4], const double spin[4], const double arm[4], int ledger,
                 struct wall_pair *pair);
    /* Energy in the springs of a contact with that history, by spring, J. */
    struct contact_loss (*elastic)(const struct law_coefs *coefs, const double contact[CONTACT_SLOTS], double overlap);
};

extern const struct law law_hertz_rolling, law_hertz_tsuji;

enum { LAW_PARTNERS = 4 }; // kinds of partner that a material may name, grains included

/* second = row | image code << IMAGE_SHIFT: x + 5 y + 25 z with x, y, z in -2..2, plus 62. */
enum { IMAGE_SHIFT = 25, IMAGE_ROW = (1 << IMAGE_SHIFT) - 1, IMAGE_REACH = 2, IMAGE_BASE = 5, IMAGE_CODES = 125, IMAGE_NONE = 62 };

#endif
