/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of kinds of worlds; one line each. */
#include "world/kind.h"

static const struct world_kind *const all[] = {&world_kind_dem, &world_kind_mpm, &world_kind_convex, &world_kind_calculation};

struct world_making world_making_of(const struct job_spec *job, const struct scree_options *options)
{
    const struct scree_options none = {0}, *o = options ? options : &none;
    return (struct world_making){.isa = o->isa, .threads = o->threads > 0 ? o->threads : (int)job->threads, .meshes = o->meshes};
}

const struct world_kind *world_kind_find(const struct job_spec *job)
{
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (all[k]->kind == job->scenario->kind && all[k]->knows(job))
            return all[k];
    return NULL;
}

enum scree_status scree_job_check(const struct job_spec *job, const struct scree_options *options, struct scree_error *err)
{
    const struct world_kind *kind = world_kind_find(job);
    const struct world_making making = world_making_of(job, options);
    return kind && kind->check ? kind->check(job, &making, err) : SCREE_OK;
}
