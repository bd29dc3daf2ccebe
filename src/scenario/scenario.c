/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of set-ups; one line each. */
#include "scenario/scenario.h"

#include <string.h>

extern const struct scenario scenario_incline, scenario_channel, scenario_collision, scenario_chute, scenario_gas, scenario_rolling;

static const struct scenario *const all[] = {&scenario_incline, &scenario_channel, &scenario_collision,
                                             &scenario_chute,   &scenario_gas,     &scenario_rolling};

const struct scenario *scenario_implementation(const char *name)
{
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (strcmp(all[k]->name, name) == 0)
            return all[k];
    return NULL;
}
