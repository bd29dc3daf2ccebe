/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Random sequential filling of the space behind the gate.
 *
 * The space is a length of the accelerator's section, floor to the tops of its
 * sides, ending at the gate; its volume is mass over density, so that its
 * length follows. Spheres of different fragments do not overlap; that their
 * polyhedra might, at the corners that no sphere fills, is of no consequence. */
#include "scenario/fragments.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/quat.h"
#include "base/rng.h"

enum { STREAM_FRAGMENTS = 3 };     // of random numbers
enum { TRIES_A_FRAGMENT = 20000 }; // in a row, before the space counts as full
#define CLEARANCE 1e-3             // of the size: from walls and gate

static const struct chute_params *params_of(const struct job_spec *job)
{
    return (const struct chute_params *)(const void *)job->params;
}

/* Volume of the section per length, m2. */
static double section_area(const struct chute *c)
{
    double half = 0.5 * (c->width - c->floor);
    return (c->floor + half) * half * tan(c->side_rad);
}

static double space_length(const struct job_spec *job, const struct chute *c)
{
    const struct chute_params *p = params_of(job);
    double mass = 1e-3 * (p->space_mass_g > 0 ? p->space_mass_g : p->mass_g);
    return mass / p->space_density_kg_m3 / section_area(c);
}

struct chute fragments_chute(const struct job_spec *job)
{
    const struct chute_params *p = params_of(job);
    struct chute c = {.height = 0.3,
                      .drop = 0.085,
                      .steepness = 11.765,
                      .run = p->run_m,
                      .floor = p->floor_m,
                      .width = p->width_m,
                      .side_rad = p->side_deg * (M_PI / 180),
                      .guard = p->guard_m,
                      .gate = p->gate_m,
                      .flatness = p->flatness * p->size_m};
    c.accelerator = c.gate + 1.2 * space_length(job, &c) + 20 * p->size_m; // room to bounce back
    return c;
}

/* ---- the grid of spheres placed so far ---- */

struct grid {
    double low[3], inverse;
    int count[3];
    int32_t *head, *next; // of a cell; of a sphere
    double (*sphere)[4];
    size_t spheres;
};

static size_t cell_of(const struct grid *g, const double x[3], const int shift[3])
{
    size_t at[3];
    for (int a = 0; a < 3; a++) {
        int k = (int)((x[a] - g->low[a]) * g->inverse) + shift[a];
        at[a] = (size_t)(k < 0 ? 0 : k >= g->count[a] ? g->count[a] - 1 : k);
    }
    return (at[2] * (size_t)g->count[1] + at[1]) * (size_t)g->count[0] + at[0];
}

