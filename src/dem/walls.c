/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Planes. Few grains are near one at a time, so this is plain scalar code; its
 * lists follow the same budget as those of pairs, its forces are added after
 * those of pairs, in the order (grain, wall). */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/vec3.h"
#include "dem/state.h"

/* Distance of a grain's surface from a wall, m; negative in contact. */
static double wall_gap(const struct dem_wall *wall, const double position[4])
{
    struct vec3 from = vec3_sub(vec3_load(position), vec3_load(wall->point));
    return vec3_dot(from, vec3_load(wall->normal)) - position[3];
}

enum scree_status walls_near(struct dem *dem, struct part *part, double horizon, double stray, struct scree_error *err)
{
    size_t h = 0;
    part->wall_count = 0;
    for (size_t i = part->from; i < part->to; i++)
        for (size_t w = 0; w < dem->wall_count; w++) {
            const struct dem_wall *wall = &dem->walls[w];
            double closing = fmin(0, vec3_dot(vec3_load(dem->velocity[i]), vec3_load(wall->normal)));
            if (wall_gap(wall, dem->position[i]) + closing * horizon > stray)
                continue;
            enum scree_status status =
                memory_grow((void **)&part->walls, &part->wall_room, part->wall_count + 1, sizeof *part->walls, err);
            if (status)
                return status;
            struct wall_pair *pair = &part->walls[part->wall_count++];
            *pair = (struct wall_pair){.grain = (uint32_t)i, .wall = (uint32_t)w, .partner = wall->partner};
            for (int a = 0; a < 3; a++)
                pair->normal[a] = -wall->normal[a];
            uint64_t key = (uint64_t)i << 32 | w;
            while (h < part->held_walls.count && part->held_walls.items[h].key < key)
                h++;
            if (h < part->held_walls.count && part->held_walls.items[h].key == key) {
                memcpy(pair->contact, part->held_walls.items[h++].contact, sizeof pair->contact);
                pair->touching = 1;
            } else { // S4.4: the effective radius is the grain's
                pair->contact[CONTACT_R] = pair->contact[CONTACT_R1] = dem->position[i][3];
            }
        }
    part->held_walls.count = 0;
    return SCREE_OK;
}

void walls_contacts(struct dem *dem, struct part *part)
{
    for (size_t k = 0; k < part->wall_count; k++) {
        struct wall_pair *pair = &part->walls[k];
        double gap = wall_gap(&dem->walls[pair->wall], dem->position[pair->grain]);
        memset(&pair->loss, 0, sizeof pair->loss);
        if (!(gap <= 0)) {
            if (pair->touching && dem->ledger) { // what its springs held is lost
                pair->loss = dem->law->elastic(&dem->coefs[pair->partner], pair->contact, 0);
                pair->loss.normal = 0;
            }
            pair->touching = 0;
            continue;
        }
        if (!pair->touching)
            memset(pair->contact, 0, CONTACT_HISTORY * sizeof *pair->contact);
        pair->touching = 1;
        pair->overlap = -gap;
        pair->approach = vec3_dot(vec3_load(dem->velocity[pair->grain]), vec3_load(pair->normal));
        if (dem->logs_formations)
            formed_wall(dem, part, pair);
        dem->law->wall(&dem->coefs[pair->partner], dem->velocity[pair->grain], dem->spin[pair->grain], dem->arm[pair->grain],
                       dem->ledger, pair);
    }
}

void wall_pair_kick(const struct wall_pair *pair, const struct sink *sink)
{
    double *v = sink->linear[pair->grain], *w = sink->angular[pair->grain];
    const double *v0 = sink->linear0[pair->grain];
    for (int a = 0; a < 3; a++) {
        v[a] -= pair->out.force[a] * v[3];
        w[a] += pair->out.torque1[a] * w[3];
        double change = (v[a] - v0[a]) * (v[a] - v0[a]);
        sink->strayed2[a] = change > sink->strayed2[a] ? change : sink->strayed2[a];
    }
}

void walls_kick(struct part *part, const struct sink *sink)
{
    for (size_t k = 0; k < part->wall_count; k++)
        if (part->walls[k].touching)
            wall_pair_kick(&part->walls[k], sink);
}
