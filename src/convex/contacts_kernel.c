/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where parts of bodies touch, and who feels it; compiled once per instruction set.
 *
 * Pairs that are due are measured four at once, as they come (distance4.h). Most touched in the step before, and touch at
 * the same corners: that is tried first. Then the contacts of the same bodies are pressed in the order of lists
 * (pressing.h), so that sums do not depend on which pairs were measured together. */
#include <math.h>
#include <string.h>

#include "convex/distance4.h"
#include "convex/pressing.h"

/* ---- contacts ---- */

static void recall(struct contact *now, const struct contact *before)
{
    memcpy(now->slip, before->slip, sizeof now->slip);
    memcpy(now->roll, before->roll, sizeof now->roll);
    memcpy(now->normal, before->normal, sizeof now->normal);
}

/* As many contacts as there are points now; each remembers what the nearest of those before did. */
static enum scree_status follow(struct convex *c, struct pair *p, const struct patch *now, struct scree_error *err)
{
    struct contact before[PATCH_POINTS_MAX];
    size_t count = 0, k = 0;
    if (now->points == 1 && p->slot != NO_CONTACT && c->contact[p->slot].next == NO_CONTACT)
        return SCREE_OK;
    for (uint32_t slot = p->slot; slot != NO_CONTACT; slot = c->contact[slot].next)
        before[count++] = c->contact[slot];
    enum scree_status status = convex_touch(c, p, now->points, err);
    if (status || count == 0)
        return status;
    for (uint32_t slot = p->slot; slot != NO_CONTACT; slot = c->contact[slot].next, k++) {
        double least = INFINITY;
        for (size_t other = 0; other < count; other++) {
            struct vec3 way = vec3_sub(vec3_load(before[other].point), now->point[k].at);
            if (vec3_dot(way, way) < least) {
                least = vec3_dot(way, way);
                recall(&c->contact[slot], &before[other]);
            }
        }
    }
    return SCREE_OK;
}

/* Points are from a's centre. */
static enum scree_status touch(struct convex *c, const struct looked *l, struct patch *now, struct scree_error *err)
{
    size_t k = 0;
    for (size_t n = 0; n < now->points; n++)
        now->point[n].at = vec3_add(vec3_load(l->a.body->position), now->point[n].at);
    enum scree_status status = follow(c, l->pair, now, err);
    if (status)
        return status;
    l->pair->due = 0;
    for (uint32_t slot = l->pair->slot; slot != NO_CONTACT; slot = c->contact[slot].next, k++) {
        struct contact *contact = &c->contact[slot];
        vec3_store3(contact->facing, now->normal);
        vec3_store3(contact->point, now->point[k].at);
        contact->slip[3] = now->point[k].overlap;
        contact->roll[3] = now->point[k].share;
    }
    return SCREE_OK;
}

static void apart(struct convex *c, const struct looked *l, double gap)
{
    convex_part(c, l->pair);
    l->pair->due = c->travel[l->group->a] + c->travel[l->group->b] + gap;
}

/* Whether a face of one may lie on a face or an edge of the other: crossed edges and corners touch in one point. No corner is
 * higher along the normal than the nearest point; those that press are lower by less than the overlap. */
static bool lies_flat(const struct side *a, const struct side *b, struct vec3 apart, struct vec3 on_a, struct vec3 on_b,
                      struct vec3 normal, double overlap)
{
    if (a->part->faces == 0 || b->part->faces == 0)
        return false;
    int of_a = corners_above(a, normal, vec3_dot(on_a, normal) - overlap);
    if (of_a < 2)
        return false;
    int of_b = corners_above(b, vec3_scale(normal, -1), vec3_dot(vec3_sub(apart, on_b), normal) - overlap);
    return of_b >= 2 && of_a + of_b > 4;
}

/* Where two parts press with faces, which are found first unless they touched with them in the step before. */
static bool meet_flat(const struct side *a, const struct side *b, struct vec3 apart, const struct vec3 *normal, struct pair *p,
                      struct patch *now)
{
    const struct patch_side of_a = {a->part, body_turn(a->body), {0, 0, 0}}, of_b = {b->part, body_turn(b->body), apart};
    if (normal)
        p->faces = patch_find(&of_a, &of_b, *normal);
    patch_measure(&of_a, &of_b, p->faces, now);
    if (now->points < 2)
        p->faces.plane = PATCH_NONE;
    return now->points >= 2;
}

/* ---- distances ---- */

