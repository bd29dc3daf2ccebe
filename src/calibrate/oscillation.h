/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The decaying oscillation of a grain that rocks (seed 000 eq. 27):
 *     u = u_0 sin(phi_0 + w t) exp(-g t),   w^2 = K - g^2,  g = beta_r K / 2,
 * with K the rolling stiffness over the inertia that takes part. The paper prints + g^2 under the root; it is -. */
#ifndef SCREE_CALIBRATE_OSCILLATION_H
#define SCREE_CALIBRATE_OSCILLATION_H

#include <stdbool.h>
#include <stddef.h>

struct oscillation {
    double rate, decay;  // w, rad/s; g, 1/s
    double cosine, sine; // u = exp(-g t) (cosine cos w t + sine sin w t)
    double misfit;       // root mean square of the residuals over that of u
};

/* Least squares over `count` samples `interval` s apart, from t = 0. False where there are not three half periods to fit. */
bool oscillation_fit(const double *u, size_t count, double interval, struct oscillation *out);

#endif
