/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds of continuum: the only file of this folder that knows its engine. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "mpm/image.h"
#include "scenario/continuum.h"
#include "world/kind.h"

struct body {
    struct mpm *mpm;
    struct continuum_plan plan; // the set-up points into it
    struct continuum_view view;
};

static bool knows(const struct job_spec *job)
{
    return continuum_scenario_find(job->scenario->name) != NULL;
}

static void gravity(const struct job_spec *job, double out[3])
{
    continuum_scenario_find(job->scenario->name)->gravity(job, out);
}

static enum scree_status site(const struct job_spec *job, struct measure_site *out, struct scree_error *err)
{
    (void)err;
    struct continuum_plan plan;
    continuum_scenario_find(job->scenario->name)->plan(job, &plan);
    const struct mpm_setup *s = &plan.setup;
    double area = s->length[0] * (s->plane ? 1 : s->length[1]);
    *out = (struct measure_site){.area = area,
                                 .area_z = area,
                                 .diameter = s->grain_diameter,
                                 .region = {-INFINITY, INFINITY},
                                 .bed = plan.bed,
                                 .gate_x = plan.gate_x,
                                 .height = plan.height,
                                 .gate_s = plan.start_s,
                                 .gate = s->body_count > 0};
    return SCREE_OK;
}

static enum scree_status make_body(const struct job_spec *job, const struct world_making *making, struct body **out,
                                   struct scree_error *err)
{
    struct body *b = memory_rows(1, sizeof *b);
    if (!b)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    continuum_scenario_find(job->scenario->name)->plan(job, &b->plan);
    b->plan.setup.threads = making->threads;
    b->plan.setup.isa = making->isa;
    *out = b;
    return SCREE_OK;
}

static void release(void *body)
{
    struct body *b = body;
    if (b)
        mpm_free(b->mpm);
    free(b);
}

static enum scree_status build(const struct job_spec *job, const struct world_making *making, void **out, struct scree_error *err)
{
    struct body *b = NULL;
    enum scree_status status = make_body(job, making, &b, err);
    if (status)
        return status;
    if ((status = mpm_create(&b->plan.setup, &b->mpm, err)))
        release(b);
    else
        *out = b;
    return status;
}

static enum scree_status advance(void *body, uint64_t steps, struct scree_error *err)
{
    return mpm_advance(((struct body *)body)->mpm, steps, err);
}

static struct world_counts counts(const void *body)
{
    const struct mpm *mpm = ((const struct body *)body)->mpm;
    return (struct world_counts){mpm_time(mpm), mpm_points(mpm), 0, mpm_isa(mpm)};
}

static uint64_t hash(const void *body)
{
    return mpm_hash(((const struct body *)body)->mpm);
}

static enum scree_status view(void *body, struct measure_now *now, struct scree_error *err)
{
    struct body *b = body;
    now->points = &b->view;
    return mpm_view(b->mpm, &b->view, err);
}

static void take_base_force(void *body, double mean[3])
{
    mpm_take_base_force(((struct body *)body)->mpm, mean);
}

static bool steer(void *body, const struct job_spec *from, const struct job_spec *to)
{
    double before[3], after[3];
    gravity(from, before);
    gravity(to, after);
    bool pulled = memcmp(before, after, sizeof before) != 0;
    if (pulled)
        mpm_set_gravity(((struct body *)body)->mpm, after);
    return pulled;
}

/* ---- images ---- */

static enum scree_status save(const void *body, struct world_image *image, struct scree_error *err)
{
    struct mpm_image m;
    enum scree_status status = mpm_save(((const struct body *)body)->mpm, &m, err);
    if (status)
        return status;
    const struct mpm_scalars *s = &m.scalars;
    image->owned[image->owned_count++] = m.contact; // handed over
    world_image_add(image, "point.position", ARRAY_REAL, 4 * s->points, m.position);
    world_image_add(image, "point.id", ARRAY_U32, s->points, m.id);
    world_image_add(image, "cell.start", ARRAY_U32, s->cells + 1, m.cell_start);
    world_image_add(image, "cell.moment", ARRAY_REAL, s->cells * MPM_IMAGE_MOMENTS, m.moment);
    world_image_add(image, "cell.momentum", ARRAY_REAL, s->cells * MPM_IMAGE_CORNERS, m.momentum);
    world_image_add(image, "node.stress", ARRAY_REAL, 8 * s->nodes, m.stress);
    world_image_add(image, "node.friction", ARRAY_REAL, s->nodes, m.friction);
    world_image_add(image, "wall.contact", ARRAY_BYTES, s->contacts * sizeof *m.contact, m.contact);
    return world_image_copy(image, "continuum", s, sizeof *s, err);
}

static enum scree_status arrays_of(const struct world_image *image, struct mpm_image *m, struct scree_error *err)
{
    const void *scalars = world_image_need(image, "continuum", ARRAY_BYTES, sizeof m->scalars);
    if (!scalars)
        return world_image_damaged("continuum", err);
    memcpy(&m->scalars, scalars, sizeof m->scalars);
    const struct mpm_scalars *s = &m->scalars;
    if (s->points > UINT32_MAX || s->cells > UINT32_MAX || s->nodes > UINT32_MAX || s->contacts > UINT32_MAX)
        return world_image_damaged("continuum", err);
    m->position = world_image_need(image, "point.position", ARRAY_REAL, 4 * s->points);
    m->id = world_image_need(image, "point.id", ARRAY_U32, s->points);
    m->cell_start = world_image_need(image, "cell.start", ARRAY_U32, s->cells + 1);
    m->moment = world_image_need(image, "cell.moment", ARRAY_REAL, s->cells * MPM_IMAGE_MOMENTS);
    m->momentum = world_image_need(image, "cell.momentum", ARRAY_REAL, s->cells * MPM_IMAGE_CORNERS);
    m->stress = world_image_need(image, "node.stress", ARRAY_REAL, 8 * s->nodes);
    m->friction = world_image_need(image, "node.friction", ARRAY_REAL, s->nodes);
    m->contact = world_image_need(image, "wall.contact", ARRAY_BYTES, s->contacts * sizeof *m->contact);
    if (!m->position || !m->id || !m->cell_start || !m->moment || !m->momentum || !m->stress || !m->friction || !m->contact)
        return world_image_damaged("an array of points, cells or nodes", err);
    return SCREE_OK;
}

static enum scree_status load(const struct world_image *image, const struct world_making *making, void **out,
                              struct scree_error *err)
{
    struct mpm_image m;
    struct body *b = NULL;
    enum scree_status status = arrays_of(image, &m, err);
    if (status || (status = make_body(&image->job, making, &b, err)))
        return status;
    if ((status = mpm_load(&m, &b->plan.setup, &b->mpm, err)))
        release(b);
    else
        *out = b;
    return status;
}

const struct world_kind world_kind_mpm = {
    .kind = SCENARIO_MPM,
    .knows = knows,
    .gravity = gravity,
    .site = site,
    .build = build,
    .free = release,
    .advance = advance,
    .counts = counts,
    .hash = hash,
    .view = view,
    .take_base_force = take_base_force,
    .steer = steer,
    .save = save,
    .load = load,
};