static struct gjk_core core_of(const struct side *s)
{
    return (struct gjk_core){s->part->vertex, s->part->vertices, body_turn(s->body), vec3_load(s->body->position)};
}

/* Into row `at` of what was measured. */
static enum scree_status distance_anew(struct convex *c, const struct looked *l, int at, struct distance4 *d,
                                       struct scree_error *err)
{
    struct gjk_core a = core_of(&l->a), b = core_of(&l->b);
    struct gjk_result r;
    enum gjk_state state = gjk_distance(&a, &b, &l->pair->cache, &r);
    c->counts.searches++;
    if (state != GJK_APART)
        return scree_fail(err, SCREE_BLOWUP, NULL,
                          state == GJK_INSIDE ? "step %llu: bodies %u and %u are deeper in each other than their crusts of %g m"
                                              : "step %llu: the distance of bodies %u and %u was not found (crusts of %g m)",
                          (unsigned long long)c->step, l->group->a, l->group->b, l->a.part->radius + l->b.part->radius);
    vec3_store3(d->on_a[at], vec3_sub(r.on_a, a.centre));
    vec3_store3(d->way[at], vec3_sub(r.on_b, r.on_a));
    d->on_a[at][3] = r.distance;
    return SCREE_OK;
}

/* One pair, which is in row `at` of what was measured. */
static enum scree_status conclude(struct convex *c, const struct looked *l, int at, struct distance4 *d, struct scree_error *err)
{
    const double crusts = l->a.part->radius + l->b.part->radius, least = d->way[at][3] - crusts;
    enum scree_status status = SCREE_OK;
    if (!(d->sure >> at & 1)) {
        if (least > 0.5 * (d->on_a[at][3] - crusts)) { // far enough not to be searched for
            apart(c, l, least);
            return SCREE_OK;
        }
        if ((status = distance_anew(c, l, at, d, err)))
            return status;
    }
    struct vec3 on_a = vec3_load(d->on_a[at]), way = vec3_load(d->way[at]), on_b = vec3_add(on_a, way);
    double distance = d->on_a[at][3], overlap = crusts - distance;
    if (overlap <= 0) {
        apart(c, l, -overlap);
        return SCREE_OK;
    }
    struct patch now = {.normal = vec3_scale(way, 1 / distance)};
    struct vec3 apart = vec3_sub(vec3_load(l->b.body->position), vec3_load(l->a.body->position)), normal = now.normal;
    if (!lies_flat(&l->a, &l->b, apart, on_a, on_b, normal, overlap) || !meet_flat(&l->a, &l->b, apart, &normal, l->pair, &now)) {
        struct vec3 middle = vec3_add(vec3_add(on_a, on_b), vec3_scale(normal, l->a.part->radius - l->b.part->radius));
        now.normal = normal;
        now.points = 1;
        now.point[0].at = vec3_scale(middle, 0.5);
        now.point[0].overlap = overlap;
        now.point[0].share = 1;
    }
    return touch(c, l, &now, err);
}

/* Pairs that wait to be measured: those of round parts, and those with corners to begin with. */
struct waiting {
    struct looked looked[4];
    int count;
    bool round;
};

static enum scree_status measure(struct convex *c, struct waiting *w, struct scree_error *err)
{
    struct distance4 d;
    enum scree_status status = SCREE_OK;
    for (int l = w->count; l < 4; l++)
        w->looked[l] = w->looked[0];
    if (w->count > 0 && w->round)
        distance_round4(w->looked, &d);
    else if (w->count > 0)
        distance_again4(w->looked, &d);
    for (int l = 0; l < w->count && !status; l++)
        status = conclude(c, &w->looked[l], l, &d, err);
    w->count = 0;
    return status;
}

static enum scree_status look(struct convex *c, const struct looked *l, struct waiting wait[2], struct scree_error *err)
{
    const struct gjk_cache *cache = &l->pair->cache;
    bool round = l->a.part->vertices == 1 && l->b.part->vertices == 1;
    c->counts.queries++;
    if (l->pair->faces.plane) {
        struct patch now;
        struct vec3 apart = vec3_sub(vec3_load(l->b.body->position), vec3_load(l->a.body->position));
        if (meet_flat(&l->a, &l->b, apart, NULL, l->pair, &now))
            return touch(c, l, &now, err);
    }
    if (!round && (cache->count < 1 || cache->count > 3)) {
        struct distance4 d = {.sure = 0, .way[0][3] = -INFINITY};
        return conclude(c, l, 0, &d, err);
    }
    struct waiting *w = &wait[round];
    w->looked[w->count++] = *l;
    return w->count == 4 ? measure(c, w, err) : SCREE_OK;
}

