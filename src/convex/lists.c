/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which bodies may touch before some body has gone farther than its own margin from
 * where it was listed. Margins grow with speed, so that one body that falls does not
 * have lists made anew every few steps, and bodies at rest are not listed with all
 * that is far: two are listed when their reaches and margins overlap. Bodies are
 * sorted into cells; lists are in the order of their numbers, whatever cells they
 * are in, so that sums of forces never change their order. */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "convex/state.h"

enum {
    MARGIN_SHARE = 24, // of the smallest reach: the margin of a body at rest
    AHEAD = 16,        // steps at its speed that a body's margin has beyond that
    SELDOM = 8 * AHEAD // steps between two lists that are more than is worth wide margins
};
static const double EASE_STEP = 1.5, SPAN_MAX = 1e100; // m

static int compare(const struct group *a, const struct group *b)
{
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return a->b < b->b ? -1 : a->b > b->b;
}

enum scree_status convex_list_room(struct list *list, size_t groups, struct scree_error *err)
{
    return memory_grow((void **)&list->group, &list->group_room, groups, sizeof *list->group, err);
}

enum scree_status convex_take_block(struct list *list, struct group *g, struct scree_error *err)
{
    if (list->spares == 0) {
        size_t pairs = (list->blocks + 1) * list->block;
        if (pairs >= NO_CONTACT)
            return scree_fail(err, SCREE_NO_MEMORY, NULL, "too many parts of bodies are near each other: %zu pairs", pairs);
        enum scree_status status = memory_grow((void **)&list->pair, &list->pair_room, pairs, sizeof *list->pair, err);
        if (status || (status = memory_grow((void **)&list->spare, &list->spare_room, list->blocks + 1, sizeof *list->spare, err)))
            return status;
        list->spare[list->spares++] = (uint32_t)(list->block * list->blocks++);
    }
    g->first = list->spare[--list->spares];
    for (size_t k = 0; k < list->block; k++)
        list->pair[g->first + k] = (struct pair){.slot = NO_CONTACT};
    return SCREE_OK;
}

static void give_back(struct convex *c, struct list *list, const struct group *g)
{
    for (size_t k = 0; k < list->block; k++)
        convex_part(c, &list->pair[g->first + k]);
    list->spare[list->spares++] = g->first; // there is room for all
}

/* Takes over what the `olds` groups that were listed before knew of the same bodies; contacts of those that are no longer near,
 * as with a gate that has gone, end. */
static enum scree_status carry_over(struct convex *c, struct list *list, size_t olds, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    size_t o = 0;
    list->pairs = 0;
    for (size_t k = 0; k < list->groups && !status; k++) {
        struct group *g = &list->group[k];
        for (; o < olds && compare(&c->old[o], g) < 0; o++)
            give_back(c, list, &c->old[o]);
        if (o < olds && compare(&c->old[o], g) == 0)
            *g = c->old[o++];
        else
            status = convex_take_block(list, g, err);
        list->pairs += pairs_of(c, list, g);
    }
    for (; o < olds; o++)
        give_back(c, list, &c->old[o]);
    return status;
}

/* Empties a list into c->old; returns how many groups it had. */
static enum scree_status set_aside(struct convex *c, struct list *list, size_t *olds, struct scree_error *err)
{
    *olds = list->groups;
    enum scree_status status = memory_grow((void **)&c->old, &c->old_room, list->groups, sizeof *c->old, err);
    if (status || list->groups == 0)
        return status;
    memcpy(c->old, list->group, list->groups * sizeof *c->old);
    list->groups = 0;
    return SCREE_OK;
}

/* ---- margins ---- */

