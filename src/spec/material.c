/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Materials: the fields, the published values, and what follows from them. */
#include <math.h>
#include <string.h>

#include "spec/spec.h"

#define AT(member) .offset = offsetof(struct material_spec, member)

static const struct field fields[] = {
    {.name = "radius_m",
     .type = FIELD_REAL,
     AT(radius_m),
     .min = 1e-6,
     .max = 10,
     .preset = 1e-3,
     .unit = "m",
     .doc = "median radius of the grains",
     .source = "seed 000 Table S1"},
    {.name = "radius_spread",
     .type = FIELD_REAL,
     AT(radius_spread),
     .min = 0,
     .max = 0.5,
     .preset = 0.05,
     .unit = "",
     .doc = "radii are uniform on radius_m * [1 - spread, 1 + spread]",
     .source = "seed 000 Table S1; uniform is ours"},
    {.name = "density_kg_m3",
     .type = FIELD_REAL,
     AT(density_kg_m3),
     .min = 1,
     .max = 1e5,
     .preset = 2530,
     .unit = "kg/m3",
     .doc = "density of the grains' matter",
     .source = "seed 000 Table S1"},
    {.name = "young_Pa",
     .type = FIELD_REAL,
     AT(young_Pa),
     .min = 1e3,
     .max = 1e13,
     .preset = 74e9,
     .unit = "Pa",
     .doc = "Young's modulus E",
     .source = "seed 000 Table S1"},
    {.name = "poisson",
     .type = FIELD_REAL,
     AT(poisson),
     .min = 0,
     .max = 0.49,
     .preset = 0.22,
     .unit = "",
     .doc = "Poisson's ratio nu",
     .source = "seed 000 Table S1"},
    {.name = "beta_s",
     .type = FIELD_REAL,
     AT(beta_s),
     .min = 0,
     .max = 1,
     .preset = 45.1e-9,
     .unit = "s",
     .doc = "ratio of viscosity to stiffness: normal, tangential, torsion",
     .source = "seed 000 S4.1, eqs 5, 10, 17"},
    {.name = "mu_t",
     .type = FIELD_REAL,
     AT(mu_t),
     .min = 0,
     .max = 10,
     .preset = 0.237,
     .unit = "",
     .doc = "sliding friction; torsional friction is 3 pi mu_t / 16",
     .source = "seed 000 S4.3, eqs 11, 18",
     .steerable = true},
    {.name = "kappa",
     .type = FIELD_REAL,
     AT(kappa),
     .min = 0,
     .max = 100,
     .preset = 0.742,
     .unit = "",
     .doc = "rolling stiffness modulus",
     .source = "seed 000 S4.2, eq. 22"},
    {.name = "beta_r_s",
     .type = FIELD_REAL,
     AT(beta_r_s),
     .min = 0,
     .max = 10,
     .preset = 2e-3,
     .unit = "s",
     .doc = "ratio of viscosity to stiffness in rolling",
     .source = "seed 000 S4.2, eq. 24"},
    {.name = "mu_r",
     .type = FIELD_REAL,
     AT(mu_r),
     .min = 0,
     .max = 10,
     .preset = 0.0175,
     .unit = "",
     .doc = "rolling friction",
     .source = "seed 000 S4.2, eq. 25"},
    {.name = "torsion_factor",
     .type = FIELD_REAL,
     AT(torsion_factor),
     .min = 0,
     .max = 100,
     .preset = 16.0 / 3.0,
     .unit = "",
     .doc = "torsional stiffness is factor * G * a^3: 16/3 as printed, 8/3 for two like bodies in series",
     .source = "seed 000 eq. 14"},
    {.name = "wall",
     .type = FIELD_GROUP,
     AT(wall),
     .unit = "",
     .doc = "side walls, where the scenario has any",
     .source = "seed 000 S4.4",
     .table = &material_wall_table},
};
const struct field_table material_table = {.name = "material",
                                           .doc = "the grains' matter; \"preset\" names a published one, other keys override it",
                                           .fields = fields,
                                           .count = sizeof fields / sizeof *fields,
                                           .size = sizeof(struct material_spec)};

