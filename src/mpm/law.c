/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The registry of laws. */
#include "mpm/law.h"

#include <stddef.h>
#include <string.h>

static const struct mpm_law *const laws[] = {&mpm_law_constant, &mpm_law_mu_i, &mpm_law_hysteretic_ramp, &mpm_law_hysteretic_step};

const struct mpm_law *mpm_law_find(const char *name)
{
    for (size_t k = 0; k < sizeof laws / sizeof *laws; k++)
        if (strcmp(laws[k]->name, name) == 0)
            return laws[k];
    return NULL;
}
