/* SPDX-License-Identifier: GPL-3.0-or-later */
/* From what is known of a contact to what the law takes (seed 001, II.C.2 and A.2). */
#ifndef SCREE_CONVEX_CONTACT_PARAMETERS_H
#define SCREE_CONVEX_CONTACT_PARAMETERS_H

#include "base/status.h"

struct contact_body {
    double mass, radius, inertia; // kg, m, kg m2 about a rolling axis; a wall has mass and inertia INFINITY
};
struct contact_wanted {
    struct contact_body a, b;
    double overlap, speed;             // largest overlap, at an impact of that speed, m, m/s
    double restitution, restitution_t; // e_n, e_t, in (0, 1]
    double rolling_friction;           // mu_r
    double steps;                      // a contact should take
};
struct contact_parameters {
    double mass;                    // m_ij, kg
    double stiffness, damping;      // k_n (eq. 16), N/m; eta_n (eq. 17), N s/m
    double stiffness_t, damping_t;  // k_t (eq. 18), N/m; eta_t (eq. 19), N s/m
    double stiffness_r, damping_r;  // k_r, N m; eta_r, N m s (A9, with the reduced radius, as the published code)
    double frequency, rate, rate_t; // omega_0; gamma_n = eta_n / 2 m_ij, gamma_t likewise, 1/s
    double duration, step;          // T_c (eq. 12) and T_c / steps, s
};

/* Refuses a value outside its range, by name. */
enum scree_status contact_parameters_find(const struct contact_wanted *wanted, struct contact_parameters *out,
                                          struct scree_error *err);

/* The rest, from a stiffness, N/m, that is given: `overlap` and `speed` are not looked at. */
enum scree_status contact_parameters_of_stiffness(const struct contact_wanted *wanted, double stiffness,
                                                  struct contact_parameters *out, struct scree_error *err);

/* Largest overlap at an impact of `speed`, m (eqs 13-15). */
double contact_parameters_overlap(const struct contact_wanted *wanted, double stiffness, double speed);

/* Stiffness by Hertz's theory between two like bodies of modulus `young`, Pa, and Poisson's ratio (eq. 10), N/m. The
 * paper's own example, 6.37e8 N/m for steel, is not what this gives: 7.7e7 for R = 1 mm. */
double contact_parameters_hertz(double young, double poisson, double reduced_radius);

#endif