static bool is_free(const struct grid *g, const double sphere[4])
{
    for (int k = 0; k < 27; k++) {
        const int shift[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        for (int32_t s = g->head[cell_of(g, sphere, shift)]; s >= 0; s = g->next[s]) {
            const double *o = g->sphere[s];
            double x = o[0] - sphere[0], y = o[1] - sphere[1], z = o[2] - sphere[2], reach = o[3] + sphere[3];
            if (x * x + y * y + z * z < reach * reach * (1 + 1e-9))
                return false;
        }
    }
    return true;
}

/* Cells as wide as a sphere, over the space in its own coordinates: along, across, normal. */
static enum scree_status grid_start(struct grid *g, const double low[3], const double high[3], double radius, size_t spheres,
                                    struct scree_error *err)
{
    size_t cells = 1;
    g->inverse = 1 / (2 * radius * (1 + 1e-6));
    for (int a = 0; a < 3; a++) {
        g->low[a] = low[a];
        g->count[a] = (int)fmin(2000, fmax(1, ceil((high[a] - low[a]) * g->inverse)));
        cells *= (size_t)g->count[a];
    }
    g->head = memory_rows(cells, sizeof *g->head);
    g->next = memory_rows(spheres, sizeof *g->next);
    g->sphere = memory_rows(spheres, sizeof *g->sphere);
    if (!g->head || !g->next || !g->sphere)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to fill the space behind the gate");
    for (size_t k = 0; k < cells; k++)
        g->head[k] = -1;
    return SCREE_OK;
}

static void grid_add(struct grid *g, const double sphere[4])
{
    static const int here[3] = {0, 0, 0};
    size_t cell = cell_of(g, sphere, here);
    memcpy(g->sphere[g->spheres], sphere, sizeof *g->sphere);
    g->next[g->spheres] = g->head[cell];
    g->head[cell] = (int32_t)g->spheres++;
}

/* ---- filling ---- */

struct space {
    const struct chute *chute;
    double low[3], high[3], clearance;
};

/* Whether a sphere (along, across, normal) keeps clear of floor, sides, gate, back and top. */
static bool is_inside(const struct space *s, const double sphere[4])
{
    double r = sphere[3] + s->clearance, lean = s->chute->side_rad;
    double out = fabs(sphere[1]) - 0.5 * s->chute->floor;
    return sphere[0] - r >= s->low[0] && sphere[0] + r <= s->high[0] && sphere[2] - r >= s->low[2] && sphere[2] + r <= s->high[2] &&
           cos(lean) * sphere[2] - sin(lean) * out >= r;
}

static struct quat random_turn(struct rng *rng)
{
    for (;;) { // uniform over rotations: a point of the unit ball in four dimensions
        struct quat q = {rng_uniform(rng, -1, 1), rng_uniform(rng, -1, 1), rng_uniform(rng, -1, 1), rng_uniform(rng, -1, 1)};
        double n = quat_norm2(q);
        if (n > 0.01 && n <= 1)
            return quat_unit(q);
    }
}

static bool try_place(const struct space *s, struct grid *g, struct rng *rng, const struct clump *shape, struct dem_body *body)
{
    double sphere[CLUMP_SPHERES_MAX][4], at[3];
    for (int a = 0; a < 3; a++)
        at[a] = rng_uniform(rng, s->low[a], s->high[a]);
    struct quat q = random_turn(rng);
    struct turn turn = quat_turn(q);
    for (size_t k = 0; k < shape->spheres; k++) {
        vec3_store3(sphere[k], vec3_add(vec3_load(at), turn_out(&turn, vec3_load(shape->sphere[k]))));
        sphere[k][3] = shape->sphere[k][3];
        if (!is_inside(s, sphere[k]) || !is_free(g, sphere[k]))
            return false;
    }
    for (size_t k = 0; k < shape->spheres; k++)
        grid_add(g, sphere[k]);
    memset(body, 0, sizeof *body);
    chute_accelerator_point(s->chute, at[0], at[1], at[2], body->position);
    /* From (along, across, normal) into space: a turn about y by the slope. */
    double half = 0.5 * chute_slope(s->chute, 0);
    quat_store(body->orientation, quat_unit(quat_product((struct quat){cos(half), 0, sin(half), 0}, q)));
    return true;
}

/* The user's own clast: by exact integrals over its polyhedron, or as said in numbers. */
static enum scree_status make_clast(const struct job_spec *job, struct clump *out, struct scree_error *err)
{
    const struct clast_spec *c = &params_of(job)->clast;
    const double *m = c->moments_kg_m2, *o = c->products_kg_m2, inertia[6] = {m[0], m[1], m[2], o[0], o[1], o[2]};
    uint32_t corner[CLAST_FACES][3];
    struct trimesh *mesh = NULL;
    enum scree_status status;
    if (c->faces.count > 0) {
        for (int64_t k = 0; k < c->faces.count; k++)
            for (int v = 0; v < 3; v++)
                corner[k][v] = (uint32_t)c->faces.row[k][v];
        status = trimesh_create(c->vertices.row, (size_t)c->vertices.count, (const uint32_t(*)[3])corner, (size_t)c->faces.count,
                                true, &mesh, err);
        if (!status)
            status = clump_inscribe(mesh, c->spheres.row, (size_t)c->spheres.count, job->fragments.density_kg_m3, out, NULL, err);
        trimesh_free(mesh);
    } else {
        status = clump_create(c->spheres.row, (size_t)c->spheres.count, c->mass_kg, c->centre_m, inertia,
                              c->mass_kg / job->fragments.density_kg_m3, out, NULL, err);
    }
    if (status == SCREE_INVALID && err) { // geometry knows no job: say whose clast it is
        char message[sizeof err->message];
        snprintf(message, sizeof message, "params.clast: %.400s", err->message);
        scree_fail(err, SCREE_INVALID, "params.clast", "%s", message);
    }
    return status;
}

/* In rows of equal spheres, or with a sphere in each corner and, between them, spheres as wide as the last edge, the shortest. */
static enum scree_status make_block(const struct job_spec *job, const double size[3], struct clump *out, struct scree_error *err)
{
    const struct chute_params *p = params_of(job);
    const double density = job->fragments.density_kg_m3;
    if (!(p->corners > 0))
        return clump_block(size, p->size_m / (2 * (double)p->spheres), density, out, err);
    enum scree_status status = clump_block(size, 0.5 * size[2], density, out, err);
    return status ? status : clump_add_corners(size, p->corners * p->size_m, out, err);
}

static enum scree_status make_shapes(const struct job_spec *job, struct clump shapes[FRAGMENT_SHAPES], struct scree_error *err)
{
    const struct chute_params *p = params_of(job);
    const double a = p->size_m, size[FRAGMENT_SHAPES][3] = {{a, a, a}, {a, a, a / 2}, {a, a / 2, a / 2}};
    enum scree_status status = SCREE_OK;
    for (int k = 0; k < FRAGMENT_SHAPES && !status; k++) // the user's stands in for all three
        status = p->clast.on ? make_clast(job, &shapes[k], err) : make_block(job, size[k], &shapes[k], err);
    return status;
}

enum scree_status fragments_fill(const struct job_spec *job, struct clump shapes[FRAGMENT_SHAPES], struct dem_body **bodies,
                                 size_t *count, struct scree_error *err)
{
    const struct chute_params *p = params_of(job);
    const struct chute chute = fragments_chute(job);
    double share[FRAGMENT_SHAPES] = {p->cubes, p->halves, fmax(0, 1 - p->cubes - p->halves)}, largest = 0;
    struct space space = {.chute = &chute,
                          .low = {-chute.gate - space_length(job, &chute), -0.5 * chute.width, 0},
                          .high = {-chute.gate, 0.5 * chute.width, 0.5 * (chute.width - chute.floor) * tan(chute.side_rad)},
                          .clearance = CLEARANCE * p->size_m};
    struct grid grid = {.head = NULL};
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_FRAGMENTS);
    size_t wanted[FRAGMENT_SHAPES], total = 0, spheres = 0;
    double placed_kg = 0;
    *bodies = NULL;
    *count = 0;
    enum scree_status status = make_shapes(job, shapes, err);
    if (status)
        return status;
    if (p->clast.on) {
        memset(share, 0, sizeof share);
        share[0] = 1;
    }
    for (int k = 0; k < FRAGMENT_SHAPES; k++) {
        for (size_t s = 0; s < shapes[k].spheres; s++)
            largest = fmax(largest, shapes[k].sphere[s][3]);
        wanted[k] = (size_t)round(1e-3 * p->mass_g * share[k] / shapes[k].mass);
        total += wanted[k];
        spheres += wanted[k] * shapes[k].spheres;
    }
    if (total == 0)
        return scree_fail(err, SCREE_INVALID, "params.mass_g", "params.mass_g: %.6g g are not one fragment of %.6g m", p->mass_g,
                          p->size_m);
    if (!(*bodies = memory_rows(total, sizeof **bodies)))
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu fragments", total);
    if (!status)
        status = grid_start(&grid, space.low, space.high, largest, spheres, err);
    for (int k = 0; k < FRAGMENT_SHAPES && !status; k++)
        for (size_t n = 0; n < wanted[k] && !status; n++) {
            int tries = 0;
            while (tries < TRIES_A_FRAGMENT && !try_place(&space, &grid, &rng, &shapes[k], &(*bodies)[*count]))
                tries++;
            if (tries == TRIES_A_FRAGMENT) {
                status = scree_fail(
                    err, SCREE_INVALID, "params.mass_g",
                    "params.mass_g: of %zu fragments %zu fit into the space behind the gate without overlap, %.4g g of %.6g g",
                    total, *count, 1e3 * placed_kg, p->mass_g);
                scree_hint(err, "a lower params.space_density_kg_m3 or a larger params.space_mass_g makes the space larger");
                break;
            }
            (*bodies)[(*count)++].shape = (uint32_t)k;
            placed_kg += shapes[k].mass;
        }
    free(grid.head);
    free(grid.next);
    free(grid.sphere);
    if (status) {
        free(*bodies);
        *bodies = NULL;
    }
    return status;
}
