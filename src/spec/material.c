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
                .torsion_factor = 16.0 / 3.0}},
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
                .torsion_factor = 16.0 / 3.0}},
};
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

/* Velocity Verlet is stable for w dt < 2 with w^2 = K / M of the stiffest mode. At
 * the largest overlap of an impact at speed v, x_max = 1.0934 v tau, the tangent
 * of Hertz's law is k = (3/2) F / x = (3/2) m/2 (v / x_max)^2 (5/4) (energy:
 * (2/5) F x = m v^2 / 4). A grain among others has about six contacts, of which
 * two line up with any direction, and slides against springs k_t / k =
 * 2 (1 - nu) / (2 - nu) < 1 that act on its spin with 1 + m r^2 / I = 3.5:
 * w^2 < 2 * 3.5 k / m. Explicit damping takes its share while beta w < 1; a factor
 * two is kept in hand. With k / m = (15/16) (v / x_max)^2 and t_c = T0 tau:
 * dt < 2 / (2 w) = x_max / v / sqrt(6.6) = (1.0934 / 3.218 / 2.56) t_c = 0.13 t_c,
 * that is, no fewer than seven or eight steps a contact. */
double material_stable_step(const struct material_spec *m, double speed)
{
    double bound = 0.13 * material_contact_time(m, speed);
    /* Damping alone: force beta k x' is stable while beta w^2 dt < 2; w here as above. */
    double w = 1 / bound, damped = 1 / (m->beta_s * w * w + 1e-300);
    return bound < damped ? bound : damped;
}
