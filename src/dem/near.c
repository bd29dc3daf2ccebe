/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pair lists at three levels, provably complete, which never change a result.
 *
 * The outer list holds pairs with a gap below the skin (rebuilt every few
 * thousand steps, see spread.h). From it a refresh takes the near list, pairs that
 * can touch within some hundred steps, which own the contacts' memory; and from
 * that the hot list, pairs that can touch within some ten steps: those are what a
 * step walks.
 *
 * Grains that touch nothing fly straight (but for gravity, common to all), so a
 * pair is taken if its straight paths bring it within reach up to the horizon,
 * plus what the two may stray from those paths: a budget. Each step adds the
 * largest change of velocity of any grain since the refresh, times the step, to
 * what may have been used of it (kernels.c notes it where contacts kick grains);
 * when budget or horizon is used up, the list is made anew before contacts are
 * looked for. The hot list's paths start at velocities that have themselves
 * changed since the near refresh: twice the largest change bounds the difference.
 *
 * Contacts are walked in the order (first row, image, second row) whatever the
 * lists held, so when and how lists are made never shows in the bits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/mesh.h"
#include "dem/spread.h"
#include "dem/state.h"

/* The share of the skin that a straight path may use up to the horizon. */
#define PATH_SHARE 0.25
/* Steps between rebuilds below which the skin grows, above which it shrinks; how far it grows. */
enum { SKIN_SHORT = 150, SKIN_LONG = 600 };
#define SKIN_MOST 8.0

bool near_complete(struct dem *dem, struct part *part)
{
    double change = 0;
    for (int k = 0; k < dem->part_count; k++) {
        const double *s = dem->parts[k].strayed2;
        double sum = s[0] + s[1] + s[2];
        change = sum > change ? sum : change;
    }
    part->age++;
    part->hot.age++;
    double falling = dem->weight * dem->step_s * (double)part->age;
    part->change = sqrt(change) + falling;
    part->strayed += part->change * dem->step_s;
    part->hot.strayed += 2 * part->change * dem->step_s;
    return !dem->plan.stale && part->age <= part->horizon && part->strayed <= part->stray;
}

/* ---- contacts that outlive a list ---- */

static enum scree_status hold(struct held_list *list, uint64_t key, const double contact[CONTACT_SLOTS], struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&list->items, &list->room, list->count + 1, sizeof *list->items, err);
    if (status)
        return status;
    struct held_contact *item = &list->items[list->count++];
    item->key = key;
    memcpy(item->contact, contact, sizeof item->contact);
    return SCREE_OK;
}

/* Adds the part's touching contacts to the lists. */
static enum scree_status hold_part(const struct part *part, struct held_list *pairs, struct held_list *walls,
                                   struct scree_error *err)
{
    const struct near_list *near = &part->near;
    enum scree_status status = SCREE_OK;
    for (size_t base = 0; base < near->count && !status; base += 64)
        for (uint64_t bits = near->touching[base / 64]; bits && !status; bits &= bits - 1) {
            size_t p = base + (size_t)__builtin_ctzll(bits);
            status = hold(pairs, (uint64_t)near->first[p] << 32 | near->second[p], near->contact[p], err);
        }
    for (size_t k = 0; k < part->wall_count && !status; k++)
        if (part->walls[k].touching)
            status = hold(walls, (uint64_t)part->walls[k].grain << 32 | part->walls[k].wall, part->walls[k].contact, err);
    return status;
}

enum scree_status near_take(struct dem *dem, struct held_list *pairs, struct held_list *walls, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (int k = 0; k < dem->part_count && !status; k++) {
        struct part *part = &dem->parts[k];
        if (dem->plan.stale) { // already out of the lists
            for (size_t h = 0; h < part->held.count && !status; h++)
                status = hold(pairs, part->held.items[h].key, part->held.items[h].contact, err);
            for (size_t h = 0; h < part->held_walls.count && !status; h++)
                status = hold(walls, part->held_walls.items[h].key, part->held_walls.items[h].contact, err);
        } else {
            hot_sync(part);
            status = hold_part(part, pairs, walls, err);
        }
        part->held.count = part->held_walls.count = 0;
    }
    return status;
}

static int by_key(const void *a, const void *b)
{
    uint64_t x = ((const struct held_contact *)a)->key, y = ((const struct held_contact *)b)->key;
    return (x > y) - (x < y);
}

