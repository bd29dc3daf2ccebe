/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `chute`: the apparatus of seed 003. What is not printed there (the
 * section's floor and sides, guards, how the gate goes) is ours: protocols 4. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/law.h"
#include "scenario/fragments.h"
#include "scenario/own_mesh.h"
#include "scenario/scenario.h"

static const struct chute_params *params_of(const struct job_spec *job)
{
    return (const struct chute_params *)(const void *)job->params;
}

static void chute_gravity(const struct job_spec *job, double gravity[3])
{
    gravity[0] = gravity[1] = 0;
    gravity[2] = -params_of(job)->gravity_m_s2;
}

static void chute_base(const struct job_spec *job, double *z, double *area_m2)
{
    *z = 0;
    *area_m2 = params_of(job)->run_m * params_of(job)->width_m; // so that verdicts are looked for
}

static double chute_grain(const struct job_spec *job)
{
    return params_of(job)->size_m;
}

static enum scree_status chute_release(const struct job_spec *job, double (**place)[4], size_t *count, struct scree_error *err)
{
    struct clump shapes[FRAGMENT_SHAPES];
    struct dem_body *bodies = NULL;
    enum scree_status status = fragments_fill(job, shapes, &bodies, count, err);
    *place = NULL;
    if (status)
        return status;
    if (!(*place = memory_rows(*count, sizeof **place)))
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu fragments", *count);
    for (size_t k = 0; k < *count && !status; k++) {
        memcpy((*place)[k], bodies[k].position, sizeof bodies[k].position);
        (*place)[k][3] = shapes[bodies[k].shape].mass;
    }
    free(bodies);
    return status;
}

static struct chute chute_shape(const struct job_spec *job)
{
    return fragments_chute(job);
}

static double lowest(const struct trimesh *mesh)
{
    double low[3], high[3];
    trimesh_bounds(mesh, low, high);
    return low[2];
}

static enum scree_status chute_build(const struct job_spec *job, const struct scenario_means *means, struct dem **out,
                                     struct scree_error *err)
{
    const struct chute_params *p = params_of(job);
    const struct chute chute = fragments_chute(job);
    struct clump shapes[FRAGMENT_SHAPES];
    struct dem_body *bodies = NULL;
    struct trimesh *mesh = NULL, *gate = NULL;
    uint8_t *partner = NULL, gate_partner[8];
    size_t count;
    enum scree_status status = fragments_fill(job, shapes, &bodies, &count, err);
    if (!status)
        status = p->mesh.on ? own_mesh_read(job, means, &mesh, &partner, err) : chute_mesh(&chute, &mesh, &partner, err);
    if (status || (status = chute_gate(&chute, &gate, err)))
        goto out;
    for (size_t t = 0; t < mesh->triangles; t++)
        partner[t] = partner[t] && p->accelerator == ACCELERATOR_GATE ? FRAGMENT_GATE : FRAGMENT_CHUTE;
    memset(gate_partner, FRAGMENT_GATE, sizeof gate_partner);
    double slope = chute_slope(&chute, 0),
           travel = chute.guard + 0.5 * (chute.width - chute.floor) * tan(chute.side_rad) + p->size_m;
    const struct dem_surface surfaces[2] = {{.mesh = mesh, .partner = partner, .until_s = INFINITY, .base = true},
                                            {.mesh = gate,
                                             .partner = gate_partner,
                                             .velocity = {p->gate_m_s * sin(slope), 0, p->gate_m_s * cos(slope)},
                                             .until_s = p->gate_m_s > 0 ? travel / p->gate_m_s : 0}};
    struct dem_setup setup = {.law = &law_hertz_tsuji,
                              .matter = &job->fragments,
                              .step_s = job->time.step_s,
                              .shapes = shapes,
                              .shape_count = FRAGMENT_SHAPES,
                              .bodies = bodies,
                              .body_count = count,
                              .surfaces = surfaces,
                              .surface_count = p->gate_m_s > 0 ? 2 : 1,
                              .floor_z = lowest(mesh) - 0.5 * p->size_m,
                              .threads = means->threads,
                              .isa = means->isa,
                              .ledger = job->record.energy.on};
    chute_gravity(job, setup.gravity);
    status = dem_create(&setup, out, err);
out:
    trimesh_free(mesh);
    trimesh_free(gate);
    free(partner);
    free(bodies);
    return status;
}

const struct scenario scenario_chute = {.name = "chute",
                                        .check = own_mesh_check,
                                        .build = chute_build,
                                        .gravity = chute_gravity,
                                        .base = chute_base,
                                        .law = &law_hertz_tsuji,
                                        .grain = chute_grain,
                                        .release = chute_release,
                                        .chute = chute_shape};
