/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Plain Drucker-Prager: one coefficient, at rest and in flow (seed 002, eq. 2.4). */
#include "mpm/law.h"

static double friction(const struct mpm_law_coefs *coefs, double inertial)
{
    (void)inertial;
    return coefs->mu;
}

const struct mpm_law mpm_law_constant = {"constant", "one friction coefficient, the avalanche angle's", "seed 002, eq. 2.4",
                                         friction};
