/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of set-ups of rigid bodies, and what they share. */
#include "scenario/rigid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

extern const struct rigid_scenario rigid_settle, rigid_dam_break, rigid_hopper;

static const struct rigid_scenario *const all[] = {&rigid_settle, &rigid_dam_break, &rigid_hopper};

const struct rigid_scenario *rigid_scenario_find(const char *name)
{
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (strcmp(all[k]->name, name) == 0)
            return all[k];
    return NULL;
}

void rigid_plan_free(struct rigid_plan *plan)
{
    free(plan->bodies);
    plan->bodies = NULL;
}

/* Convex parts by their corners. */
static enum scree_status hulls(const struct body_points *points, const struct rigid_spec *m, struct composite *out,
                               struct scree_error *err)
{
    struct polyhedron part[BODY_PARTS_MAX];
    for (size_t k = 0; k < points->parts; k++) {
        double corner[BODY_POINTS_MAX][3];
        size_t from = points->first[k], count = points->first[k + 1] - from;
        for (size_t v = 0; v < count; v++)
            memcpy(corner[v], points->point[from + v], sizeof corner[v]);
        struct scree_error why = {.message = ""};
        enum scree_status status = polyhedron_create((const double(*)[3])corner, count, &part[k], &why);
        if (status)
            return scree_fail(err, status, "params.body.points_m", "params.body.points_m: part %zu: %s", k, why.message);
    }
    return composite_create(part, points->parts, m->density_kg_m3, m->crust_m, out, NULL, err);
}

enum { CYLINDER_SIDES = 24 };

static enum scree_status shape_of(const struct body_spec *b, const struct rigid_spec *m, struct composite *out,
                                  struct scree_error *err)
{
    struct polyhedron part;
    struct body_points points;
    enum scree_status status = SCREE_OK;
    switch ((enum body_shape)b->shape) {
    case BODY_CROSS:
        return composite_cross(b->length_m, b->width_m, b->thickness_m, m->density_kg_m3, m->crust_m, out, err);
    case BODY_BOX:
        status = polyhedron_box((const double[3]){b->length_m, b->width_m, b->thickness_m}, &part, err);
        break;
    case BODY_TETRAPOD:
        return composite_tetrapod(b->length_m, b->radius_m, m->density_kg_m3, m->crust_m, out, err);
    case BODY_SPHERE:
        return composite_sphere(b->radius_m, m->density_kg_m3, out, err);
    case BODY_PRISM:
        status = polyhedron_prism((int)b->sides, b->radius_m, b->length_m, &part, err);
        break;
    case BODY_CYLINDER: // a prism of the circle's area
        status = polyhedron_prism(CYLINDER_SIDES, b->radius_m * sqrt(2 * M_PI / CYLINDER_SIDES / sin(2 * M_PI / CYLINDER_SIDES)),
                                  b->length_m, &part, err);
        break;
    case BODY_HULLS:
        status = body_points(b, &points, err);
        return status ? status : hulls(&points, m, out, err);
    case BODY_SPHERES:
        status = body_points(b, &points, err);
        return status ? status : composite_spheres((const double(*)[4])points.point, points.count, m->density_kg_m3, out, err);
    }
    return status ? status : composite_create(&part, 1, m->density_kg_m3, m->crust_m, out, NULL, err);
}

/* Of the shape's own refusals, which know no fields. */
static enum scree_status shaped(const struct body_spec *b, const struct rigid_spec *m, struct composite *out,
                                struct scree_error *err)
{
    struct scree_error why = {.message = ""};
    enum scree_status status = shape_of(b, m, out, &why);
    const char *path = b->shape >= BODY_HULLS ? "params.body.points_m" : "params.body.shape";
    if (status && *why.path == '\0')
        return scree_fail(err, status, path, "%s: %s", path, why.message);
    return status ? scree_fail(err, status, why.path, "%s", why.message) : SCREE_OK;
}

enum scree_status rigid_body_check(const struct job_spec *job, const struct body_spec *body, struct scree_error *err)
{
    struct composite shape;
    enum scree_status status = shaped(body, &job->rigid, &shape, err);
    return status ? status : rigid_step_check(job, shape.mass, err);
}

/* Between two things of reduced mass m_ij and reduced radius R_ij (eqs 9-12, A5-A9; k_r with R_ij as the published code). */
static struct spring_pair law_between(const struct rigid_spec *m, double mass, double radius, double friction, double rolling)
{
    double log_e = log(m->restitution);
    double damping = -2 * sqrt(m->stiffness * mass) * log_e / sqrt(M_PI * M_PI + log_e * log_e);
    double rolled = 3 * rolling * rolling * radius * radius;
    return (struct spring_pair){.stiffness = m->stiffness,
                                .damping = damping,
                                .stiffness_t = m->memory ? m->stiffness_t : 0,
                                .damping_t = 2 * mass * m->rate_t,
                                .friction = friction,
                                .stiffness_r = m->memory ? rolled * m->stiffness : 0,
                                .damping_r = rolled * damping,
                                .rolling_friction = rolling,
                                .radius = radius,
                                .clamp = m->clamp};
}

enum scree_status rigid_fill(const struct job_spec *job, const struct body_spec *body, double gravity, struct rigid_plan *plan,
                             struct scree_error *err)
{
    const struct rigid_spec *m = &job->rigid;
    *plan = (struct rigid_plan){.setup = {.step_s = job->time.step_s, .gravity = {0, 0, -gravity}, .average = m->average}};
    enum scree_status status = shaped(body, m, &plan->shape, err);
    if (status)
        return status;
    if ((status = rigid_step_check(job, plan->shape.mass, err)))
        return status;
    double radius = cbrt(3 * plan->shape.volume / (4 * M_PI)); // of the sphere of its volume, as in the paper
    plan->setup.between = law_between(m, 0.5 * plan->shape.mass, 0.5 * radius, m->friction, m->rolling);
    plan->setup.at_wall = law_between(m, plan->shape.mass, radius, m->at_wall, m->rolling_wall);
    plan->setup.shapes = &plan->shape;
    plan->setup.shape_count = 1;
    plan->setup.walls = plan->walls;
    return SCREE_OK;
}

void rigid_box(struct rigid_plan *plan, double length, double width)
{
    const struct convex_wall walls[] = {{{0, 0, 0}, {0, 0, 1}, 0},
                                        {{0, 0, 0}, {1, 0, 0}, 0},
                                        {{length, 0, 0}, {-1, 0, 0}, 0},
                                        {{0, 0, 0}, {0, 1, 0}, 0},
                                        {{0, width, 0}, {0, -1, 0}, 0}};
    memcpy(plan->walls, walls, sizeof walls);
    plan->setup.wall_count = sizeof walls / sizeof *walls;
    plan->length = length;
    plan->width = width;
}
