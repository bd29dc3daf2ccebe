/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walls made of triangles.
 *
 * Which contacts a grain has. Every triangle within reach offers its nearest
 * point. Neighbours share edges and corners, so one contact is offered many
 * times; what counts is decided by where on its triangle the point lies:
 *   - the deepest comes first; at equal depth the lower triangle;
 *   - a point on an edge or corner is dropped where a deeper contact lies on a
 *     face, or edge, that has this edge or corner: it is the rim of that contact;
 *   - a contact whose normal is within some 14 degrees of a deeper one's is
 *     dropped: on a sphere two points with such normals are one contact. Seen
 *     from inside a bowl of flat pieces a grain so touches one piece at a time,
 *     and the depth is continuous where it goes over from one to the next.
 * The rest are real: both walls of a corner, face and gate.
 *
 * What a contact remembers. A contact lives with its grain, not with a triangle:
 * at each step one with nearly the normal that an earlier one had is that one,
 * gone on, on whatever triangle; the law turns its springs onto the new normal.
 *
 * Lists follow those of pairs: triangles within the skin from the cells' rebuild,
 * of these the ones that could be touched from the refresh, by the same budget.
 * Surfaces that move have few triangles and are asked afresh at each refresh. */
#include "dem/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"

#define SAME_NORMAL 0.97
enum { CONTACTS_MAX = 4, HITS_MAX = 32 }; // of one grain with one surface, the deepest: three walls meet in a corner

/* ---- making ---- */

static enum scree_status start_surface(struct surface *s, const struct dem_surface *setup, size_t index, struct scree_error *err)
{
    const struct trimesh *m = setup->mesh;
    enum scree_status status = trimesh_create((const double(*)[3])m->vertex, m->vertices, (const uint32_t(*)[3])m->corner,
                                              m->triangles, false, &s->mesh, err);
    if (status)
        return status;
    s->plane = memory_rows(m->triangles, sizeof *s->plane);
    s->partner = memory_rows(m->triangles, sizeof *s->partner);
    if (!s->plane || !s->partner)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a wall of %zu triangles", m->triangles);
    memcpy(s->velocity, setup->velocity, sizeof s->velocity);
    s->from_s = setup->from_s;
    s->until_s = setup->until_s;
    s->base = setup->base;
    s->moves = setup->velocity[0] != 0 || setup->velocity[1] != 0 || setup->velocity[2] != 0;
    for (size_t t = 0; t < m->triangles; t++) {
        s->partner[t] = setup->partner ? setup->partner[t] : 0;
        if (s->partner[t] >= LAW_PARTNERS)
            return scree_fail(err, SCREE_INVALID, NULL, "wall %zu: triangle %zu has no material %d", index, t, s->partner[t]);
        struct vec3 a = vec3_load(s->mesh->vertex[s->mesh->corner[t][0]]), b = vec3_load(s->mesh->vertex[s->mesh->corner[t][1]]),
                    c = vec3_load(s->mesh->vertex[s->mesh->corner[t][2]]), n = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
        n = vec3_scale(n, 1 / sqrt(vec3_dot(n, n)));
        vec3_store3(s->plane[t], n);
        s->plane[t][3] = vec3_dot(n, a);
    }
    return SCREE_OK;
}

