/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Friction that is larger at rest (seed 002, eq. 6.1): mu + dmu (1 - I/I*) below
 * I*, mu above. The published code has a step instead of the ramp: mu + dmu
 * below I*. Both are offered, since the figures come from the code. */
#include "mpm/law.h"

static double ramp(const struct mpm_law_coefs *coefs, double inertial)
{
    return inertial < coefs->inertial_star ? coefs->mu + coefs->delta_mu * (1 - inertial / coefs->inertial_star) : coefs->mu;
}

static double step(const struct mpm_law_coefs *coefs, double inertial)
{
    return inertial < coefs->inertial_star ? coefs->mu + coefs->delta_mu : coefs->mu;
}

const struct mpm_law mpm_law_hysteretic_ramp = {"hysteretic", "larger friction at rest, falling linearly with I",
                                                "seed 002, eq. 6.1", ramp};
const struct mpm_law mpm_law_hysteretic_step = {"hysteretic-step", "larger friction below I*, as in the published code",
                                                "seed 002, section 6, published code", step};