/* A body that is hit gets a speed that its margin did not know: where lists do not last, all margins are made wider. */
static void set_margins(struct convex *c)
{
    uint64_t since = c->step - c->listed_at;
    if (since < AHEAD)
        c->ease = fmin(CONVEX_EASE_MAX, c->ease * EASE_STEP);
    else if (since > SELDOM)
        c->ease = fmax(1, c->ease / EASE_STEP);
    c->listed_at = c->step;
    double reach_min = INFINITY;
    for (size_t k = 0; k < c->bodies; k++)
        reach_min = fmin(reach_min, c->body[k].shape->reach);
    for (size_t k = 0; k < c->bodies; k++) {
        struct body *b = &c->body[k];
        memcpy(b->listed, b->position, 3 * sizeof(double));
        b->listed[3] = c->ease * reach_min / MARGIN_SHARE + AHEAD * c->setup.step_s * sqrt(vec3_square(b->velocity));
    }
}

/* ---- cells ---- */

/* Cubes that hold all bodies: as many as there are bodies, or fewer. */
struct cells {
    double low[3], size; // m
    size_t count[3];
};

static size_t cell_along(const struct cells *cells, int axis, double x)
{
    double at = floor((x - cells->low[axis]) / cells->size);
    return at <= 0 ? 0 : at >= (double)cells->count[axis] ? cells->count[axis] - 1 : (size_t)at;
}

static size_t cell_of(const struct cells *cells, const double x[3])
{
    return cell_along(cells, 0, x[0]) +
           cells->count[0] * (cell_along(cells, 1, x[1]) + cells->count[1] * cell_along(cells, 2, x[2]));
}

static struct cells lay_cells(const struct convex *c)
{
    struct cells cells = {.low = {INFINITY, INFINITY, INFINITY}};
    double high[3] = {-INFINITY, -INFINITY, -INFINITY}, span[3], all;
    for (size_t k = 0; k < c->bodies; k++) {
        const struct body *b = &c->body[k];
        cells.size += 2 * (b->shape->reach + b->listed[3]) / (double)c->bodies;
        for (int i = 0; i < 3; i++) {
            cells.low[i] = fmin(cells.low[i], b->position[i]);
            high[i] = fmax(high[i], b->position[i]);
        }
    }
    for (int i = 0; i < 3; i++)
        span[i] = fmin(high[i] - cells.low[i], SPAN_MAX);
    do {
        all = 1;
        for (int i = 0; i < 3; i++)
            all *= floor(span[i] / cells.size) + 1;
        cells.size *= 1.25;
    } while (all > (double)c->bodies);
    for (int i = 0; i < 3; i++)
        cells.count[i] = (size_t)(span[i] / cells.size) + 1;
    return cells;
}

/* Turns counts in start[1..] into where each begins. */
static void begin_at(uint32_t *start, size_t count)
{
    for (size_t k = 0; k < count; k++)
        start[k + 1] += start[k];
}

static void sort_into_cells(struct convex *c, const struct cells *cells)
{
    size_t all = cells->count[0] * cells->count[1] * cells->count[2];
    memset(c->start, 0, (all + 2) * sizeof *c->start);
    for (size_t k = 0; k < c->bodies; k++)
        c->start[cell_of(cells, c->body[k].position) + 2]++;
    begin_at(c->start + 1, all);
    for (uint32_t k = 0; k < c->bodies; k++) {
        const struct body *b = &c->body[k];
        struct celled *at = &c->celled[c->start[cell_of(cells, b->position) + 1]++];
        *at = (struct celled){{b->position[0], b->position[1], b->position[2]}, b->shape->reach + b->listed[3], k};
    }
}

/* All bodies in a row of cells that are no wider than one and near it: each pair is found by the wider of the two. */
static enum scree_status find_in(struct convex *c, const struct celled *one, size_t from, size_t to, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (const struct celled *two = c->celled + from; two < c->celled + to && !status; two++) {
        double x = two->position[0] - one->position[0], y = two->position[1] - one->position[1],
               z = two->position[2] - one->position[2], reach = one->reach + two->reach;
        if (x * x + y * y + z * z > reach * reach || two->reach > one->reach ||
            (two->reach == one->reach && two->body <= one->body))
            continue;
        if ((status = memory_grow((void **)&c->found, &c->found_room, c->founds + 1, sizeof *c->found, err)))
            break;
        bool first = one->body < two->body;
        c->found[c->founds++] = (struct found){first ? one->body : two->body, first ? two->body : one->body};
    }
    return status;
}

