/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where parts touch, and who feels it; compiled once per instruction set.
 *
 * The corners of a body are put into space once a step, when they are first asked
 * for; four at once are then measured along a direction. Most pairs that are looked
 * at touched in the step before, and touch at the same corners: that is tried first,
 * and what holds good is what GJK would end with (geom/gjk.c, which is asked where
 * it does not, and is the reference that this is tested against). */
#include <math.h>

#include "base/lanes.h"
#include "convex/state.h"

/* ---- corners in space ---- */

SIMD_INLINE const double *corners_of(struct convex *c, struct body *b)
{
    double *x = c->corner + (size_t)(b - c->body) * 3 * c->corners;
    if (b->placed == c->step + 1)
        return x;
    const double *own = b->outline->own;
    const size_t n = b->outline->corners;
    for (size_t k = 0; k < n; k += 4) {
        v4 u = v4_load(own + k), v = v4_load(own + n + k), w = v4_load(own + 2 * n + k);
        for (int i = 0; i < 3; i++)
            v4_store(x + (size_t)i * c->corners + k,
                     u * v4_all(b->axis[0][i]) + v * v4_all(b->axis[1][i]) + w * v4_all(b->axis[2][i]));
    }
    b->placed = c->step + 1;
    return x;
}

/* The corners of a part: x, with y and z `stride` farther. */
struct side {
    const struct body *body;
    const struct composite_part *part;
    const double *x;
    size_t stride;
};

SIMD_INLINE struct side side_of(struct convex *c, struct body *b, size_t part)
{
    return (struct side){b, &b->shape->part[part], corners_of(c, b) + b->outline->from[part], c->corners};
}

SIMD_INLINE struct vec3 corner(const struct side *s, size_t k)
{
    return (struct vec3){s->x[k], s->x[s->stride + k], s->x[2 * s->stride + k]};
}

/* How far the part reaches along d from its body's centre, times |d|. */
SIMD_INLINE double highest(const struct side *s, struct vec3 d)
{
    const v4 dx = v4_all(d.x), dy = v4_all(d.y), dz = v4_all(d.z);
    v4 most = v4_all(-INFINITY);
    for (size_t k = 0; k < s->part->vertices; k += 4)
        most = v4_max(most, dx * v4_load(s->x + k) + dy * v4_load(s->x + s->stride + k) + dz * v4_load(s->x + 2 * s->stride + k));
    double low = most[0] > most[1] ? most[0] : most[1], high = most[2] > most[3] ? most[2] : most[3];
    return low > high ? low : high;
}

/* ---- distance ---- */

#define FLAT     1e-12 // as in geom/gjk.c
#define TOUCHING 1e-26 // square of the distance over that of the size, as there
#define ROUNDING 4e-15 // by which the corners' own heights along v may differ from v.v, over the square of their size

/* Shares of one to three corners of the difference in its point that is nearest to the origin; false where that lies on
 * the rim or the corners span nothing. */
SIMD_INLINE bool shares_of(const struct vec3 w[3], int count, double share[3])
{
    share[0] = 1, share[1] = share[2] = 0;
    if (count == 1)
        return true;
    struct vec3 e = vec3_sub(w[1], w[0]);
    double ee = vec3_dot(e, e);
    if (count == 2) {
        if (!(ee > 0))
            return false;
        share[1] = -vec3_dot(e, w[0]) / ee;
        share[0] = 1 - share[1];
        return share[0] > 0 && share[1] > 0;
    }
    struct vec3 f = vec3_sub(w[2], w[0]), n = vec3_cross(e, f), p = vec3_scale(w[0], -1);
    double nn = vec3_dot(n, n);
    if (!(nn > FLAT * ee * vec3_dot(f, f)))
        return false;
    double over = 1 / nn;
    share[1] = vec3_dot(vec3_cross(p, f), n) * over;
    share[2] = vec3_dot(vec3_cross(e, p), n) * over;
    share[0] = 1 - share[1] - share[2];
    return share[0] > 0 && share[1] > 0 && share[2] > 0;
}

/* The distance by the corners that the pair was nearest at last time, true if no others are nearer. Points are from a's
 * centre. */
