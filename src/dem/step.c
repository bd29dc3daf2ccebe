/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The time step: velocity Verlet with the half-step velocity in the damping.
 *
 *     drift      v(n+1/2) = v + g dt,  x(n+1) = x(n) + dt v(n+1/2)
 *     lists      refreshed if they may have become incomplete (near.c)
 *     contacts   which pairs touch, and the law on each, at x(n+1), v(n+1/2)
 *     kick       each grain takes its own contacts in fixed order
 *     account    force on the base, dissipated energy
 *
 * Members of the team own contiguous grains (struct part) and meet twice a step.
 * A grain's contacts with lower rows come first: those of earlier parts are
 * taken from their exports, part by part, then its own part's, which is the
 * order of rows, so the sum does not depend on how many parts there are. */
#include <string.h>

#include "dem/state.h"

/* Adds the ticks since the last call to a phase; member 0 of a profiled world only. */
static inline void clock_phase(const struct dem *dem, const struct part *part, enum dem_phase phase)
{
    static _Thread_local uint64_t last;
    if (!dem->profile || part != dem->parts)
        return;
    uint64_t now = __builtin_ia32_rdtsc();
    if (last)
        dem->profile->ticks[phase] += now - last;
    last = now;
}

static struct pair_batch batch_of(const struct dem *dem, const struct part *part)
{
    return (struct pair_batch){.position = (const double(*)[4])dem->position,
                               .velocity = (const double(*)[4])dem->velocity,
                               .spin = (const double(*)[4])dem->spin,
                               .arm = (const double(*)[4])dem->arm,
                               .shift = (const double(*)[4])dem->shift,
                               .first = part->near.first,
                               .second = part->near.second,
                               .contact = part->near.contact,
                               .active = part->active,
                               .active_count = part->active_count,
                               .out = part->out,
                               .loss = dem->ledger ? part->loss : NULL};
}

/* Touching pairs that others look at after this member: those whose second grain
 * another part must kick, and those whose force counts as force on the base. */
static void list_shared(const struct dem *dem, struct part *part)
{
    part->export_count = part->on_base_count = 0;
    for (size_t k = 0; k < part->active_count; k++) {
        size_t j = part->near.second[part->active[k]] & IMAGE_ROW;
        if (j >= dem->moving) {
            if (counts_on_base(dem, touch_y(dem, part->near.first[part->active[k]], j)))
                part->on_base[part->on_base_count++] = (uint32_t)k;
        } else if (j >= part->to)
            part->exports[part->export_count++] = (uint32_t)k;
    }
}

static void contacts(struct dem *dem, struct part *part)
{
    struct pair_batch batch = batch_of(dem, part), hot = batch;
    hot.first = part->hot.first;
    hot.second = part->hot.second;
    hot.near = part->hot.near;
    part->active_count = dem->kernels->touch(&hot, part->hot.reach2, part->hot.count, part->hot.touching, part->active,
                                             dem->ledger ? part->ended : NULL, &part->ended_count);
    batch.active_count = part->active_count;
    if (dem->logs_formations)
        formed_pairs(dem, part);
    clock_phase(dem, part, DEM_SEARCH);
    dem->law->pairs[dem->isa](&dem->coefs[0], &batch);
    list_shared(dem, part);
    walls_contacts(dem, part);
    mesh_contacts(dem, part);
}

/* Second grains of earlier parts' contacts that this part owns. */
static void kick_imports(struct dem *dem, struct part *part, const struct sink *sink)
{
    for (const struct part *other = dem->parts; other < part; other++)
        for (size_t e = 0; e < other->export_count; e++) {
            uint32_t k = other->exports[e];
            size_t j = other->near.second[other->active[k]] & IMAGE_ROW;
            if (j < part->from || j >= part->to)
                continue;
            double *v = sink->linear[j], *w = sink->angular[j];
            for (int a = 0; a < 3; a++) {
                v[a] += other->out[k].force[a] * v[3];
                w[a] += other->out[k].torque2[a] * w[3];
                double change = (v[a] - sink->linear0[j][a]) * (v[a] - sink->linear0[j][a]);
                sink->strayed2[a] = change > sink->strayed2[a] ? change : sink->strayed2[a];
            }
        }
}

