/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds of grains: the only file of this folder that knows the grain engine. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "dem/dem.h"
#include "dem/image.h"
#include "scenario/scenario.h"
#include "world/kind.h"

struct body {
    struct dem *dem;
    struct view view;
};

static bool knows(const struct job_spec *job)
{
    return scenario_implementation(job->scenario->name) != NULL;
}

static void gravity(const struct job_spec *job, double out[3])
{
    scenario_implementation(job->scenario->name)->gravity(job, out);
}

enum { LAYERS = 16 }; // that profiles reach over four times, where the scenario does not say

static enum scree_status site(const struct job_spec *job, struct measure_site *out, struct scree_error *err)
{
    const struct scenario *scenario = scenario_implementation(job->scenario->name);
    *out = (struct measure_site){.region = {-INFINITY, INFINITY}};
    out->diameter = scenario->grain ? scenario->grain(job) : 2 * job->material.radius_m;
    out->density = scenario->law ? job->fragments.density_kg_m3 : job->material.density_kg_m3;
    scenario->base(job, &out->base_z, &out->area);
    out->layers = LAYERS;
    if (scenario->profile)
        scenario->profile(job, &out->layers, &out->area_z, out->region);
    if (!scenario->release) {
        out->area_z = out->area_z > 0 ? out->area_z : out->area;
        return SCREE_OK;
    }
    double(*release)[4];
    enum scree_status status = scenario->release(job, &release, &out->fall.count, err);
    if (status)
        return status;
    out->fall.release = (const double(*)[4])release;
    out->fall.chute = scenario->chute(job);
    out->fall.grain_m = out->diameter;
    return SCREE_OK;
}

static enum scree_status make_body(struct body **out, struct scree_error *err)
{
    *out = memory_rows(1, sizeof **out);
    return *out ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a world");
}

static void release(void *body)
{
    struct body *b = body;
    if (b)
        dem_free(b->dem);
    free(b);
}

/* Of a body whose engine is made, or was not. */
static enum scree_status finish(struct body *b, const struct world_making *making, enum scree_status status, void **out)
{
    if (status) {
        release(b);
        return status;
    }
    dem_log_formations(b->dem, making->needs & MEASURE_FORMATIONS);
    *out = b;
    return SCREE_OK;
}

static struct scenario_means means_of(const struct world_making *making)
{
    return (struct scenario_means){.isa = making->isa, .threads = making->threads, .meshes = making->meshes};
}

static enum scree_status check(const struct job_spec *job, const struct world_making *making, struct scree_error *err)
{
    const struct scenario *scenario = scenario_implementation(job->scenario->name);
    const struct scenario_means means = means_of(making);
    return scenario->check ? scenario->check(job, &means, err) : SCREE_OK;
}

static enum scree_status build(const struct job_spec *job, const struct world_making *making, void **out, struct scree_error *err)
{
    struct body *b;
    enum scree_status status = make_body(&b, err);
    if (status)
        return status;
    const struct scenario_means means = means_of(making);
    status = scenario_implementation(job->scenario->name)->build(job, &means, &b->dem, err);
    return finish(b, making, status, out);
}

static enum scree_status advance(void *body, uint64_t steps, struct scree_error *err)
{
    return dem_advance(((struct body *)body)->dem, steps, err);
}

static struct world_counts counts(const void *body)
{
    const struct dem *dem = ((const struct body *)body)->dem;
    return (struct world_counts){dem_time(dem), dem_moving(dem), dem_fixed(dem), dem_isa(dem)};
}

static uint64_t hash(const void *body)
{
    return dem_hash(((const struct body *)body)->dem);
}

static enum scree_status view(void *body, struct measure_now *now, struct scree_error *err)
{
    struct body *b = body;
    now->grains = &b->view;
    return dem_view(b->dem, &b->view, err);
}

static void take_base_force(void *body, double mean[3])
{
    dem_take_base_force(((struct body *)body)->dem, mean);
}

static size_t take_formations(void *body, const struct view_formation **formations)
{
    return dem_take_formations(((struct body *)body)->dem, formations);
}

