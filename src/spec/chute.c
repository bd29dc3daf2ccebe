/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `chute` as the user sees it. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member) .offset = offsetof(struct chute_params, member)

static const char *const accelerators[] = {"chute", "gate", NULL};

#define CLAST(member) .offset = offsetof(struct clast_spec, member)

static const struct field clast_fields[] = {
    {.name = "spheres",
     .type = FIELD_ROWS,
     CLAST(spheres),
     .size = CLAST_SPHERES,
     .columns = 4,
     .min = -1,
     .max = 1,
     .unit = "m",
     .doc = "what touches: x, y, z and radius of each sphere, in any frame",
     .source = "seed 003 3.1"},
    {.name = "vertices",
     .type = FIELD_ROWS,
     CLAST(vertices),
     .size = CLAST_VERTICES,
     .columns = 3,
     .min = -1,
     .max = 1,
     .unit = "m",
     .doc = "of the convex polyhedron that the spheres are inscribed in, in the same frame",
     .source = "seed 003 3.1"},
    {.name = "faces",
     .type = FIELD_ROWS,
     CLAST(faces),
     .size = CLAST_FACES,
     .columns = 3,
     .min = 0,
     .max = CLAST_VERTICES - 1,
     .unit = "",
     .doc = "its triangles: three vertices each by number from 0, anticlockwise from outside; they give mass and inertia exactly",
     .source = ""},
    {.name = "mass_kg",
     .type = FIELD_REAL,
     CLAST(mass_kg),
     .min = 0,
     .max = 1e3,
     .preset = 0,
     .unit = "kg",
     .doc = "without faces: its mass",
     .source = ""},
    {.name = "centre_m",
     .type = FIELD_VEC3,
     CLAST(centre_m),
     .min = -1,
     .max = 1,
     .preset = 0,
     .unit = "m",
     .doc = "without faces: its centre of mass",
     .source = ""},
    {.name = "moments_kg_m2",
     .type = FIELD_VEC3,
     CLAST(moments_kg_m2),
     .min = 0,
     .max = 1e3,
     .preset = 0,
     .unit = "kg m2",
     .doc = "without faces: xx, yy, zz of its inertia tensor about the centre of mass",
     .source = ""},
    {.name = "products_kg_m2",
     .type = FIELD_VEC3,
     CLAST(products_kg_m2),
     .min = -1e3,
     .max = 1e3,
     .preset = 0,
     .unit = "kg m2",
     .doc = "without faces: xy, xz, yz of that tensor",
     .source = ""},
};
static const struct field_table clast_table = {"clast", "", clast_fields, sizeof clast_fields / sizeof *clast_fields,
                                               sizeof(struct clast_spec)};

#define MESH(member) .offset = offsetof(struct mesh_spec, member)

static const struct field mesh_fields[] = {
    {.name = "file",
     .type = FIELD_TEXT,
     MESH(file),
     .size = MESH_FILE_MAX,
     .unit = "",
     .doc =
         "STL (binary or ASCII) or OBJ, seen from the job's own file; scree reads it, gives it to the daemon and fills sha256 in",
     .source = "",
     .aside = true},
    {.name = "sha256",
     .type = FIELD_TEXT,
     MESH(sha256),
     .size = MESH_NAME_MAX,
     .unit = "",
     .doc = "name of a mesh that the daemon has: the SHA-256 of the file's bytes",
     .source = ""},
    {.name = "unit_m",
     .type = FIELD_REAL,
     MESH(unit_m),
     .min = 1e-9,
     .max = 1e3,
     .preset = 1,
     .unit = "m",
     .doc = "what the file's lengths are in: 0.001 for millimetres",
     .source = ""},
    {.name = "closed",
     .type = FIELD_BOOL,
     MESH(closed),
     .preset = 1,
     .unit = "",
     .doc = "refuse a mesh that does not enclose a space; false takes sheets, which have a rim",
     .source = ""},
};
static const struct field_table mesh_table = {"mesh", "", mesh_fields, sizeof mesh_fields / sizeof *mesh_fields,
                                              sizeof(struct mesh_spec)};