void kick_rows(struct dem *dem, struct part *part, const struct sink *sink)
{
    struct pair_batch batch = batch_of(dem, part);
    kick_imports(dem, part, sink);
    dem->kernels->kick(&batch, sink->linear, sink->angular, sink->linear0, part->from, part->to, sink->strayed2);
    walls_kick(part, sink);
    mesh_kick(dem, part, sink);
}

/* What the springs of ended contacts held is lost; Hertz's gives all back. */
static void account_ended(struct dem *dem, const struct part *part)
{
    for (size_t k = 0; k < part->ended_count; k++) {
        struct contact_loss left = dem->law->elastic(&dem->coefs[0], part->near.contact[part->ended[k]], 0);
        left.normal = 0;
        add_loss(dem->lost, &left);
    }
}

static void account_pairs(struct dem *dem, const struct part *part)
{
    for (size_t k = 0; k < part->on_base_count; k++)
        for (int a = 0; a < 3; a++)
            dem->base_sum[a] += part->out[part->on_base[k]].force[a];
    for (size_t k = 0; k < part->active_count && dem->ledger; k++)
        add_loss(dem->lost, &part->loss[k]);
}

static void account_walls(struct dem *dem, const struct part *part)
{
    for (size_t k = 0; k < part->wall_count; k++) {
        const struct wall_pair *pair = &part->walls[k];
        if (pair->touching && dem->walls[pair->wall].base && counts_on_base(dem, dem->position[pair->grain][1]))
            for (int a = 0; a < 3; a++)
                dem->base_sum[a] += pair->out.force[a];
        if (dem->ledger)
            add_loss(dem->lost, &pair->loss);
    }
}

/* Member 0: each kind over all parts in order, so that sums have one order
 * however many parts there are. */
static void account(struct dem *dem)
{
    for (int p = 0; p < dem->part_count; p++)
        account_pairs(dem, &dem->parts[p]);
    for (int p = 0; p < dem->part_count && dem->ledger; p++)
        account_ended(dem, &dem->parts[p]);
    for (int p = 0; p < dem->part_count; p++)
        account_walls(dem, &dem->parts[p]);
    mesh_account(dem);
    if (dem->logs_formations)
        formed_gather(dem);
    dem->base_steps++;
    dem->step++;
}

/* What a slice hands to the team. */
struct slice {
    struct dem *dem;
    uint64_t first, steps;
    enum scree_status status; // written by member 0, read behind a barrier
    struct scree_error *err;
};

static enum scree_status first_failure(const struct dem *dem, struct scree_error *err)
{
    for (int k = 0; k < dem->part_count; k++)
        if (dem->parts[k].status) {
            if (err)
                *err = dem->parts[k].error;
            return dem->parts[k].status;
        }
    return SCREE_OK;
}

static void slice_member(void *context, int member)
{
    struct slice *slice = context;
    struct dem *dem = slice->dem;
    struct part *part = &dem->parts[member];
    for (uint64_t k = 0; k < slice->steps; k++) {
        uint64_t step = slice->first + k;
        if (step > 0 && step % DEM_HOUSEKEEPING == 0) {
            /* Before the step, so that between slices rows and lists belong together;
             * behind a barrier, since others may still be kicking their grains. */
            order_look(dem, part);
            team_barrier(dem->team);
            if (member == 0)
                slice->status = order_housekeeping(dem, slice->err);
            team_barrier(dem->team);
            if (slice->status)
                return;
        }
        dem->motion->drift(dem, part);
        clock_phase(dem, part, DEM_INTEGRATE);
        team_barrier(dem->team);
        if (!near_complete(dem, part)) {
            near_refresh(dem, member);
            team_barrier(dem->team);
            if (first_failure(dem, NULL))
                return;
        }
        near_heat(dem, part);
        clock_phase(dem, part, DEM_LISTS);
        contacts(dem, part);
        clock_phase(dem, part, DEM_LAW);
        team_barrier(dem->team);
        dem->motion->kick(dem, part);
        clock_phase(dem, part, DEM_GATHER);
        if (member == 0)
            account(dem);
        clock_phase(dem, part, DEM_MEASURE);
    }
}

enum scree_status dem_advance(struct dem *dem, uint64_t steps, struct scree_error *err)
{
    struct slice slice = {.dem = dem, .first = dem->step, .steps = steps, .err = err};
    team_run(dem->team, slice_member, &slice);
    enum scree_status status = first_failure(dem, err);
    return status ? status : slice.status;
}
