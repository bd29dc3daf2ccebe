/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How far chains of contacts reach up from the base. */
#ifndef SCREE_MEASURE_CONNECTIVITY_H
#define SCREE_MEASURE_CONNECTIVITY_H

#include <stddef.h>

/* lambda of P_C ~ exp(-z / (lambda d)), seed 000 S1: least squares of ln P_C over heights 0 < z <= top at which
 * P_C > 0.02, weighted by how much is there (protocols 1.8). z is over the base. 0 where under two heights count or
 * P_C does not fall. */
double connectivity_lambda(const double *z, const double *joined, const double *all, size_t n, double top, double diameter);

#endif
