/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walls of triangles in images: the surfaces themselves, and every contact as it
 * stands, for contacts with meshes live beside the lists. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/mesh.h"

enum scree_status mesh_save(const struct dem *dem, struct dem_image *image, struct scree_error *err)
{
    struct dem_scalars *n = &image->scalars;
    size_t count = dem->mesh ? dem->mesh->count : 0, contacts;
    for (size_t k = 0; k < count; k++) {
        n->vertices += dem->mesh->surface[k].mesh->vertices;
        n->triangles += dem->mesh->surface[k].mesh->triangles;
    }
    n->surfaces = count;
    image->surface = memory_rows(count, sizeof *image->surface);
    image->vertex = memory_rows(n->vertices, sizeof *image->vertex);
    image->corner = memory_rows(n->triangles, sizeof *image->corner);
    image->partner = memory_rows(n->triangles, sizeof *image->partner);
    if (!image->surface || !image->vertex || !image->corner || !image->partner)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image of %zu walls", count);
    size_t v = 0, t = 0;
    for (size_t k = 0; k < count; k++) {
        const struct surface *s = &dem->mesh->surface[k];
        struct dem_surface_head *head = &image->surface[k];
        *head = (struct dem_surface_head){s->mesh->vertices, s->mesh->triangles, s->base, {0}, s->from_s, s->until_s};
        memcpy(head->velocity, s->velocity, sizeof head->velocity);
        memcpy(image->vertex + v, s->mesh->vertex, s->mesh->vertices * sizeof *image->vertex);
        memcpy(image->corner + t, s->mesh->corner, s->mesh->triangles * sizeof *image->corner);
        memcpy(image->partner + t, s->partner, s->mesh->triangles);
        v += s->mesh->vertices;
        t += s->mesh->triangles;
    }
    enum scree_status status = mesh_take(dem, &image->mesh_pair, &contacts, err);
    n->mesh_contacts = contacts;
    return status;
}

/* Contacts name grains and surfaces that exist. */
static bool pairs_are_sound(const struct dem_image *image)
{
    for (size_t k = 0; k < image->scalars.mesh_contacts; k++) {
        const struct wall_pair *pair = &image->mesh_pair[k];
        if (pair->grain >= image->scalars.moving || pair->wall >= image->scalars.surfaces || pair->partner < 0 ||
            pair->partner >= LAW_PARTNERS)
            return false;
    }
    return true;
}

enum scree_status mesh_load(struct dem *dem, const struct dem_image *image, struct scree_error *err)
{
    size_t count = image->scalars.surfaces, v = 0, t = 0;
    if (count == 0)
        return SCREE_OK;
    enum scree_status status = SCREE_OK;
    struct dem_surface *surfaces = memory_rows(count, sizeof *surfaces);
    struct trimesh **meshes = memory_rows(count, sizeof *meshes);
    if (!surfaces || !meshes)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu walls", count);
    for (size_t k = 0; k < count && !status; k++) {
        const struct dem_surface_head *head = &image->surface[k];
        if (head->vertices > image->scalars.vertices - v || head->triangles > image->scalars.triangles - t) {
            status = scree_fail(err, SCREE_CORRUPT, NULL, "the image's walls have more triangles than it holds");
            break;
        }
        status = trimesh_create((const double(*)[3])image->vertex + v, head->vertices, (const uint32_t(*)[3])image->corner + t,
                                head->triangles, false, &meshes[k], err);
        surfaces[k] = (struct dem_surface){.mesh = meshes[k],
                                           .partner = image->partner + t,
                                           .velocity = {head->velocity[0], head->velocity[1], head->velocity[2]},
                                           .from_s = head->from_s,
                                           .until_s = head->until_s,
                                           .base = head->base != 0};
        v += head->vertices;
        t += head->triangles;
    }
    if (!status && !pairs_are_sound(image))
        status = scree_fail(err, SCREE_CORRUPT, NULL, "the image's contacts name walls that it does not hold");
    if (!status && !(status = mesh_create(dem, surfaces, count, err)))
        status = mesh_give(dem, image->mesh_pair, image->scalars.mesh_contacts, err);
    for (size_t k = 0; meshes && k < count; k++)
        trimesh_free(meshes[k]);
    free(meshes);
    free(surfaces);
    return status;
}
