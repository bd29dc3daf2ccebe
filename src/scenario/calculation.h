/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenarios without a world: what follows from a job's params by closed forms or a small equation of motion. They run as
 * jobs and in studies as any other; all that comes of them is numbers of the summary. */
#ifndef SCREE_SCENARIO_CALCULATION_H
#define SCREE_SCENARIO_CALCULATION_H

#include "scree.h"

enum { CALCULATION_NUMBERS_MAX = 32 };

struct calculation_result {
    struct scree_number numbers[CALCULATION_NUMBERS_MAX];
    size_t count;
};

struct calculation {
    const char *name; // as in scenario_list
    enum scree_status (*run)(const struct job_spec *job, struct calculation_result *out, struct scree_error *err);
};
const struct calculation *calculation_find(const char *name);

/* Copies `count` numbers into an empty result. */
void calculation_put(struct calculation_result *out, const struct scree_number *numbers, size_t count);

#endif
