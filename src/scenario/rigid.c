/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The list of set-ups of rigid bodies, and what they share. */
#include "scenario/rigid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/rng.h"

extern const struct rigid_scenario rigid_settle, rigid_dam_break;

static const struct rigid_scenario *const all[] = {&rigid_settle, &rigid_dam_break};

enum { STREAM_POUR = 5 }; // of random numbers

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

static enum scree_status shape_of(const struct body_spec *b, const struct rigid_spec *m, struct composite *out,
                                  struct scree_error *err)
{
    struct polyhedron box;
    enum scree_status status;
    switch ((enum body_shape)b->shape) {
    case BODY_CROSS:
        return composite_cross(b->length_m, b->width_m, b->thickness_m, m->density_kg_m3, m->crust_m, out, err);
    case BODY_BOX:
        status = polyhedron_box((const double[3]){b->length_m, b->width_m, b->thickness_m}, &box, err);
        return status ? status : composite_create(&box, 1, m->density_kg_m3, m->crust_m, out, NULL, err);
    case BODY_TETRAPOD:
        return composite_tetrapod(b->length_m, b->radius_m, m->density_kg_m3, m->crust_m, out, err);
    case BODY_SPHERE:
        break;
    }
    return composite_sphere(b->radius_m, m->density_kg_m3, out, err);
}

/* Between two things of reduced mass m_ij and reduced radius R_ij (eqs 9-12, A5-A9; k_r with R_ij as the published code). */
static struct spring_pair law_between(const struct rigid_spec *m, double mass, double radius, double friction)
{
    double log_e = log(m->restitution);
    double damping = -2 * sqrt(m->stiffness * mass) * log_e / sqrt(M_PI * M_PI + log_e * log_e);
    double rolled = 3 * m->rolling * m->rolling * radius * radius;
    return (struct spring_pair){.stiffness = m->stiffness,
                                .damping = damping,
                                .stiffness_t = m->stiffness_t,
                                .damping_t = 2 * mass * m->rate_t,
                                .friction = friction,
                                .stiffness_r = rolled * m->stiffness,
                                .damping_r = rolled * damping,
                                .rolling_friction = m->rolling,
                                .radius = radius,
                                .clamp = m->clamp};
}

enum scree_status rigid_fill(const struct job_spec *job, const struct body_spec *body, double gravity, struct rigid_plan *plan,
                             struct scree_error *err)
{
    const struct rigid_spec *m = &job->rigid;
    *plan = (struct rigid_plan){.setup = {.step_s = job->time.step_s, .gravity = {0, 0, -gravity}, .average = m->average}};
    enum scree_status status = shape_of(body, m, &plan->shape, err);
    if (status)
        return status;
    double radius = cbrt(3 * plan->shape.volume / (4 * M_PI)); // of the sphere of its volume, as in the paper
    plan->setup.between = law_between(m, 0.5 * plan->shape.mass, 0.5 * radius, m->friction);
    plan->setup.at_wall = law_between(m, plan->shape.mass, radius, m->at_wall);
    plan->setup.shapes = &plan->shape;
    plan->setup.shape_count = 1;
    plan->setup.walls = plan->walls;
    return SCREE_OK;
}

void rigid_box(struct rigid_plan *plan, double length, double width)
{
    const struct convex_wall walls[] = {{{0, 0, 0}, {0, 0, 1}},
                                        {{0, 0, 0}, {1, 0, 0}},
                                        {{length, 0, 0}, {-1, 0, 0}},
                                        {{0, 0, 0}, {0, 1, 0}},
                                        {{0, width, 0}, {0, -1, 0}}};
    memcpy(plan->walls, walls, sizeof walls);
    plan->setup.wall_count = sizeof walls / sizeof *walls;
    plan->length = length;
    plan->width = width;
}

/* Uniform over all orientations (Shoemake 1992). */
static void any_way(struct rng *rng, double orientation[4])
{
    double u = rng_uniform(rng, 0, 1), a = rng_uniform(rng, 0, 2 * M_PI), b = rng_uniform(rng, 0, 2 * M_PI);
    orientation[0] = sqrt(1 - u) * sin(a);
    orientation[1] = sqrt(1 - u) * cos(a);
    orientation[2] = sqrt(u) * sin(b);
    orientation[3] = sqrt(u) * cos(b);
}

enum scree_status rigid_pour(const struct job_spec *job, size_t count, double length, double width, struct rigid_plan *plan,
                             struct scree_error *err)
{
    struct rng rng = rng_start((uint64_t)job->seed, STREAM_POUR);
    double across = 2 * plan->shape.reach;
    size_t along = (size_t)fmax(1, floor(length / across)), over = (size_t)fmax(1, floor(width / across));
    const double cell[2] = {length / (double)along, width / (double)over};
    plan->bodies = memory_rows(count, sizeof *plan->bodies);
    if (!plan->bodies)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu bodies", count);
    for (size_t k = 0; k < count; k++) {
        struct convex_body *b = &plan->bodies[k];
        const size_t at[2] = {k % along, k / along % over};
        for (int a = 0; a < 2; a++) {
            double room = 0.5 * fmax(0, cell[a] - across);
            b->position[a] = ((double)at[a] + 0.5) * cell[a] + rng_uniform(&rng, -room, room);
        }
        b->position[2] = ((double)(k / (along * over)) + 0.5) * across;
        any_way(&rng, b->orientation);
    }
    plan->setup.bodies = plan->bodies;
    plan->setup.body_count = count;
    return SCREE_OK;
}