SIMD_INLINE bool distance_again(const struct side *a, const struct side *b, const struct gjk_cache *cache, struct vec3 apart,
                                struct gjk_result *out)
{
    struct vec3 on_a[3], w[3], at = {0, 0, 0}, v = {0, 0, 0};
    double share[3], size2 = 0;
    if (cache->count < 1 || cache->count > 3)
        return false;
    for (int k = 0; k < 3; k++) {
        int from = k < cache->count ? k : 0;
        on_a[k] = corner(a, cache->a[from]);
        w[k] = vec3_add(vec3_sub(corner(b, cache->b[from]), on_a[k]), apart);
        double square = vec3_dot(w[k], w[k]);
        size2 = square > size2 ? square : size2;
    }
    if (!shares_of(w, cache->count, share))
        return false;
    for (int k = 0; k < 3; k++) {
        v = vec3_add(v, vec3_scale(w[k], share[k]));
        at = vec3_add(at, vec3_scale(on_a[k], share[k]));
    }
    double vv = vec3_dot(v, v);
    double nearest = vec3_dot(v, apart) - highest(b, vec3_scale(v, -1)) - highest(a, v);
    if (!(vv > TOUCHING * size2 && vv - nearest <= ROUNDING * size2))
        return false;
    out->distance = sqrt(vv);
    out->normal = vec3_scale(v, 1 / out->distance);
    out->on_a = at;
    out->on_b = vec3_add(at, v);
    return true;
}

static struct gjk_core core_of(const struct side *s)
{
    return (struct gjk_core){s->part->vertex, s->part->vertices, body_turn(s->body), vec3_load(s->body->position)};
}

static enum scree_status distance_anew(struct convex *c, const struct group *g, const struct side *a, const struct side *b,
                                       struct pair *p, struct gjk_result *out, struct scree_error *err)
{
    struct gjk_core ca = core_of(a), cb = core_of(b);
    enum gjk_state state = gjk_distance(&ca, &cb, &p->cache, out);
    c->counts.searches++;
    if (state != GJK_APART)
        return scree_fail(err, SCREE_BLOWUP, NULL,
                          state == GJK_INSIDE ? "step %llu: bodies %u and %u are deeper in each other than their crusts of %g m"
                                              : "step %llu: the distance of bodies %u and %u was not found (crusts of %g m)",
                          (unsigned long long)c->step, g->a, g->b, a->part->radius + b->part->radius);
    out->on_a = vec3_sub(out->on_a, ca.centre);
    out->on_b = vec3_sub(out->on_b, ca.centre);
    return SCREE_OK;
}

/* ---- contacts between bodies ---- */

/* A contact's law at a point; `share` of it is felt. */
static void press(const struct convex *c, const struct spring_pair *law, const struct spring_motion *motion, struct vec3 point,
                  double share, struct contact *contact)
{
    contact->point = point;
    contact->share = share;
    contact->result = spring_memory_step(law, motion, c->setup.step_s, &contact->memory);
    contact->elastic = 0.5 * law->stiffness * motion->overlap * motion->overlap;
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
            struct vec3 way = vec3_sub(before[other].point, now->point[k].at);
            if (vec3_dot(way, way) < least) {
                least = vec3_dot(way, way);
                c->contact[slot].memory = before[other].memory;
            }
        }
    }
    return SCREE_OK;
}

/* Points are from a's centre. */
static enum scree_status touch(struct convex *c, struct group *g, struct pair *p, struct patch *now, struct scree_error *err)
{
    const struct body *a = &c->body[g->a], *b = &c->body[g->b];
    size_t k = 0;
    for (size_t n = 0; n < now->points; n++)
        now->point[n].at = vec3_add(vec3_load(a->position), now->point[n].at);
    enum scree_status status = follow(c, p, now, err);
    if (status)
        return status;
    p->due = 0;
    g->touching++;
    for (uint32_t slot = p->slot; slot != NO_CONTACT; slot = c->contact[slot].next, k++) {
        struct vec3 point = now->point[k].at;
        struct spring_motion motion = {.overlap = now->point[k].overlap,
                                       .normal = now->normal,
                                       .velocity = vec3_sub(body_velocity_at(a, point), body_velocity_at(b, point)),
                                       .spin = vec3_sub(vec3_load(a->omega), vec3_load(b->omega))};
        press(c, &c->setup.between, &motion, point, now->point[k].share, &c->contact[slot]);
    }
    return SCREE_OK;
}

/* How many corners are higher along d than that; one may be counted again where the part's are filled up. */
SIMD_INLINE int corners_above(const struct side *s, struct vec3 d, double height)
{
    const v4 dx = v4_all(d.x), dy = v4_all(d.y), dz = v4_all(d.z), limit = v4_all(height);
    int count = 0;
    for (size_t k = 0; k < s->part->vertices; k += 4) {
        v4 h = dx * v4_load(s->x + k) + dy * v4_load(s->x + s->stride + k) + dz * v4_load(s->x + 2 * s->stride + k);
        count += __builtin_popcount(m4_bits(h >= limit));
    }
    return count;
}

