/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Counter-based random numbers: the k-th number of a stream is a pure function
 * of (seed, stream, k), so that set-ups do not depend on the order in which
 * anything is drawn, nor on threads. */
#ifndef SCREE_BASE_RNG_H
#define SCREE_BASE_RNG_H

#include <stdint.h>

struct rng {
    uint64_t seed, stream, counter;
};

/* Numbers of different streams of one seed are independent. */
struct rng rng_start(uint64_t seed, uint64_t stream);

/* The next 64 random bits. */
uint64_t rng_next(struct rng *rng);

/* Uniform on [low, high). */
double rng_uniform(struct rng *rng, double low, double high);

#endif
