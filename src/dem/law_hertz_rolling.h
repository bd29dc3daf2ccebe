/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the plain law and its kernels share. */
#ifndef SCREE_DEM_LAW_HERTZ_ROLLING_H
#define SCREE_DEM_LAW_HERTZ_ROLLING_H

#include "base/vec3.h"
#include "dem/law.h"

void hertz_rolling_pairs_v2(const struct law_coefs *coefs, const struct pair_batch *batch);
void hertz_rolling_pairs_v3(const struct law_coefs *coefs, const struct pair_batch *batch);
void hertz_rolling_pairs_v4(const struct law_coefs *coefs, const struct pair_batch *batch);

/* Energy of a spring: (force or torque)^2 / 2 k; an unloaded contact stores nothing. */
static inline double spring_energy(double force_squared, double stiffness)
{
    return stiffness > 0 ? force_squared / (2.0 * stiffness) : 0.0;
}

/* Energies of the tangential, torsional and rolling springs (normal is left 0),
 * with stiffnesses by eqs 7, 14, 22 from the contact radius and normal force of
 * the step that left them. */
static inline struct contact_loss hertz_rolling_springs(const struct law_coefs *c, struct vec3 ft, double mn, struct vec3 mr,
                                                        double a, double fn, double r)
{
    return (struct contact_loss){
        .tangential = spring_energy(vec3_dot(ft, ft), c->tangential * a),
        .torsion = spring_energy(mn * mn, c->torsion * (a * a * a)),
        .rolling = spring_energy(vec3_dot(mr, mr), c->rolling * fn * r),
    };
}

#endif
