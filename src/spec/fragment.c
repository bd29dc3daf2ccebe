/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The matter of angular fragments and of what they touch: seed 003, Tables 1 and 2. */
#include <math.h>

#include "spec/spec.h"

#define MATTER(member) .offset = offsetof(struct fragment_matter, member)
#define PAIR(member)   .offset = offsetof(struct fragment_pair, member)
#define AT(member)     .offset = offsetof(struct fragment_spec, member)
#define COUNT(array)   (sizeof(array) / sizeof *(array))

static const struct field matter_fields[] = {
    {.name = "shear_modulus_Pa",
     .type = FIELD_REAL,
     MATTER(shear_Pa),
     .min = 1e3,
     .max = 1e13,
     .preset = 2.38e10,
     .unit = "Pa",
     .doc = "shear modulus G",
     .source = "seed 003 Table 1"},
    {.name = "poisson",
     .type = FIELD_REAL,
     MATTER(poisson),
     .min = 0,
     .max = 0.49,
     .preset = 0.19,
     .unit = "",
     .doc = "Poisson's ratio nu",
     .source = "seed 003 Table 1"},
};
static const struct field_table matter_table = {"matter", "", matter_fields, COUNT(matter_fields), sizeof(struct fragment_matter)};

static const struct field pair_fields[] = {
    {.name = "restitution",
     .type = FIELD_REAL,
     PAIR(restitution),
     .min = 0.01,
     .max = 1,
     .preset = 0.49,
     .unit = "",
     .doc = "coefficient of restitution e, the same at any speed",
     .source = "seed 003 Table 2, eqs 8-10"},
    {.name = "friction",
     .type = FIELD_REAL,
     PAIR(friction),
     .min = 0,
     .max = 10,
     .preset = 0.45,
     .unit = "",
     .doc = "coefficient of static friction mu_s",
     .source = "seed 003 Table 2"},
    {.name = "rolling_friction",
     .type = FIELD_REAL,
     PAIR(rolling),
     .min = 0,
     .max = 10,
     .preset = 0.035,
     .unit = "",
     .doc = "coefficient of rolling friction mu_r",
     .source = "seed 003 Table 2, eq. 13"},
};
static const struct field_table pair_table = {"pair", "", pair_fields, COUNT(pair_fields), sizeof(struct fragment_pair)};

static const struct field fields[] = {
    {.name = "density_kg_m3",
     .type = FIELD_REAL,
     AT(density_kg_m3),
     .min = 1,
     .max = 1e5,
     .preset = 2700,
     .unit = "kg/m3",
     .doc = "density of the clasts",
     .source = "seed 003 Table 1"},
    {.name = "clast",
     .type = FIELD_GROUP,
     AT(clast),
     .unit = "",
     .doc = "matter of the clasts",
     .source = "",
     .table = &matter_table},
    {.name = "chute",
     .type = FIELD_GROUP,
     AT(chute),
     .unit = "",
     .doc = "matter of the chute",
     .source = "",
     .table = &matter_table},
    {.name = "gate", .type = FIELD_GROUP, AT(gate), .unit = "", .doc = "matter of the gate", .source = "", .table = &matter_table},
    {.name = "clast_clast",
     .type = FIELD_GROUP,
     AT(clast_clast),
     .unit = "",
     .doc = "between clasts",
     .source = "",
     .table = &pair_table},
    {.name = "clast_chute",
     .type = FIELD_GROUP,
     AT(clast_chute),
     .unit = "",
     .doc = "between clasts and chute",
     .source = "",
     .table = &pair_table},
    {.name = "clast_gate",
     .type = FIELD_GROUP,
     AT(clast_gate),
     .unit = "",
     .doc = "between clasts and gate, or an accelerator of the gate's matter",
     .source = "",
     .table = &pair_table},
    {.name = "softening",
     .type = FIELD_REAL,
     AT(softening),
     .min = 1,
     .max = 1e6,
     .preset = 1,
     .unit = "",
     .doc = "moduli are divided by it: steps grow as its square root, overlaps as its power 2/5 to 2/3",
     .source = "ours; protocols 4"},
    {.name = "clamp",
     .type = FIELD_BOOL,
     AT(clamp),
     .preset = 0,
     .unit = "",
     .doc = "normal forces never pull at the end of a contact; restitution is then larger than asked for",
     .source = "targets S3-10, B-03"},
};
const struct field_table fragment_table = {
    .name = "material",
    .doc = "the clasts' matter and that of what they touch; \"preset\" names a published one, other keys override it",
    .fields = fields,
    .count = COUNT(fields),
    .size = sizeof(struct fragment_spec)};

const struct fragment_spec fragment_igneous = {.preset = "igneous-fragments",
                                               .density_kg_m3 = 2700,
                                               .clast = {.shear_Pa = 2.38e10, .poisson = 0.19},
                                               .chute = {.shear_Pa = 6.85e9, .poisson = 0.35},
                                               .gate = {.shear_Pa = 25e9, .poisson = 0.36},
                                               .clast_clast = {.restitution = 0.49, .friction = 0.45, .rolling = 0.035},
                                               .clast_chute = {.restitution = 0.3, .friction = 0.9, .rolling = 0.07},
                                               .clast_gate = {.restitution = 0.53, .friction = 0.1, .rolling = 0.07},
                                               .softening = 1};

const struct fragment_matter *fragment_matter_of(const struct fragment_spec *m, int partner)
{
    return partner == FRAGMENT_GATE ? &m->gate : partner == FRAGMENT_CHUTE ? &m->chute : &m->clast;
}

const struct fragment_pair *fragment_pair_of(const struct fragment_spec *m, int partner)
{
    return partner == FRAGMENT_GATE ? &m->clast_gate : partner == FRAGMENT_CHUTE ? &m->clast_chute : &m->clast_clast;
}

double fragment_young_modulus(const struct fragment_matter *m)
{
    return 2 * m->shear_Pa * (1 + m->poisson);
}

double fragment_rayleigh_time(const struct fragment_spec *m, double radius_m)
{
    return M_PI * radius_m * sqrt(m->density_kg_m3 * m->softening / m->clast.shear_Pa) / (0.1631 * m->clast.poisson + 0.8766);
}
