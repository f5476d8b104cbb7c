/* Eight doubles as four pairs: what every processor of an architecture has (SSE2, NEON), or plain C. The same bits in all. */
#ifndef DEHYST_LANES_PORTABLE_H
#define DEHYST_LANES_PORTABLE_H

#include <stdint.h>

#if defined(__SSE2__) && !defined(LANES_PLAIN)
#include <emmintrin.h>
typedef __m128d pair;
static inline pair pair_load(const double *p) { return _mm_loadu_pd(p); }
static inline void pair_store(double *p, pair a) { _mm_storeu_pd(p, a); }
static inline void pair_store_first(double *p, pair a) { _mm_store_sd(p, a); }
static inline pair pair_all(double a) { return _mm_set1_pd(a); }
static inline pair pair_add(pair a, pair b) { return _mm_add_pd(a, b); }
static inline pair pair_sub(pair a, pair b) { return _mm_sub_pd(a, b); }
static inline pair pair_mul(pair a, pair b) { return _mm_mul_pd(a, b); }
static inline pair pair_min(pair a, pair b) { return _mm_min_pd(a, b); }
static inline pair pair_max(pair a, pair b) { return _mm_max_pd(a, b); }
static inline unsigned pair_le(pair a, pair b) { return (unsigned)_mm_movemask_pd(_mm_cmple_pd(a, b)); }
static inline pair pair_shift(pair a, pair b) { return _mm_shuffle_pd(b, a, 1); } /* the last of b, the first of a */
static inline double pair_sum(pair a) { return _mm_cvtsd_f64(a) + _mm_cvtsd_f64(_mm_unpackhi_pd(a, a)); }
#elif defined(__aarch64__) && !defined(LANES_PLAIN)
#include <arm_neon.h>
typedef float64x2_t pair;
static inline pair pair_load(const double *p) { return vld1q_f64(p); }
static inline void pair_store(double *p, pair a) { vst1q_f64(p, a); }
static inline void pair_store_first(double *p, pair a) { *p = vgetq_lane_f64(a, 0); }
static inline pair pair_all(double a) { return vdupq_n_f64(a); }
static inline pair pair_add(pair a, pair b) { return vaddq_f64(a, b); }
static inline pair pair_sub(pair a, pair b) { return vsubq_f64(a, b); }
static inline pair pair_mul(pair a, pair b) { return vmulq_f64(a, b); }
static inline pair pair_min(pair a, pair b) { return vbslq_f64(vcltq_f64(a, b), a, b); }
static inline pair pair_max(pair a, pair b) { return vbslq_f64(vcgtq_f64(a, b), a, b); }
static inline unsigned pair_le(pair a, pair b)
{
    const uint64x2_t bits = vcleq_f64(a, b);
    return (unsigned)((vgetq_lane_u64(bits, 0) & 1) | (vgetq_lane_u64(bits, 1) & 2));
}
static inline pair pair_shift(pair a, pair b) { return vextq_f64(b, a, 1); }
static inline double pair_sum(pair a) { return vgetq_lane_f64(a, 0) + vgetq_lane_f64(a, 1); }
#else
typedef struct pair { double l, h; } pair;
static inline pair pair_load(const double *p) { pair r = {p[0], p[1]}; return r; }
static inline void pair_store(double *p, pair a) { p[0] = a.l; p[1] = a.h; }
static inline void pair_store_first(double *p, pair a) { *p = a.l; }
static inline pair pair_all(double a) { pair r = {a, a}; return r; }
static inline pair pair_add(pair a, pair b) { pair r = {a.l + b.l, a.h + b.h}; return r; }
static inline pair pair_sub(pair a, pair b) { pair r = {a.l - b.l, a.h - b.h}; return r; }
static inline pair pair_mul(pair a, pair b) { pair r = {a.l * b.l, a.h * b.h}; return r; }
static inline pair pair_min(pair a, pair b) { pair r = {a.l < b.l ? a.l : b.l, a.h < b.h ? a.h : b.h}; return r; }
static inline pair pair_max(pair a, pair b) { pair r = {a.l > b.l ? a.l : b.l, a.h > b.h ? a.h : b.h}; return r; }
static inline unsigned pair_le(pair a, pair b) { return (unsigned)(a.l <= b.l) | (unsigned)(a.h <= b.h) << 1; }
static inline pair pair_shift(pair a, pair b) { pair r = {b.h, a.l}; return r; }
static inline double pair_sum(pair a) { return a.l + a.h; }
#endif

#define LANES_NAME(name) name##_portable
typedef struct lanes { pair v[4]; } lanes;
#define LANES_TWO(name, op) static inline lanes name(lanes a, lanes b) \
    { lanes r = {{op(a.v[0], b.v[0]), op(a.v[1], b.v[1]), op(a.v[2], b.v[2]), op(a.v[3], b.v[3])}}; return r; }
LANES_TWO(lanes_add, pair_add)
LANES_TWO(lanes_sub, pair_sub)
LANES_TWO(lanes_mul, pair_mul)
LANES_TWO(lanes_min, pair_min)
LANES_TWO(lanes_max, pair_max)
#undef LANES_TWO
static inline lanes lanes_load(const double *p)
{
    lanes r = {{pair_load(p), pair_load(p + 2), pair_load(p + 4), pair_load(p + 6)}};
    return r;
}
static inline void lanes_store(double *p, lanes a)
{
    for (int k = 0; k < 4; ++k) pair_store(p + 2 * k, a.v[k]);
}
static inline lanes lanes_all(double a)
{
    const pair v = pair_all(a);
    lanes r = {{v, v, v, v}};
    return r;
}
static inline lanes lanes_fma(lanes a, lanes b, lanes c) { return lanes_add(lanes_mul(a, b), c); }
static inline unsigned lanes_le(lanes a, lanes b)
{
    return pair_le(a.v[0], b.v[0]) | pair_le(a.v[1], b.v[1]) << 2 | pair_le(a.v[2], b.v[2]) << 4 |
           pair_le(a.v[3], b.v[3]) << 6;
}
static inline double lanes_sum(lanes a)
{
    return pair_sum(pair_add(pair_add(a.v[0], a.v[2]), pair_add(a.v[1], a.v[3])));
}
static inline lanes lanes_load_first(const double *p, int64_t count)
{
    double v[8];
    for (int k = 0; k < 8; ++k) v[k] = k < count ? p[k] : 0.0;
    return lanes_load(v);
}
static inline lanes lanes_keep(lanes a, int count)
{
    double v[8];
    lanes_store(v, a);
    for (int k = 0; k < 8; ++k) v[k] = k < count ? v[k] : 0.0;
    return lanes_load(v);
}
static inline lanes lanes_shift(lanes a, lanes b)
{
    lanes r = {{pair_shift(a.v[0], b.v[3]), pair_shift(a.v[1], a.v[0]), pair_shift(a.v[2], a.v[1]),
                pair_shift(a.v[3], a.v[2])}};
    return r;
}
static inline void lanes_store_one(double *p, lanes a, int lane)
{
    const pair both = a.v[lane / 2];
    pair_store_first(p, pair_shift(both, both));
}
static inline void lanes_add_sums(lanes a, lanes b, lanes c, lanes d, double *sums)
{
    sums[0] += lanes_sum(a);
    sums[1] += lanes_sum(b);
    sums[2] += lanes_sum(c);
    sums[3] += lanes_sum(d);
}

#endif
