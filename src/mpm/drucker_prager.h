/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The Drucker-Prager rheology as a complementarity of cones (seed 002, eqs 2.7, A1-A9).
 *
 * A symmetric tensor is six numbers {xx, yy, zz, yz, zx, xy}. In a plane world
 * (d = 2) the plane is x, z: yy, yz and xy are zero and are not looked at. The
 * norm is the paper's, ||t|| = sqrt(t:t / 2), so the strain rate of a simple
 * shear at rate s has the norm s / 2.
 *
 * These are the plain functions, for checks and for what is done once a step;
 * the sweep's own, four numbers at a time, are in local.h. */
#ifndef SCREE_MPM_DRUCKER_PRAGER_H
#define SCREE_MPM_DRUCKER_PRAGER_H

#include <stdbool.h>

enum { TENSOR = 6 };

double tensor_trace(const double t[TENSOR]);
/* dev = t - Tr(t)/d I. */
void tensor_deviator(const double t[TENSOR], bool plane, double dev[TENSOR]);
double tensor_norm(const double t[TENSOR]);

/* How far (gamma, lambda) are from DP(mu): the modified Fischer-Burmeister
 * function, zero exactly on eq. 2.7. Both arguments in the same unit. */
void drucker_prager_root(const double gamma[TENSOR], const double lambda[TENSOR], double mu, bool plane, double f[TENSOR]);

/* The nearest point of K_c = { ||Dev t|| <= c Tr(t) / sqrt(2d) } (eq. A1) in the norm above. */
void cone_project(const double t[TENSOR], double aperture, bool plane, double nearest[TENSOR]);

/* Eigenvectors (columns of q, q[row][column]) and eigenvalues of a symmetric
 * 3 x 3 matrix {xx, yy, zz, yz, zx, xy}, by Jacobi's rotations. */
void tensor_eigen(const double t[TENSOR], double q[3][3], double value[3]);

/* r = q^T t q, and back: t = q r q^T. */
void tensor_rotate(const double t[TENSOR], const double q[3][3], double r[TENSOR]);
void tensor_rotate_back(const double r[TENSOR], const double q[3][3], double t[TENSOR]);

enum phase { PHASE_GAS, PHASE_STATIC, PHASE_FLOWING };

/* Solves the row of one node: given b and a diagonal block W that belongs to
 * K = sum c c^T (W lambda = (lambda K + K lambda) / 2, see local.h), finds lambda
 * with (W lambda + b, lambda) in DP(mu). K must be positive definite. */
enum phase drucker_prager_solve(const double k[TENSOR], const double b[TENSOR], double mu, bool plane, double lambda[TENSOR]);

#endif
