/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One row of the Gauss-Seidel sweep: the stress at one node while all others are held.
 *
 * The row's own block follows from one small matrix. Node j's stress pushes node
 * i with lambda c_i, and its strain rate sees that node with sym(u_i (x) c_i), so
 *
 *     W lambda = sum_i sym((lambda c_i) (x) c_i) = (lambda K + K lambda) / 2,   K = sum_i c_i c_i^T.
 *
 * In the eigenbasis of K, W is diagonal: k_a on the diagonal parts and
 * (k_a + k_b)/2 off it. There the law (eq. 2.7) needs no iteration over six
 * unknowns. In the flowing state Tr(gamma) = 0 and Dev(gamma) = -alpha Dev(lambda)
 * with alpha = ||Dev(gamma)|| / (mu p) > 0, hence
 *
 *     W lambda + alpha Dev(lambda) = -b
 *
 * is linear for a given alpha: each off-diagonal part by itself, and a diagonal
 * plus a rank-one matrix for the three others, whose trace is
 *
 *     T = -d sum_a b_a/(k_a + alpha) / sum_a k_a/(k_a + alpha).
 *
 * What is left is one number, alpha, from ||Dev lambda|| = mu T/d. Its inverse
 * form 1/||Dev lambda|| - 1/(mu p) is linear in alpha when K is isotropic, so
 * Newton's method takes two or three steps. If Tr(b) < 0 a root exists: at
 * alpha -> infinity lambda is isotropic and inside the cone; at alpha = 0 either
 * it is inside (static, gamma = 0) or outside; and on the cone T >= 0.
 * If Tr(b) >= 0, lambda = 0 solves the row (gas).
 *
 * This replaces Newton on the six-dimensional Fischer-Burmeister function of the
 * paper's section A.3: same root, always found, tenth of the work. */
#ifndef SCREE_MPM_LOCAL_H
#define SCREE_MPM_LOCAL_H

#include <math.h>

#include "base/simd.h"

/* The dimension: which diagonal parts there are, and 1/d. */
struct local_axes {
    v4 on; // 1 or 0 for x, y, z; the fourth lane is 0
    double inverse;
};
SIMD_INLINE struct local_axes local_axes(int plane)
{
    return (struct local_axes){plane ? v4_set(1, 0, 1, 0) : v4_set(1, 1, 1, 0), plane ? 1.0 / 2 : 1.0 / 3};
}

SIMD_INLINE double v4_sum3(v4 a)
{
    return a[0] + a[1] + a[2];
}

/* lambda at a given alpha. */
struct local_point {
    v4 diagonal, deviator, off; // parts of lambda; deviator of the diagonal ones
    v4 inverse_d, inverse_o;    // 1/(k + alpha)
    double trace, share, norm;  // T, sum k/(k + alpha), ||Dev lambda||
};
SIMD_INLINE struct local_point local_at(struct local_axes axes, v4 kd, v4 ko, v4 bd, v4 bo, double alpha)
{
    struct local_point p;
    p.inverse_d = axes.on / (kd + v4_all(alpha));
    p.inverse_o = v4_all(1) / (ko + v4_all(alpha));
    p.share = v4_sum3(kd * p.inverse_d);
    p.trace = -v4_sum3(bd * p.inverse_d) / (axes.inverse * p.share);
    double mean = p.trace * axes.inverse;
    p.diagonal = (v4_all(alpha * mean) - bd) * p.inverse_d;
    p.deviator = p.diagonal - v4_all(mean) * axes.on;
    p.off = -bo * p.inverse_o;
    p.norm = sqrt(0.5 * v4_sum3(p.deviator * p.deviator) + v4_sum3(p.off * p.off));
    return p;
}

enum { LOCAL_NEWTON_MAX = 80 };
#define LOCAL_EXACT 1e-13 // relative distance from the cone that rounding leaves

/* Derivatives along alpha of the linear system above, and Newton's next alpha:
 * negative where the inverse form has no value. */
struct local_slope {
    v4 diagonal, off;
    double next;
};
SIMD_INLINE struct local_slope local_newton(struct local_axes axes, const struct local_point *p, double mu, double alpha)
{
    struct local_slope s;
    double bound = mu * p->trace * axes.inverse;
    double trace_rate = -v4_sum3(p->deviator * p->inverse_d) / (axes.inverse * p->share);
    s.diagonal = (v4_all(trace_rate * axes.inverse * alpha + p->trace * axes.inverse) - p->diagonal) * p->inverse_d;
    s.off = -p->off * p->inverse_o;
    double norm_rate = (0.5 * v4_sum3(p->deviator * s.diagonal) + v4_sum3(p->off * s.off)) / p->norm;
    /* h = 1/norm - 1/bound, and its slope, both times norm * bound. */
    double slope = -norm_rate * bound / p->norm + mu * trace_rate * axes.inverse * p->norm / bound;
    s.next = bound > 0 ? alpha - (bound - p->norm) / slope : -1;
    return s;
}

/* The root alpha from a guess `start` > 0; `at` holds lambda on return. Static rows
 * end at alpha = 0. Within a relative distance `near` of the cone the last step is taken along the slope.
 * Returns alpha, or -1 - alpha if the steps ran out (rows with a hopelessly thin K; the caller counts). */
