/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The read-only picture of a world at the time of its last step, and its hash.
 *
 * Rows hold v(n-1/2) plus the kicks of contacts at x(n); the velocity at step n
 * is v(n-1/2) plus half of those kicks and half of gravity's, so half the kicks
 * are taken back, contact by contact. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "dem/bodies.h"
#include "dem/mesh.h"
#include "dem/state.h"

static enum scree_status view_room(struct dem *dem, size_t contacts, struct scree_error *err)
{
    size_t n = dem->grains;
    if (!dem->view_position)
        dem->view_position = memory_rows(n, sizeof *dem->view_position);
    if (!dem->view_velocity)
        dem->view_velocity = memory_rows(n, sizeof *dem->view_velocity);
    if (!dem->view_spin)
        dem->view_spin = memory_rows(n, sizeof *dem->view_spin);
    if (!dem->view_position || !dem->view_velocity || !dem->view_spin)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to look at %zu grains", n);
    return memory_grow((void **)&dem->view_contacts, &dem->view_contact_room, contacts, sizeof *dem->view_contacts, err);
}

static void view_rows(struct dem *dem)
{
    double dt = dem->step_s;
    for (size_t i = 0; i < dem->grains; i++) {
        bool moves = i < dem->moving;
        double r = dem->position[i][3];
        for (int a = 0; a < 3; a++) {
            double x = dem->position[i][a], box = dem->length[a];
            dem->view_position[i][a] = box > 0 ? x - floor(x / box) * box : x;
            dem->view_velocity[i][a] = moves ? dem->velocity[i][a] + 0.5 * dem->gravity[a] * dt : 0;
            dem->view_spin[i][a] = dem->spin[i][a];
        }
        dem->view_position[i][3] = r;
        dem->view_velocity[i][3] = dem->mass[i];
        dem->view_spin[i][3] = 0.4 * dem->mass[i] * r * r;
    }
}

static void take_back(struct dem *dem, size_t row, double sign, const double force[3], const double torque[3])
{
    for (int a = 0; a < 3; a++) {
        dem->view_velocity[row][a] -= 0.5 * sign * force[a] * dem->velocity[row][3];
        dem->view_spin[row][a] -= 0.5 * torque[a] * dem->spin[row][3];
    }
}

static void finish_contact(const struct dem *dem, int partner, const double contact[CONTACT_SLOTS], const struct contact_out *out,
                           struct view_contact *c)
{
    struct contact_loss e = dem->law->elastic(&dem->coefs[partner], contact, c->overlap);
    c->elastic = e.normal + e.tangential + e.torsion + e.rolling;
    c->force_normal = vec3_dot(vec3_load(out->force), vec3_load(c->normal));
    memcpy(c->force, out->force, sizeof c->force);
    memcpy(c->torque_a, out->torque1, sizeof c->torque_a);
    memcpy(c->torque_b, out->torque2, sizeof c->torque_b);
}

static void view_pairs(struct dem *dem, const struct part *part, struct view *view)
{
    for (size_t k = 0; k < part->active_count; k++) {
        uint32_t p = part->active[k], i = part->near.first[p], second = part->near.second[p], j = second & IMAGE_ROW;
        struct vec3 x = vec3_sub(vec3_load(dem->position[j]), vec3_load(dem->position[i]));
        x = vec3_add(x, vec3_load(dem->shift[second >> IMAGE_SHIFT]));
        double distance = sqrt(vec3_dot(x, x));
        struct vec3 n = vec3_scale(x, 1.0 / distance);
        struct view_contact *c = &dem->view_contacts[view->contacts++];
        *c = (struct view_contact){
            .a = i, .b = j, .on_base = j >= dem->moving, .overlap = fmax(0, dem->position[i][3] + dem->position[j][3] - distance)};
        vec3_store3(c->normal, n);
        finish_contact(dem, 0, part->near.contact[p], &part->out[k], c);
        take_back(dem, i, -1, part->out[k].force, part->out[k].torque1);
        take_back(dem, j, 1, part->out[k].force, part->out[k].torque2);
        if (j >= dem->moving && counts_on_base(dem, touch_y(dem, i, j)))
            for (int a = 0; a < 3; a++)
                view->base_force[a] += part->out[k].force[a];
    }
}

