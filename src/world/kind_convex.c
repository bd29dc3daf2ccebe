/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds of rigid convex bodies: the only file of this folder that knows their
 * engine. Measurements see them as grains with bodies of one member each. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "convex/image.h"
#include "geom/patch.h"
#include "scenario/rigid.h"
#include "world/kind.h"

struct body {
    struct convex *convex;
    struct view view;
};

static bool knows(const struct job_spec *job)
{
    return rigid_scenario_find(job->scenario->name) != NULL;
}

static void gravity(const struct job_spec *job, double out[3])
{
    out[0] = out[1] = 0;
    out[2] = -rigid_scenario_find(job->scenario->name)->gravity(job);
}

static enum scree_status check(const struct job_spec *job, const struct world_making *making, struct scree_error *err)
{
    (void)making;
    return rigid_body_check(job, rigid_scenario_find(job->scenario->name)->body(job), err);
}

/* A mean over contacts jumps whenever one of them comes or goes: composites keep some 1e-5 sqrt(g d) at rest, where forces that
 * are summed leave them 1e-12. */
#define JUMPING 1e-4

static enum scree_status site(const struct job_spec *job, struct measure_site *out, struct scree_error *err)
{
    struct rigid_plan plan;
    enum scree_status status = rigid_scenario_find(job->scenario->name)->plan(job, &plan, err);
    if (status)
        return status;
    double area = plan.length * plan.width;
    *out = (struct measure_site){.area = area,
                                 .area_z = plan.layer ? area : 0,
                                 .diameter = 2 * cbrt(3 * plan.shape.volume / (4 * M_PI)),
                                 .density = job->rigid.density_kg_m3,
                                 .region = {-INFINITY, INFINITY},
                                 .length_x = plan.length,
                                 .width_y = plan.width,
                                 .calm = plan.setup.average && plan.shape.parts > 1 ? JUMPING : 0,
                                 .ledge_z = plan.ledge,
                                 .gate = plan.setup.gate.present && plan.ledge == 0,
                                 .gate_s = plan.setup.gate.start_s};
    if (out->gate)
        out->gate_x = plan.walls[plan.setup.gate.wall].point[0];
    rigid_plan_free(&plan);
    return SCREE_OK;
}

static void release(void *body)
{
    struct body *b = body;
    if (b)
        convex_free(b->convex);
    free(b);
}

/* From a plan alone, or on from an image. */
static enum scree_status make(const struct job_spec *job, const struct convex_image *image, const char *isa, void **out,
                              struct scree_error *err)
{
    struct rigid_plan plan;
    struct body *b = memory_rows(1, sizeof *b);
    if (!b)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
    enum scree_status status = rigid_scenario_find(job->scenario->name)->plan(job, &plan, err);
    plan.setup.isa = isa;
    if (!status)
        status = image ? convex_load(image, &plan.setup, &b->convex, err) : convex_create(&plan.setup, &b->convex, err);
    rigid_plan_free(&plan);
    if (status)
        release(b);
    else
        *out = b;
    return status;
}

static enum scree_status build(const struct job_spec *job, const struct world_making *making, void **out, struct scree_error *err)
{
    return make(job, NULL, making->isa, out, err);
}

static enum scree_status advance(void *body, uint64_t steps, struct scree_error *err)
{
    return convex_advance(((struct body *)body)->convex, steps, err);
}

static struct world_counts counts(const void *body)
{
    const struct convex *c = ((const struct body *)body)->convex;
    return (struct world_counts){convex_time(c), convex_bodies(c), 0, convex_isa(c)};
}

static uint64_t hash(const void *body)
{
    return convex_hash(((const struct body *)body)->convex);
}

static enum scree_status view(void *body, struct measure_now *now, struct scree_error *err)
{
    struct body *b = body;
    now->grains = &b->view;
    return convex_view(b->convex, &b->view, err);
}

static void take_base_force(void *body, double mean[3])
{
    convex_take_base_force(((struct body *)body)->convex, mean);
}

static bool steer(void *body, const struct job_spec *from, const struct job_spec *to)
{
    double before[3], after[3];
    gravity(from, before);
    gravity(to, after);
    bool pulled = memcmp(before, after, sizeof before) != 0;
    if (pulled)
        convex_set_gravity(((struct body *)body)->convex, after);
    return pulled;
}

/* ---- images ---- */

static enum scree_status save(const void *body, struct world_image *image, struct scree_error *err)
{
    struct convex_image c;
    enum scree_status status = convex_save(((const struct body *)body)->convex, &c, err);
    if (status)
        return status;
    void *const arrays[] = {c.body, c.group, c.group_due, c.who, c.pair_due, c.contact};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        image->owned[image->owned_count++] = arrays[k]; // handed over
    const struct convex_scalars *s = &c.scalars;
    world_image_add(image, "body", ARRAY_REAL, s->bodies * CONVEX_IMAGE_BODY, c.body);
    world_image_add(image, "group", ARRAY_U32, (s->near + s->wall) * 2, c.group);
    world_image_add(image, "group.due", ARRAY_REAL, s->near + s->wall, c.group_due);
    world_image_add(image, "pair.who", ARRAY_U32, s->pairs * CONVEX_IMAGE_WHO, c.who);
    world_image_add(image, "pair.due", ARRAY_REAL, s->pairs, c.pair_due);
    world_image_add(image, "contact", ARRAY_REAL, s->contacts * CONVEX_IMAGE_CONTACT, c.contact);
    return world_image_copy(image, "bodies", &c.scalars, sizeof c.scalars, err);
}

static enum scree_status load(const struct world_image *image, const struct world_making *making, void **out,
                              struct scree_error *err)
{
    struct convex_image c = {0};
    const void *scalars = world_image_need(image, "bodies", ARRAY_BYTES, sizeof c.scalars);
    if (!scalars)
        return world_image_damaged("bodies", err);
    memcpy(&c.scalars, scalars, sizeof c.scalars);
    const struct convex_scalars *s = &c.scalars;
    if (s->bodies > UINT32_MAX || s->near > UINT32_MAX || s->wall > UINT32_MAX || s->pairs > UINT32_MAX ||
        s->contacts / PATCH_POINTS_MAX > s->pairs)
        return world_image_damaged("bodies", err);
    c.body = world_image_need(image, "body", ARRAY_REAL, s->bodies * CONVEX_IMAGE_BODY);
    c.group = world_image_need(image, "group", ARRAY_U32, (s->near + s->wall) * 2);
    c.group_due = world_image_need(image, "group.due", ARRAY_REAL, s->near + s->wall);
    c.who = world_image_need(image, "pair.who", ARRAY_U32, s->pairs * CONVEX_IMAGE_WHO);
    c.pair_due = world_image_need(image, "pair.due", ARRAY_REAL, s->pairs);
    c.contact = world_image_need(image, "contact", ARRAY_REAL, s->contacts * CONVEX_IMAGE_CONTACT);
    if (!c.body || !c.group || !c.group_due || !c.who || !c.pair_due || !c.contact)
        return world_image_damaged("an array of bodies or pairs", err);
    return make(&image->job, &c, making->isa, out, err);
}

const struct world_kind world_kind_convex = {
    .kind = SCENARIO_DEM,
    .knows = knows,
    .gravity = gravity,
    .check = check,
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
