/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See own_mesh.h. */
#include "scenario/own_mesh.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "scenario/fragments.h"

/* A sound mesh and its bounds, m. */
struct found {
    struct mesh_spec spec;
    double low[3], high[3];
};

/* A mesh in other units than was said lies elsewhere, or is as large as no laboratory. */
static enum scree_status check_place(const struct job_spec *job, const struct found *found, struct scree_error *err)
{
    const struct chute chute = fragments_chute(job);
    const double *low = found->low, *high = found->high, most = 100 * (chute.run + chute.accelerator);
    double foot[3], largest = 0;
    bool under = true;
    chute_accelerator_point(&chute, -chute.gate, 0, 0, foot);
    for (int a = 0; a < 3; a++) {
        under &= low[a] <= foot[a] && (a == 2 || high[a] >= foot[a]);
        largest = fmax(largest, high[a] - low[a]);
    }
    if (under && largest <= most)
        return SCREE_OK;
    scree_fail(err, SCREE_INVALID, "params.mesh",
               "params.mesh: it reaches over x %.4g..%.4g, y %.4g..%.4g, z %.4g..%.4g m: not below %.4g, %.4g, %.4g m, "
               "where the gate's foot is, or farther than %.4g m",
               low[0], high[0], low[1], high[1], low[2], high[2], foot[0], foot[1], foot[2], most);
    scree_hint(err, "is params.mesh.unit_m what the file's lengths are in? 0.001 for millimetres");
    return SCREE_INVALID;
}

static enum scree_status find_path(const struct mesh_spec *spec, const char *folder, char path[1200], struct scree_error *err)
{
    if (folder && snprintf(path, 1200, "%s/%s", folder, spec->sha256) < 1200 && access(path, R_OK) == 0)
        return SCREE_OK;
    scree_fail(err, SCREE_INVALID, "params.mesh.sha256", "params.mesh.sha256: there is no mesh %.12s... here", spec->sha256);
    scree_hint(err, "params.mesh.file names a file that scree reads and gives to the daemon");
    return SCREE_INVALID;
}

static enum scree_status read_file(const struct mesh_spec *spec, const char *path, struct trimesh **out, struct scree_error *err)
{
    struct scree_error why = {0};
    enum scree_status status = trimesh_read(path, spec->unit_m, false, out, &why);
    if (!status && spec->closed && (status = trimesh_check_closed(*out, &why))) {
        scree_hint(&why, "params.mesh.closed: false takes sheets, which have a rim");
        trimesh_free(*out);
        *out = NULL;
    }
    if (!status)
        return SCREE_OK;
    scree_fail(err, status, "params.mesh", "params.mesh: %.400s", why.message); // geometry knows no job
    scree_hint(err, "%s", why.hint);
    return status;
}

enum scree_status own_mesh_read(const struct job_spec *job, const struct scenario_means *means, struct trimesh **out,
                                uint8_t **upslope, struct scree_error *err)
{
    const struct mesh_spec *spec = &((const struct chute_params *)(const void *)job->params)->mesh;
    char path[1200];
    struct found found;
    *out = NULL;
    *upslope = NULL;
    enum scree_status status = find_path(spec, means->meshes, path, err);
    if (status || (status = read_file(spec, path, out, err)))
        return status;
    trimesh_bounds(*out, found.low, found.high);
    status = check_place(job, &found, err);
    if (!status && !(*upslope = memory_rows((*out)->triangles, 1)))
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a wall of %zu triangles", (*out)->triangles);
    if (status) {
        trimesh_free(*out);
        *out = NULL;
    }
    for (size_t t = 0; !status && t < (*out)->triangles; t++)
        (*upslope)[t] = chute_upslope(*out, t);
    return status;
}

enum scree_status own_mesh_check(const struct job_spec *job, const struct scenario_means *means, struct scree_error *err)
{
    /* Thousands of a study's trials name one mesh, and reading it each time would take a minute. What a name names never
     * changes, so that what was found last holds. */
    static _Thread_local struct found last;
    const struct mesh_spec *spec = &((const struct chute_params *)(const void *)job->params)->mesh;
    struct trimesh *mesh;
    char path[1200];
    if (!spec->on)
        return SCREE_OK;
    enum scree_status status = find_path(spec, means->meshes, path, err);
    if (status)
        return status;
    if (strcmp(last.spec.sha256, spec->sha256) != 0 || last.spec.unit_m != spec->unit_m || last.spec.closed != spec->closed) {
        if ((status = read_file(spec, path, &mesh, err)))
            return status;
        last.spec = *spec;
        trimesh_bounds(mesh, last.low, last.high);
        trimesh_free(mesh);
    }
    return check_place(job, &last, err);
}