enum scree_status mesh_create(struct dem *dem, const struct dem_surface *surfaces, size_t count, struct scree_error *err)
{
    if (count == 0)
        return SCREE_OK;
    for (int a = 0; a < 3; a++)
        if (dem->length[a] > 0)
            return scree_fail(err, SCREE_INVALID, NULL, "walls of triangles do not stand in a periodic domain");
    struct mesh *mesh = dem->mesh = memory_rows(1, sizeof *mesh);
    if (!mesh || !(mesh->surface = memory_rows(count, sizeof *mesh->surface)) ||
        !(mesh->part = memory_rows((size_t)dem->part_count, sizeof *mesh->part)) ||
        !(mesh->asked = memory_rows(dem->moving, sizeof *mesh->asked)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu walls of triangles", count);
    mesh->part_count = dem->part_count;
    for (size_t k = 0; k < count; k++) {
        enum scree_status status = start_surface(&mesh->surface[mesh->count++], &surfaces[k], k, err);
        if (status)
            return status;
    }
    return SCREE_OK;
}

void mesh_free(struct mesh *mesh)
{
    if (!mesh)
        return;
    for (size_t k = 0; k < mesh->count; k++) {
        trimesh_free(mesh->surface[k].mesh);
        free(mesh->surface[k].plane);
        free(mesh->surface[k].partner);
    }
    for (int k = 0; mesh->part && k < mesh->part_count; k++) {
        struct mesh_part *p = &mesh->part[k];
        free(p->outer);
        free(p->unit);
        free(p->group);
        free(p->triangle);
        free(p->found);
        free(p->contact);
        free(p->next);
        free(p->ended);
    }
    free(mesh->part);
    free(mesh->asked);
    free(mesh->surface);
    free(mesh);
}

/* ---- where surfaces are ---- */

struct place { // of a surface at an instant
    double shift[3], velocity[3];
    bool there;
};

static struct place surface_place(const struct surface *s, double time_s)
{
    struct place place = {.there = time_s <= s->until_s};
    for (int a = 0; a < 3 && s->moves && time_s > s->from_s; a++) {
        place.velocity[a] = s->velocity[a];
        place.shift[a] = s->velocity[a] * (time_s - s->from_s);
    }
    return place;
}

/* Positions are those of the step under way. */
static double mesh_now(const struct dem *dem)
{
    return (double)(dem->step + 1) * dem->step_s;
}

/* Above a triangle's plane, on the side it turns to. Far says more cheaply than distance_to that a triangle is out of reach. */
static double height_over(const double plane[4], const double point[3])
{
    return plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] - plane[3];
}

static double distance_to(const struct surface *s, uint32_t triangle, const double point[3])
{
    struct nearest near = trimesh_nearest(s->mesh, triangle, point);
    struct vec3 d = vec3_sub(vec3_load(near.point), vec3_load(point));
    return sqrt(vec3_dot(d, d));
}

enum scree_status mesh_check(const struct dem *dem, struct scree_error *err)
{
    for (size_t k = 0; dem->mesh && k < dem->mesh->count; k++)
        for (size_t i = 0; i < dem->moving; i++) {
            const struct surface *s = &dem->mesh->surface[k];
            const double *x = dem->position[i];
            uint32_t found[64];
            size_t count = trimesh_near(s->mesh, x, x[3], found, 64);
            for (size_t f = 0; f < count && f < 64; f++) {
                double overlap = x[3] - distance_to(s, found[f], x);
                if (overlap > 1e-9 * x[3])
                    return scree_fail(err, SCREE_INVALID, "params",
                                      "grain %u starts %.3g m deep in triangle %u of surface %zu (walls and gates must be clear)",
                                      dem->id[i], overlap, found[f], k);
            }
        }
    return SCREE_OK;
}

/* ---- lists ---- */

/* Triangles of a surface within `radius` of a point; *count of them in p->found. */
static enum scree_status ask(struct mesh_part *p, const struct surface *s, const double point[3], double radius, size_t *count,
                             struct scree_error *err)
{
    for (;;) {
        *count = trimesh_near(s->mesh, point, radius, p->found, p->found_room);
        if (*count <= p->found_room)
            return SCREE_OK;
        enum scree_status status = memory_grow((void **)&p->found, &p->found_room, *count, sizeof *p->found, err);
        if (status)
            return status;
    }
}

static enum scree_status add_outer(struct mesh_near **list, size_t *room, size_t *count, struct mesh_near item,
                                   struct scree_error *err)
{
    enum scree_status status = memory_grow((void **)list, room, *count + 1, sizeof **list, err);
    if (!status)
        (*list)[(*count)++] = item;
    return status;
}

/* Triangles that rows of one unit, [from, to), may touch within the skin: those near a ball about the first that holds all. */
static enum scree_status ask_unit(const struct dem *dem, struct mesh_part *p, size_t from, size_t to, double skin,
                                  struct scree_error *err)
{
    const double *middle = dem->position[from];
    double ball = 0;
    enum scree_status status = SCREE_OK;
    for (size_t i = from; i < to; i++) {
        struct vec3 out = vec3_sub(vec3_load(dem->position[i]), vec3_load(middle));
        double reach = sqrt(vec3_dot(out, out)) + dem->position[i][3] + skin;
        ball = reach > ball ? reach : ball;
    }
    p->unit_count = 0;
    for (uint32_t k = 0; k < dem->mesh->count && !status; k++) {
        const struct surface *s = &dem->mesh->surface[k];
        size_t count = 0;
        status = s->moves ? SCREE_OK : ask(p, s, middle, ball, &count, err);
        for (size_t f = 0; f < count && !status; f++)
            status = add_outer(&p->unit, &p->unit_room, &p->unit_count, (struct mesh_near){0, k, p->found[f]}, err);
    }
    return status;
}

enum scree_status mesh_outer(struct dem *dem, struct part *part, double skin, struct scree_error *err)
{
    if (!dem->mesh)
        return SCREE_OK;
    struct mesh_part *p = &dem->mesh->part[part - dem->parts];
    enum scree_status status = SCREE_OK;
    p->outer_count = 0;
    memcpy(dem->mesh->asked[part->from], dem->position[part->from], (part->to - part->from) * sizeof *dem->mesh->asked);
    for (size_t i = part->from, next = i; i < part->to && !status; i++) {
        if (i == next) {
            next = dem->motion->next(dem, i);
            status = ask_unit(dem, p, i, next, skin, err);
        }
        for (size_t f = 0; f < p->unit_count && !status; f++) {
            const struct surface *s = &dem->mesh->surface[p->unit[f].surface];
            uint32_t t = p->unit[f].triangle;
            const double *x = dem->position[i], reach = x[3] + skin;
            if (fabs(height_over(s->plane[t], x)) <= reach && distance_to(s, t, x) <= reach)
                status = add_outer(&p->outer, &p->outer_room, &p->outer_count,
                                   (struct mesh_near){(uint32_t)i, p->unit[f].surface, t}, err);
        }
    }
    return status;
}

static enum scree_status add_near(struct mesh_part *p, uint32_t grain, uint32_t surface, uint32_t triangle, struct scree_error *err)
{
    struct mesh_group *last = p->group_count ? &p->group[p->group_count - 1] : NULL;
    enum scree_status status =
        memory_grow((void **)&p->triangle, &p->triangle_room, p->triangle_count + 1, sizeof *p->triangle, err);
    if (!status && (!last || last->grain != grain || last->surface != surface)) {
        if ((status = memory_grow((void **)&p->group, &p->group_room, p->group_count + 1, sizeof *p->group, err)))
            return status;
        last = &p->group[p->group_count++];
        *last = (struct mesh_group){grain, surface, (uint32_t)p->triangle_count, 0};
    }
    if (status)
        return status;
    p->triangle[p->triangle_count++] = triangle;
    last->count++;
    return SCREE_OK;
}

/* How near a triangle must be now for the grain to touch it within the horizon. */
static double within(const struct dem *dem, size_t i, const struct surface *s, double horizon, double stray)
{
    struct vec3 v = vec3_load(dem->velocity[i]), w = vec3_load(s->velocity);
    double speed = sqrt(vec3_dot(v, v)) + (s->moves ? sqrt(vec3_dot(w, w)) : 0);
    return dem->position[i][3] + speed * horizon + stray;
}

/* Triangles of a surface that moves, where it is now. */
static enum scree_status near_moving(struct dem *dem, struct mesh_part *p, uint32_t i, uint32_t k, double radius,
                                     struct scree_error *err)
{
    const struct surface *s = &dem->mesh->surface[k];
    struct place place = surface_place(s, mesh_now(dem));
    double at[3];
    size_t count;
    for (int a = 0; a < 3; a++)
        at[a] = dem->position[i][a] - place.shift[a];
    enum scree_status status = ask(p, s, at, radius, &count, err);
    for (size_t f = 0; f < count && !status; f++)
        status = add_near(p, i, k, p->found[f], err);
    return status;
}

/* Room for whatever the groups can hold, so that steps need none. */
static enum scree_status contact_room(struct mesh_part *p, struct scree_error *err)
{
    size_t need = CONTACTS_MAX * p->group_count + p->contact_count, room = p->contact_room;
    enum scree_status status = memory_grow((void **)&p->contact, &room, need, sizeof *p->contact, err);
    size_t next_room = p->contact_room;
    if (status || (status = memory_grow((void **)&p->next, &next_room, room, sizeof *p->next, err)))
        return status;
    p->contact_room = room;
    return memory_grow((void **)&p->ended, &p->ended_room, room, sizeof *p->ended, err);
}

enum scree_status mesh_near(struct dem *dem, struct part *part, double horizon, double stray, struct scree_error *err)
{
    if (!dem->mesh)
        return SCREE_OK;
    struct mesh_part *p = &dem->mesh->part[part - dem->parts];
    enum scree_status status = SCREE_OK;
    size_t o = 0;
    p->group_count = p->triangle_count = 0;
    for (uint32_t i = (uint32_t)part->from; i < part->to; i++)
        for (uint32_t k = 0; k < dem->mesh->count && !status; k++) {
            const struct surface *s = &dem->mesh->surface[k];
            double radius = within(dem, i, s, horizon, stray);
            if (s->moves)
                status = near_moving(dem, p, i, k, radius, err);
            for (; o < p->outer_count && p->outer[o].grain == i && p->outer[o].surface == k && !status; o++)
                if (fabs(height_over(s->plane[p->outer[o].triangle], dem->position[i])) <= radius &&
                    distance_to(s, p->outer[o].triangle, dem->position[i]) <= radius)
                    status = add_near(p, i, k, p->outer[o].triangle, err);
        }
    if (status)
        return status;
    return contact_room(p, err);
}

/* ---- contacts ---- */

struct hit {
    uint32_t triangle, corner[3]; // of the feature touched; repeated where it has fewer than three
    double overlap, normal[3];    // out of the grain
};

/* Whether and how a sphere touches one triangle. */
static bool touch(const struct surface *s, uint32_t triangle, const double at[3], double radius, struct hit *hit)
{
    const double *plane = s->plane[triangle], height = height_over(plane, at);
    if (fabs(height) > radius)
        return false;
    struct nearest near = trimesh_nearest(s->mesh, triangle, at);
    const uint32_t *c = s->mesh->corner[triangle];
    *hit = (struct hit){.triangle = triangle, .corner = {c[0], c[1], c[2]}};
    if (near.feature == 0) { // by the plane, so that a flat of many triangles is one
        hit->overlap = radius - fabs(height);
        for (int a = 0; a < 3; a++)
            hit->normal[a] = height > 0 ? -plane[a] : plane[a];
        return true;
    }
    struct vec3 d = vec3_sub(vec3_load(near.point), vec3_load(at));
    double distance = sqrt(vec3_dot(d, d));
    if (!(distance <= radius) || distance == 0)
        return false;
    int first = near.feature <= 3 ? near.feature - 1 : near.feature - 4, second = near.feature <= 3 ? (first + 1) % 3 : first;
    hit->corner[0] = c[first];
    hit->corner[1] = hit->corner[2] = c[second];
    hit->overlap = radius - distance;
    vec3_store3(hit->normal, vec3_scale(d, 1 / distance));
    return true;
}

static bool before(const struct hit *a, const struct hit *b)
{
    return a->overlap > b->overlap || (a->overlap == b->overlap && a->triangle < b->triangle);
}

/* Whether `rim`'s feature belongs to the closure of `hit`'s. */
static bool is_rim(const struct hit *rim, const struct hit *hit)
{
    for (int r = 0; r < 3; r++)
        if (rim->corner[r] != hit->corner[0] && rim->corner[r] != hit->corner[1] && rim->corner[r] != hit->corner[2])
            return false;
    return true;
}

/* The grain's contacts with a surface, deepest first. */
static size_t resolve(const struct dem *dem, const struct mesh_part *p, const struct mesh_group *g, const double at[3],
                      struct hit out[CONTACTS_MAX])
{
    const struct surface *s = &dem->mesh->surface[g->surface];
    struct hit hits[HITS_MAX + 1];
    size_t count = 0, kept = 0;
    for (uint32_t k = 0; k < g->count; k++) {
        if (!touch(s, p->triangle[g->from + k], at, dem->position[g->grain][3], &hits[count]))
            continue;
        for (size_t place = count; place > 0 && before(&hits[place], &hits[place - 1]); place--) {
            struct hit deeper = hits[place];
            hits[place] = hits[place - 1];
            hits[place - 1] = deeper;
        }
        count += count < HITS_MAX; // the shallowest of very many falls off
    }
    for (size_t k = 0; k < count && kept < CONTACTS_MAX; k++) {
        bool real = true;
        for (size_t o = 0; o < kept && real; o++)
            real = !is_rim(&hits[k], &out[o]) && vec3_dot(vec3_load(hits[k].normal), vec3_load(out[o].normal)) < SAME_NORMAL;
        if (real)
            out[kept++] = hits[k];
    }
    return kept;
}

/* The contact among old ones, not yet taken, whose normal is this hit's. */
static struct wall_pair *goes_on(struct wall_pair *old, size_t count, const struct hit *hit)
{
    struct wall_pair *best = NULL;
    double nearest = SAME_NORMAL;
    for (size_t k = 0; k < count; k++) {
        double cosine = vec3_dot(vec3_load(old[k].normal), vec3_load(hit->normal));
        if (old[k].touching && cosine > nearest) {
            nearest = cosine;
            best = &old[k];
        }
    }
    return best;
}

/* What the springs of a contact held is lost. */
static void end_pair(const struct dem *dem, struct mesh_part *p, const struct wall_pair *pair)
{
    if (!dem->ledger)
        return;
    p->ended[p->ended_count] = dem->law->elastic(&dem->coefs[pair->partner], pair->contact, 0);
    p->ended[p->ended_count++].normal = 0;
}

static void group_contacts(struct dem *dem, struct mesh_part *p, const struct mesh_group *g, struct wall_pair *old, size_t olds)
{
    const struct surface *s = &dem->mesh->surface[g->surface];
    struct place place = surface_place(s, mesh_now(dem));
    const double *v = dem->velocity[g->grain];
    double at[3], velocity[4] = {v[0] - place.velocity[0], v[1] - place.velocity[1], v[2] - place.velocity[2], v[3]};
    struct hit hits[CONTACTS_MAX];
    for (int a = 0; a < 3; a++)
        at[a] = dem->position[g->grain][a] - place.shift[a];
    size_t count = place.there ? resolve(dem, p, g, at, hits) : 0;
    for (size_t k = 0; k < count; k++) {
        struct wall_pair *pair = &p->next[p->next_count++], *was = goes_on(old, olds, &hits[k]);
        double radius = dem->position[g->grain][3];
        if (was) {
            memcpy(pair->contact, was->contact, sizeof pair->contact);
            was->touching = 0;
        } else {
            memset(pair->contact, 0, sizeof pair->contact);
            pair->contact[CONTACT_R] = pair->contact[CONTACT_R1] = radius;
        }
        pair->grain = g->grain;
        pair->wall = g->surface;
        pair->touching = 1;
        pair->loss = (struct contact_loss){0};
        pair->partner = s->partner[hits[k].triangle];
        pair->overlap = hits[k].overlap;
        memcpy(pair->normal, hits[k].normal, sizeof pair->normal);
        pair->approach = vec3_dot(vec3_load(velocity), vec3_load(pair->normal));
        dem->law->wall(&dem->coefs[pair->partner], velocity, dem->spin[g->grain], dem->arm[g->grain], dem->ledger, pair);
    }
    for (size_t k = 0; k < olds; k++)
        if (old[k].touching)
            end_pair(dem, p, &old[k]);
}

static bool stands_before(const struct wall_pair *pair, uint32_t grain, uint32_t surface)
{
    return pair->grain < grain || (pair->grain == grain && pair->wall < surface);
}

void mesh_contacts(struct dem *dem, struct part *part)
{
    if (!dem->mesh)
        return;
    struct mesh_part *p = &dem->mesh->part[part - dem->parts];
    size_t o = 0;
    p->next_count = p->ended_count = 0;
    for (size_t k = 0; k < p->group_count; k++) {
        const struct mesh_group *g = &p->group[k];
        for (; o < p->contact_count && stands_before(&p->contact[o], g->grain, g->surface); o++)
            end_pair(dem, p, &p->contact[o]);
        size_t from = o;
        while (o < p->contact_count && p->contact[o].grain == g->grain && p->contact[o].wall == g->surface)
            o++;
        group_contacts(dem, p, g, p->contact + from, o - from);
    }
    for (; o < p->contact_count; o++)
        end_pair(dem, p, &p->contact[o]);
    struct wall_pair *old = p->contact;
    p->contact = p->next;
    p->contact_count = p->next_count;
    p->next = old;
}

void mesh_kick(struct dem *dem, struct part *part, const struct sink *sink)
{
    if (!dem->mesh)
        return;
    const struct mesh_part *p = &dem->mesh->part[part - dem->parts];
    for (size_t k = 0; k < p->contact_count; k++)
        wall_pair_kick(&p->contact[k], sink);
}

void mesh_account(struct dem *dem)
{
    for (int k = 0; dem->mesh && k < dem->part_count; k++) {
        const struct mesh_part *p = &dem->mesh->part[k];
        for (size_t c = 0; c < p->contact_count; c++) {
            const struct wall_pair *pair = &p->contact[c];
            for (int a = 0; a < 3 && dem->mesh->surface[pair->wall].base; a++)
                dem->base_sum[a] += pair->out.force[a];
            if (dem->ledger)
                add_loss(dem->lost, &pair->loss);
        }
    }
    for (int k = 0; dem->mesh && k < dem->part_count; k++)
        for (size_t c = 0; c < dem->mesh->part[k].ended_count; c++)
            add_loss(dem->lost, &dem->mesh->part[k].ended[c]);
}

/* ---- contacts that change hands ---- */

struct moved {
    uint64_t key;
    size_t from;
};

static int by_key(const void *a, const void *b)
{
    const struct moved *p = a, *q = b;
    if (p->key != q->key)
        return p->key < q->key ? -1 : 1;
    return (p->from > q->from) - (p->from < q->from);
}

enum scree_status mesh_take(const struct dem *dem, struct wall_pair **out, size_t *count, struct scree_error *err)
{
    size_t total = 0;
    for (int k = 0; dem->mesh && k < dem->part_count; k++)
        total += dem->mesh->part[k].contact_count;
    *count = 0;
    if (!(*out = memory_rows(total, sizeof **out)))
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu contacts with walls", total);
    for (int k = 0; dem->mesh && k < dem->part_count; k++) {
        const struct mesh_part *p = &dem->mesh->part[k];
        if (p->contact_count)
            memcpy(*out + *count, p->contact, p->contact_count * sizeof **out);
        *count += p->contact_count;
    }
    return SCREE_OK;
}

enum scree_status mesh_give(struct dem *dem, const struct wall_pair *pairs, size_t count, struct scree_error *err)
{
    struct moved *order = memory_rows(count, sizeof *order);
    enum scree_status status = order ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to sort %zu contacts", count);
    for (size_t k = 0; k < count && !status; k++)
        order[k] = (struct moved){(uint64_t)pairs[k].grain << 32 | pairs[k].wall, k};
    if (!status)
        qsort(order, count, sizeof *order, by_key);
    size_t at = 0;
    for (int k = 0; dem->mesh && k < dem->part_count && !status; k++) {
        struct mesh_part *p = &dem->mesh->part[k];
        size_t from = at;
        while (at < count && order[at].key >> 32 < dem->parts[k].to)
            at++;
        p->contact_count = at - from;
        p->group_count = 0;
        if ((status = contact_room(p, err)))
            break;
        for (size_t c = from; c < at; c++)
            p->contact[c - from] = pairs[order[c].from];
    }
    free(order);
    return status;
}

enum scree_status mesh_follow(struct dem *dem, const uint32_t *new_row, struct scree_error *err)
{
    struct wall_pair *pairs = NULL;
    size_t count;
    if (!dem->mesh)
        return SCREE_OK;
    enum scree_status status = mesh_take(dem, &pairs, &count, err);
    for (size_t k = 0; k < count && !status; k++)
        pairs[k].grain = new_row[pairs[k].grain];
    if (!status)
        status = mesh_give(dem, pairs, count, err);
    free(pairs);
    return status;
}