static void view_walls(struct dem *dem, const struct part *part, struct view *view)
{
    for (size_t k = 0; k < part->wall_count; k++) {
        const struct wall_pair *pair = &part->walls[k];
        if (!pair->touching)
            continue;
        struct view_contact *c = &dem->view_contacts[view->contacts++];
        *c = (struct view_contact){
            .a = pair->grain, .b = VIEW_WALL + pair->wall, .on_base = dem->walls[pair->wall].base, .overlap = pair->overlap};
        memcpy(c->normal, pair->normal, sizeof c->normal);
        finish_contact(dem, pair->partner, pair->contact, &pair->out, c);
        memset(c->torque_b, 0, sizeof c->torque_b);
        take_back(dem, pair->grain, -1, pair->out.force, pair->out.torque1);
        if (dem->walls[pair->wall].base && counts_on_base(dem, dem->position[pair->grain][1]))
            for (int a = 0; a < 3; a++)
                view->base_force[a] += pair->out.force[a];
    }
}

/* The first surface that counts as the base. */
static const struct trimesh *base_mesh(const struct dem *dem)
{
    for (size_t k = 0; dem->mesh && k < dem->mesh->count; k++)
        if (dem->mesh->surface[k].base)
            return dem->mesh->surface[k].mesh;
    return NULL;
}

static void view_mesh(struct dem *dem, const struct mesh_part *part, struct view *view)
{
    for (size_t k = 0; k < part->contact_count; k++) {
        const struct wall_pair *pair = &part->contact[k];
        struct view_contact *c = &dem->view_contacts[view->contacts++];
        *c = (struct view_contact){.a = pair->grain,
                                   .b = VIEW_WALL + (uint32_t)dem->wall_count + pair->wall,
                                   .on_base = dem->mesh->surface[pair->wall].base,
                                   .overlap = pair->overlap};
        memcpy(c->normal, pair->normal, sizeof c->normal);
        finish_contact(dem, pair->partner, pair->contact, &pair->out, c);
        memset(c->torque_b, 0, sizeof c->torque_b);
        take_back(dem, pair->grain, -1, pair->out.force, pair->out.torque1);
        for (int a = 0; a < 3 && dem->mesh->surface[pair->wall].base; a++)
            view->base_force[a] += pair->out.force[a];
    }
}

static void view_approach(const struct dem *dem, struct view *view)
{
    for (size_t k = 0; k < view->contacts; k++) {
        struct view_contact *c = &dem->view_contacts[k];
        struct vec3 v = vec3_load(dem->view_velocity[c->a]);
        if (c->b < VIEW_WALL)
            v = vec3_sub(v, vec3_load(dem->view_velocity[c->b]));
        c->approach = vec3_dot(v, vec3_load(c->normal));
    }
}

