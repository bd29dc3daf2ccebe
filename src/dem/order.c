/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a world needs now and then: a look for blow-up, grains wrapped back into
 * the periodic box, rows sorted so that neighbours in space are neighbours in
 * memory. All at multiples of DEM_HOUSEKEEPING steps and by rules that look at
 * the state alone, so that slices and threads do not show. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/state.h"

static enum scree_status blow_up(const struct dem *dem, size_t row, const char *what, struct scree_error *err)
{
    const double *x = dem->position[row];
    uint64_t good = dem->step - DEM_HOUSEKEEPING;
    enum scree_status status =
        scree_fail(err, SCREE_BLOWUP, NULL, "step %llu: grain %u %s (x %.4g, y %.4g, z %.4g m); last good time %.9g s",
                   (unsigned long long)dem->step, dem->id[row], what, x[0], x[1], x[2], (double)good * dem->step_s);
    scree_hint(err, "a shorter time.step_s, softer grains or a slower start may help");
    return status;
}

static bool is_finite(const struct dem *dem, size_t i)
{
    const double *x = dem->position[i], *v = dem->velocity[i], *w = dem->spin[i];
    return isfinite(x[0] + x[1] + x[2] + v[0] + v[1] + v[2] + w[0] + w[1] + w[2]);
}

void order_look(const struct dem *dem, struct part *part)
{
    part->lost = part->to;
    for (size_t i = part->to; i-- > part->from;)
        if (!is_finite(dem, i) || dem->position[i][2] < dem->floor_z)
            part->lost = i;
    part->outside = false;
    for (int a = 0; a < 3; a++) {
        double low = -0.5 * dem->length[a], high = 1.5 * dem->length[a];
        for (size_t i = part->from; i < part->to && high > 0; i++)
            part->outside |= dem->position[i][a] < low || dem->position[i][a] >= high;
    }
}

static enum scree_status look_for_blow_up(const struct dem *dem, struct scree_error *err)
{
    for (int k = 0; k < dem->part_count; k++) {
        size_t row = dem->parts[k].lost;
        if (row < dem->parts[k].to)
            return blow_up(dem, row,
                           is_finite(dem, row) ? "went through the base" : "has a position, velocity or spin that is not a number",
                           err);
    }
    return SCREE_OK;
}

static bool wrap_due(const struct dem *dem)
{
    bool due = false;
    for (int k = 0; k < dem->part_count; k++)
        due |= dem->parts[k].outside;
    return due;
}

/* Image code of a pair once its grains have been moved by whole boxes. */
static uint32_t image_moved(uint32_t code, const int8_t from[3], const int8_t to[3])
{
    int32_t out = 0, rest = (int32_t)code, boxes[3];
    for (int a = 0; a < 3; a++) {
        boxes[a] = rest % IMAGE_BASE - IMAGE_REACH + to[a] - from[a];
        rest /= IMAGE_BASE;
    }
    for (int a = 2; a >= 0; a--)
        out = out * IMAGE_BASE + boxes[a] + IMAGE_REACH;
    return (uint32_t)out;
}

void order_boxes(const struct dem *dem, const double place[3], int8_t boxes[4])
{
    for (int a = 0; a < 3; a++) {
        double box = dem->length[a];
        boxes[a] = box > 0 && (place[a] < 0 || place[a] >= box) ? (int8_t)floor(place[a] / box) : 0;
    }
}

static enum scree_status wrap(struct dem *dem, struct scree_error *err)
{
    struct held_list pairs = {0}, walls = {0};
    int8_t(*boxes)[4] = memory_rows(dem->grains, sizeof *boxes);
    enum scree_status status =
        boxes ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to wrap %zu grains", dem->grains);
    if (status || (status = near_take(dem, &pairs, &walls, err)))
        goto out;
    dem->motion->wrap(dem, boxes);
    for (size_t i = 0; i < dem->moving; i++)
        for (int a = 0; a < 3; a++)
            if (boxes[i][a])
                dem->position[i][a] -= boxes[i][a] * dem->length[a];
    for (size_t k = 0; k < pairs.count; k++) {
        uint32_t i = (uint32_t)(pairs.items[k].key >> 32), second = (uint32_t)pairs.items[k].key, j = second & IMAGE_ROW;
        pairs.items[k].key = (uint64_t)i << 32 | j | image_moved(second >> IMAGE_SHIFT, boxes[i], boxes[j]) << IMAGE_SHIFT;
    }
    status = near_give(dem, &pairs, &walls, err);
out:
    free(boxes);
    free(pairs.items);
    free(walls.items);
    return status;
}

/* ---- order in memory ---- */

struct place {
    uint64_t curve; // position along the space-filling curve
    uint32_t row;
};

static uint64_t spread(uint64_t x) // 21 bits to every third bit
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