const struct material_preset material_presets[] = {
    {.name = "glass-beads-2mm",
     .doc = "soda lime glass beads of the slidequake flows",
     .source = "seed 000 Table S1 (moduli in GPa)",
     .note =
         "beta_s = 45.1 ns is the published value and reproduces the paper's runs. It gives a restitution of 0.981 for Foerster's "
         "spheres at 1.2 m/s; the 0.97 that the paper states needs 71.2 ns (its length scale lost a factor pi).",
     .values = {.preset = "glass-beads-2mm",
                .radius_m = 1e-3,
                .radius_spread = 0.05,
                .density_kg_m3 = 2530,
                .young_Pa = 74e9,
                .poisson = 0.22,
                .beta_s = 45.1e-9,
                .mu_t = 0.237,
                .kappa = 0.742,
                .beta_r_s = 2e-3,
                .mu_r = 0.0175,
                .torsion_factor = 16.0 / 3.0,
                .wall = MATERIAL_PMMA}},
    {.name = "foerster-3mm",
     .doc = "glass spheres of the collision experiments of Foerster, Louge, Chang and Allia (1994)",
     .source = "seed 000 S4.1 (E in GPa); friction and rolling as in Table S1",
     .note = "With beta_s = 45.1 ns the restitution at 1.2 m/s is 0.981; the measured 0.97 needs 71.2 ns.",
     .values = {.preset = "foerster-3mm",
                .radius_m = 1.5e-3,
                .radius_spread = 0,
                .density_kg_m3 = 2500,
                .young_Pa = 71e9,
                .poisson = 0.22,
                .beta_s = 45.1e-9,
                .mu_t = 0.237,
                .kappa = 0.742,
                .beta_r_s = 2e-3,
                .mu_r = 0.0175,
                .torsion_factor = 16.0 / 3.0,
                .wall = MATERIAL_PMMA}},
    {.name = "pmma-wall",
     .doc = "acrylic side walls of the channel that slidequakes flow in: a material's \"wall\"",
     .source = "seed 000 Table S1 (moduli in GPa)",
     .note = "beta_s = 200 ns is the published value. With it a bead dropped from 0.1 m rises to 0.091 m again; the 0.08 m that "
             "the paper states needs 492 ns.",
     .kind = &material_walls,
     .others = &material_pmma},
    {.name = "igneous-fragments",
     .doc = "angular fragments of an igneous rock upon clay and aluminium, as in flows down a curved chute",
     .source = "seed 003 Tables 1 and 2",
     .note = "At full stiffness steps are some 1e-7 s. softening = 1000 makes them 32 times longer; say what overlap was reached.",
     .kind = &material_fragments,
     .others = &fragment_igneous},
    {.name = "plastic-crosses",
     .doc = "crosses of 27 mm as in dam breaks of entangled bodies",
     .source = "seed 001 Table I",
     .note = "k_n is that of a body on a wall (m_ij = m); k_t and gamma_t are calibrated and far from eqs 18 and 19. Normal forces "
             "are not "
             "clamped and those of two bodies are averaged over their points of contact, as in the published code.",
     .kind = &material_rigid,
     .others = &rigid_crosses},
    {.name = "hopper-beads",
     .doc = "beads of 1 mm radius that a hopper lets go",
     .source = "seed 001 Table II",
     .note =
         "Friction between bodies is varied from 0.05 to 0.65; the radius is params.body.radius_m. The step is 5e-7 s; softened by "
         "100 (k_n and k_t / 100, gamma_t / 10) it is 5e-6 s.",
     .kind = &material_rigid,
     .others = &rigid_beads},
};
const struct material_kind material_beads = {"hertz-mindlin-rolling", &material_table};
const struct material_kind material_walls = {"hertz-mindlin-rolling", &material_wall_table};
const struct material_kind material_fragments = {"hertz-mindlin-tsuji", &fragment_table};
const struct material_kind material_rigid = {"spring-dashpot-memory", &rigid_table};

const struct material_kind *material_preset_kind(const struct material_preset *preset)
{
    return preset->kind ? preset->kind : &material_beads;
}

const void *material_preset_values(const struct material_preset *preset)
{
    return preset->kind ? preset->others : &preset->values;
}

const struct material_kind *scenario_material(const struct scenario_fields *scenario)
{
    return material_preset_kind(material_preset_find(scenario->material));
}

const size_t material_preset_count = sizeof material_presets / sizeof *material_presets;

const struct material_preset *material_preset_find(const char *name)
{
    for (size_t k = 0; k < material_preset_count; k++)
        if (strcmp(material_presets[k].name, name) == 0)
            return &material_presets[k];
    return NULL;
}

double material_shear_modulus(const struct material_spec *m)
{
    return m->young_Pa / (2 * (1 + m->poisson));
}

double material_torsion_friction(const struct material_spec *m)
{
    return 3 * M_PI * m->mu_t / 16;
}

double material_grain_mass(const struct material_spec *m)
{
    return m->density_kg_m3 * (4.0 / 3.0) * M_PI * pow(m->radius_m, 3);
}

double material_contact_time(const struct material_spec *m, double speed)
{
    const double duration = 3.218065; // T0 of eq. 43
    double soft = M_PI * m->density_kg_m3 * (1 - m->poisson * m->poisson) / m->young_Pa;
    return duration * 2 * m->radius_m * pow(soft * soft / (16 * speed), 0.2); // eq. 42, 16 in place of 4: both spheres free
}

/* Velocity Verlet is stable while w dt < 2, with w the fastest motion of a contact.
 *
 * Stiffness. In an impact of two like grains (mass m) at speed v the overlap
 * reaches x: (2/5) F x = m v^2 / 4, so Hertz's tangent there is
 * k = (3/2) F / x = (15/16) m (v / x)^2, and x / v = 1.0934 t_c / T0.
 * Sliding is faster than the normal motion (w^2 = 2 k / m), for its spring
 * k_t = k 2 (1 - nu) / (2 - nu) turns the grains as well as it shifts them:
 * w^2 = k_t (2 / m) (1 + m r^2 / I) = 7 k_t / m.
 *
 * Damping. A viscous force beta k v' taken at the half step is a lagged one and
 * shortens the limit to dt = (2 / w) (sqrt(1 + s^2) - s) with s = beta w / 2; for
 * strong damping that is 2 / (beta w^2).
 *
 * Neighbours. Six equal contacts raise w^2 at most sixfold (no eigenvalue is above
 * twice a grain's own stiffness), but many contacts at once carry everyday
 * impacts of 0.1 m/s where the assumed v is 1 m/s, and w goes with v^(1/5):
 * sqrt(6) 0.1^(1/5) = 1.5, which is the margin kept.
 *
 * Torsion is softer by (a / r)^2. Rolling is capped by mu_r, so that no step can
 * make it grow. */
double material_stable_step(const struct material_spec *m, double speed)
{
    const double duration = 3.218065, depth = 1.0934, margin = 1.5; // T0; largest overlap over v tau
    double overlap_s = depth / duration * material_contact_time(m, speed);
    double sliding = 2 * (1 - m->poisson) / (2 - m->poisson);
    double w = sqrt(7 * sliding * 15 / 16) / overlap_s, s = 0.5 * m->beta_s * w;
    return 2 / w / (sqrt(1 + s * s) + s) / margin; // 1 / (sqrt + s) is sqrt - s without cancellation
}
