/* SPDX-License-Identifier: GPL-3.0-or-later */
/* mu(I) = mu_stop + (mu_2 - mu_stop) / (1 + I0/I) (seed 002, eq. 4.2): mu_stop at
 * I = 0 and mu_2 as I grows without limit. */
#include "mpm/law.h"

static double friction(const struct mpm_law_coefs *coefs, double inertial)
{
    return coefs->mu + (coefs->mu_2 - coefs->mu) * inertial / (inertial + coefs->inertial0);
}

const struct mpm_law mpm_law_mu_i = {"mu(I)", "friction that grows with the inertial number", "seed 002, eq. 4.2", friction};
