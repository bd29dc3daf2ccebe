/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The time step:
 *
 *     assemble   mass, momentum plus gravity's, and rows from the cells' sums
 *     solve      stresses such that the new velocities obey the law everywhere
 *     account    force on the floor, over-full nodes, how well it was solved
 *     move       points take the new velocities, move, and deposit in their new cells
 *
 * Velocities are implicit in the stresses and points are carried by the solved
 * field, so no elastic time scale bounds the step, only that points should cross
 * a fraction of a cell. Members of the team share each part; every sum has one
 * order whoever takes it. */
#include <math.h>
#include <time.h>

#include "mpm/state.h"

size_t member_share(size_t count, int member, int members)
{
    return count * (size_t)member / (size_t)members;
}

static double thread_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void mpm_clock(struct mpm *mpm, int member, enum mpm_phase phase)
{
    if (!mpm->profile || member != 0)
        return;
    double now = thread_seconds();
    mpm->profile->seconds[phase] += now - mpm->phase_began;
    mpm->phase_began = now;
}

static void account(struct mpm *mpm)
{
    assemble_floor_force(mpm, mpm->base_last);
    for (int a = 0; a < 3; a++)
        mpm->base_sum[a] += mpm->base_last[a];
    mpm->base_steps++;
    mpm->report.overfull = assemble_overfull(mpm);
}

/* Member 0, after the points have moved. */
static enum scree_status check(struct mpm *mpm, struct scree_error *err)
{
    double courant = 0;
    for (int k = 0; k < mpm->part_count; k++) {
        const struct member_part *part = &mpm->parts[k];
        if (part->status) {
            if (err)
                *err = part->error;
            return part->status;
        }
        if (!(part->courant <= courant))
            courant = part->courant;
        mpm->report.stalls += part->stalls;
        mpm->parts[k].stalls = 0;
    }
    mpm->report.worst_courant = courant;
    mpm->step++;
    rigid_tilt(mpm);
    if (courant <= 1)
        return SCREE_OK;
    enum scree_status status =
        scree_fail(err, SCREE_BLOWUP, NULL, "step %llu: a point crosses %.3g cells at once; last good time %.6g s",
                   (unsigned long long)mpm->step, courant, (double)(mpm->step - 1) * mpm->step_s);
    scree_hint(err, "a smaller time.step_s");
    return status;
}

struct slice {
    struct mpm *mpm;
    uint64_t steps;
    enum scree_status status; // written by member 0, read behind a barrier
    struct scree_error *err;
};

static void slice_member(void *context, int member)
{
    struct slice *slice = context;
    struct mpm *mpm = slice->mpm;
    for (uint64_t k = 0; k < slice->steps; k++) {
        assemble(mpm, member);
        team_barrier(mpm->team);
        mpm_clock(mpm, member, MPM_ASSEMBLE);
        gauss_seidel(mpm, member);
        if (member == 0)
            account(mpm);
        team_barrier(mpm->team);
        mpm_clock(mpm, member, MPM_ASSEMBLE);
        points_move(mpm, member);
        team_barrier(mpm->team);
        if (member == 0)
            slice->status = check(mpm, slice->err);
        team_barrier(mpm->team);
        if (slice->status)
            return;
    }
}

enum scree_status mpm_advance(struct mpm *mpm, uint64_t steps, struct scree_error *err)
{
    struct slice slice = {.mpm = mpm, .steps = steps, .err = err};
    if (mpm->profile)
        mpm->phase_began = thread_seconds();
    team_run(mpm->team, slice_member, &slice);
    return slice.status;
}
