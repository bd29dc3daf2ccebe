/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Four doubles side by side, the same to the bit on every instruction set.
 *
 * Arithmetic is GCC's vector extension (`+ - * /` and comparisons), which lowers
 * to two SSE registers where there is no AVX. Only what the extension lacks is
 * spelled out here, once per level; kernels themselves hold no #ifdef. Each
 * operation is IEEE-exact per lane and nothing is fused, hence the same bits. */
#ifndef SCREE_BASE_SIMD_H
#define SCREE_BASE_SIMD_H

#include <immintrin.h>
#include <stdint.h>

typedef double v4 __attribute__((vector_size(32), may_alias));
typedef int64_t m4 __attribute__((vector_size(32), may_alias)); // a lane is all ones or all zeros

#define SIMD_INLINE static inline __attribute__((always_inline))

SIMD_INLINE v4 v4_load(const double *row) // 32-byte aligned
{
    return *(const v4 *)row;
}
SIMD_INLINE void v4_store(double *row, v4 a)
{
    *(v4 *)row = a;
}
SIMD_INLINE v4 v4_set(double a, double b, double c, double d)
{
    return (v4){a, b, c, d};
}
SIMD_INLINE v4 v4_all(double a)
{
    return (v4){a, a, a, a};
}

#ifdef __AVX__
SIMD_INLINE v4 v4_sqrt(v4 a)
{
    return (v4)_mm256_sqrt_pd((__m256d)a);
}
SIMD_INLINE v4 v4_max(v4 a, v4 b)
{
    return (v4)_mm256_max_pd((__m256d)a, (__m256d)b);
}
SIMD_INLINE v4 v4_min(v4 a, v4 b)
{
    return (v4)_mm256_min_pd((__m256d)a, (__m256d)b);
}
SIMD_INLINE v4 v4_select(m4 mask, v4 yes, v4 no)
{
    return (v4)_mm256_blendv_pd((__m256d)no, (__m256d)yes, (__m256d)mask);
}
SIMD_INLINE unsigned m4_bits(m4 mask)
{
    return (unsigned)_mm256_movemask_pd((__m256d)mask);
}
#else
SIMD_INLINE __m128d v4_low(v4 a)
{
    return (__m128d){a[0], a[1]};
}
SIMD_INLINE __m128d v4_high(v4 a)
{
    return (__m128d){a[2], a[3]};
}
SIMD_INLINE v4 v4_join(__m128d low, __m128d high)
{
    return (v4){low[0], low[1], high[0], high[1]};
}
SIMD_INLINE v4 v4_sqrt(v4 a)
{
    return v4_join(_mm_sqrt_pd(v4_low(a)), _mm_sqrt_pd(v4_high(a)));
}
SIMD_INLINE v4 v4_max(v4 a, v4 b)
{
    return v4_join(_mm_max_pd(v4_low(a), v4_low(b)), _mm_max_pd(v4_high(a), v4_high(b)));
}
SIMD_INLINE v4 v4_min(v4 a, v4 b)
{
    return v4_join(_mm_min_pd(v4_low(a), v4_low(b)), _mm_min_pd(v4_high(a), v4_high(b)));
}
SIMD_INLINE v4 v4_select(m4 mask, v4 yes, v4 no)
{
    return (v4)(((m4)yes & mask) | ((m4)no & ~mask));
}
SIMD_INLINE unsigned m4_bits(m4 mask)
{
    v4 a = (v4)mask;
    return (unsigned)(_mm_movemask_pd(v4_low(a)) | _mm_movemask_pd(v4_high(a)) << 2);
}
#endif

SIMD_INLINE v4 v4_abs(v4 a)
{
    const m4 sign = {INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN};
    return (v4)((m4)a & ~sign);
}

/* Four rows become four columns: out[c][l] = row[l][c]. */
SIMD_INLINE void v4_transpose(v4 r0, v4 r1, v4 r2, v4 r3, v4 *c0, v4 *c1, v4 *c2, v4 *c3)
{
    v4 a = __builtin_shufflevector(r0, r1, 0, 4, 2, 6);
    v4 b = __builtin_shufflevector(r0, r1, 1, 5, 3, 7);
    v4 c = __builtin_shufflevector(r2, r3, 0, 4, 2, 6);
    v4 d = __builtin_shufflevector(r2, r3, 1, 5, 3, 7);
    *c0 = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    *c1 = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    *c2 = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    *c3 = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

#endif
