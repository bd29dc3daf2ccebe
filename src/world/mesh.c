/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes that users bring, looked at before they are kept. */
#include "geom/trimesh.h"
#include "scree.h"

enum scree_status scree_mesh_look(const char *bytes, size_t size, struct scree_mesh *out, struct scree_error *err)
{
    struct trimesh *mesh;
    enum scree_status status = trimesh_parse(bytes, size, 1, false, &mesh, err);
    if (status)
        return status;
    *out = (struct scree_mesh){
        .vertices = mesh->vertices, .triangles = mesh->triangles, .closed = trimesh_check_closed(mesh, NULL) == SCREE_OK};
    trimesh_bounds(mesh, out->low, out->high);
    trimesh_free(mesh);
    return SCREE_OK;
}
