/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See image.h. */
#include "mpm/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "mpm/state.h"

_Static_assert((int)MPM_IMAGE_MOMENTS == (int)MOMENT_ROOM && (int)MPM_IMAGE_CORNERS == (int)CORNER_ROOM,
               "an image holds a cell's sums");

static struct mpm_scalars scalars_of(const struct mpm *mpm)
{
    const struct mpm_report *r = &mpm->report;
    struct mpm_scalars s = {.points = mpm->points,
                            .cells = mpm->grid.cell_count,
                            .nodes = mpm->grid.node_count,
                            .contacts = mpm->contact_count,
                            .step = mpm->step,
                            .base_steps = mpm->base_steps,
                            .rows = r->rows,
                            .sweeps = r->sweeps,
                            .sweeps_total = r->sweeps_total,
                            .unconverged = r->unconverged,
                            .stalls = r->stalls,
                            .moved = r->moved,
                            .residual_mean = r->residual.mean,
                            .residual_largest = r->residual.largest,
                            .overfull = r->overfull,
                            .worst_courant = r->worst_courant};
    memcpy(s.gravity, mpm->gravity, sizeof s.gravity);
    memcpy(s.base_sum, mpm->base_sum, sizeof s.base_sum);
    memcpy(s.base_last, mpm->base_last, sizeof s.base_last);
    return s;
}

enum scree_status mpm_save(const struct mpm *mpm, struct mpm_image *image, struct scree_error *err)
{
    *image = (struct mpm_image){.scalars = scalars_of(mpm),
                                .position = mpm->position,
                                .id = mpm->id,
                                .cell_start = mpm->cell_start,
                                .moment = mpm->moment,
                                .momentum = mpm->momentum,
                                .stress = mpm->stress,
                                .friction = mpm->friction,
                                .contact = memory_rows(mpm->contact_count, sizeof *image->contact)};
    if (!image->contact)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for an image of %zu contacts", mpm->contact_count);
    for (size_t k = 0; k < mpm->contact_count; k++) {
        const struct contact *c = &mpm->contacts[k];
        image->contact[k] = (struct mpm_image_contact){.node = c->node, .owner = c->owner};
        for (int a = 0; a < 3; a++)
            image->contact[k].push[a] = c->force[a];
    }
    return SCREE_OK;
}

void mpm_image_free(struct mpm_image *image)
{
    free(image->contact);
    image->contact = NULL;
}

/* Points lie in the cells that say so, and every name comes once. */
static bool points_are_sound(const struct mpm_image *image, const struct grid *g)
{
    size_t points = image->scalars.points, cells = image->scalars.cells;
    if (image->cell_start[0] != 0 || image->cell_start[cells] != points)
        return false;
    for (size_t cell = 0; cell < cells; cell++)
        if (image->cell_start[cell] > image->cell_start[cell + 1] || image->cell_start[cell + 1] > points)
            return false;
    bool *seen = calloc(points, sizeof *seen), sound = seen != NULL;
    for (size_t cell = 0; sound && cell < cells; cell++) {
        int place[3];
        grid_cell_place(g, cell, place);
        for (size_t p = image->cell_start[cell]; sound && p < image->cell_start[cell + 1]; p++) {
            const double *x = image->position[p];
            for (int a = 0; a < 3; a++)
                sound &= fabs(x[a] * g->inverse[a] - place[a] - 0.5) <= 0.5 + 1e-9;
            sound &= x[3] > 0 && isfinite(x[3]) && image->id[p] < points && !seen[image->id[p]];
            if (sound)
                seen[image->id[p]] = true;
        }
    }
    free(seen);
    return sound;
}

static bool contacts_are_sound(const struct mpm_image *image, const struct mpm *mpm)
{
    for (size_t k = 0; k < image->scalars.contacts; k++) {
        const struct mpm_image_contact *c = &image->contact[k];
        if (c->node >= mpm->grid.node_count || c->owner >= MPM_FACES + mpm->body_count)
            return false;
        if (k > 0 && (c->node < c[-1].node || (c->node == c[-1].node && c->owner <= c[-1].owner)))
            return false;
    }
    return true;
}