enum scree_status dem_view(struct dem *dem, struct view *view, struct scree_error *err)
{
    size_t contacts = 0;
    for (int k = 0; k < dem->part_count; k++)
        contacts += dem->parts[k].active_count + dem->parts[k].wall_count + (dem->mesh ? dem->mesh->part[k].contact_count : 0);
    enum scree_status status = view_room(dem, contacts, err);
    if (status)
        return status;
    *view = (struct view){.time_s = dem_time(dem),
                          .step_s = dem->step_s,
                          .step = dem->step,
                          .moving = dem->moving,
                          .fixed = dem->grains - dem->moving,
                          .id = dem->id,
                          .position = (const double(*)[4])dem->view_position,
                          .velocity = (const double(*)[4])dem->view_velocity,
                          .spin = (const double(*)[4])dem->view_spin,
                          .contact = dem->view_contacts,
                          .gravity_work = dem->motion->potential(dem) - dem->start_potential + dem->wrapped_work,
                          .base_mesh = base_mesh(dem),
                          .dissipated_normal = dem->lost[0],
                          .dissipated_tangential = dem->lost[1],
                          .dissipated_torsion = dem->lost[2],
                          .dissipated_rolling = dem->lost[3]};
    for (int a = 0; a < 3; a++) {
        view->length[a] = dem->length[a];
        view->periodic[a] = dem->length[a] > 0;
        view->gravity[a] = dem->gravity[a];
    }
    view_rows(dem);
    if (dem->step > 0) { // before the first step nothing has been evaluated
        for (int k = 0; k < dem->part_count; k++)
            view_pairs(dem, &dem->parts[k], view);
        for (int k = 0; k < dem->part_count; k++)
            view_walls(dem, &dem->parts[k], view);
        for (int k = 0; dem->mesh && k < dem->part_count; k++)
            view_mesh(dem, &dem->mesh->part[k], view);
    }
    if (dem->bodies && (status = bodies_view(dem, view, err)))
        return status;
    view_approach(dem, view);
    return SCREE_OK;
}

/* ---- hash ---- */

uint64_t hash_double(uint64_t h, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    h = (h ^ bits) * 0x9e3779b97f4a7c15u;
    return h ^ (h >> 29);
}

static uint64_t hash_contact(uint64_t h, const double contact[CONTACT_SLOTS], double sign)
{
    static const int signed_slots[] = {CONTACT_FT_X, CONTACT_FT_Y, CONTACT_FT_Z, CONTACT_MR_X, CONTACT_MR_Y, CONTACT_MR_Z};
    for (size_t s = 0; s < sizeof signed_slots / sizeof *signed_slots; s++)
        h = hash_double(h, sign * contact[signed_slots[s]] + 0.0); // + 0 makes one zero of two
    h = hash_double(h, contact[CONTACT_MN] + 0.0);
    h = hash_double(h, contact[CONTACT_FN]);
    return hash_double(h, contact[CONTACT_A]);
}

/* Grains and contacts are added up, each hashed with its ids, so that the order
 * in memory does not show. */
uint64_t dem_hash(const struct dem *dem)
{
    uint64_t sum = hash_double(1, (double)dem->step);
    for (size_t i = 0; i < dem->grains; i++) {
        uint64_t h = hash_double(2, dem->id[i]);
        for (int a = 0; a < 4; a++) {
            h = hash_double(h, dem->position[i][a]);
            h = hash_double(h, dem->velocity[i][a]);
            h = hash_double(h, dem->spin[i][a]);
        }
        sum += h;
    }
    for (int k = 0; k < dem->part_count; k++) {
        const struct part *part = &dem->parts[k];
        for (size_t c = 0; c < part->active_count; c++) {
            uint32_t p = part->active[c], a = dem->id[part->near.first[p]], b = dem->id[part->near.second[p] & IMAGE_ROW];
            uint64_t h = hash_double(hash_double(3, a < b ? a : b), a < b ? b : a);
            sum += hash_contact(h, part->near.contact[p], a < b ? 1 : -1);
        }
        for (size_t w = 0; w < part->wall_count; w++)
            if (part->walls[w].touching)
                sum += hash_contact(hash_double(hash_double(4, dem->id[part->walls[w].grain]), part->walls[w].wall),
                                    part->walls[w].contact, 1);
        for (size_t c = 0; dem->mesh && c < dem->mesh->part[k].contact_count; c++) {
            const struct wall_pair *pair = &dem->mesh->part[k].contact[c];
            uint64_t h = hash_double(hash_double(6, dem->id[pair->grain]), pair->wall);
            for (int a = 0; a < 3; a++)
                h = hash_double(h, pair->normal[a] + 0.0);
            sum += hash_contact(h, pair->contact, 1);
        }
    }
    return dem->bodies ? bodies_hash(dem, sum) : sum;
}
