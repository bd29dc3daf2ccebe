/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Set-ups of rigid bodies: how a job's params become a convex_setup. */
#ifndef SCREE_SCENARIO_RIGID_H
#define SCREE_SCENARIO_RIGID_H

#include "convex/convex.h"
#include "spec/spec.h"

enum { RIGID_WALLS_MAX = 6 };

/* A set-up with what it points to; fill and use it where it lies. */
struct rigid_plan {
    struct convex_setup setup;
    struct composite shape;
    struct convex_wall walls[RIGID_WALLS_MAX];
    struct convex_body *bodies; // owned
    double length, width;       // of the floor, m
    double ledge;               // height of a hopper's bottom over it; 0: there is none, m
    bool layer;                 // bodies rest or flow on it as a layer
};
void rigid_plan_free(struct rigid_plan *plan);

struct rigid_scenario {
    const char *name; // as in scenario_list
    enum scree_status (*plan)(const struct job_spec *job, struct rigid_plan *plan, struct scree_error *err);
    /* Of the job's params as they now stand, downwards, m/s2. */
    double (*gravity)(const struct job_spec *job);
    const struct body_spec *(*body)(const struct job_spec *job);
};
const struct rigid_scenario *rigid_scenario_find(const char *name);

/* Refuses bodies that are none: what only their geometry tells, without pouring any. */
enum scree_status rigid_body_check(const struct job_spec *job, const struct body_spec *body, struct scree_error *err);

/* Shape, law and step of a job's bodies. */
enum scree_status rigid_fill(const struct job_spec *job, const struct body_spec *body, double gravity, struct rigid_plan *plan,
                             struct scree_error *err);

/* An open box from the origin to length, width. */
void rigid_box(struct rigid_plan *plan, double length, double width);

/* `count` bodies over a floor of length times width, turned every way: none touches another (pour.c). */
enum scree_status rigid_pour(const struct job_spec *job, size_t count, double length, double width, struct rigid_plan *plan,
                             struct scree_error *err);

#endif