/* Sums in the order in which the first world added them up: by name. */
static void sum_volume(struct mpm *mpm)
{
    double *by_id = (double *)mpm->spare_position;
    for (size_t p = 0; p < mpm->points; p++)
        by_id[mpm->id[p]] = mpm->position[p][3];
    mpm->total_volume = 0;
    for (size_t p = 0; p < mpm->points; p++)
        mpm->total_volume += by_id[p];
}

static void copy_state(struct mpm *mpm, const struct mpm_image *image)
{
    const struct mpm_scalars *s = &image->scalars;
    memcpy(mpm->position, image->position, s->points * sizeof *mpm->position);
    memcpy(mpm->id, image->id, s->points * sizeof *mpm->id);
    memcpy(mpm->cell_start, image->cell_start, (s->cells + 1) * sizeof *mpm->cell_start);
    memcpy(mpm->moment, image->moment, s->cells * sizeof *mpm->moment);
    memcpy(mpm->momentum, image->momentum, s->cells * sizeof *mpm->momentum);
    memcpy(mpm->stress, image->stress, s->nodes * sizeof *mpm->stress);
    memcpy(mpm->friction, image->friction, s->nodes * sizeof *mpm->friction);
    mpm->contact_count = s->contacts;
    for (size_t k = 0; k < s->contacts; k++) {
        const struct mpm_image_contact *c = &image->contact[k];
        mpm->contacts[k] =
            (struct contact){.force = v4_set(c->push[0], c->push[1], c->push[2], 0), .node = c->node, .owner = c->owner};
    }
    mpm->step = s->step;
    mpm->base_steps = s->base_steps;
    memcpy(mpm->gravity, s->gravity, sizeof mpm->gravity);
    memcpy(mpm->base_sum, s->base_sum, sizeof mpm->base_sum);
    memcpy(mpm->base_last, s->base_last, sizeof mpm->base_last);
    mpm->report = (struct mpm_report){.rows = s->rows,
                                      .contacts = s->contacts,
                                      .sweeps = s->sweeps,
                                      .residual = {s->residual_mean, s->residual_largest},
                                      .sweeps_total = s->sweeps_total,
                                      .unconverged = s->unconverged,
                                      .stalls = s->stalls,
                                      .moved = s->moved,
                                      .overfull = s->overfull,
                                      .worst_courant = s->worst_courant};
    sum_volume(mpm);
}

enum scree_status mpm_load(const struct mpm_image *image, const struct mpm_setup *setup, struct mpm **out, struct scree_error *err)
{
    struct mpm *mpm;
    const struct mpm_scalars *s = &image->scalars;
    enum scree_status status = mpm_start(setup, &mpm, err);
    if (status)
        return status;
    if (s->cells != mpm->grid.cell_count || s->nodes != mpm->grid.node_count || s->points == 0 || s->points >= UINT32_MAX ||
        s->contacts > rigid_contacts_most(&mpm->grid, mpm->body_count))
        status = scree_fail(err, SCREE_CORRUPT, NULL, "the image has %llu cells, the set-up %zu", (unsigned long long)s->cells,
                            mpm->grid.cell_count);
    else if (!points_are_sound(image, &mpm->grid))
        status = scree_fail(err, SCREE_CORRUPT, NULL, "the image's points are not in its cells");
    else if (!contacts_are_sound(image, mpm))
        status = scree_fail(err, SCREE_CORRUPT, NULL, "the image's contacts are not in order");
    else
        status = points_room(mpm, s->points, err);
    if (status) {
        mpm_free(mpm);
        return status;
    }
    copy_state(mpm, image);
    points_share(mpm);
    *out = mpm;
    return SCREE_OK;
}
