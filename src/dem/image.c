/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See image.h. Contacts go back through the lists' own way of outliving a
 * rebuild; then the last step's forces are put beside them. */
#include "dem/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/bodies.h"
#include "dem/mesh.h"
#include "dem/state.h"

static enum scree_status contact_arrays(struct dem_image *image, struct scree_error *err)
{
    size_t pairs = image->scalars.contacts, walls = image->scalars.wall_contacts;
    image->keys = memory_rows(pairs, sizeof *image->keys);
    image->contact = memory_rows(pairs, sizeof *image->contact);
    image->out = memory_rows(pairs, sizeof *image->out);
    image->wall_keys = memory_rows(walls, sizeof *image->wall_keys);
    image->wall_contact = memory_rows(walls, sizeof *image->wall_contact);
    image->wall_out = memory_rows(walls, sizeof *image->wall_out);
    image->wall_overlap = memory_rows(walls, sizeof *image->wall_overlap);
    if (image->keys && image->contact && image->out && image->wall_keys && image->wall_contact && image->wall_out &&
        image->wall_overlap)
        return SCREE_OK;
    dem_image_free(image);
    return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image of %zu contacts", pairs + walls);
}

void dem_image_free(struct dem_image *image)
{
    free(image->keys);
    free(image->contact);
    free(image->out);
    free(image->wall_keys);
    free(image->wall_contact);
    free(image->wall_out);
    free(image->wall_overlap);
    free(image->body);
    free(image->surface);
    free(image->vertex);
    free(image->corner);
    free(image->partner);
    free(image->mesh_pair);
    memset(image, 0, sizeof *image);
}

static struct dem_scalars scalars_of(const struct dem *dem)
{
    struct dem_scalars s = {.moving = dem->moving,
                            .grains = dem->grains,
                            .walls = dem->wall_count,
                            .bodies = dem->bodies ? dem->bodies->count : 0,
                            .step = dem->step,
                            .base_steps = dem->base_steps,
                            .ledger = dem->ledger,
                            .step_s = dem->step_s,
                            .floor_z = dem->floor_z,
                            .wrapped_work = dem->wrapped_work,
                            .start_potential = dem->start_potential};
    memcpy(s.gravity, dem->gravity, sizeof s.gravity);
    memcpy(s.length, dem->length, sizeof s.length);
    memcpy(s.base_y, dem->base_y, sizeof s.base_y);
    memcpy(s.base_sum, dem->base_sum, sizeof s.base_sum);
    memcpy(s.lost, dem->lost, sizeof s.lost);
    for (int k = 0; k < dem->part_count; k++) {
        s.contacts += dem->parts[k].active_count;
        for (size_t w = 0; w < dem->parts[k].wall_count; w++)
            s.wall_contacts += dem->parts[k].walls[w].touching != 0;
    }
    return s;
}

enum scree_status dem_save(const struct dem *dem, struct dem_image *image, struct scree_error *err)
{
    *image = (struct dem_image){.scalars = scalars_of(dem),
                                .position = dem->position,
                                .velocity = dem->velocity,
                                .spin = dem->spin,
                                .mass = dem->mass,
                                .id = dem->id,
                                .walls = dem->walls};
    enum scree_status status = contact_arrays(image, err);
    if (status)
        return status;
    if ((dem->bodies && (status = bodies_save(dem, image, err))) || (status = mesh_save(dem, image, err))) {
        dem_image_free(image);
        return status;
    }
    size_t c = 0, w = 0;
    for (int k = 0; k < dem->part_count; k++) {
        const struct part *part = &dem->parts[k];
        for (size_t a = 0; a < part->active_count; a++, c++) {
            uint32_t p = part->active[a];
            image->keys[c] = (uint64_t)part->near.first[p] << 32 | part->near.second[p];
            memcpy(image->contact[c], part->near.contact[p], sizeof *image->contact);
            image->out[c] = part->out[a];
        }
        for (size_t a = 0; a < part->wall_count; a++) {
            const struct wall_pair *pair = &part->walls[a];
            if (!pair->touching)
                continue;
            image->wall_keys[w] = (uint64_t)pair->grain << 32 | pair->wall;
            memcpy(image->wall_contact[w], pair->contact, sizeof *image->wall_contact);
            image->wall_overlap[w] = pair->overlap;
            image->wall_out[w++] = pair->out;
        }
    }
    return SCREE_OK;
}

/* Keys name rows and images that exist. */
static bool keys_are_sound(const struct dem_image *image)
{
    const struct dem_scalars *s = &image->scalars;
    for (size_t k = 0; k < s->contacts; k++) {
        uint64_t first = image->keys[k] >> 32, second = (uint32_t)image->keys[k];
        if (first >= s->moving || (second & IMAGE_ROW) >= s->grains || (second & IMAGE_ROW) <= first ||
            second >> IMAGE_SHIFT >= IMAGE_CODES || (k > 0 && image->keys[k] <= image->keys[k - 1]))
            return false;
    }
    for (size_t k = 0; k < s->wall_contacts; k++)
        if (image->wall_keys[k] >> 32 >= s->moving || (uint32_t)image->wall_keys[k] >= s->walls)
            return false;
    for (size_t k = 0; k < s->walls; k++)
        if (image->walls[k].partner < 0 || image->walls[k].partner >= LAW_PARTNERS)
            return false;
    if (s->bodies > s->moving || (s->bodies && !bodies_are_sound(image)))
        return false;
    return s->moving > 0 && s->moving <= s->grains && s->grains < IMAGE_ROW;
}

static bool are_finite(const double *values, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (!isfinite(values[k]))
            return false;
    return true;
}

