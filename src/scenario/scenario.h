/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Set-ups: how a job's params become a world. The user's side of a scenario
 * (name, fields, checks) is in spec/; one file here builds each. */
#ifndef SCREE_SCENARIO_SCENARIO_H
#define SCREE_SCENARIO_SCENARIO_H

#include "dem/dem.h"
#include "geom/chute.h"
#include "spec/spec.h"

/* What building takes beside the job. */
struct scenario_means {
    const char *isa; // NULL: the best there is
    int threads;
    const char *meshes; // folder of the meshes that jobs name, each a file called by its SHA-256; NULL: there are none
};

struct scenario {
    const char *name; // as in scenario_list
    /* Builds the world of a checked job. *out is owned by the caller. */
    enum scree_status (*build)(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                               struct scree_error *err);
    /* Refuses what job_check cannot tell and building would. NULL: nothing. */
    enum scree_status (*check)(const struct job_spec *job, const struct scenario_means *means, struct scree_error *err);
    /* Gravity of the job's params as they now stand, for steering. */
    void (*gravity)(const struct job_spec *job, double gravity[3]);
    /* Height of the nominal top of the base and basal area, for bulk measurements; area 0: none. */
    void (*base)(const struct job_spec *job, double *z, double *area_m2);
    /* What profiles along z are taken of: grains over each point of the base, basal area, and the region of y, [from, to),
     * that counts; both area and region are left as they are where the whole base counts. NULL: no scenario's own. */
    void (*profile)(const struct job_spec *job, size_t *layers, double *area_m2, double region[2]);
    const struct law *law; // that its worlds go by; NULL: hertz-mindlin-rolling
    /* Size of a grain, m; NULL: the material's median diameter. */
    double (*grain)(const struct job_spec *job);
    /* Flows that are let go and come to rest; NULL for others. Where bodies start, by
     * id: x, y, z, mass; owned by the caller. The chute they run down. */
    enum scree_status (*release)(const struct job_spec *job, double (**place)[4], size_t *count, struct scree_error *err);
    struct chute (*chute)(const struct job_spec *job);
};
const struct scenario *scenario_implementation(const char *name);

#endif
