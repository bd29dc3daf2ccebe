/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See models.h. */
#include "measure/models.h"

#include <math.h>

static double grain_mass(const struct coarse_grid *grid, double density)
{
    double d = grid->diameter;
    return M_PI / 6 * density * d * d * d;
}

double models_minimal_integrand(const struct coarse_grid *grid, const struct profile *p, double base_z, double density)
{
    double height = (p->z - base_z) / grid->diameter;
    /* A head-on impact of two free grains passes on m v, one on a fixed grain twice that; impacts below the base's top are on it.
     */
    double impulse = grain_mass(grid, density) * sqrt(p->normal2) * (height < 0 ? 2 : 1);
    double passed = height > 0 ? p->joined * pow(MODELS_CONTACT_SHARE, MODELS_CONTACTS * height) : 1;
    return grid->area * p->impacts * impulse * impulse * MODELS_NORMAL_SHARE * passed;
}

/* A layer of grains that pass over bumps a diameter apart at that speed, whose relative spread is v: <u^3> = u^3 (1 + 3 v^2). */
static double layer_power(const struct coarse_grid *grid, double density, double fraction, double speed, double temperature)
{
    double d = grid->diameter, cubed = speed * speed * speed + 3 * speed * temperature;
    return grid->area * fraction * M_PI / 6 * density * density * d * d * d * cubed;
}

void models_power(const struct coarse_grid *grid, const struct profile *profile, const struct profile_bulk *bulk, double base_z,
                  double density, struct model_power *out)
{
    double d = grid->diameter, low = base_z + 0.5 * d;
    *out = (struct model_power){.pressure = grid->area * bulk->pressure * bulk->pressure};
    for (size_t k = 0; k < grid->count; k++) {
        const struct profile *p = &profile[k];
        double height = fmax(0, (p->z - base_z) / d), impulse = 2 * grain_mass(grid, density) * sqrt(p->temperature);
        out->minimal += models_minimal_integrand(grid, p, base_z, density) * grid->step;
        out->attenuated +=
            grid->area * p->impacts * impulse * impulse * MODELS_NORMAL_SHARE * exp(-MODELS_ATTENUATION * height) * grid->step;
    }
    double fraction = profiles_at(grid, profile, offsetof(struct profile, fraction), low);
    double temperature = profiles_at(grid, profile, offsetof(struct profile, temperature), low);
    double speed = fabs(profiles_at(grid, profile, offsetof(struct profile, velocity), low));
    out->thin = layer_power(grid, density, bulk->fraction, fabs(bulk->velocity), bulk->temperature);
    out->thick = layer_power(grid, density, fraction, speed, temperature);
}
