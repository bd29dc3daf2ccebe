/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The granular continuum as the user sees it: rheology, points, solver. */
#include "base/text.h"
#include "spec/scenarios.h"

/* Points are numbered in 32 bits. */
#define SPEC_POINTS_MAX 4e9

#define AT(member) .offset = offsetof(struct continuum_spec, member)

static const char *const laws[] = {"constant", "mu(I)", "hysteretic", "hysteretic-step", NULL};

static const struct field fields[] = {
    {.name = "density_kg_m3",
     .type = FIELD_REAL,
     AT(density_kg_m3),
     .min = 1,
     .max = 1e5,
     .preset = 1473,
     .unit = "kg/m3",
     .doc = "of the material where it is densest",
     .source = "seed 002 Table 1"},
    {.name = "grain_m",
     .type = FIELD_REAL,
     AT(grain_m),
     .min = 1e-7,
     .max = 10,
     .preset = 0.47e-3,
     .unit = "m",
     .doc = "diameter of a grain, in the inertial number alone",
     .source = "seed 002 Table 1"},
    {.name = "law",
     .type = FIELD_ENUM,
     AT(law),
     .preset = LAW_CONSTANT,
     .unit = "",
     .doc = "friction of the bulk: constant; mu(I); larger at rest, falling linearly or (published code) by a step",
     .source = "seed 002 eqs 2.4, 4.2, 6.1",
     .choices = laws},
    {.name = "mu",
     .type = FIELD_REAL,
     AT(mu),
     .min = 0,
     .max = 1,
     .preset = 0.44,
     .unit = "",
     .doc =
         "friction coefficient; with mu(I) that at I = 0, with a hysteretic law that in flow. Above 1 the law's cone holds states "
         "of tension: |Dev sigma| = mu p turns one principal stress in the plane of shear",
     .source = "seed 002 Table 1"},
    {.name = "mu_2",
     .type = FIELD_REAL,
     AT(mu_2),
     .min = 0,
     .max = 1,
     .preset = 0.64,
     .unit = "",
     .doc = "mu(I) at large I",
     .source = "seed 002 section 4.3"},
    {.name = "inertial0",
     .type = FIELD_REAL,
     AT(inertial0),
     .min = 1e-9,
     .max = 1e3,
     .preset = 0.279,
     .unit = "",
     .doc = "I at which mu(I) is half way",
     .source = "seed 002 section 4.3"},
    {.name = "delta_mu",
     .type = FIELD_REAL,
     AT(delta_mu),
     .min = 0,
     .max = 1,
     .preset = 0.16,
     .unit = "",
     .doc = "what rest adds to mu with a hysteretic law",
     .source = "seed 002 section 6"},
    {.name = "inertial_star",
     .type = FIELD_REAL,
     AT(inertial_star),
     .min = 1e-9,
     .max = 1e3,
     .preset = 4e-2,
     .unit = "",
     .doc = "I at which that is gone",
     .source = "seed 002 section 6"},
    {.name = "inertial_fraction",
     .type = FIELD_REAL,
     AT(inertial_fraction),
     .min = 0.01,
     .max = 1,
     .preset = 0.6,
     .unit = "",
     .doc = "I = d ||Dev e|| sqrt(rho/p), ||e|| = sqrt(e:e/2), with rho = density over this: 0.6 grains (published code), 1 bulk "
            "(paper)",
     .source = "seed 002 eq. 4.1"},
    {.name = "points",
     .type = FIELD_INT,
     AT(points),
     .min = 1,
     .max = 16,
     .preset = 6,
     .unit = "",
     .doc = "material points along a cell's edge: 6 are 216 a cell",
     .source = "seed 002 section 4.1"},
    {.name = "jitter",
     .type = FIELD_REAL,
     AT(jitter),
     .min = 0,
     .max = 1,
     .preset = 1,
     .unit = "",
     .doc = "0: points on a lattice; 1: each anywhere in its share of the cell",
     .source = "seed 002 section 4.1"},
    {.name = "tolerance",
     .type = FIELD_REAL,
     AT(tolerance),
     .min = 0,
     .max = 1,
     .preset = 1e-11,
     .unit = "",
     .doc = "mean squared residual of the law, in units of sqrt(g / cell height), at which a step is solved",
     .source = ""},
    {.name = "sweeps",
     .type = FIELD_INT,
     AT(sweeps),
     .min = 1,
     .max = 1000000,
     .preset = 200,
     .unit = "",
     .doc = "Gauss-Seidel sweeps a step at most; steps that need more are counted and reported",
     .source = ""},
    {.name = "recover_s",
     .type = FIELD_REAL,
     AT(recover_s),
     .min = 0,
     .max = 1e6,
     .preset = 0,
     .unit = "s",
     .doc = "over-full places expand again over this time; 0: never, as in the published code",
     .source = ""},
};
const struct field_table continuum_table = {"continuum", "", fields, sizeof fields / sizeof *fields, sizeof(struct continuum_spec)};

double continuum_bytes(double points, double cells)
{
    /* A point twice, with its name; a node with its row and coupling, a cell with its sums. */
    return points * 110 + cells * 2500;
}

enum scree_status continuum_check(const struct job_spec *job, const struct continuum_spec *c, double speed, double cell,
                                  struct scree_error *err)
{
    char step[TEXT_REAL_MAX];
    /* A point must not cross a cell in one step at the speed of the highest fall there is. */
    if (job->time.step_s * speed > cell) {
        scree_fail(err, SCREE_INVALID, "time.step_s",
                   "time.step_s: in %s s a point falling at %.3g m/s crosses more than a cell of %.3g m: at most %.3g s",
                   text_real(job->time.step_s, step), speed, cell, cell / speed);
        scree_hint(err, "a quarter of that is a good choice");
        return SCREE_INVALID;
    }
    if (c->law == LAW_MU_I && c->mu_2 < c->mu)
        return scree_fail(err, SCREE_INVALID, "params.continuum.mu_2",
                          "params.continuum.mu_2: %.3g is below mu, %.3g: mu(I) must not fall with I", c->mu_2, c->mu);
    if ((c->law == LAW_HYSTERETIC || c->law == LAW_HYSTERETIC_STEP) && c->mu + c->delta_mu > 1)
        return scree_fail(
            err, SCREE_INVALID, "params.continuum.delta_mu",
            "params.continuum.delta_mu: %.3g makes mu + delta_mu = %.3g at rest, above 1, where the law's cone holds tension",
            c->delta_mu, c->mu + c->delta_mu);
    if (job->scenario->cost(job).moving > SPEC_POINTS_MAX)
        return scree_fail(err, SCREE_INVALID, "params.continuum.points",
                          "params.continuum.points: %.3g material points are more than the %.3g that a world holds",
                          job->scenario->cost(job).moving, SPEC_POINTS_MAX);
    return check_intervals(job, err);
}
