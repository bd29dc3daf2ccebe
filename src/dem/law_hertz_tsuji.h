/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the plain law and its kernels share. */
#ifndef SCREE_DEM_LAW_HERTZ_TSUJI_H
#define SCREE_DEM_LAW_HERTZ_TSUJI_H

#include "dem/law.h"

/* Rolling torque never takes more than this share of a grain's rotation in one
 * step and contact, so that torques of constant size cannot rock a grain to and
 * fro: eight contacts together stop it. */
#define TSUJI_STOP 8.0
/* Stands for nothing in a divisor, rad/s. */
#define TSUJI_NOTHING 1e-100

void hertz_tsuji_pairs_v2(const struct law_coefs *coefs, const struct pair_batch *batch);
void hertz_tsuji_pairs_v3(const struct law_coefs *coefs, const struct pair_batch *batch);
void hertz_tsuji_pairs_v4(const struct law_coefs *coefs, const struct pair_batch *batch);

#endif
