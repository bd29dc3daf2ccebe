/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What calculations share: there is no world to record, and one step does it. */
#include <stdio.h>

#include "spec/scenarios.h"

void calculation_defaults(struct job_spec *job)
{
    job->record.basal_force.on = job->record.bulk.on = false;
    job->time = (struct time_spec){1, 1};
    job->stop.when = 0;
}

struct job_cost calculation_cost(const struct job_spec *job)
{
    (void)job;
    return (struct job_cost){.steps = 1, .bytes = 1e4};
}

enum scree_status calculation_check(const struct job_spec *job, struct scree_error *err)
{
    const struct field_table *record = field_find(&job_table, "record")->table;
    for (size_t k = 0; k < record->count; k++)
        if (record_find(job, record->fields[k].name).on) {
            char path[64];
            snprintf(path, sizeof path, "record.%s", record->fields[k].name);
            return scree_fail(err, SCREE_INVALID, path, "%s: scenario %s is a calculation, without a world to record", path,
                              job->scenario->name);
        }
    return SCREE_OK;
}
