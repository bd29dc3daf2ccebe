/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The law `spring-dashpot-memory`: linear spring and dashpot, Coulomb friction and
 * rolling resistance, each with a memory (seed 001, eqs 5-8 and A1-A5).
 *
 * Everything is said of body a, which touches b: the normal points from a to b,
 * relative motions are a's less b's at the point of contact, results act on a;
 * b has the opposite. */
#ifndef SCREE_CONVEX_LAW_SPRING_MEMORY_H
#define SCREE_CONVEX_LAW_SPRING_MEMORY_H

#include <stdbool.h>

#include "base/vec3.h"

/* What one pair of bodies goes by. */
struct spring_pair {
    double stiffness, damping;     // k_n, N/m; eta_n = 2 m_ij gamma_n, N s/m
    double stiffness_t, damping_t; // k_t, N/m; eta_t, N s/m
    double friction;               // mu_c
    double stiffness_r, damping_r; // k_r, N m; eta_r, N m s
    double rolling_friction;       // mu_r
    double radius;                 // R_ij = R_i R_j / (R_i + R_j), m
    bool clamp;                    // normal forces never pull: eq. 5's max(., 0), which the published code has not
};

/* What a contact remembers between steps; all zero before its first. */
struct spring_memory {
    struct vec3 slip;   // delta_t of eq. 8, across `normal`, m
    struct vec3 torque; // M_k of eq. A2, across `normal`, N m
    struct vec3 normal; // of the last step
};

struct spring_motion {
    double overlap;       // delta_n, m
    struct vec3 normal;   // from a to b, unit length
    struct vec3 velocity; // of a's surface against b's, m/s
    struct vec3 spin;     // of a against b, rad/s
};

struct spring_result {
    struct vec3 force;  // on a at the point of contact, N
    struct vec3 torque; // on a beyond that force's, N m
    double normal;      // component of the force that pushes apart, N
    bool slides, rolls; // friction, rolling resistance at their limits
};

/* Turns the memory into the plane across `normal`. */
void spring_memory_turn(struct spring_memory *memory, struct vec3 normal);

/* One step of step_s, s; the memory becomes that of the step's end. */
struct spring_result spring_memory_step(const struct spring_pair *pair, const struct spring_motion *motion, double step_s,
                                        struct spring_memory *memory);

#endif