static const struct field fields[] = {
    {.name = "mass_g",
     .type = FIELD_REAL,
     AT(mass_g),
     .min = 1e-3,
     .max = 1e6,
     .preset = 27,
     .unit = "g",
     .doc = "mass of the flow",
     .source = "seed 003 3.1"},
    {.name = "size_m",
     .type = FIELD_REAL,
     AT(size_m),
     .min = 1e-5,
     .max = 1,
     .preset = 2e-3,
     .unit = "m",
     .doc = "grain size: edge of the cubes, longest edge of all",
     .source = "seed 003 3.1"},
    {.name = "cubes",
     .type = FIELD_REAL,
     AT(cubes),
     .min = 0,
     .max = 1,
     .preset = 0.38,
     .unit = "",
     .doc = "share of cubes in the mass",
     .source = "seed 003 3.1"},
    {.name = "halves",
     .type = FIELD_REAL,
     AT(halves),
     .min = 0,
     .max = 1,
     .preset = 0.22,
     .unit = "",
     .doc = "share of half cubes in the mass; the rest are quarters",
     .source = "seed 003 3.1"},
    {.name = "spheres",
     .type = FIELD_INT,
     AT(spheres),
     .min = 2,
     .max = 4,
     .preset = 2,
     .unit = "",
     .doc = "spheres along a cube's edge, 2 or 4: of radius size/4 or size/8",
     .source = "ours; protocols 4"},
    {.name = "corners",
     .type = FIELD_REAL,
     AT(corners),
     .min = 0,
     .max = 0.25,
     .preset = 0,
     .unit = "",
     .doc = "radius over size_m of a sphere in each corner, between which spheres as wide as the shortest edge stand in place of "
            "params.spheres; 0: none. Such fragments stand on their corners, as polyhedra do",
     .source = "ours"},
    {.name = "clast",
     .type = FIELD_SWITCH,
     AT(clast),
     .preset = 0,
     .unit = "",
     .doc = "a clast of your own, of which all are, in place of cubes, halves and quarters; size_m stays the delta of beta",
     .source = "",
     .table = &clast_table},
    {.name = "space_mass_g",
     .type = FIELD_REAL,
     AT(space_mass_g),
     .min = 0,
     .max = 1e6,
     .preset = 0,
     .unit = "g",
     .doc = "the space behind the gate is made for this mass; 0: mass_g. More makes a smaller initial compaction",
     .source = "seed 003 3.1"},
    {.name = "space_density_kg_m3",
     .type = FIELD_REAL,
     AT(space_density_kg_m3),
     .min = 1,
     .max = 3000,
     .preset = 731,
     .unit = "kg/m3",
     .doc = "density of the mass that the space is made for",
     .source = "seed 003 3.1"},
    {.name = "accelerator",
     .type = FIELD_ENUM,
     AT(accelerator),
     .preset = 0,
     .unit = "",
     .doc = "whose matter the accelerator has",
     .source = "seed 003 3.1, Table 2",
     .choices = accelerators},
    {.name = "gate_m_s",
     .type = FIELD_REAL,
     AT(gate_m_s),
     .min = 0,
     .max = 100,
     .preset = 0,
     .unit = "m/s",
     .doc = "speed at which the gate slides off, normal to the accelerator; 0: it vanishes at the start",
     .source = "ours; protocols 4"},
    SPEC_GRAVITY_ROW(AT(gravity_m_s2)),
    {.name = "floor_m",
     .type = FIELD_REAL,
     AT(floor_m),
     .min = 1e-3,
     .max = 10,
     .preset = 0.03,
     .unit = "m",
     .doc = "width of the flat floor of the section",
     .source = "ours; protocols 4"},
    {.name = "width_m",
     .type = FIELD_REAL,
     AT(width_m),
     .min = 1e-3,
     .max = 10,
     .preset = 0.054,
     .unit = "m",
     .doc = "width of the section across the tops of its sides",
     .source = "seed 003 2"},
    {.name = "side_deg",
     .type = FIELD_REAL,
     AT(side_deg),
     .min = 5,
     .max = 85,
     .preset = 45,
     .unit = "deg",
     .doc = "of the sides to the floor",
     .source = "ours; protocols 4"},
    {.name = "guard_m",
     .type = FIELD_REAL,
     AT(guard_m),
     .min = 1e-3,
     .max = 10,
     .preset = 0.05,
     .unit = "m",
     .doc = "upright guards on the sides: nothing leaves the apparatus",
     .source = "ours"},
    {.name = "run_m",
     .type = FIELD_REAL,
     AT(run_m),
     .min = 0.01,
     .max = 100,
     .preset = 1.4,
     .unit = "m",
     .doc = "horizontal length of the curved chute",
     .source = "seed 003 2"},
    {.name = "gate_m",
     .type = FIELD_REAL,
     AT(gate_m),
     .min = 1e-3,
     .max = 10,
     .preset = 0.223,
     .unit = "m",
     .doc = "gate above the join, along the accelerator",
     .source = "seed 003 2"},
    {.name = "flatness",
     .type = FIELD_REAL,
     AT(flatness),
     .min = 1e-5,
     .max = 0.1,
     .preset = 0.005,
     .unit = "sizes",
     .doc = "the curve is cut into flats that are nowhere farther from it, in grain sizes",
     .source = "ours"},
    {.name = "mesh",
     .type = FIELD_SWITCH,
     AT(mesh),
     .preset = 0,
     .unit = "",
     .doc = "an apparatus of your own, triangles in place of accelerator and chute; x is downslope, z up, and x = 0 where "
            "the gate is gate_m upslope of. Space behind the gate, gate and measurements stay those of the geometry above",
     .source = "",
     .table = &mesh_table},
};
static const struct field_table table = {"params", "", fields, sizeof fields / sizeof *fields, sizeof(struct chute_params)};
_Static_assert(sizeof(struct chute_params) <= SPEC_PARAMS_MAX, "params fit the job");

