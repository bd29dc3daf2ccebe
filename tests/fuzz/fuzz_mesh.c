/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes that users give: whatever the bytes are, they are a surface with finite bounds or refused in words. */
#include <math.h>

#include "check.h"
#include "scree.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct scree_mesh mesh;
    struct scree_error err = {0};
    if (scree_mesh_look((const char *)data, size, &mesh, &err)) {
        CHECK(err.status == SCREE_INVALID);
        check_text(err.message);
        return 0;
    }
    CHECK(mesh.triangles > 0 && mesh.vertices >= 3);
    for (int a = 0; a < 3; a++)
        CHECK(isfinite(mesh.low[a]) && isfinite(mesh.high[a]) && mesh.low[a] <= mesh.high[a]);
    return 0;
}