static enum scree_status find_pairs(struct convex *c, struct scree_error *err)
{
    const struct cells cells = lay_cells(c);
    enum scree_status status = SCREE_OK;
    sort_into_cells(c, &cells);
    c->founds = 0;
    for (size_t k = 0; k < c->bodies && !status; k++) {
        const struct celled *one = &c->celled[k];
        size_t from[3], to[3];
        for (int i = 0; i < 3; i++) {
            from[i] = cell_along(&cells, i, one->position[i] - 2 * one->reach);
            to[i] = cell_along(&cells, i, one->position[i] + 2 * one->reach);
        }
        for (size_t z = from[2]; z <= to[2]; z++)
            for (size_t y = from[1]; y <= to[1] && !status; y++) {
                size_t row = cells.count[0] * (y + cells.count[1] * z);
                status = find_in(c, one, c->start[row + from[0]], c->start[row + to[0] + 1], err);
            }
    }
    return status;
}

static void sort_row(struct group *row, size_t count)
{
    for (size_t k = 1; k < count; k++) {
        const struct group moved = row[k];
        size_t at = k;
        for (; at > 0 && row[at - 1].b > moved.b; at--)
            row[at] = row[at - 1];
        row[at] = moved;
    }
}

/* In the order of numbers: the first of two is counted into place, of the second each has but a few. */
static enum scree_status find_near(struct convex *c, struct scree_error *err)
{
    enum scree_status status = find_pairs(c, err);
    if (status || (status = convex_list_room(&c->near, c->founds, err)))
        return status;
    memset(c->start, 0, (c->bodies + 1) * sizeof *c->start);
    for (size_t k = 0; k < c->founds; k++)
        c->start[c->found[k].a + 1]++;
    begin_at(c->start, c->bodies);
    for (size_t k = 0; k < c->founds; k++)
        c->near.group[c->start[c->found[k].a]++] = (struct group){.a = c->found[k].a, .b = c->found[k].b};
    for (size_t a = 0, from = 0; a < c->bodies; from = c->start[a++])
        sort_row(c->near.group + from, c->start[a] - from);
    c->near.groups = c->founds;
    return SCREE_OK;
}

static enum scree_status add_wall(struct convex *c, uint32_t body, uint32_t wall, struct scree_error *err)
{
    enum scree_status status = convex_list_room(&c->wall, c->wall.groups + 1, err);
    if (!status)
        c->wall.group[c->wall.groups++] = (struct group){.a = body, .b = wall};
    return status;
}

static enum scree_status find_walls(struct convex *c, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (uint32_t a = 0; a < c->bodies; a++)
        for (uint32_t w = 0; w < c->setup.wall_count && !status; w++) {
            const struct body *body = &c->body[a];
            const struct gate_now gate = convex_gate_now(c, w);
            struct vec3 from = vec3_sub(vec3_load(body->position), vec3_load(c->walls[w].point));
            double far = vec3_dot(from, vec3_load(c->walls[w].normal)), reach = body->shape->reach + body->listed[3];
            if (far <= reach && gate.stands && !(gate.partial && far < -reach)) // which has another side
                status = add_wall(c, a, w, err);
        }
    return status;
}

enum scree_status convex_rebuild(struct convex *c, struct scree_error *err)
{
    size_t olds;
    set_margins(c);
    enum scree_status status = set_aside(c, &c->near, &olds, err);
    if (status || (status = find_near(c, err)) || (status = carry_over(c, &c->near, olds, err)) ||
        (status = set_aside(c, &c->wall, &olds, err)) || (status = find_walls(c, err)) ||
        (status = carry_over(c, &c->wall, olds, err)))
        return status;
    convex_tidy(c);
    c->counts.rebuilds++;
    return SCREE_OK;
}
