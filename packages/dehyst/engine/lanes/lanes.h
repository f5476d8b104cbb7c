/* Eight doubles at once, the same operations at every level.
 *
 * This header is compiled once per instruction set (LANES_LEVEL). Sums run over eight fixed lanes at every level, so levels
 * differ by fused multiply-add alone. */
#ifndef DEHYST_LANES_H
#define DEHYST_LANES_H

#include <stdint.h>

#if LANES_LEVEL == 2
#include <immintrin.h>
#define LANES_NAME(name) name##_avx512
typedef __m512d lanes;
static inline lanes lanes_load(const double *p) { return _mm512_loadu_pd(p); }
static inline void lanes_store(double *p, lanes a) { _mm512_storeu_pd(p, a); }
static inline lanes lanes_all(double a) { return _mm512_set1_pd(a); }
static inline lanes lanes_add(lanes a, lanes b) { return _mm512_add_pd(a, b); }
static inline lanes lanes_sub(lanes a, lanes b) { return _mm512_sub_pd(a, b); }
static inline lanes lanes_mul(lanes a, lanes b) { return _mm512_mul_pd(a, b); }
static inline lanes lanes_fma(lanes a, lanes b, lanes c) { return _mm512_fmadd_pd(a, b, c); } /* a b + c */
static inline lanes lanes_min(lanes a, lanes b) { return _mm512_min_pd(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm512_max_pd(a, b); }
/* bit k set where a_k <= b_k; false for NaN */
static inline unsigned lanes_le(lanes a, lanes b) { return (unsigned)_mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
static inline double lanes_sum(lanes a) { return _mm512_reduce_add_pd(a); }
/* the first `count` <= 8 of p, the others 0 and not read; the first `count` lanes of a; the last lane of b, then a */
static inline lanes lanes_load_first(const double *p, int64_t count) { return _mm512_maskz_loadu_pd((__mmask8)((1u << count) - 1), p); }
static inline lanes lanes_keep(lanes a, int count) { return _mm512_maskz_mov_pd((__mmask8)((1u << count) - 1), a); }
static inline lanes lanes_shift(lanes a, lanes b)
{
    return _mm512_castsi512_pd(_mm512_alignr_epi64(_mm512_castpd_si512(a), _mm512_castpd_si512(b), 7));
}
/* lane 3 or 7 */
static inline void lanes_store_one(double *p, lanes a, int lane) { _mm512_mask_storeu_pd(p - lane, (__mmask8)(1u << lane), a); }
/* sums[0 .. 3] += sums of a, b, c, d */
static inline void lanes_add_sums(lanes a, lanes b, lanes c, lanes d, double *sums)
{
    const __m512d ab = _mm512_add_pd(_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
    const __m512d cd = _mm512_add_pd(_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
    const __m512d two = _mm512_add_pd(_mm512_shuffle_f64x2(ab, cd, 0x88), _mm512_shuffle_f64x2(ab, cd, 0xdd));
    const __m512d one = _mm512_add_pd(two, _mm512_shuffle_f64x2(two, two, 0xb1)); /* ab in [0, 1], cd in [4, 5] */
    _mm_storeu_pd(sums, _mm_add_pd(_mm_loadu_pd(sums), _mm512_castpd512_pd128(one)));
    _mm_storeu_pd(sums + 2, _mm_add_pd(_mm_loadu_pd(sums + 2), _mm512_extractf64x2_pd(one, 2)));
}
#elif LANES_LEVEL == 1
#include <immintrin.h>
#define LANES_NAME(name) name##_avx2
typedef struct lanes { __m256d l, h; } lanes;
static inline lanes lanes_load(const double *p) { lanes r = {_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4)}; return r; }
static inline void lanes_store(double *p, lanes a) { _mm256_storeu_pd(p, a.l); _mm256_storeu_pd(p + 4, a.h); }
static inline lanes lanes_all(double a) { lanes r = {_mm256_set1_pd(a), _mm256_set1_pd(a)}; return r; }
#define LANES_TWO(name, op) static inline lanes name(lanes a, lanes b) { lanes r = {op(a.l, b.l), op(a.h, b.h)}; return r; }
LANES_TWO(lanes_add, _mm256_add_pd)
LANES_TWO(lanes_sub, _mm256_sub_pd)
LANES_TWO(lanes_mul, _mm256_mul_pd)
LANES_TWO(lanes_min, _mm256_min_pd)
LANES_TWO(lanes_max, _mm256_max_pd)
#undef LANES_TWO
static inline lanes lanes_fma(lanes a, lanes b, lanes c)
{
    lanes r = {_mm256_fmadd_pd(a.l, b.l, c.l), _mm256_fmadd_pd(a.h, b.h, c.h)};
    return r;
}
static inline unsigned lanes_le(lanes a, lanes b)
{
    const int low = _mm256_movemask_pd(_mm256_cmp_pd(a.l, b.l, _CMP_LE_OQ));
    const int high = _mm256_movemask_pd(_mm256_cmp_pd(a.h, b.h, _CMP_LE_OQ));
    return (unsigned)low | ((unsigned)high << 4);
}
static inline double lanes_sum(lanes a)
{
    const __m256d four = _mm256_add_pd(a.l, a.h);
    const __m128d two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd(four, 1));
    return _mm_cvtsd_f64(two) + _mm_cvtsd_f64(_mm_unpackhi_pd(two, two));
}
static inline __m256i lanes_below(int64_t count, int first) /* all bits where first + lane < count */
{
    const __m256i lane = _mm256_set_epi64x(first + 3, first + 2, first + 1, first);
    return _mm256_cmpgt_epi64(_mm256_set1_epi64x(count), lane);
}
static inline lanes lanes_load_first(const double *p, int64_t count)
{
    lanes r = {_mm256_maskload_pd(p, lanes_below(count, 0)), _mm256_setzero_pd()};
    if (count > 4) {
        r.h = _mm256_maskload_pd(p + 4, lanes_below(count, 4));
    }
    return r;
}
static inline lanes lanes_keep(lanes a, int count)
{
    lanes r = {_mm256_and_pd(a.l, _mm256_castsi256_pd(lanes_below(count, 0))),
               _mm256_and_pd(a.h, _mm256_castsi256_pd(lanes_below(count, 4)))};
    return r;
}
static inline lanes lanes_shift(lanes a, lanes b)
{
    lanes r = {_mm256_shuffle_pd(_mm256_permute2f128_pd(b.h, a.l, 0x21), a.l, 5),
               _mm256_shuffle_pd(_mm256_permute2f128_pd(a.l, a.h, 0x21), a.h, 5)};
    return r;
}
static inline void lanes_store_one(double *p, lanes a, int lane)
{
    _mm_storeh_pd(p, _mm256_extractf128_pd(lane == 7 ? a.h : a.l, 1));
}
static inline void lanes_add_sums(lanes a, lanes b, lanes c, lanes d, double *sums)
{
    const __m256d ab = _mm256_hadd_pd(_mm256_add_pd(a.l, a.h), _mm256_add_pd(b.l, b.h)); /* a01, b01, a23, b23 */
    const __m256d cd = _mm256_hadd_pd(_mm256_add_pd(c.l, c.h), _mm256_add_pd(d.l, d.h));
    const __m256d all = _mm256_add_pd(_mm256_permute2f128_pd(ab, cd, 0x20), _mm256_permute2f128_pd(ab, cd, 0x31));
    _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), all));
}
#else
#include "lanes_portable.h"
#endif

