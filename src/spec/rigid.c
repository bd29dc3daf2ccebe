/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rigid convex bodies and composites of them: their matter and their shapes (seed 001). */
#include <math.h>
#include <stdio.h>

#include "base/text.h"
#include "spec/scenarios.h"

#define AT(member)   .offset = offsetof(struct rigid_spec, member)
#define OF(member)   .offset = offsetof(struct body_spec, member)
#define COUNT(array) (sizeof(array) / sizeof *(array))

static const struct field fields[] = {
    {.name = "density_kg_m3",
     .type = FIELD_REAL,
     AT(density_kg_m3),
     .min = 1,
     .max = 1e5,
     .preset = 770,
     .unit = "kg/m3",
     .doc = "density of the bodies",
     .source = "seed 001 Table I"},
    {.name = "stiffness_N_m",
     .type = FIELD_REAL,
     AT(stiffness),
     .min = 1e-3,
     .max = 1e12,
     .preset = 4.5e5,
     .unit = "N/m",
     .doc = "normal stiffness k_n",
     .source = "seed 001 Table I"},
    {.name = "restitution",
     .type = FIELD_REAL,
     AT(restitution),
     .min = 0.01,
     .max = 1,
     .preset = 0.85,
     .unit = "",
     .doc = "coefficient of restitution e_n of a head-on impact, without the clamp",
     .source = "seed 001 Table I, eq. 11"},
    {.name = "stiffness_t_N_m",
     .type = FIELD_REAL,
     AT(stiffness_t),
     .min = 0,
     .max = 1e12,
     .preset = 300,
     .unit = "N/m",
     .doc = "tangential stiffness k_t; 0: friction has no memory",
     .source = "seed 001 Table I"},
    {.name = "gamma_t_1_s",
     .type = FIELD_REAL,
     AT(rate_t),
     .min = 0,
     .max = 1e9,
     .preset = 1e3,
     .unit = "1/s",
     .doc = "tangential damping gamma_t = eta_t / 2 m_ij",
     .source = "seed 001 Table I"},
    {.name = "friction",
     .type = FIELD_REAL,
     AT(friction),
     .min = 0,
     .max = 10,
     .preset = 0.46,
     .unit = "",
     .doc = "coefficient of friction mu_c between bodies",
     .source = "seed 001 Table I"},
    {.name = "friction_wall",
     .type = FIELD_REAL,
     AT(at_wall),
     .min = 0,
     .max = 10,
     .preset = 0.62,
     .unit = "",
     .doc = "coefficient of friction mu_c between bodies and walls",
     .source = "seed 001 Table I"},
    {.name = "rolling_friction",
     .type = FIELD_REAL,
     AT(rolling),
     .min = 0,
     .max = 10,
     .preset = 0,
     .unit = "",
     .doc = "coefficient of rolling friction mu_r between bodies",
     .source = "seed 001 eqs A1-A9"},
    {.name = "rolling_friction_wall",
     .type = FIELD_REAL,
     AT(rolling_wall),
     .min = 0,
     .max = 10,
     .preset = 0,
     .unit = "",
     .doc = "coefficient of rolling friction mu_r between bodies and walls",
     .source = "seed 001 Table II"},
    {.name = "crust_m",
     .type = FIELD_REAL,
     AT(crust_m),
     .min = 1e-9,
     .max = 1,
     .preset = 1e-4,
     .unit = "m",
     .doc = "shell in which bodies touch: their edges are rounded by it, no overlap may be twice as deep",
     .source = "protocols 2.1"},
    {.name = "average",
     .type = FIELD_BOOL,
     AT(average),
     .preset = 1,
     .unit = "",
     .doc = "the force between two bodies is the mean over their points of contact, as in the published code; false: the sum",
     .source = "protocols 2.1"},
    {.name = "clamp",
     .type = FIELD_BOOL,
     AT(clamp),
     .preset = 0,
     .unit = "",
     .doc = "normal forces never pull; restitution is then larger than asked for",
     .source = "seed 001 eq. 5, targets S1-01"},
    {.name = "memory",
     .type = FIELD_BOOL,
     AT(memory),
     .preset = 1,
     .unit = "",
     .doc = "contacts remember how far they slid and rolled; false: k_t and k_r are nothing, the dashpots alone resist",
     .source = "seed 001 B.1, V.B"},
};
const struct field_table rigid_table = {
    .name = "material",
    .doc = "the bodies' matter and what they do when they touch; \"preset\" names a published one, other keys override it",
    .fields = fields,
    .count = COUNT(fields),
    .size = sizeof(struct rigid_spec)};

const struct rigid_spec rigid_crosses = {.preset = "plastic-crosses",
                                         .density_kg_m3 = 770,
                                         .stiffness = 4.5e5,
                                         .restitution = 0.85,
                                         .stiffness_t = 300,
                                         .rate_t = 1e3,
                                         .friction = 0.46,
                                         .at_wall = 0.62,
                                         .crust_m = 1e-4,
                                         .average = true,
                                         .memory = true};