enum scree_status near_give(struct dem *dem, struct held_list *pairs, struct held_list *walls, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    struct held_list *lists[2] = {pairs, walls};
    for (int w = 0; w < 2; w++) {
        if (lists[w]->count)
            qsort(lists[w]->items, lists[w]->count, sizeof *lists[w]->items, by_key);
        size_t h = 0;
        for (int k = 0; k < dem->part_count; k++) {
            struct part *part = &dem->parts[k];
            struct held_list *own = w ? &part->held_walls : &part->held;
            for (; h < lists[w]->count && lists[w]->items[h].key >> 32 < part->to && !status; h++)
                status = hold(own, lists[w]->items[h].key, lists[w]->items[h].contact, err);
        }
    }
    dem->plan.stale = true;
    return status;
}

/* ---- the refresh ---- */

/* The largest way of own grains from where they were, m. */
static double way_from(const struct dem *dem, const struct part *part, double (*from)[4])
{
    double way2 = 0;
    for (size_t i = part->from; i < part->to; i++) {
        const double *x = dem->position[i], *o = from[i];
        double d = (x[0] - o[0]) * (x[0] - o[0]) + (x[1] - o[1]) * (x[1] - o[1]) + (x[2] - o[2]) * (x[2] - o[2]);
        way2 = d > way2 ? d : way2;
    }
    return sqrt(way2);
}

static void measure_motion(const struct dem *dem, struct part *part)
{
    double speed2 = 0;
    for (size_t i = part->from; i < part->to; i++) {
        const double *v = dem->velocity[i];
        double s = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        speed2 = s > speed2 ? s : speed2;
    }
    part->fastest = sqrt(speed2);
    part->displaced = way_from(dem, part, dem->position0);
    part->off_wall = dem->mesh ? way_from(dem, part, dem->mesh->asked) : 0;
}

/* A budget that was used up early was too small; a horizon reached with most of
 * it left means that less would have done. Every member comes to the same
 * number, from numbers that are the same in every part. */
static void stray_adapt(const struct dem *dem, struct part *part)
{
    const struct near_plan *plan = &dem->plan;
    if (part->stray <= 0)
        part->stray = plan->stray;
    else if (part->strayed > part->stray && part->age < plan->target)
        part->stray = fmin(part->stray * 1.25, 0.05 * plan->skin);
    else if (part->strayed < 0.5 * part->stray)
        part->stray = fmax(part->stray * 0.8, 1e-6 * plan->skin);
}

/* Grains that fly far in a step (soft ones, small ones that fall a long way) use a
 * thin skin up within a few steps: it grows while rebuilds come fast, and goes
 * back when they are rare. Member 0, between barriers. */
static void skin_adapt(const struct dem *dem, struct near_plan *plan)
{
    uint64_t lasted = dem->step - plan->since;
    if (!plan->stale && lasted < SKIN_SHORT)
        plan->skin = fmin(plan->skin * 1.25, SKIN_MOST * plan->least);
    else if (lasted > SKIN_LONG)
        plan->skin = fmax(plan->skin * 0.9, plan->least);
    plan->since = dem->step;
}

/* Steps, `target` at most, until something that goes `way` a step has gone `room`. */
static uint64_t steps_within(double room, double way, uint64_t target)
{
    double most = way > 0 ? floor(room / way) : 1e9;
    return most < 1 ? 1 : most < (double)target ? (uint64_t)most : target;
}

/* Straight paths are followed for as long as lists of this skin can vouch for, by how grains go together (spread.h). */
static enum scree_status plan_paths(struct dem *dem, struct spread_bound *bound, struct scree_error *err)
{
    struct near_plan *plan = &dem->plan;
    enum scree_status status = spread_measure(dem->cells, dem, plan->skin, bound, err);
    if (!status)
        plan->horizon = steps_within(2 * PATH_SHARE * plan->skin, bound->rate * dem->step_s, plan->target);
    return status;
}