static const struct chute_params *params_of(const struct job_spec *job)
{
    return (const struct chute_params *)(const void *)job->params;
}

/* Rest: what the paper calls the end of an experiment. A flow lasts some 1.5 s. */
static void chute_defaults(struct job_spec *job)
{
    job->time = (struct time_spec){.step_s = 1e-7, .end_s = 4};
    job->stop.when = STOP_REST;
    job->record.flow.on = true;
    job->record.basal_force.every_s = 1e-4;
    job->record.bulk.every_s = 1e-2;
}

static struct job_cost chute_cost(const struct job_spec *job)
{
    const struct chute_params *p = params_of(job);
    /* Spheres of cubes, halves and quarters: rows of two along the edge, or of four, which leave inner ones out; or corners
     * and, between them, spheres as wide as the shortest edge. */
    static const double rows[2][3] = {{8, 4, 2}, {56, 32, 16}}, cornered[3] = {9, 12, 10};
    const double *of = p->corners > 0 ? cornered : rows[p->spheres == 4];
    double cube = job->fragments.density_kg_m3 * p->size_m * p->size_m * p->size_m;
    double mass = p->mass_g * 1e-3, quarters = 1 - p->cubes - p->halves;
    if (p->clast.on) // its mass is known once it is built: that of a cube, if it has not been said
        cube = p->clast.mass_kg > 0 ? p->clast.mass_kg : cube;
    double per_cube = p->cubes * of[0] + 2 * p->halves * of[1] + 4 * quarters * of[2];
    struct job_cost cost = {.moving = mass / cube * (p->clast.on ? (double)p->clast.spheres.count : per_cube),
                            .steps = fmax(1, round(job->time.end_s / job->time.step_s))};
    cost.bytes = cost.moving * SPEC_BYTES_PER_GRAIN;
    return cost;
}

/* Steps above this share of the Rayleigh time do not follow contacts (20 to 40 % is EDEM's habit). */
#define RAYLEIGH_SHARE 0.4

/* Of the smallest sphere: contacts of it are the quickest. */
static double smallest_radius(const struct chute_params *p)
{
    double smallest = INFINITY;
    for (int64_t k = 0; p->clast.on && k < p->clast.spheres.count; k++)
        smallest = fmin(smallest, p->clast.spheres.row[k][3]);
    if (p->clast.on)
        return smallest;
    return p->corners > 0 ? p->corners * p->size_m : p->size_m / (2 * (double)p->spheres);
}

