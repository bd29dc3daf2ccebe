/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Motion of free grains: a row is a unit, and contacts kick its velocity and
 * spin where they stand. */
#include "dem/state.h"

static void free_drift(struct dem *dem, struct part *part)
{
    double dt = dem->step_s, kick[3] = {dem->gravity[0] * dt, dem->gravity[1] * dt, dem->gravity[2] * dt};
    dem->kernels->drift(dem->position, dem->velocity, part->from, part->to, kick, dt);
}

static void free_kick(struct dem *dem, struct part *part)
{
    const struct sink sink = {dem->velocity, dem->spin, dem->velocity0, part->strayed2};
    kick_rows(dem, part, &sink);
}

static size_t free_next(const struct dem *dem, size_t row)
{
    (void)dem;
    return row + 1;
}

static const double *free_place(const struct dem *dem, size_t row)
{
    return dem->position[row];
}

static void free_wrap(struct dem *dem, int8_t (*boxes)[4])
{
    for (size_t i = 0; i < dem->moving; i++) {
        order_boxes(dem, dem->position[i], boxes[i]);
        for (int a = 0; a < 3; a++)
            if (boxes[i][a])
                dem->wrapped_work += dem->mass[i] * dem->gravity[a] * boxes[i][a] * dem->length[a];
    }
}

static void free_nudge(struct dem *dem, const double change[3])
{
    for (size_t i = 0; i < dem->moving; i++)
        for (int a = 0; a < 3; a++)
            dem->velocity[i][a] += change[a];
}

static double free_potential(const struct dem *dem)
{
    double sum = 0;
    for (size_t i = 0; i < dem->moving; i++) {
        const double *x = dem->position[i];
        sum += dem->mass[i] * (dem->gravity[0] * x[0] + dem->gravity[1] * x[1] + dem->gravity[2] * x[2]);
    }
    return sum;
}

static enum scree_status free_follow(struct dem *dem, const uint32_t *new_row, struct scree_error *err)
{
    (void)dem, (void)new_row, (void)err;
    return SCREE_OK;
}

const struct motion motion_free = {.drift = free_drift,
                                   .kick = free_kick,
                                   .next = free_next,
                                   .place = free_place,
                                   .wrap = free_wrap,
                                   .nudge = free_nudge,
                                   .potential = free_potential,
                                   .follow = free_follow};