/* The first lane. */
static inline void lanes_store_first(double *p, lanes a)
{
#if LANES_LEVEL == 2
    _mm_store_sd(p, _mm512_castpd512_pd128(a));
#elif LANES_LEVEL == 1
    _mm_store_sd(p, _mm256_castpd256_pd128(a.l));
#else
    pair_store_first(p, a.v[0]);
#endif
}

/* The first `count` < 8 lanes. */
static inline void lanes_store_some(double *p, lanes a, int count)
{
#if LANES_LEVEL == 2
    _mm512_mask_storeu_pd(p, (__mmask8)((1u << count) - 1u), a);
#elif LANES_LEVEL == 1
    _mm256_maskstore_pd(p, lanes_below(count, 0), a.l);
    _mm256_maskstore_pd(p + 4, lanes_below(count, 4), a.h);
#else
    double v[8];
    lanes_store(v, a);
    for (int k = 0; k < count; ++k) p[k] = v[k];
#endif
}

/* Sums of eight: lanes_fold first, which may halve them, then lane k of lanes_sums is the sum of all of a[k]. */
#if LANES_LEVEL == 2
typedef __m512d lanes_folded;
static inline lanes_folded lanes_fold(lanes a) { return a; }
static inline lanes lanes_sums(const lanes_folded *a)
{
    const __m512d a01 = _mm512_add_pd(_mm512_unpacklo_pd(a[0], a[1]), _mm512_unpackhi_pd(a[0], a[1]));
    const __m512d a23 = _mm512_add_pd(_mm512_unpacklo_pd(a[2], a[3]), _mm512_unpackhi_pd(a[2], a[3]));
    const __m512d a45 = _mm512_add_pd(_mm512_unpacklo_pd(a[4], a[5]), _mm512_unpackhi_pd(a[4], a[5]));
    const __m512d a67 = _mm512_add_pd(_mm512_unpacklo_pd(a[6], a[7]), _mm512_unpackhi_pd(a[6], a[7]));
    /* quarters of a01: (sums of the pair) x 4; bring quarters together */
    const __m512d low = _mm512_add_pd(_mm512_shuffle_f64x2(a01, a23, 0x88), _mm512_shuffle_f64x2(a01, a23, 0xdd));
    const __m512d high = _mm512_add_pd(_mm512_shuffle_f64x2(a45, a67, 0x88), _mm512_shuffle_f64x2(a45, a67, 0xdd));
    return _mm512_add_pd(_mm512_shuffle_f64x2(low, high, 0x88), _mm512_shuffle_f64x2(low, high, 0xdd));
}
#elif LANES_LEVEL == 1
typedef __m256d lanes_folded;
static inline lanes_folded lanes_fold(lanes a) { return _mm256_add_pd(a.l, a.h); }
static inline __m256d lanes_sums_of_four(const lanes_folded *a)
{
    const __m256d a01 = _mm256_hadd_pd(a[0], a[1]), a23 = _mm256_hadd_pd(a[2], a[3]);
    return _mm256_add_pd(_mm256_permute2f128_pd(a01, a23, 0x20), _mm256_permute2f128_pd(a01, a23, 0x31));
}
static inline lanes lanes_sums(const lanes_folded *a)
{
    const lanes r = {lanes_sums_of_four(a), lanes_sums_of_four(a + 4)};
    return r;
}
#else
typedef double lanes_folded;
static inline lanes_folded lanes_fold(lanes a) { return lanes_sum(a); }
static inline lanes lanes_sums(const lanes_folded *a) { return lanes_load(a); }
#endif

/* Store to an address that is a multiple of 64, past the caches where that exists. */
static inline void lanes_stream(double *p, lanes a)
{
#if LANES_LEVEL == 2
    _mm512_stream_pd(p, a);
#elif LANES_LEVEL == 1
    _mm256_stream_pd(p, a.l);
    _mm256_stream_pd(p + 4, a.h);
#else
    lanes_store(p, a);
#endif
}

/* Such stores are seen by others after it. */
static inline void lanes_fence(void)
{
#if LANES_LEVEL > 0
    _mm_sfence();
#endif
}

/* total += a, and what rounding took away goes to low: the sum of both is as good as one rounded once (Knuth's two-sum). */
static inline void lanes_add_exactly(double *total, double *low, lanes a)
{
    const lanes t = lanes_load(total), sum = lanes_add(t, a), back = lanes_sub(sum, t);
    const lanes lost = lanes_add(lanes_sub(t, lanes_sub(sum, back)), lanes_sub(a, back));
    lanes_store(total, sum);
    lanes_store(low, lanes_add(lanes_load(low), lost));
}

/* a b + c of one number, as lanes_fma does it at this level */
static inline double lanes_fma_one(double a, double b, double c)
{
#if LANES_LEVEL > 0
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}

#endif
