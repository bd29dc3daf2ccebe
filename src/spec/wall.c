/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A side wall that beads flow along: seed 000, S4.4. */
#include "spec/spec.h"

#define AT(member) .offset = offsetof(struct material_wall, member)

static const char *const presets[] = {"pmma-wall", NULL};

static const struct field fields[] = {
    {.name = "preset",
     .type = FIELD_ENUM,
     AT(preset),
     .unit = "",
     .doc = "the published wall that the other values are those of, unless they are given",
     .source = "seed 000 S4.4",
     .choices = presets},
    {.name = "young_Pa",
     .type = FIELD_REAL,
     AT(young_Pa),
     .min = 1e3,
     .max = 1e13,
     .preset = 3.3e9,
     .unit = "Pa",
     .doc = "Young's modulus E_w; a contact goes by the harmonic mean with the beads'",
     .source = "seed 000 Table S1, in GPa"},
    {.name = "poisson",
     .type = FIELD_REAL,
     AT(poisson),
     .min = 0,
     .max = 0.49,
     .preset = 0.4,
     .unit = "",
     .doc = "Poisson's ratio nu_w",
     .source = "seed 000 Table S1"},
    {.name = "beta_s",
     .type = FIELD_REAL,
     AT(beta_s),
     .min = 0,
     .max = 1,
     .preset = 200e-9,
     .unit = "s",
     .doc = "ratio of viscosity to stiffness between bead and wall, beta_w",
     .source = "seed 000 Table S1"},
    {.name = "mu",
     .type = FIELD_REAL,
     AT(mu),
     .min = 0,
     .max = 10,
     .preset = 0.10510423526567647,
     .unit = "",
     .doc = "sliding friction between bead and wall: tan 6 deg; torsional friction is 3 pi mu / 16",
     .source = "seed 000 S4.4",
     .steerable = true},
};
const struct field_table material_wall_table = {
    .name = "wall",
    .doc = "the matter of side walls",
    .fields = fields,
    .count = sizeof fields / sizeof *fields,
    .size = sizeof(struct material_wall),
};

const struct material_wall material_pmma = MATERIAL_PMMA;

double material_wall_mean(double bead, double wall)
{
    return 2 / (1 / bead + 1 / wall);
}

double material_plane_modulus(const struct material_spec *m, int partner)
{
    const struct material_wall *w = &m->wall;
    double bead = m->young_Pa / (1 - m->poisson * m->poisson);
    if (partner == BEAD_MIRROR)
        return 2 * bead;
    return partner == BEAD_WALL ? material_wall_mean(bead, w->young_Pa / (1 - w->poisson * w->poisson)) : bead;
}

/* Against a wall the radius is the bead's, not half of it, and the wall does not
 * recede: by eq. 5 two beads of half the modulus exert on each other what wall and
 * bead do, and each of them goes half the way, as before a mirror. */
struct material_spec material_as_wall(const struct material_spec *m)
{
    struct material_spec as = *m;
    as.young_Pa = 0.5 * (1 - m->poisson * m->poisson) * material_plane_modulus(m, BEAD_WALL);
    as.beta_s = m->wall.beta_s;
    as.mu_t = m->wall.mu;
    return as;
}