/* Pairs: while no grain has gone half the skin, nothing needs to be known of how they go together. */
static enum scree_status plan_pairs(struct dem *dem, double fastest, double displaced, double stray, struct scree_error *err)
{
    struct near_plan *plan = &dem->plan;
    struct spread_bound bound;
    double way = fastest * dem->step_s;
    enum scree_status status;
    plan->rebuild = plan->ask_walls = plan->stale;
    plan->horizon = plan->target;
    if (!(way <= PATH_SHARE * plan->skin))
        return scree_fail(err, SCREE_BLOWUP, NULL, "a grain moves %.3g m in step %llu, %.3g m/s", way,
                          (unsigned long long)dem->step, fastest);
    if (!plan->stale) {
        if (displaced + way * (double)plan->target + stray <= 0.5 * plan->skin)
            return SCREE_OK;
        if ((status = plan_paths(dem, &bound, err)))
            return status;
        plan->rebuild = bound.moved + bound.rate * dem->step_s * (double)plan->horizon + 2 * stray > plan->skin;
    }
    if (!plan->rebuild)
        return SCREE_OK;
    skin_adapt(dem, plan);
    plan->stale = false;
    plan->rebuilds++;
    status = cells_fill(dem->cells, dem, 2 * dem->largest_radius + plan->skin, err);
    return status ? status : plan_paths(dem, &bound, err);
}

/* Walls of triangles stand still, so that a grain's own way counts. */
static void plan_walls(struct dem *dem, double fastest, double off_wall, double stray)
{
    struct near_plan *plan = &dem->plan;
    double way = fastest * dem->step_s;
    plan->horizon = steps_within(0.5 * plan->skin, way, plan->horizon);
    plan->ask_walls = plan->ask_walls || off_wall + way * (double)plan->horizon + stray > plan->wall_skin;
    if (plan->ask_walls)
        plan->wall_skin = plan->skin;
}

static enum scree_status near_room(struct near_list *near, size_t need, struct scree_error *err)
{
    size_t padded = need ? (need + 3) / 4 * 4 : 4; // so that the arrays exist
    if (padded <= near->room)
        return SCREE_OK;
    size_t room[5] = {near->room, near->room, near->room, near->room, (near->room + 63) / 64};
    size_t grown = padded + padded / 4 + 64;
    enum scree_status status;
    if ((status = memory_grow((void **)&near->first, &room[0], grown, sizeof *near->first, err)) ||
        (status = memory_grow((void **)&near->second, &room[1], grown, sizeof *near->second, err)) ||
        (status = memory_grow((void **)&near->reach2, &room[2], grown, sizeof *near->reach2, err)) ||
        (status = memory_grow((void **)&near->contact, &room[3], grown, sizeof *near->contact, err)) ||
        (status = memory_grow((void **)&near->touching, &room[4], (grown + 63) / 64, sizeof *near->touching, err)))
        return status;
    near->room = grown;
    return SCREE_OK;
}

/* The near list out of the kept outer pairs, with what touching pairs remember. */
static enum scree_status near_fill(struct dem *dem, struct part *part, size_t kept, struct scree_error *err)
{
    struct near_list *near = &part->near;
    enum scree_status status = near_room(near, kept, err);
    if (status)
        return status;
    near->count = kept;
    memset(near->touching, 0, (kept + 63) / 64 * sizeof *near->touching);
    size_t h = 0;
    for (size_t k = 0; k < kept; k++) {
        uint32_t i = part->outer_first[part->kept[k]], second = part->outer_second[part->kept[k]];
        double r1 = dem->position[i][3], r2 = dem->position[second & IMAGE_ROW][3], *contact = near->contact[k];
        uint64_t key = (uint64_t)i << 32 | second;
        near->first[k] = i;
        near->second[k] = second;
        near->reach2[k] = (r1 + r2) * (r1 + r2);
        if (h < part->held.count && part->held.items[h].key == key) {
            memcpy(contact, part->held.items[h++].contact, sizeof near->contact[k]);
            near->touching[k / 64] |= 1ull << k % 64;
        } else {
            memset(contact, 0, CONTACT_HISTORY * sizeof *contact);
            contact[CONTACT_R] = r1 * r2 / (r1 + r2); // eq. 3
            contact[CONTACT_R1] = r1;
            contact[CONTACT_R2] = r2;
        }
        while (h < part->held.count && part->held.items[h].key < key)
            h++;
    }
    for (size_t k = kept; k < (kept + 3) / 4 * 4; k++) {
        near->first[k] = 0;
        near->second[k] = (uint32_t)IMAGE_NONE << IMAGE_SHIFT;
        near->reach2[k] = -1;
    }
    part->held.count = 0;
    return SCREE_OK;
}

