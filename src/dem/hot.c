/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The hot list: near pairs that can touch within the next few steps, packed for
 * the step's walk. Completeness and budget are near.c's; this level needs no
 * word with other parts. */
#include <string.h>

#include "base/memory.h"
#include "dem/state.h"

/* Steps that a hot list is made for, and the share by which the change of velocity may grow meanwhile. */
enum { HOT_STEPS = 12 };
#define HOT_GROWTH 1.15

enum scree_status hot_room(struct hot_list *hot, size_t need, struct scree_error *err)
{
    size_t padded = (need + 3) / 4 * 4;
    if (padded <= hot->room)
        return SCREE_OK;
    size_t grown = padded + padded / 4 + 64, room[5] = {hot->room, hot->room, hot->room, hot->room, (hot->room + 63) / 64};
    enum scree_status status;
    if ((status = memory_grow((void **)&hot->first, &room[0], grown, sizeof *hot->first, err)) ||
        (status = memory_grow((void **)&hot->second, &room[1], grown, sizeof *hot->second, err)) ||
        (status = memory_grow((void **)&hot->near, &room[2], grown, sizeof *hot->near, err)) ||
        (status = memory_grow((void **)&hot->reach2, &room[3], grown, sizeof *hot->reach2, err)) ||
        (status = memory_grow((void **)&hot->touching, &room[4], (grown + 63) / 64, sizeof *hot->touching, err)))
        return status;
    hot->room = grown;
    return SCREE_OK;
}

/* The near list's bits become those of the hot list. */
void hot_sync(struct part *part)
{
    const struct hot_list *hot = &part->hot;
    memset(part->near.touching, 0, (part->near.count + 63) / 64 * sizeof *part->near.touching);
    for (size_t base = 0; base < hot->count; base += 64)
        for (uint64_t bits = hot->touching[base / 64]; bits; bits &= bits - 1) {
            uint32_t p = hot->near[base + (size_t)__builtin_ctzll(bits)];
            part->near.touching[p / 64] |= 1ull << p % 64;
        }
}

/* A hot list out of the near list, whose bits are true. Its room was made with the near list's. */
void hot_fill(struct dem *dem, struct part *part)
{
    struct near_list *near = &part->near;
    struct hot_list *hot = &part->hot;
    const struct pair_batch all = {.position = (const double(*)[4])dem->position,
                                   .velocity = (const double(*)[4])dem->velocity,
                                   .shift = (const double(*)[4])dem->shift,
                                   .first = near->first,
                                   .second = near->second};
    hot->horizon = HOT_STEPS;
    hot->stray = 2 * HOT_GROWTH * part->change * dem->step_s * HOT_STEPS + 1e-6 * dem->plan.skin;
    hot->strayed = 0;
    hot->age = 0;
    double margin = hot->stray + (part->speed + part->change) * dem->step_s;
    hot->count = dem->kernels->approach(&all, near->count, HOT_STEPS * dem->step_s, margin, hot->near);
    memset(hot->touching, 0, (hot->count + 63) / 64 * sizeof *hot->touching);
    for (size_t k = 0; k < hot->count; k++) {
        uint32_t p = hot->near[k];
        hot->first[k] = near->first[p];
        hot->second[k] = near->second[p];
        hot->reach2[k] = near->reach2[p];
        hot->touching[k / 64] |= (near->touching[p / 64] >> p % 64 & 1) << k % 64;
    }
    for (size_t k = hot->count; k < (hot->count + 3) / 4 * 4; k++) {
        hot->first[k] = 0;
        hot->second[k] = (uint32_t)IMAGE_NONE << IMAGE_SHIFT;
        hot->reach2[k] = -1;
    }
}

void near_heat(struct dem *dem, struct part *part)
{
    if (part->hot.age <= part->hot.horizon && part->hot.strayed <= part->hot.stray)
        return;
    hot_sync(part);
    hot_fill(dem, part);
}