const struct rigid_spec rigid_beads = {.preset = "hopper-beads",
                                       .density_kg_m3 = 2500,
                                       .stiffness = 7.34e5,
                                       .restitution = 0.45,
                                       .stiffness_t = 2.26e5,
                                       .rate_t = 4e4,
                                       .friction = 0.5,
                                       .at_wall = 0.45,
                                       .rolling = 0.45,
                                       .rolling_wall = 0.1,
                                       .crust_m = 1e-4,
                                       .average = true,
                                       .memory = true};

static const char *const shapes[] = {"cross", "box", "tetrapod", "sphere", "prism", "cylinder", "hulls", "spheres", NULL};
static const struct field body_fields[] = {
    {.name = "shape",
     .type = FIELD_ENUM,
     OF(shape),
     .preset = BODY_CROSS,
     .unit = "",
     .doc = "cross of two boxes, box, tetrapod of four six-sided legs, sphere, upright prism, cylinder (a thin one is a coin), "
            "hulls of "
            "points, glued spheres",
     .source = "seed 001 III.B",
     .choices = shapes},
    {.name = "length_m",
     .type = FIELD_REAL,
     OF(length_m),
     .min = 1e-5,
     .max = 10,
     .preset = 0.027,
     .unit = "m",
     .doc = "of a cross' arms from end to end, of a box, a prism, a cylinder; of a tetrapod's legs from its centre",
     .source = "seed 001 III.B"},
    {.name = "width_m",
     .type = FIELD_REAL,
     OF(width_m),
     .min = 1e-5,
     .max = 10,
     .preset = 0.002,
     .unit = "m",
     .doc = "of a cross' arms, of a box",
     .source = "seed 001 III.B"},
    {.name = "thickness_m",
     .type = FIELD_REAL,
     OF(thickness_m),
     .min = 1e-5,
     .max = 10,
     .preset = 0.003,
     .unit = "m",
     .doc = "of a cross, of a box",
     .source = "seed 001 III.B"},
    {.name = "radius_m",
     .type = FIELD_REAL,
     OF(radius_m),
     .min = 1e-5,
     .max = 10,
     .preset = 0.0042,
     .unit = "m",
     .doc = "of a sphere, a cylinder; of a prism and a tetrapod's legs to their corners",
     .source = "seed 001 III.B"},
    {.name = "sides",
     .type = FIELD_INT,
     OF(sides),
     .min = 3,
     .max = 32,
     .preset = 3,
     .unit = "sides",
     .doc = "of a prism",
     .source = ""},
    {.name = "points_m",
     .type = FIELD_TEXT,
     OF(points_m),
     .size = BODY_POINTS_TEXT,
     .unit = "m",
     .doc = "of hulls: corners \"x y z, x y z, ...\" of a convex part, parts apart by \";\"; of glued spheres: \"x y z r, ...\"",
     .source = ""},
};
const struct field_table body_table = {"body", "", body_fields, COUNT(body_fields), sizeof(struct body_spec)};

double rigid_contact_time(const struct rigid_spec *m, double reduced_mass)
{
    double log_e = log(m->restitution);
    return sqrt(reduced_mass * (M_PI * M_PI + log_e * log_e) / m->stiffness);
}

/* Half the longest way between two points of what is listed, and a lower bound of its volume: its thinnest part's is not
 * known here. */
static double listed_reach(const struct body_spec *b)
{
    struct body_points p;
    double most = 0;
    if (body_points(b, &p, NULL))
        return 0;
    for (size_t i = 0; i < p.count; i++)
        for (size_t k = 0; k <= i; k++) {
            const double *u = p.point[i], *v = p.point[k];
            double way2 = (u[0] - v[0]) * (u[0] - v[0]) + (u[1] - v[1]) * (u[1] - v[1]) + (u[2] - v[2]) * (u[2] - v[2]);
            most = fmax(most, 0.5 * (sqrt(way2) + u[3] + v[3]));
        }
    return most;
}

double body_reach(const struct body_spec *b)
{
    double l = b->length_m, w = b->width_m, t = b->thickness_m;
    switch ((enum body_shape)b->shape) {
    case BODY_CROSS:
    case BODY_BOX:
        return 0.5 * sqrt(l * l + w * w + t * t);
    case BODY_TETRAPOD:
        return hypot(l, b->radius_m);
    case BODY_PRISM:
    case BODY_CYLINDER:
        return hypot(0.5 * l, b->radius_m);
    case BODY_HULLS:
    case BODY_SPHERES:
        return listed_reach(b);
    case BODY_SPHERE:
        break;
    }
    return b->radius_m;
}

