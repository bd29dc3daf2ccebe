/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A head-on impact of seed 000's normal force (eq. 5) as its equation has it, without time steps of a world.
 *
 * In units of the impact speed v and of the length L with L^(5/2) = v^2 m / k, where m is the reduced mass and
 * k = 2 E sqrt(r) / 3 (1 - nu^2) the stiffness at reduced radius r, the overlap x obeys
 *     x'' = -sqrt(x) (x + b x'),   x(0) = 0, x'(0) = 1,   b = beta v / L,
 * which is what S4.1 solves to find beta, and S4.5 to judge a time step. */
#ifndef SCREE_CALIBRATE_IMPACT_H
#define SCREE_CALIBRATE_IMPACT_H

struct impact {
    double damping;             // b
    double time, overlap, rate; // since the beginning, in those units; rate starts as 1
    double end;                 // when the surfaces part, 0: not yet
};

/* L, m, for a stiffness modulus E / (1 - nu^2), Pa. */
double impact_length(double reduced_mass, double reduced_radius, double modulus, double speed);

void impact_start(struct impact *impact, double damping);

/* Goes on by `by`; stops where the overlap returns to 0, from when on it is 0 and the rate that of parting. */
void impact_advance(struct impact *impact, double by);

/* The force there, in units of m v^2 / L. */
double impact_force(const struct impact *impact);

/* Restitution, and the time that the contact takes. */
double impact_restitution(double damping, double *duration);

/* The damping that gives a restitution in (0, 1]. */
double impact_damping(double restitution);

#endif