static enum scree_status check_clast(const struct clast_spec *clast, struct scree_error *err)
{
    if (clast->spheres.count == 0)
        return scree_fail(err, SCREE_INVALID, "params.clast.spheres", "params.clast.spheres: a clast needs a sphere to touch with");
    for (int64_t k = 0; k < clast->spheres.count; k++)
        if (!(clast->spheres.row[k][3] > 0))
            return scree_fail(err, SCREE_INVALID, "params.clast.spheres", "params.clast.spheres: sphere %lld has no radius",
                              (long long)k);
    for (int64_t k = 0; k < clast->faces.count; k++)
        for (int c = 0; c < 3; c++)
            if (clast->faces.row[k][c] != floor(clast->faces.row[k][c]) || clast->faces.row[k][c] >= (double)clast->vertices.count)
                return scree_fail(err, SCREE_INVALID, "params.clast.faces", "params.clast.faces: triangle %lld has no such vertex",
                                  (long long)k);
    if (clast->faces.count > 0 && clast->mass_kg > 0)
        return scree_fail(err, SCREE_INVALID, "params.clast.mass_kg",
                          "params.clast.mass_kg: faces give the mass already, with material.density_kg_m3");
    return SCREE_OK;
}

static enum scree_status check_mesh(const struct mesh_spec *mesh, struct scree_error *err)
{
    if (strlen(mesh->sha256) == MESH_NAME_MAX - 1 && strspn(mesh->sha256, "0123456789abcdef") == MESH_NAME_MAX - 1)
        return SCREE_OK;
    if (*mesh->sha256)
        scree_fail(err, SCREE_INVALID, "params.mesh.sha256", "params.mesh.sha256: 64 digits 0..9, a..f are expected");
    else
        scree_fail(err, SCREE_INVALID, "params.mesh.sha256", "params.mesh.sha256: which mesh? The name of one is missing");
    scree_hint(err, "params.mesh.file names a file that scree reads and gives to the daemon");
    return SCREE_INVALID;
}

static enum scree_status chute_check(const struct job_spec *job, struct scree_error *err)
{
    const struct chute_params *p = params_of(job);
    char text[TEXT_REAL_MAX];
    double longest = RAYLEIGH_SHARE * fragment_rayleigh_time(&job->fragments, smallest_radius(p));
    enum scree_status status = p->clast.on ? check_clast(&p->clast, err) : SCREE_OK;
    if (!status && p->mesh.on)
        status = check_mesh(&p->mesh, err);
    if (status)
        return status;
    if (p->spheres == 3)
        return scree_fail(err, SCREE_INVALID, "params.spheres",
                          "params.spheres: 3 along an edge leave half a sphere; 2 or 4 are taken");
    if (p->cubes + p->halves > 1 + 1e-12)
        return scree_fail(err, SCREE_INVALID, "params.halves", "params.halves: cubes and halves make up %s of the mass",
                          text_real(p->cubes + p->halves, text));
    if (p->width_m < p->floor_m)
        return scree_fail(err, SCREE_INVALID, "params.width_m", "params.width_m: %s m is less than the floor's",
                          text_real(p->width_m, text));
    if (p->size_m > 0.2 * p->floor_m)
        return scree_fail(err, SCREE_INVALID, "params.size_m", "params.size_m: %s m is more than a fifth of the floor's width",
                          text_real(p->size_m, text));
    if (p->space_mass_g > 0 && p->space_mass_g < p->mass_g)
        return scree_fail(err, SCREE_INVALID, "params.space_mass_g",
                          "params.space_mass_g: a space made for %s g does not hold the flow's mass",
                          text_real(p->space_mass_g, text));
    if (job->record.contact.on)
        return scree_fail(err, SCREE_INVALID, "record.contact",
                          "record.contact: is for scenario collision, where there is one contact");
    if (chute_cost(job).moving > SPEC_GRAINS_MAX)
        return scree_fail(err, SCREE_INVALID, "params", "params: %.4g spheres are more than the %.4g that a world holds",
                          chute_cost(job).moving, (double)SPEC_GRAINS_MAX);
    if (job->time.step_s > longest) {
        scree_fail(err, SCREE_INVALID, "time.step_s",
                   "time.step_s: %s s is above %.3g s, which is %.0f %% of the Rayleigh time of these spheres",
                   text_real(job->time.step_s, text), longest, 100 * RAYLEIGH_SHARE);
        scree_hint(err, "shorten time.step_s, or set material.softening: the step grows as its square root");
        return SCREE_INVALID;
    }
    return check_intervals(job, err);
}

const struct scenario_fields scenario_chute_fields = {
    .name = "chute",
    .doc = "angular fragments let go behind a gate run down a curved chute and come to rest",
    .source = "seed 003",
    .kind = SCENARIO_DEM,
    .material = "igneous-fragments",
    .params = &table,
    .defaults = chute_defaults,
    .check = chute_check,
    .cost = chute_cost,
};
