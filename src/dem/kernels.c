/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Row loops of the step; see kernels.h. Compiled once per instruction set, with
 * ISA naming the table. A row is one vector: x, y, z and a constant that the
 * arithmetic leaves alone. */
#include "dem/kernels.h"

#include "dem/lanes.h"

static void drift(double (*position)[4], double (*velocity)[4], size_t from, size_t to, const double kick[3], double dt)
{
    const v4 g = v4_set(kick[0], kick[1], kick[2], 0), t = v4_set(dt, dt, dt, 0);
    for (size_t i = from; i < to; i++) {
        v4 v = v4_load(velocity[i]) + g;
        v4_store(velocity[i], v);
        v4_store(position[i], v4_load(position[i]) + t * v);
    }
}

/* From grain 1 to the image of grain 2. */
SIMD_INLINE v4 separation(const struct pair_batch *b, size_t p)
{
    uint32_t second = b->second[p];
    return (v4_load(b->position[second & IMAGE_ROW]) - v4_load(b->position[b->first[p]])) +
           v4_load(b->shift[second >> IMAGE_SHIFT]);
}

SIMD_INLINE unsigned touching_of_four(const struct pair_batch *b, const double *reach2, size_t p)
{
    v4 x, y, z, unused;
    v4_transpose(separation(b, p), separation(b, p + 1), separation(b, p + 2), separation(b, p + 3), &x, &y, &z, &unused);
    return m4_bits((m4)(x * x + y * y + z * z <= v4_load(&reach2[p])));
}

static size_t touch(const struct pair_batch *b, const double *reach2, size_t count, uint64_t *touching, uint32_t *active,
                    uint32_t *ended, size_t *ended_count)
{
    size_t found = 0, finished = 0;
    for (size_t base = 0; base < count; base += 64) {
        uint64_t bits = 0, was = touching[base / 64];
        size_t end = count - base < 64 ? count - base : 64;
        for (size_t k = 0; k < end; k += 4)
            bits |= (uint64_t)touching_of_four(b, reach2, base + k) << k;
        for (uint64_t fresh = bits & ~was; fresh; fresh &= fresh - 1) {
            double *contact = b->contact[b->near[base + (size_t)__builtin_ctzll(fresh)]];
            for (int s = 0; s < CONTACT_HISTORY; s++)
                contact[s] = 0;
        }
        if (ended)
            for (uint64_t gone = was & ~bits; gone; gone &= gone - 1)
                ended[finished++] = b->near[base + (size_t)__builtin_ctzll(gone)];
        for (uint64_t left = bits; left; left &= left - 1)
            active[found++] = b->near[base + (size_t)__builtin_ctzll(left)];
        touching[base / 64] = bits;
    }
    if (ended)
        *ended_count = finished;
    return found;
}

/* A row of velocity and one of spin, in registers. */
struct motion {
    v4 velocity, spin;
};

SIMD_INLINE struct motion motion_load(double (*velocity)[4], double (*spin)[4], uint32_t i)
{
    return (struct motion){v4_load(velocity[i]), v4_load(spin[i])};
}

SIMD_INLINE void motion_store(double (*velocity)[4], double (*spin)[4], uint32_t i, struct motion m)
{
    v4_store(velocity[i], m.velocity);
    v4_store(spin[i], m.spin);
}

SIMD_INLINE v4 strayed_more(v4 stray, v4 velocity, const double velocity0[4])
{
    v4 change = velocity - v4_load(velocity0);
    return v4_max(stray, change * change);
}

/* Contacts of one first grain follow each other, so its rows stay in registers
 * meanwhile; it cannot be a second grain then, since second rows are higher. */
static void kick(const struct pair_batch *b, double (*velocity)[4], double (*spin)[4], double (*velocity0)[4], size_t from,
                 size_t to, double strayed2[4])
{
    if (b->active_count == 0)
        return;
    v4 stray = v4_load(strayed2);
    uint32_t i = b->first[b->active[0]];
    struct motion one = motion_load(velocity, spin, i);
    for (size_t k = 0; k < b->active_count; k++) {
        uint32_t p = b->active[k], j = b->second[p] & IMAGE_ROW;
        const struct contact_out *out = &b->out[k];
        v4 force = v4_load(out->force);
        if (b->first[p] != i) {
            motion_store(velocity, spin, i, one);
            stray = strayed_more(stray, one.velocity, velocity0[i]);
            i = b->first[p];
            one = motion_load(velocity, spin, i);
        }
        one.velocity = one.velocity - force * v4_all(one.velocity[3]);
        one.spin = one.spin + v4_load(out->torque1) * v4_all(one.spin[3]);
        if (j >= from && j < to) {
            struct motion two = motion_load(velocity, spin, j);
            two.velocity = two.velocity + force * v4_all(two.velocity[3]);
            two.spin = two.spin + v4_load(out->torque2) * v4_all(two.spin[3]);
            motion_store(velocity, spin, j, two);
            stray = strayed_more(stray, two.velocity, velocity0[j]);
        }
    }
    motion_store(velocity, spin, i, one);
    v4_store(strayed2, strayed_more(stray, one.velocity, velocity0[i]));
}

/* On the line between two grains now, distance changes at the rate n.(v2 - v1)
 * at first and can only be larger later than that rate would make it (the path
 * is straight and distance is convex), so distance >= d + min(0, n.dv) t. Both
 * may leave their paths by `stray`. Multiplied by d to spare the division. */
static size_t approach(const struct pair_batch *b, size_t count, double horizon, double stray, uint32_t *kept)
{
    const v4 zero = {0};
    size_t found = 0;
    for (size_t p = 0; p < count; p += 4) {
        v4 x, y, z, u, v, w, reach, unused;
        v4 rows[4], speeds[4];
        double radii[4];
        for (size_t l = 0; l < 4; l++) {
            size_t q = p + l < count ? p + l : count - 1;
            uint32_t i = b->first[q], j = b->second[q] & IMAGE_ROW;
            rows[l] = separation(b, q);
            speeds[l] = v4_load(b->velocity[j]) - v4_load(b->velocity[i]);
            radii[l] = b->position[i][3] + b->position[j][3];
        }
        v4_transpose(rows[0], rows[1], rows[2], rows[3], &x, &y, &z, &unused);
        v4_transpose(speeds[0], speeds[1], speeds[2], speeds[3], &u, &v, &w, &unused);
        reach = v4_set(radii[0], radii[1], radii[2], radii[3]) + v4_all(2.0 * stray);
        v4 distance2 = x * x + y * y + z * z, closing = x * u + y * v + z * w;
        unsigned bits = m4_bits((m4)(distance2 + v4_min(closing, zero) * v4_all(horizon) <= reach * v4_sqrt(distance2)));
        for (size_t l = 0; l < 4 && p + l < count; l++) {
            kept[found] = (uint32_t)(p + l);
            found += bits >> l & 1u;
        }
    }
    return found;
}

const struct kernels PER_ISA(kernels) = {.drift = drift,
                                         .touch = touch,
                                         .kick = kick,
                                         .approach = approach,
                                         .bodies_drift = PER_ISA(bodies_drift),
                                         .bodies_gather = PER_ISA(bodies_gather)};
