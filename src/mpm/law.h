/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Friction coefficients of the bulk as functions of the inertial number.
 *
 * I = d ||Dev e|| sqrt(rho_I / p) (seed 002, eq. 4.1) with the paper's norm
 * ||t|| = sqrt(t:t / 2): in a simple shear at rate s, ||e|| = s / 2, so this I is
 * half of Jop's (targets, errata of S2). rho_I is the density of the grains in
 * the published code and of the bulk in the paper's text: the set-up says which.
 * I is that of the last step at each node: the coefficient is explicit in time.
 *
 * One law is one file with one descriptor, and one line in law.c. */
#ifndef SCREE_MPM_LAW_H
#define SCREE_MPM_LAW_H

struct mpm_law_coefs {
    double mu;                      // friction coefficient at high (hysteretic), low (mu(I)) or any I
    double mu_2, inertial0;         // mu(I): the limit at high I, and the I half way
    double delta_mu, inertial_star; // hysteretic: what rest adds, and the I at which it is gone
};

struct mpm_law {
    const char *name, *doc, *source;
    double (*friction)(const struct mpm_law_coefs *coefs, double inertial);
};

extern const struct mpm_law mpm_law_constant, mpm_law_mu_i, mpm_law_hysteretic_ramp, mpm_law_hysteretic_step;

/* By name; NULL if there is none. */
const struct mpm_law *mpm_law_find(const char *name);

#endif