static enum scree_status part_room(struct dem *dem, struct part *part, size_t kept, struct scree_error *err)
{
    enum scree_status status;
    if ((status = memory_grow((void **)&part->active, &part->active_room, kept, sizeof *part->active, err)) ||
        (status = memory_grow((void **)&part->out, &part->out_room, kept, sizeof *part->out, err)) ||
        (status = memory_grow((void **)&part->exports, &part->export_room, kept, sizeof *part->exports, err)) ||
        (status = memory_grow((void **)&part->on_base, &part->on_base_room, kept, sizeof *part->on_base, err)))
        return status;
    if (!dem->ledger)
        return SCREE_OK;
    if ((status = memory_grow((void **)&part->loss, &part->loss_room, kept + 1, sizeof *part->loss, err)))
        return status;
    return memory_grow((void **)&part->ended, &part->ended_room, kept, sizeof *part->ended, err);
}

/* `fastest` widens the reach by one step's way, so that a pair that touched at
 * the last step is always near and its end is seen. */
static enum scree_status part_refresh(struct dem *dem, struct part *part, uint64_t horizon, double fastest, struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)&part->kept, &part->kept_room, part->outer_count + 4, sizeof *part->kept, err);
    if (status)
        return status;
    struct pair_batch outer = {.position = (const double(*)[4])dem->position,
                               .velocity = (const double(*)[4])dem->velocity,
                               .shift = (const double(*)[4])dem->shift,
                               .first = part->outer_first,
                               .second = part->outer_second};
    double seconds = (double)horizon * dem->step_s, margin = part->stray + fastest * dem->step_s;
    size_t kept = dem->kernels->approach(&outer, part->outer_count, seconds, margin, part->kept);
    if ((status = part_room(dem, part, kept, err)) || (status = near_fill(dem, part, kept, err)) ||
        (status = walls_near(dem, part, seconds, margin, err)) || (status = mesh_near(dem, part, seconds, margin, err)))
        return status;
    memcpy(dem->velocity0[part->from], dem->velocity[part->from], (part->to - part->from) * sizeof *dem->velocity0);
    memset(part->strayed2, 0, sizeof part->strayed2);
    part->speed = fastest;
    if ((status = hot_room(&part->hot, kept + 4, err)))
        return status;
    hot_fill(dem, part);
    return SCREE_OK;
}

/* Member 0: which lists are to be made anew, and for how many steps. */
static void plan_lists(struct dem *dem, struct part *first)
{
    struct near_plan *plan = &dem->plan;
    double displaced = 0, off_wall = 0;
    plan->fastest = 0;
    for (int k = 0; k < dem->part_count; k++) {
        plan->fastest = fmax(plan->fastest, dem->parts[k].fastest);
        displaced = fmax(displaced, dem->parts[k].displaced);
        off_wall = fmax(off_wall, dem->parts[k].off_wall);
    }
    plan->status = plan_pairs(dem, plan->fastest, displaced, first->stray, &first->error);
    if (dem->mesh && !plan->status)
        plan_walls(dem, plan->fastest, off_wall, first->stray);
    plan->refreshes++;
}

void near_refresh(struct dem *dem, int member)
{
    struct part *part = &dem->parts[member];
    struct near_plan *plan = &dem->plan;
    if (!plan->stale) {
        hot_sync(part);
        part->status = hold_part(part, &part->held, &part->held_walls, &part->error);
    }
    measure_motion(dem, part);
    stray_adapt(dem, part);
    team_barrier(dem->team);

    if (member == 0)
        plan_lists(dem, part);
    team_barrier(dem->team);
    if (!part->status)
        part->status = plan->status; // member 0 has the message
    if (!part->status && plan->rebuild) {
        part->status = cells_pairs(dem->cells, dem, part, plan->skin, &part->error);
        memcpy(dem->position0[part->from], dem->position[part->from], (part->to - part->from) * sizeof *dem->position0);
    }
    if (!part->status && plan->ask_walls)
        part->status = mesh_outer(dem, part, plan->wall_skin, &part->error);
    if (!part->status)
        part->status = part_refresh(dem, part, plan->horizon, plan->fastest, &part->error);
    part->strayed = 0;
    part->age = 0;
    part->horizon = plan->horizon;
}