/* Whether a face of one may lie on a face or an edge of the other: crossed edges and corners touch in one point. No corner is
 * higher along the normal than the nearest point; those that press are lower by less than the overlap. */
static bool lies_flat(const struct side *a, const struct side *b, struct vec3 apart, const struct gjk_result *r, double overlap)
{
    if (a->part->faces == 0 || b->part->faces == 0)
        return false;
    int of_a = corners_above(a, r->normal, vec3_dot(r->on_a, r->normal) - overlap);
    if (of_a < 2)
        return false;
    int of_b = corners_above(b, vec3_scale(r->normal, -1), vec3_dot(vec3_sub(apart, r->on_b), r->normal) - overlap);
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
    p->flat = now->points >= 2;
    return p->flat;
}

static enum scree_status meet_pair(struct convex *c, struct group *g, const struct side *a, const struct side *b, struct pair *p,
                                   struct scree_error *err)
{
    struct gjk_result r;
    struct patch now;
    struct vec3 apart = vec3_sub(vec3_load(b->body->position), vec3_load(a->body->position));
    enum scree_status status = SCREE_OK;
    c->counts.queries++;
    if (p->flat && meet_flat(a, b, apart, NULL, p, &now))
        return touch(c, g, p, &now, err);
    if (!distance_again(a, b, &p->cache, apart, &r) && (status = distance_anew(c, g, a, b, p, &r, err)))
        return status;
    double overlap = a->part->radius + b->part->radius - r.distance;
    if (overlap <= 0) {
        convex_part(c, p);
        p->due = a->body->position[3] + b->body->position[3] - overlap;
        return SCREE_OK;
    }
    if (!lies_flat(a, b, apart, &r, overlap) || !meet_flat(a, b, apart, &r.normal, p, &now)) {
        struct vec3 middle = vec3_add(vec3_add(r.on_a, r.on_b), vec3_scale(r.normal, a->part->radius - b->part->radius));
        now.normal = r.normal;
        now.points = 1;
        now.point[0].at = vec3_scale(middle, 0.5);
        now.point[0].overlap = overlap;
        now.point[0].share = 1;
    }
    return touch(c, g, p, &now, err);
}

static void feel(struct body *b, struct vec3 point, struct vec3 force, struct vec3 torque)
{
    struct vec3 arm = vec3_sub(point, vec3_load(b->position));
    vec3_store3(b->force, vec3_add(vec3_load(b->force), force));
    vec3_store3(b->torque, vec3_add(vec3_load(b->torque), vec3_add(vec3_cross(arm, force), torque)));
}

static double share_of(const struct convex *c, const struct group *g)
{
    return c->setup.average && g->touching > 1 ? 1.0 / (double)g->touching : 1;
}

static void hand_out(struct convex *c, const struct group *g, size_t pairs)
{
    double share = share_of(c, g);
    for (size_t k = 0; k < pairs; k++)
        for (uint32_t slot = c->near.pair[g->first + k].slot; slot != NO_CONTACT; slot = c->contact[slot].next) {
            struct contact *contact = &c->contact[slot];
            contact->share *= share;
            struct vec3 force = vec3_scale(contact->result.force, contact->share);
            struct vec3 torque = vec3_scale(contact->result.torque, contact->share);
            feel(&c->body[g->a], contact->point, force, torque);
            feel(&c->body[g->b], contact->point, vec3_scale(force, -1), vec3_scale(torque, -1));
        }
}

enum scree_status PER_ISA(convex_meet)(struct convex *c, struct scree_error *err);
enum scree_status PER_ISA(convex_meet)(struct convex *c, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    for (size_t k = 0; k < c->near.groups; k++) {
        struct group *g = &c->near.group[k];
        struct body *a = &c->body[g->a], *b = &c->body[g->b];
        double travel = a->position[3] + b->position[3];
        if (travel < g->due)
            continue;
        struct pair *p = &c->near.pair[g->first];
        g->due = INFINITY;
        g->touching = 0;
        for (size_t pa = 0; pa < a->shape->parts; pa++)
            for (size_t pb = 0; pb < b->shape->parts; pb++, p++) {
                if (travel >= p->due) {
                    struct side sa = side_of(c, a, pa), sb = side_of(c, b, pb);
                    if ((status = meet_pair(c, g, &sa, &sb, p, err)))
                        return status;
                }
                g->due = p->due < g->due ? p->due : g->due;
            }
        if (g->touching > 0)
            hand_out(c, g, pairs_between(a, b));
    }
    return SCREE_OK;
}

/* ---- contacts with walls ---- */