/* Morton's curve over cells of a grain's size. */
static uint64_t curve_place(const struct dem *dem, const double position[3])
{
    uint64_t place = 0;
    for (int a = 0; a < 3; a++) {
        double x = position[a], box = dem->length[a];
        if (box > 0)
            x -= floor(x / box) * box;
        double cell = floor(x / (2.0 * dem->largest_radius)) + (box > 0 ? 0 : 0x80000);
        place |= spread(cell < 0 ? 0 : cell > 0x1fffff ? 0x1fffff : (uint64_t)cell) << (2 - a);
    }
    return place;
}

static int by_place(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    if (p->curve != q->curve)
        return p->curve < q->curve ? -1 : 1;
    return (p->row > q->row) - (p->row < q->row);
}

/* Rows [from, to) of an array into the order of `places`. */
static void permute(void *array, size_t size, const struct place *places, size_t from, size_t to, char *scratch)
{
    for (size_t k = from; k < to; k++)
        memcpy(scratch + (k - from) * size, (char *)array + places[k].row * size, size);
    memcpy((char *)array + from * size, scratch, (to - from) * size);
}

/* Contact (i, j) under its new rows; a pair that changes sides changes the sign
 * of the forces that it remembers and the side of its radii. */
static void renumber(struct held_contact *held, const uint32_t *new_row)
{
    uint32_t second = (uint32_t)held->key, code = second >> IMAGE_SHIFT;
    uint32_t i = new_row[held->key >> 32], j = new_row[second & IMAGE_ROW];
    if (i > j) {
        uint32_t swap = i;
        i = j;
        j = swap;
        code = (uint32_t)(IMAGE_CODES - 1) - code;
        double *c = held->contact, radius = c[CONTACT_R1];
        for (int s = CONTACT_FT_X; s <= CONTACT_FT_Z; s++)
            c[s] = -c[s];
        for (int s = CONTACT_MR_X; s <= CONTACT_MR_Z; s++)
            c[s] = -c[s];
        c[CONTACT_R1] = c[CONTACT_R2];
        c[CONTACT_R2] = radius;
    }
    held->key = (uint64_t)i << 32 | j | code << IMAGE_SHIFT;
}

static void move_rows(struct dem *dem, const struct place *places, char *scratch)
{
    size_t n = dem->grains;
    permute(dem->position, sizeof *dem->position, places, 0, n, scratch);
    permute(dem->velocity, sizeof *dem->velocity, places, 0, n, scratch);
    permute(dem->spin, sizeof *dem->spin, places, 0, n, scratch);
    permute(dem->id, sizeof *dem->id, places, 0, n, scratch);
    permute(dem->mass, sizeof *dem->mass, places, 0, n, scratch);
    permute(dem->arm, sizeof *dem->arm, places, 0, n, scratch);
}

enum scree_status order_rows(struct dem *dem, struct scree_error *err)
{
    size_t n = dem->grains;
    struct held_list pairs = {0}, walls = {0};
    struct place *places = memory_rows(n, sizeof *places);
    uint32_t *new_row = memory_rows(n, sizeof *new_row);
    char *scratch = memory_rows(n, sizeof *dem->position);
    enum scree_status status = SCREE_OK;
    if (!places || !new_row || !scratch) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to sort %zu grains", n);
        goto out;
    }
    if ((status = near_take(dem, &pairs, &walls, err)))
        goto out;
    for (size_t i = 0; i < n; i++)
        places[i] = (struct place){curve_place(dem, i < dem->moving ? dem->motion->place(dem, i) : dem->position[i]), (uint32_t)i};
    qsort(places, dem->moving, sizeof *places, by_place);
    qsort(places + dem->moving, n - dem->moving, sizeof *places, by_place);
    for (size_t k = 0; k < n; k++)
        new_row[places[k].row] = (uint32_t)k;
    move_rows(dem, places, scratch);
    if ((status = dem->motion->follow(dem, new_row, err)) || (status = mesh_follow(dem, new_row, err)))
        goto out;
    for (size_t k = 0; k < pairs.count; k++)
        renumber(&pairs.items[k], new_row);
    for (size_t k = 0; k < walls.count; k++)
        walls.items[k].key = (uint64_t)new_row[walls.items[k].key >> 32] << 32 | (uint32_t)walls.items[k].key;
    status = near_give(dem, &pairs, &walls, err);
out:
    free(places);
    free(new_row);
    free(scratch);
    free(pairs.items);
    free(walls.items);
    return status;
}

enum scree_status order_housekeeping(struct dem *dem, struct scree_error *err)
{
    enum scree_status status = look_for_blow_up(dem, err);
    if (!status && wrap_due(dem))
        status = wrap(dem, err);
    if (!status && dem->step % DEM_REORDER_STEPS == 0)
        status = order_rows(dem, err);
    return status;
}
