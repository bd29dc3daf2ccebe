/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Models of the high-frequency power P_F^0 that a flow exerts on its base.
 *
 * The supporting information of seed 000 names the models it compares but prints
 * none of their formulas. What is here is this project's own formulation of each
 * idea (protocols 1.12) from impacts at rate n_I(z) with impulse J(z):
 *     P_F^0 = A int n_I(z) J(z)^2 <cos^2> T(z) dz
 * with T what the way to the base leaves. None has a fitted constant but those
 * named below. Do not cite numbers from here as the papers'. How well they do over
 * several flows (epsilon) is drawn by `scree plot` of a sweep.
 *
 * The two layer models let a grain hit a bump a diameter. What the public abstract of
 * the model they are after says is power as the *average* speed cubed, and of its two
 * limits that grains are about as large as the flow is deep (thin) or far smaller
 * (thick). In a thin flow every grain is a basal one, so the speed is the flow's mean;
 * in a thick one it is the basal layer's own, and there the idea is off by its rate:
 * on the base of a flow 8 d deep at 22 degrees grains move at 6 mm/s, so that a bump
 * would be hit 3 times a second, and form some 20,000 contacts a second at 7 mm/s. */
#ifndef SCREE_MEASURE_MODELS_H
#define SCREE_MEASURE_MODELS_H

#include "measure/profiles.h"

/* Share of an impact's power along the base's normal; share that a contact passes on; contacts a diameter of height
 * (eqs 52, 53: d/2 and 1/3, hence eta = 1/9 a diameter). */
#define MODELS_NORMAL_SHARE  (1.0 / 3.0)
#define MODELS_CONTACT_SHARE (1.0 / 3.0)
#define MODELS_CONTACTS      2.0
#define MODELS_ATTENUATION   1.0 // gamma of the attenuated model, a diameter of height: to be fitted

struct model_power {
    double minimal;    // T = P_C eta^(z/d), J = m <dn^2>^(1/2), doubled on the base; no constant
    double thin;       // A phi (pi/6) rho^2 d^3 u^3 (1 + 3 v^2): all grains hit bumps at the flow's mean speed; no constant
    double thick;      // the same at the speed and agitation of the basal layer alone; no constant
    double attenuated; // T = exp(-gamma z/d), J = 2 m T^(1/2); gamma
    double pressure;   // A p^2: P_F^0 is proportional to it, with a free constant, N2/m2
};

/* The minimal model's integrand at one height, N2/(Hz m). */
double models_minimal_integrand(const struct coarse_grid *grid, const struct profile *p, double base_z, double density);

/* Predictions for the flow over grid->area, N2/Hz. */
void models_power(const struct coarse_grid *grid, const struct profile *profile, const struct profile_bulk *bulk, double base_z,
                  double density, struct model_power *out);

#endif
