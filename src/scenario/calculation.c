/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of calculations; one line each. */
#include "scenario/calculation.h"

#include <assert.h>
#include <string.h>

extern const struct calculation calculation_damping, calculation_plastic_yield, calculation_contact_parameters;

static const struct calculation *const all[] = {&calculation_damping, &calculation_plastic_yield, &calculation_contact_parameters};

const struct calculation *calculation_find(const char *name)
{
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (strcmp(all[k]->name, name) == 0)
            return all[k];
    return NULL;
}

void calculation_put(struct calculation_result *out, const struct scree_number *numbers, size_t count)
{
    assert(count <= CALCULATION_NUMBERS_MAX);
    memcpy(out->numbers, numbers, count * sizeof *numbers);
    out->count = count;
}