/* Numbers that a state can have: lists are made of them before the first step looks for a blow-up. */
static bool state_is_sound(const struct dem_image *image)
{
    const struct dem_scalars *s = &image->scalars;
    const double bounds[] = {s->step_s, s->gravity[0], s->gravity[1], s->gravity[2], s->length[0], s->length[1], s->length[2]};
    if (!are_finite(bounds, sizeof bounds / sizeof *bounds) || s->step_s <= 0 || isnan(s->floor_z) || isnan(s->base_y[0]) ||
        isnan(s->base_y[1])) // infinite ones: no floor, no bound
        return false;
    for (size_t w = 0; w < s->walls; w++) {
        unsigned char flag;
        memcpy(&flag, &image->walls[w].base, 1); // a bool that holds something else must not be read as one
        if (flag > 1)
            return false;
    }
    for (size_t i = 0; i < s->grains; i++) {
        double radius = image->position[i][3];
        if (!are_finite(image->position[i], 4) || !are_finite(image->velocity[i], 3) || !are_finite(image->spin[i], 3) ||
            !(radius > 0) || !(image->mass[i] > 0) || !isfinite(image->mass[i]))
            return false;
        for (int a = 0; a < 3; a++)
            if (fabs(image->position[i][a]) > (s->length[a] > 0 ? 100 * s->length[a] : 1e6 * radius))
                return false;
    }
    return true;
}

static enum scree_status held_of(struct held_list *list, const uint64_t *keys, double (*contact)[CONTACT_SLOTS], size_t count,
                                 struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&list->items, &list->room, count, sizeof *list->items, err);
    for (list->count = 0; !status && list->count < count; list->count++) {
        list->items[list->count].key = keys[list->count];
        memcpy(list->items[list->count].contact, contact[list->count], sizeof list->items->contact);
    }
    return status;
}

/* The forces of the last step beside the contacts, in the same order. */
static enum scree_status put_forces(struct dem *dem, const struct dem_image *image, struct scree_error *err)
{
    size_t c = 0, w = 0;
    for (int k = 0; k < dem->part_count; k++) {
        struct part *part = &dem->parts[k];
        for (size_t base = 0; base < part->near.count; base += 64)
            for (uint64_t bits = part->near.touching[base / 64]; bits && c < image->scalars.contacts; bits &= bits - 1, c++) {
                part->active[part->active_count] = (uint32_t)(base + (size_t)__builtin_ctzll(bits));
                part->out[part->active_count++] = image->out[c];
            }
        for (size_t a = 0; a < part->wall_count && w < image->scalars.wall_contacts; a++)
            if (part->walls[a].touching) {
                part->walls[a].overlap = image->wall_overlap[w];
                part->walls[a].out = image->wall_out[w++];
            }
    }
    if (c != image->scalars.contacts || w != image->scalars.wall_contacts)
        return scree_fail(err, SCREE_CORRUPT, NULL, "contacts of the image do not touch");
    return SCREE_OK;
}

static void put_scalars(struct dem *dem, const struct dem_scalars *s)
{
    dem->step = s->step;
    dem->base_steps = s->base_steps;
    memcpy(dem->base_sum, s->base_sum, sizeof s->base_sum);
    memcpy(dem->lost, s->lost, sizeof s->lost);
    dem->wrapped_work = s->wrapped_work;
    dem->start_potential = s->start_potential;
}

enum scree_status dem_load(const struct dem_image *image, const struct law *law, const void *matter, const char *isa, int threads,
                           struct dem **out, struct scree_error *err)
{
    const struct dem_scalars *s = &image->scalars;
    struct held_list pairs = {0}, walls = {0};
    struct dem *dem = NULL;
    if (!keys_are_sound(image))
        return scree_fail(err, SCREE_CORRUPT, NULL, "the image names grains that it does not hold");
    if (!state_is_sound(image))
        return scree_fail(err, SCREE_CORRUPT, NULL, "the image holds numbers that no state has");
    struct dem_setup setup = {.law = law,
                              .matter = matter,
                              .step_s = s->step_s,
                              .body_count = s->bodies,
                              .walls = image->walls,
                              .wall_count = s->walls,
                              .floor_z = s->floor_z,
                              .threads = threads,
                              .isa = isa,
                              .ledger = s->ledger != 0};
    memcpy(setup.gravity, s->gravity, sizeof s->gravity);
    memcpy(setup.length, s->length, sizeof s->length);
    memcpy(setup.base_y, s->base_y, sizeof s->base_y);
    enum scree_status status = dem_start(&setup, s->moving, s->grains, &dem, err);
    if (status)
        return status;
    memcpy(dem->position, image->position, s->grains * sizeof *dem->position);
    memcpy(dem->velocity, image->velocity, s->grains * sizeof *dem->velocity);
    memcpy(dem->spin, image->spin, s->grains * sizeof *dem->spin);
    memcpy(dem->mass, image->mass, s->grains * sizeof *dem->mass);
    memcpy(dem->id, image->id, s->grains * sizeof *dem->id);
    if (dem->bodies)
        bodies_load(dem, image);
    put_scalars(dem, s);
    dem_cut(dem);
    dem_plan(dem);
    if ((status = mesh_load(dem, image, err)) || (status = held_of(&pairs, image->keys, image->contact, s->contacts, err)) ||
        (status = held_of(&walls, image->wall_keys, image->wall_contact, s->wall_contacts, err)) ||
        (status = near_give(dem, &pairs, &walls, err)) || (status = dem_first_lists(dem, err)))
        goto out;
    status = put_forces(dem, image, err);
out:
    free(pairs.items);
    free(walls.items);
    if (status)
        dem_free(dem);
    else
        *out = dem;
    return status;
}