SIMD_INLINE double local_root(struct local_axes axes, v4 kd, v4 ko, v4 bd, v4 bo, double mu, double start, double near,
                              struct local_point *at)
{
    double low = -1, high = INFINITY, alpha = start; // low = -1: nothing known of alpha = 0 yet
    for (int step = 0; step < LOCAL_NEWTON_MAX; step++) {
        *at = local_at(axes, kd, ko, bd, bo, alpha);
        double excess = at->norm - mu * at->trace * axes.inverse;
        if (fabs(excess) <= LOCAL_EXACT * at->norm || at->norm == 0 || (alpha == 0 && excess < 0))
            return alpha;
        if (excess > 0)
            low = alpha;
        else
            high = alpha;
        struct local_slope slope = local_newton(axes, at, mu, alpha);
        double next = slope.next;
        if (fabs(excess) <= near * at->norm && next > 0) { // lambda is linear over so short a way, to near squared
            at->diagonal += v4_all(next - alpha) * slope.diagonal;
            at->off += v4_all(next - alpha) * slope.off;
            return next;
        }
        if (low < 0 && !(next > 0 && next < high))
            next = 0; // is it static?
        else if (!(next > low && next < high))
            next = high < INFINITY ? 0.5 * (fmax(low, 0) + high) : 2 * low + v4_sum3(kd * axes.on) * axes.inverse;
        if (next == alpha)
            return alpha; // the bracket has no number left inside
        alpha = next;
    }
    return -1 - alpha;
}

/* Solves the row. Returns 0 gas, 1 static, 2 flowing (enum phase); *alpha is the
 * last root of this row (a good start for the next visit; 0 when it was static) and is updated. */
SIMD_INLINE int local_solve(struct local_axes axes, v4 kd, v4 ko, v4 bd, v4 bo, double mu, double near, double *alpha, v4 *diagonal,
                            v4 *off, unsigned *stalls)
{
    const v4 zero = {0, 0, 0, 0};
    double trace_b = v4_sum3(bd);
    if (!(trace_b < 0)) {
        *diagonal = *off = zero;
        return 0;
    }
    if (mu <= 0) { // alpha -> infinity
        *diagonal = v4_all(-trace_b / v4_sum3(kd * axes.on)) * axes.on;
        *off = zero;
        return 2;
    }
    struct local_point p;
    double start = *alpha;
    if (!(start > 0)) {
        p = local_at(axes, kd, ko, bd, bo, 0);
        double bound = -mu * trace_b / v4_sum3(kd * axes.on);
        if (p.norm > mu * p.trace * axes.inverse) // outside: as if K were isotropic
            start = v4_sum3(kd * axes.on) * axes.inverse * fmax(p.norm / bound - 1, 1e-3);
    }
    double root = start > 0 ? local_root(axes, kd, ko, bd, bo, mu, start, near, &p) : 0;
    *stalls += root < 0;
    *alpha = root < 0 ? -1 - root : root;
    *diagonal = p.diagonal;
    *off = p.off;
    return root > 0 ? 2 : 1;
}

/* |f_MFB(gamma, lambda)|^2 (eqs A4, A5, A9) from the parts of both tensors in any common basis. */
SIMD_INLINE double local_residual(struct local_axes axes, v4 gd, v4 go, v4 ld, v4 lo, double mu)
{
    double d = 1 / axes.inverse, mu_cone = sqrt(2 * axes.inverse) * mu;
    double trace_g = v4_sum3(gd), trace_l = v4_sum3(ld);
    v4 dev_g = gd - v4_all(trace_g * axes.inverse) * axes.on, dev_l = ld - v4_all(trace_l * axes.inverse) * axes.on;
    double norm_g = sqrt(0.5 * v4_sum3(dev_g * dev_g) + v4_sum3(go * go));
    /* A4 adds mu~ sqrt(2/d) ||Dev gamma|| I; A5 scales the stress's trace and the strain's deviator by mu~. */
    trace_g += mu_cone * sqrt(2 * axes.inverse) * norm_g * d;
    trace_l *= mu_cone;
    dev_g *= v4_all(mu_cone);
    v4 off_g = go * v4_all(mu_cone);
    /* ||t||^2 = Tr^2/(2d) + ||Dev||^2. */
    double square = (trace_g * trace_g + trace_l * trace_l) * 0.5 * axes.inverse + 0.5 * v4_sum3(dev_g * dev_g + dev_l * dev_l) +
                    v4_sum3(off_g * off_g + lo * lo);
    v4 mix_d = v4_all(trace_g) * dev_g + v4_all(trace_l) * dev_l, mix_o = v4_all(trace_g) * off_g + v4_all(trace_l) * lo;
    double mix = 0.5 * v4_sum3(mix_d * mix_d) + v4_sum3(mix_o * mix_o);
    double s = sqrt(d * (square + sqrt(fmax(0, square * square - 2 * axes.inverse * mix))));
    if (s == 0)
        return 0;
    double trace_f = trace_g + trace_l - s;
    v4 dev_f = v4_all(1 - trace_g / s) * dev_g + v4_all(1 - trace_l / s) * dev_l;
    v4 off_f = v4_all(1 - trace_g / s) * off_g + v4_all(1 - trace_l / s) * lo;
    return trace_f * trace_f * 0.5 * axes.inverse + 0.5 * v4_sum3(dev_f * dev_f) + v4_sum3(off_f * off_f);
}

#endif