/* What is under a gate, or has come past it, is not touched by it. */
static bool past_gate(const struct gate_now *gate, const struct pair *p, double z, double height)
{
    return !gate->stands || z < gate->lift || (p->slot == NO_CONTACT && height < 0 && !gate->hole);
}

/* How far a corner at x is from a level wall with a hole, which has two sides, and from which way. Over the hole the rim's
 * nearest point is what it may touch: where a corner comes off the wall that is the same. */
static double from_rim(const double hole[2][2], struct vec3 x, double height, struct vec3 *away)
{
    const double aside[4] = {x.x - hole[0][0], hole[0][1] - x.x, x.y - hole[1][0], hole[1][1] - x.y};
    static const struct vec3 inwards[4] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    int nearest = 0;
    for (int k = 1; k < 4; k++)
        nearest = aside[k] < aside[nearest] ? k : nearest;
    double in = aside[nearest] > 0 ? aside[nearest] : 0, far = sqrt(in * in + height * height);
    if (far > 0)
        *away = vec3_scale(vec3_add(vec3_scale(*away, height), vec3_scale(inwards[nearest], in)), 1 / far);
    return far;
}

static void hand_out_wall(struct convex *c, const struct group *g)
{
    double share = share_of(c, g);
    struct body *a = &c->body[g->a];
    for (size_t k = 0; k < a->outline->corners; k++) {
        const struct pair *p = &c->wall.pair[g->first + k];
        if (p->slot == NO_CONTACT)
            continue;
        struct contact *contact = &c->contact[p->slot];
        struct vec3 force = vec3_scale(contact->result.force, share);
        contact->share = share;
        feel(a, contact->point, force, vec3_scale(contact->result.torque, share));
        if (g->b == 0)
            c->base = vec3_sub(c->base, force);
    }
}

/* The corners of a part against a wall; returns the least gap of those that do not touch it, m. */
static enum scree_status meet_wall(struct convex *c, struct group *g, const struct side *s, const struct gate_now *gate,
                                   struct pair *pair, double *gap, struct scree_error *err)
{
    const struct convex_wall *wall = &c->walls[g->b];
    struct vec3 normal = vec3_load(wall->normal), centre = vec3_load(s->body->position);
    double at = vec3_dot(vec3_sub(centre, vec3_load(wall->point)), normal), crust = s->part->radius;
    for (size_t k = 0; k < s->part->vertices; k++) {
        struct pair *p = &pair[k];
        struct vec3 x = corner(s, k), away = normal;
        double height = at + vec3_dot(x, normal);
        if (gate->hole)
            height = from_rim(gate->hole, vec3_add(centre, x), height, &away);
        double overlap = crust - height;
        if (overlap <= 0) {
            convex_part(c, p);
            *gap = -overlap < *gap ? -overlap : *gap;
            continue;
        }
        *gap = 0;
        if (gate->partial && past_gate(gate, p, centre.z + x.z, height)) {
            convex_part(c, p);
            continue;
        }
        struct vec3 point = vec3_add(centre, vec3_sub(x, vec3_scale(away, 0.5 * (height + crust))));
        struct spring_motion motion = {.overlap = overlap,
                                       .normal = vec3_scale(away, -1),
                                       .velocity = body_velocity_at(s->body, point),
                                       .spin = vec3_load(s->body->omega)};
        motion.velocity.z -= gate->speed;
        enum scree_status status = convex_touch(c, p, 1, err);
        if (status)
            return status;
        g->touching++;
        press(c, &c->setup.at_wall, &motion, point, 1, &c->contact[p->slot]);
    }
    return SCREE_OK;
}

enum scree_status PER_ISA(convex_meet_walls)(struct convex *c, struct scree_error *err);
enum scree_status PER_ISA(convex_meet_walls)(struct convex *c, struct scree_error *err)
{
    for (size_t k = 0; k < c->wall.groups; k++) {
        struct group *g = &c->wall.group[k];
        struct body *a = &c->body[g->a];
        double gap = INFINITY;
        if (a->position[3] < g->due)
            continue;
        g->touching = 0;
        const struct gate_now gate = convex_gate_now(c, g->b);
        for (size_t p = 0; p < a->shape->parts; p++) {
            struct side s = side_of(c, a, p);
            enum scree_status status = meet_wall(c, g, &s, &gate, &c->wall.pair[g->first + a->outline->from[p]], &gap, err);
            if (status)
                return status;
        }
        g->due = gap > 0 ? a->position[3] + gap : 0;
        if (g->touching > 0)
            hand_out_wall(c, g);
    }
    return SCREE_OK;
}
