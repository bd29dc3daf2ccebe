/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random sequential insertion over columns of cells: overlap is looked for in
 * the nine columns around a try, each of which keeps its grains in one chain. */
#include "scenario/packing.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

struct columns {
    int count[2];
    double inverse[2];
    size_t layers; // cells stacked in a column; the last takes all above
    double layer_height, floor_z;
    int32_t *head; // newest grain of a cell, or -1
    int32_t *next; // by grain
};

static size_t cell_of(const struct columns *c, const double x[3], const int shift[3])
{
    size_t at[3];
    for (int a = 0; a < 2; a++) {
        int k = (int)(x[a] * c->inverse[a]) + shift[a];
        at[a] = (size_t)((k % c->count[a] + c->count[a]) % c->count[a]);
    }
    double z = floor((x[2] - c->floor_z) / c->layer_height) + shift[2];
    at[2] = z < 0 ? 0 : z >= (double)c->layers ? c->layers - 1 : (size_t)z;
    return (at[2] * (size_t)c->count[1] + at[1]) * (size_t)c->count[0] + at[0];
}

static bool overlaps(const struct columns *c, const struct packing *p, const struct dem_grain *grains,
                     const struct dem_grain *grain)
{
    int low[2], high[2]; // with one or two columns along an axis each is visited once
    for (int a = 0; a < 2; a++) {
        low[a] = c->count[a] > 2 ? -1 : 0;
        high[a] = c->count[a] > 1 ? 1 : 0;
    }
    for (int dz = -1; dz <= 1; dz++)
        for (int dy = low[1]; dy <= high[1]; dy++)
            for (int dx = low[0]; dx <= high[0]; dx++) {
                const int shift[3] = {dx, dy, dz};
                for (int32_t k = c->head[cell_of(c, grain->position, shift)]; k >= 0; k = c->next[k]) {
                    double d2 = 0, reach = grain->radius + grains[k].radius;
                    for (int a = 0; a < 3; a++) {
                        double d = grain->position[a] - grains[k].position[a];
                        if (a == 0 || (a == 1 && !p->between))
                            d -= p->length[a] * round(d / p->length[a]);
                        d2 += d * d;
                    }
                    if (d2 < reach * reach)
                        return true;
                }
            }
    return false;
}

static void link_grain(struct columns *c, const struct dem_grain *grain, int32_t index)
{
    const int here[3] = {0, 0, 0};
    size_t cell = cell_of(c, grain->position, here);
    c->next[index] = c->head[cell];
    c->head[cell] = index;
}

static enum scree_status columns_make(struct columns *c, const struct packing *p, size_t grains, struct scree_error *err)
{
    double width = 2 * p->radius * (1 + p->spread);
    size_t area = 1;
    for (int a = 0; a < 2; a++) {
        c->count[a] = (int)fmax(1, floor(p->length[a] / width));
        c->inverse[a] = c->count[a] / p->length[a];
        area *= (size_t)c->count[a];
    }
    c->layer_height = width;
    c->floor_z = p->floor_z - width; // obstacles may lie a little below
    c->layers = grains / area * 3 + 16;
    c->head = memory_rows(area * c->layers, sizeof *c->head);
    c->next = memory_rows(grains, sizeof *c->next);
    if (!c->head || !c->next)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to place %zu grains", grains);
    for (size_t k = 0; k < area * c->layers; k++)
        c->head[k] = -1;
    return SCREE_OK;
}

enum scree_status packing_insert(const struct packing *p, struct rng *rng, size_t count, struct dem_grain *out,
                                 struct scree_error *err)
{
    struct columns c = {0};
    size_t total = p->obstacle_count + count;
    struct dem_grain *all = memory_rows(total, sizeof *all);
    enum scree_status status =
        all ? columns_make(&c, p, total, err) : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to place grains");
    if (status)
        goto out;
    for (size_t k = 0; k < p->obstacle_count; k++) {
        all[k] = p->obstacles[k];
        link_grain(&c, &all[k], (int32_t)k);
    }
    double ceiling = p->first_ceiling;
    for (size_t k = p->obstacle_count; k < total; k++) {
        struct dem_grain *grain = &all[k];
        *grain = (struct dem_grain){.density = p->density};
        grain->radius = p->radius * rng_uniform(rng, 1 - p->spread, 1 + p->spread);
        const double margin = p->between ? grain->radius : 0;
        for (;; ceiling += p->rise) {
            grain->position[0] = rng_uniform(rng, 0, p->length[0]);
            grain->position[1] = rng_uniform(rng, margin, p->length[1] - margin);
            grain->position[2] = p->floor_z + grain->radius + rng_uniform(rng, 0, ceiling);
            if (!overlaps(&c, p, all, grain))
                break;
        }
        link_grain(&c, grain, (int32_t)k);
        out[k - p->obstacle_count] = *grain;
    }
out:
    free(all);
    free(c.head);
    free(c.next);
    return status;
}
