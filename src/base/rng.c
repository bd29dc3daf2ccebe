/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Two rounds of the 64-bit finaliser of Stafford (variant 13, as used by
 * SplitMix64: Steele, Lea, Flood 2014) over seed, stream and counter. Ample for
 * set-ups; not for cryptography. */
#include "base/rng.h"

static uint64_t mix(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

struct rng rng_start(uint64_t seed, uint64_t stream)
{
    return (struct rng){.seed = mix(seed + 0x9e3779b97f4a7c15u), .stream = mix(stream ^ 0xd1b54a32d192ed03u)};
}

uint64_t rng_next(struct rng *rng)
{
    uint64_t k = ++rng->counter;
    return mix(mix(rng->seed + k * 0x9e3779b97f4a7c15u) ^ rng->stream);
}

double rng_uniform(struct rng *rng, double low, double high)
{
    double unit = (double)(rng_next(rng) >> 11) * 0x1p-53;
    return low + (high - low) * unit;
}