static bool steer(void *body, const struct job_spec *from, const struct job_spec *to)
{
    struct dem *dem = ((struct body *)body)->dem;
    double before[3], after[3];
    gravity(from, before);
    gravity(to, after);
    bool pulled = memcmp(before, after, sizeof before) != 0;
    bool rubbed = from->material.mu_t != to->material.mu_t || from->material.wall.mu != to->material.wall.mu;
    if (pulled)
        dem_set_gravity(dem, after);
    if (rubbed)
        dem_set_material(dem, &to->material);
    return pulled || rubbed;
}

/* ---- images ---- */

static enum scree_status save(const void *body, struct world_image *image, struct scree_error *err)
{
    struct dem_image d;
    enum scree_status status = dem_save(((const struct body *)body)->dem, &d, err);
    if (status)
        return status;
    const struct dem_scalars *s = &d.scalars;
    /* The contact arrays are handed over. */
    void *const arrays[] = {d.keys,    d.contact, d.out,    d.wall_keys, d.wall_contact, d.wall_out, d.wall_overlap,
                            d.surface, d.vertex,  d.corner, d.partner,   d.mesh_pair,    d.body};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        image->owned[image->owned_count++] = arrays[k];
    world_image_add(image, "position", ARRAY_REAL, 4 * s->grains, d.position);
    world_image_add(image, "velocity", ARRAY_REAL, 4 * s->grains, d.velocity);
    world_image_add(image, "spin", ARRAY_REAL, 4 * s->grains, d.spin);
    world_image_add(image, "mass", ARRAY_REAL, s->grains, d.mass);
    world_image_add(image, "id", ARRAY_U32, s->grains, d.id);
    world_image_add(image, "walls", ARRAY_BYTES, s->walls * sizeof *d.walls, d.walls);
    world_image_add(image, "contact.key", ARRAY_U64, s->contacts, d.keys);
    world_image_add(image, "contact.memory", ARRAY_REAL, s->contacts * CONTACT_SLOTS, d.contact);
    world_image_add(image, "contact.force", ARRAY_REAL, s->contacts * sizeof *d.out / sizeof(double), d.out);
    world_image_add(image, "wall.key", ARRAY_U64, s->wall_contacts, d.wall_keys);
    world_image_add(image, "wall.memory", ARRAY_REAL, s->wall_contacts * CONTACT_SLOTS, d.wall_contact);
    world_image_add(image, "wall.force", ARRAY_REAL, s->wall_contacts * sizeof *d.wall_out / sizeof(double), d.wall_out);
    world_image_add(image, "wall.overlap", ARRAY_REAL, s->wall_contacts, d.wall_overlap);
    world_image_add(image, "surfaces", ARRAY_BYTES, s->surfaces * sizeof *d.surface, d.surface);
    world_image_add(image, "surface.vertex", ARRAY_REAL, 3 * s->vertices, d.vertex);
    world_image_add(image, "surface.corner", ARRAY_U32, 3 * s->triangles, d.corner);
    world_image_add(image, "surface.partner", ARRAY_BYTES, s->triangles, d.partner);
    world_image_add(image, "surface.contact", ARRAY_BYTES, s->mesh_contacts * sizeof *d.mesh_pair, d.mesh_pair);
    if (s->bodies) {
        world_image_add(image, "body", ARRAY_REAL, 4 * DEM_BODY_ROWS * s->bodies, d.body);
        world_image_add(image, "body.offset", ARRAY_REAL, 4 * s->moving, d.offset);
        world_image_add(image, "body.first", ARRAY_U32, s->bodies + 1, d.body_first);
        world_image_add(image, "body.id", ARRAY_U32, s->bodies, d.body_id);
        world_image_add(image, "body.shape", ARRAY_U32, s->bodies, d.body_shape);
    }
    return world_image_copy(image, "grains", s, sizeof *s, err);
}