double body_volume(const struct body_spec *b)
{
    double l = b->length_m, w = b->width_m, t = b->thickness_m, r = b->radius_m, n = (double)b->sides;
    switch ((enum body_shape)b->shape) {
    case BODY_CROSS:
        return (2 * l - w) * w * t;
    case BODY_BOX:
        return l * w * t;
    case BODY_TETRAPOD:
        return 4 * l * 1.5 * sqrt(3) * r * r;
    case BODY_PRISM:
        return 0.5 * n * r * r * sin(2 * M_PI / n) * l;
    case BODY_CYLINDER:
        return M_PI * r * r * l;
    case BODY_HULLS:
    case BODY_SPHERES: // of the ball around it: the scenario weighs it
        r = listed_reach(b);
        break;
    case BODY_SPHERE:
        break;
    }
    return 4 * M_PI / 3 * r * r * r;
}

double body_thinnest(const struct body_spec *b)
{
    switch ((enum body_shape)b->shape) {
    case BODY_CROSS:
    case BODY_BOX:
        return fmin(b->width_m, b->thickness_m);
    case BODY_TETRAPOD:
        return b->radius_m;
    case BODY_PRISM:
    case BODY_CYLINDER:
        return fmin(b->length_m, b->radius_m);
    case BODY_SPHERE:
    case BODY_HULLS:
    case BODY_SPHERES:
        break;
    }
    return INFINITY;
}

double body_gap(const struct body_spec *b)
{
    double thinnest = body_thinnest(b);
    return isfinite(thinnest) ? thinnest : b->shape == BODY_SPHERE ? 2 * body_reach(b) : 0;
}

/* ---- what their scenarios share ---- */

void rigid_defaults(struct job_spec *job)
{
    job->time.step_s = 2.5e-6;
    job->record.basal_force.every_s = 1e-4;
    job->record.bulk.on = true;
    job->record.heap.on = true;
}

enum { BYTES_PER_BODY = 8000 }; // with its pairs of parts where bodies are entangled

struct job_cost rigid_cost(const struct job_spec *job, double bodies)
{
    return (struct job_cost){
        .moving = bodies, .steps = fmax(1, round(job->time.end_s / job->time.step_s)), .bytes = bodies * BYTES_PER_BODY};
}

/* Records that a world of bodies has nothing for. */
static enum scree_status check_records(const struct job_spec *job, struct scree_error *err)
{
    static const char *const not [] = {"profiles", "connectivity", "collisions", "energy", "contact", "flow"};
    for (size_t k = 0; k < COUNT(not ); k++)
        if (record_find(job, not [k]).on) {
            char path[64];
            snprintf(path, sizeof path, "record.%s", not [k]);
            return scree_fail(err, SCREE_INVALID, path, "%s: is for worlds of spheres, and scenario %s has rigid bodies", path,
                              job->scenario->name);
        }
    return check_intervals(job, err);
}

enum scree_status rigid_step_check(const struct job_spec *job, double mass, struct scree_error *err)
{
    char step[TEXT_REAL_MAX];
    double duration = rigid_contact_time(&job->rigid, 0.5 * mass);
    if (job->time.step_s <= duration / 8)
        return SCREE_OK;
    scree_fail(err, SCREE_INVALID, "time.step_s", "time.step_s: %s s is above an eighth of a contact's duration, %.3g s",
               text_real(job->time.step_s, step), duration);
    scree_hint(err, "a twentieth is a good choice; it grows as material.stiffness_N_m to the power -1/2");
    return SCREE_INVALID;
}

enum scree_status rigid_check(const struct job_spec *job, const struct body_spec *body, double length, double width,
                              const char *path, struct scree_error *err)
{
    const struct rigid_spec *m = &job->rigid;
    char a[TEXT_REAL_MAX], b[TEXT_REAL_MAX];
    double across = 2 * body_reach(body);
    double thinnest = body_thinnest(body);
    struct body_points points;
    if (body->shape >= BODY_HULLS && body_points(body, &points, err))
        return SCREE_INVALID;
    if (job->threads > 1)
        return scree_fail(err, SCREE_INVALID, "threads",
                          "threads: %lld: worlds of rigid bodies step in one thread, several jobs at once",
                          (long long)job->threads);
    if (fmin(length, width) < across)
        return scree_fail(err, SCREE_INVALID, fmin(length, width) == length ? path : "params.width_m",
                          "%s: %s m do not hold a body that is %s m across, whatever way it is turned",
                          fmin(length, width) == length ? path : "params.width_m", text_real(fmin(length, width), a),
                          text_real(across, b));
    if (body->shape == BODY_CROSS && body->width_m >= body->length_m)
        return scree_fail(err, SCREE_INVALID, "params.body.width_m", "params.body.width_m: arms of %s m are wider than long, %s m",
                          text_real(body->width_m, a), text_real(body->length_m, b));
    if (m->crust_m > 0.25 * thinnest)
        return scree_fail(err, SCREE_INVALID, "material.crust_m",
                          "material.crust_m: %s m leave no core to a body that is %s m thin: at most a quarter of it",
                          text_real(m->crust_m, a), text_real(thinnest, b));
    enum scree_status status = rigid_step_check(job, m->density_kg_m3 * body_volume(body), err);
    return status ? status : check_records(job, err);
}
