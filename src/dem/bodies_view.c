/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bodies as others see them, at the time of the last step: half of the last
 * kicks is taken back, as view.c does for free grains. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/quat.h"
#include "dem/bodies.h"

static void view_one(const struct dem *dem, size_t k, struct view_body *out)
{
    const struct bodies *b = dem->bodies;
    const double dt = dem->step_s;
    *out = (struct view_body){.id = b->id[k],
                              .shape = b->shape[k],
                              .first = b->first[k],
                              .members = b->first[k + 1] - b->first[k],
                              .mass = b->position[k][3],
                              .volume = b->inverse[k][3]};
    struct turn turn = quat_turn(quat_load(b->orientation[k]));
    struct vec3 momentum = vec3_sub(vec3_load(b->momentum[k]), vec3_scale(vec3_load(b->torque[k]), 0.5 * dt));
    struct vec3 own = turn_in(&turn, momentum);
    own = (struct vec3){own.x * b->inverse[k][0], own.y * b->inverse[k][1], own.z * b->inverse[k][2]};
    vec3_store3(out->momentum, momentum);
    vec3_store3(out->spin, turn_out(&turn, own));
    for (int a = 0; a < 3; a++) {
        out->position[a] = b->position[k][a];
        out->velocity[a] = b->velocity[k][a] - 0.5 * b->force[k][a] * b->velocity[k][3] + 0.5 * dem->gravity[a] * dt;
    }
    for (int a = 0; a < 4; a++)
        out->orientation[a] = b->orientation[k][a];
}

enum scree_status bodies_view(struct dem *dem, struct view *view, struct scree_error *err)
{
    struct bodies *b = dem->bodies;
    if (!b->view && !(b->view = memory_rows(b->count, sizeof *b->view)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to look at %zu bodies", b->count);
    for (size_t k = 0; k < b->count; k++) {
        struct view_body *body = &b->view[k];
        view_one(dem, k, body);
        struct vec3 velocity = vec3_load(body->velocity), spin = vec3_load(body->spin);
        for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
            vec3_store3(dem->view_velocity[i], vec3_add(velocity, vec3_cross(spin, vec3_load(dem->arm[i]))));
            vec3_store3(dem->view_spin[i], spin);
            dem->view_spin[i][3] = 0;
        }
    }
    view->bodies = b->count;
    view->body = b->view;
    return SCREE_OK;
}

uint64_t bodies_hash(const struct dem *dem, uint64_t sum)
{
    const struct bodies *b = dem->bodies;
    for (size_t k = 0; k < b->count; k++) {
        uint64_t h = hash_double(5, b->id[k]);
        for (int a = 0; a < 4; a++) {
            h = hash_double(h, b->position[k][a]);
            h = hash_double(h, b->velocity[k][a]);
            h = hash_double(h, b->momentum[k][a] + 0.0);
            h = hash_double(h, b->orientation[k][a] + 0.0);
        }
        sum += h;
    }
    return sum;
}

/* ---- images ---- */

enum { KINDS = DEM_BODY_ROWS };

static void rows_of(const struct bodies *b, double (*rows[KINDS])[4])
{
    double(*const all[KINDS])[4] = {b->position, b->velocity, b->momentum, b->orientation, b->inverse, b->force, b->torque};
    memcpy(rows, all, sizeof all);
}

enum scree_status bodies_save(const struct dem *dem, struct dem_image *image, struct scree_error *err)
{
    const struct bodies *b = dem->bodies;
    double(*rows[KINDS])[4];
    image->body = memory_rows(KINDS * b->count, sizeof *image->body);
    if (!image->body)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image of %zu bodies", b->count);
    rows_of(b, rows);
    for (size_t k = 0; k < KINDS; k++)
        memcpy(image->body + k * b->count, rows[k], b->count * sizeof *image->body);
    image->offset = b->offset;
    image->body_first = b->first;
    image->body_id = b->id;
    image->body_shape = b->shape;
    return SCREE_OK;
}

bool bodies_are_sound(const struct dem_image *image)
{
    uint64_t count = image->scalars.bodies;
    if (image->body_first[0] != 0 || image->body_first[count] != image->scalars.moving)
        return false;
    for (size_t k = 0; k < count; k++)
        if (image->body_first[k + 1] <= image->body_first[k] || image->body_first[k + 1] > image->scalars.moving)
            return false;
    for (size_t k = 0; k < DEM_BODY_ROWS * count; k++)
        for (int a = 0; a < 4; a++)
            if (!isfinite(image->body[k][a]))
                return false;
    return true;
}

/* Rows' own places are the image's: after a wrap they differ from these in the last bit until the next drift. */
void bodies_load(struct dem *dem, const struct dem_image *image)
{
    struct bodies *b = dem->bodies;
    double(*rows[KINDS])[4];
    rows_of(b, rows);
    for (size_t k = 0; k < KINDS; k++)
        memcpy(rows[k], image->body + k * b->count, b->count * sizeof *image->body);
    memcpy(b->offset, image->offset, dem->moving * sizeof *b->offset);
    memcpy(b->first, image->body_first, (b->count + 1) * sizeof *b->first);
    memcpy(b->id, image->body_id, b->count * sizeof *b->id);
    memcpy(b->shape, image->body_shape, b->count * sizeof *b->shape);
    for (size_t k = 0; k < b->count; k++) {
        struct turn turn = quat_turn(quat_load(b->orientation[k]));
        for (size_t i = b->first[k]; i < b->first[k + 1]; i++) {
            vec3_store(dem->arm[i], turn_out(&turn, vec3_load(b->offset[i])));
            b->of[i] = (uint32_t)k;
            b->load[i][3] = b->twist[i][3] = 1;
        }
    }
}
