/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The log of contacts that form, kept only when asked for.
 *
 * A contact has formed at the first step at which its grains overlap. That is
 * seen between the search and the law: its history is blank then, and velocities
 * are still those of the flight (eqs 4 and 8 at v(n+1/2), before any force of the
 * contact). Each member notes its own; member 0 gathers them once a step, pairs
 * of all parts before walls of all parts, which is one order on any number of
 * threads. Walls of triangles are not noted. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "dem/state.h"

static struct view_formation *append(struct part *part, struct formed_list *list)
{
    struct scree_error error = {0};
    enum scree_status status = memory_grow((void **)&list->items, &list->room, list->count + 1, sizeof *list->items, &error);
    if (!status)
        return &list->items[list->count++];
    part->status = status;
    part->error = error;
    return NULL;
}

static bool blank(const double contact[CONTACT_SLOTS])
{
    return contact[CONTACT_A] == 0 && contact[CONTACT_FN] == 0;
}

/* `slide` is the relative velocity of the surfaces; its part along the normal is taken out. */
static void note(const struct dem *dem, struct view_formation *f, struct vec3 place, struct vec3 n, double approach,
                 struct vec3 slide)
{
    double at[3];
    vec3_store3(at, place);
    f->time_s = (double)(dem->step + 1) * dem->step_s;
    for (int a = 0; a < 3; a++)
        f->place[a] = dem->length[a] > 0 ? at[a] - floor(at[a] / dem->length[a]) * dem->length[a] : at[a];
    vec3_store3(f->normal, n);
    f->approach = approach;
    vec3_store3(f->tangential, vec3_sub(slide, vec3_scale(n, vec3_dot(slide, n))));
}

void formed_pairs(struct dem *dem, struct part *part)
{
    for (size_t k = 0; k < part->active_count; k++) {
        uint32_t p = part->active[k], i = part->near.first[p], second = part->near.second[p], j = second & IMAGE_ROW;
        if (!blank(part->near.contact[p]))
            continue;
        struct vec3 from = vec3_load(dem->position[i]);
        struct vec3 x = vec3_add(vec3_sub(vec3_load(dem->position[j]), from), vec3_load(dem->shift[second >> IMAGE_SHIFT]));
        double distance = sqrt(vec3_dot(x, x)), r1 = dem->position[i][3], r2 = dem->position[j][3];
        if (!(distance < r1 + r2))
            continue; // they touch without overlap, and exert nothing yet
        struct view_formation *f = append(part, &part->formed);
        if (!f)
            return;
        *f = (struct view_formation){.a = dem->id[i], .b = dem->id[j], .fixed = j >= dem->moving};
        struct vec3 n = vec3_scale(x, 1.0 / distance);
        struct vec3 v = vec3_sub(vec3_load(dem->velocity[i]), vec3_load(dem->velocity[j]));
        struct vec3 w = vec3_add(vec3_scale(vec3_load(dem->spin[i]), r1), vec3_scale(vec3_load(dem->spin[j]), r2));
        struct vec3 place = vec3_add(from, vec3_scale(n, 0.5 * (distance + r1 - r2)));
        note(dem, f, place, n, vec3_dot(v, n), vec3_add(v, vec3_cross(w, n)));
    }
}

void formed_wall(struct dem *dem, struct part *part, const struct wall_pair *pair)
{
    if (!blank(pair->contact) || !(pair->overlap > 0))
        return;
    struct view_formation *f = append(part, &part->formed_walls);
    if (!f)
        return;
    *f = (struct view_formation){.a = dem->id[pair->grain], .b = VIEW_WALL + pair->wall, .fixed = dem->walls[pair->wall].base};
    struct vec3 n = vec3_load(pair->normal), v = vec3_load(dem->velocity[pair->grain]);
    double r = dem->position[pair->grain][3];
    struct vec3 place = vec3_add(vec3_load(dem->position[pair->grain]), vec3_scale(n, r - 0.5 * pair->overlap));
    struct vec3 w = vec3_scale(vec3_load(dem->spin[pair->grain]), r);
    note(dem, f, place, n, pair->approach, vec3_add(v, vec3_cross(w, n)));
}

/* Member 0: what one kind of list holds goes to the end of the log. */
static void gather(struct dem *dem, struct part *part, struct formed_list *list)
{
    if (list->count == 0)
        return;
    struct formed_list *log = &dem->formed;
    enum scree_status status =
        memory_grow((void **)&log->items, &log->room, log->count + list->count, sizeof *log->items, &part->error);
    if (status) {
        part->status = status;
        return;
    }
    memcpy(log->items + log->count, list->items, list->count * sizeof *list->items);
    log->count += list->count;
    list->count = 0;
}

void formed_gather(struct dem *dem)
{
    for (int p = 0; p < dem->part_count; p++)
        gather(dem, &dem->parts[p], &dem->parts[p].formed);
    for (int p = 0; p < dem->part_count; p++)
        gather(dem, &dem->parts[p], &dem->parts[p].formed_walls);
}

void dem_log_formations(struct dem *dem, bool on)
{
    dem->logs_formations = on;
}

size_t dem_take_formations(struct dem *dem, const struct view_formation **formations)
{
    size_t count = dem->formed.count;
    *formations = dem->formed.items;
    dem->formed.count = 0;
    return count;
}