static enum scree_status load(const struct world_image *image, const struct world_making *making, void **out,
                              struct scree_error *err)
{
    struct dem_image d = {.scalars = {0}};
    const void *scalars = world_image_need(image, "grains", ARRAY_BYTES, sizeof d.scalars);
    if (!scalars)
        return world_image_damaged("grains", err);
    memcpy(&d.scalars, scalars, sizeof d.scalars);
    const struct dem_scalars *s = &d.scalars;
    if (s->grains > SPEC_GRAINS_MAX || s->contacts > 64 * s->grains || s->wall_contacts > 64 * s->grains || s->walls > 1000 ||
        s->bodies > s->moving || s->surfaces > 1000 || s->vertices > TRIMESH_VERTICES_MAX || s->triangles > TRIMESH_TRIANGLES_MAX ||
        s->mesh_contacts > 64 * s->grains)
        return world_image_damaged("grains", err);
    d.position = world_image_need(image, "position", ARRAY_REAL, 4 * s->grains);
    d.velocity = world_image_need(image, "velocity", ARRAY_REAL, 4 * s->grains);
    d.spin = world_image_need(image, "spin", ARRAY_REAL, 4 * s->grains);
    d.mass = world_image_need(image, "mass", ARRAY_REAL, s->grains);
    d.id = world_image_need(image, "id", ARRAY_U32, s->grains);
    d.walls = world_image_need(image, "walls", ARRAY_BYTES, s->walls * sizeof *d.walls);
    d.keys = world_image_need(image, "contact.key", ARRAY_U64, s->contacts);
    d.contact = world_image_need(image, "contact.memory", ARRAY_REAL, s->contacts * CONTACT_SLOTS);
    d.out = world_image_need(image, "contact.force", ARRAY_REAL, s->contacts * sizeof *d.out / sizeof(double));
    d.wall_keys = world_image_need(image, "wall.key", ARRAY_U64, s->wall_contacts);
    d.wall_contact = world_image_need(image, "wall.memory", ARRAY_REAL, s->wall_contacts * CONTACT_SLOTS);
    d.wall_out = world_image_need(image, "wall.force", ARRAY_REAL, s->wall_contacts * sizeof *d.wall_out / sizeof(double));
    d.wall_overlap = world_image_need(image, "wall.overlap", ARRAY_REAL, s->wall_contacts);
    if (!d.position || !d.velocity || !d.spin || !d.mass || !d.id || !d.walls || !d.keys || !d.contact || !d.out || !d.wall_keys ||
        !d.wall_contact || !d.wall_out || !d.wall_overlap)
        return world_image_damaged("an array of grains or contacts", err);
    d.surface = world_image_need(image, "surfaces", ARRAY_BYTES, s->surfaces * sizeof *d.surface);
    d.vertex = world_image_need(image, "surface.vertex", ARRAY_REAL, 3 * s->vertices);
    d.corner = world_image_need(image, "surface.corner", ARRAY_U32, 3 * s->triangles);
    d.partner = world_image_need(image, "surface.partner", ARRAY_BYTES, s->triangles);
    d.mesh_pair = world_image_need(image, "surface.contact", ARRAY_BYTES, s->mesh_contacts * sizeof *d.mesh_pair);
    if (!d.surface || !d.vertex || !d.corner || !d.partner || !d.mesh_pair)
        return world_image_damaged("an array of the walls", err);
    if (s->bodies) {
        d.body = world_image_need(image, "body", ARRAY_REAL, 4 * DEM_BODY_ROWS * s->bodies);
        d.offset = world_image_need(image, "body.offset", ARRAY_REAL, 4 * s->moving);
        d.body_first = world_image_need(image, "body.first", ARRAY_U32, s->bodies + 1);
        d.body_id = world_image_need(image, "body.id", ARRAY_U32, s->bodies);
        d.body_shape = world_image_need(image, "body.shape", ARRAY_U32, s->bodies);
        if (!d.body || !d.offset || !d.body_first || !d.body_id || !d.body_shape)
            return world_image_damaged("an array of the bodies", err);
    }
    struct body *b;
    enum scree_status status = make_body(&b, err);
    if (status)
        return status;
    const struct law *law = scenario_implementation(image->job.scenario->name)->law;
    status = dem_load(&d, law, &image->job.material, making->isa, making->threads, &b->dem, err);
    return finish(b, making, status, out);
}

const struct world_kind world_kind_dem = {
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
    .take_formations = take_formations,
    .steer = steer,
    .save = save,
    .load = load,
};