/* ---- bodies ---- */

/* A gap between the spheres around two bodies that do not touch: none of their parts need be looked at before it may have
 * closed. */
static double gap_around(const struct body *a, const struct body *b)
{
    struct vec3 apart = vec3_sub(vec3_load(b->position), vec3_load(a->position));
    return sqrt(vec3_dot(apart, apart)) - (a->inverse[3] + b->inverse[3]);
}

/* Bodies whose travel says so; written without a branch, for which it is cannot be guessed. */
static void find_due(struct convex *c)
{
    const double *travel = c->travel;
    c->mets = 0;
    for (uint32_t k = 0; k < c->near.groups; k++) {
        const struct group *g = &c->near.group[k];
        c->met[c->mets] = k;
        c->mets += travel[g->a] + travel[g->b] < g->due ? 0U : 1U;
    }
}

static enum scree_status look_at_parts(struct convex *c, struct group *g, double travel, struct waiting wait[2],
                                       struct scree_error *err)
{
    struct body *a = &c->body[g->a], *b = &c->body[g->b];
    const size_t parts = b->shape->parts, pairs = a->shape->parts * parts;
    uint16_t due[COMPOSITE_PARTS_MAX * COMPOSITE_PARTS_MAX];
    size_t dues = 0;
    for (uint16_t k = 0; k < pairs; k++) {
        due[dues] = k;
        dues += travel < c->near.pair[g->first + k].due ? 0U : 1U;
    }
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < dues && !status; k++) {
        struct looked l = {g, &c->near.pair[g->first + due[k]], side_of(c, a, due[k] / parts), side_of(c, b, due[k] % parts)};
        status = look(c, &l, wait, err);
    }
    return status;
}

/* Some of the groups that are due; what of them need not be pressed leaves the list. Returns how many are left. */
static size_t look_at_groups(struct convex *c, uint32_t *due, size_t dues, struct waiting wait[2], enum scree_status *status,
                             struct scree_error *err)
{
    size_t kept = 0;
    for (size_t k = 0; k < dues && !*status; k++) {
        struct group *g = &c->near.group[due[k]];
        double travel = c->travel[g->a] + c->travel[g->b], gap;
        if (g->touching == 0 && (gap = gap_around(&c->body[g->a], &c->body[g->b])) > 0) {
            g->due = travel + gap;
            continue;
        }
        due[kept++] = due[k];
        *status = look_at_parts(c, g, travel, wait, err);
    }
    for (int k = 0; k < 2 && !*status; k++)
        *status = measure(c, &wait[k], err);
    return kept;
}

enum { AT_ONCE = 256 }; // groups that are looked at, then pressed, while they are at hand

/* When the two are due again, and how many pairs of parts touch. */
static void take_stock(const struct convex *c, struct group *g, size_t pairs)
{
    const struct pair *p = &c->near.pair[g->first];
    g->due = INFINITY;
    g->touching = 0;
    for (size_t k = 0; k < pairs; k++) {
        g->due = p[k].due < g->due ? p[k].due : g->due;
        g->touching += p[k].slot != NO_CONTACT;
    }
}

enum scree_status PER_ISA(convex_meet)(struct convex *c, struct scree_error *err);
enum scree_status PER_ISA(convex_meet)(struct convex *c, struct scree_error *err)
{
    struct pressing pressing = {.convex = c, .law = &c->setup.between};
    struct waiting wait[2] = {{.round = false}, {.round = true}};
    enum scree_status status = SCREE_OK;
    find_due(c);
    for (size_t from = 0, some; from < c->mets; from += some) {
        some = c->mets - from < AT_ONCE ? c->mets - from : AT_ONCE;
        size_t kept = look_at_groups(c, c->met + from, some, wait, &status, err);
        if (status)
            return status;
        for (size_t k = from; k < from + kept; k++) {
            struct group *g = &c->near.group[c->met[k]];
            struct body *a = &c->body[g->a], *b = &c->body[g->b];
            size_t pairs = pairs_between(a, b);
            take_stock(c, g, pairs);
            for (size_t p = 0; p < pairs && g->touching > 0; p++)
                press_pair(&pressing, &c->near.pair[g->first + p], a, b, share_of(c, g));
        }
        press_rest(&pressing);
    }
    return SCREE_OK;
}
