/* Dense evaluation: all plays of a block of operators at once, samples of a block one after another.
 *
 * With p = z + r a play is p = max(x, min(x + 2 r, p)), and sum w z = sum w p - sum w r. That has an absolute error of the
 * order of eps sum |w| (r + |x|), which the caller weighs. Eight operators are a vector; a few vectors stay in registers
 * while the samples stream by, and the sums of eight samples are formed together. */
#include "kernels.h"
#include "lanes.h"

void LANES_NAME(engine_dense)(int32_t vectors, double *p, const double *width, const double *weight, int64_t samples,
                              const double *x, double *y, double base, double *moved, const engine_ahead *ahead);
int64_t LANES_NAME(engine_centre)(int64_t samples, const double *x, double center, double limit, double *u);
void LANES_NAME(engine_sum)(int64_t samples, const double *a, const double *b, double *y);

#if LANES_LEVEL == 2
#define MOST 8 /* vectors in registers */
enum { COMPOSE = 2 }; /* up to so many vectors the clamps of two samples are composed */
#elif LANES_LEVEL == 1
#define MOST 4
enum { COMPOSE = 1 };
#else
#define MOST 4
enum { COMPOSE = 0 };
#endif

#define INLINE static inline __attribute__((always_inline))

/* Samples by eight for `vectors` vectors, which the compiler knows. */
INLINE void plain(int vectors, double *p, const double *width, const double *weight, int64_t samples, const double *x,
                  double *y, double base, int add, double *moved, const engine_ahead *ahead)
{
    lanes play[MOST], wide[MOST], gain[MOST];
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
        play[v] = lanes_load(p + 8 * v);
        wide[v] = lanes_load(width + 8 * v);
        gain[v] = lanes_load(weight + 8 * v);
    }
    for (int64_t k = 0; k < samples; k += 8) {
        lanes_folded sums[8];
        if (!add) {
            __builtin_prefetch(ahead->read + k);
            __builtin_prefetch(ahead->write + k, 1);
        }
#pragma GCC unroll 8
        for (int j = 0; j < 8; ++j) {
            const lanes now = lanes_all(x[k + j]);
            lanes sum = lanes_all(0.0);
#pragma GCC unroll 8
            for (int v = 0; v < vectors; ++v) {
                play[v] = lanes_max(now, lanes_min(lanes_add(now, wide[v]), play[v]));
                sum = v == 0 ? lanes_mul(gain[v], play[v]) : lanes_fma(gain[v], play[v], sum);
            }
            if (moved) {
                lanes_store_first(moved + k + j, play[vectors - 1]);
            }
            sums[j] = lanes_fold(sum);
        }
        const lanes sum = lanes_sums(sums);
        lanes_store(y + k, lanes_add(add ? lanes_load(y + k) : lanes_all(base), sum));
    }
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
        lanes_store(p + 8 * v, play[v]);
    }
}

/* The same bits where one sample would wait for the one before: max(a, min(c, p)) of two samples is one such clamp. */
INLINE void composed(int vectors, double *p, const double *width, const double *weight, int64_t samples, const double *x,
                     double *y, double base, int add, double *moved, const engine_ahead *ahead)
{
    lanes play[MOST], wide[MOST], gain[MOST];
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
        play[v] = lanes_load(p + 8 * v);
        wide[v] = lanes_load(width + 8 * v);
        gain[v] = lanes_load(weight + 8 * v);
    }
    for (int64_t k = 0; k < samples; k += 8) {
        lanes_folded sums[8];
        if (!add) {
            __builtin_prefetch(ahead->read + k);
            __builtin_prefetch(ahead->write + k, 1);
        }
#pragma GCC unroll 4
        for (int j = 0; j < 8; j += 2) {
            const lanes one = lanes_all(x[k + j]), two = lanes_all(x[k + j + 1]);
            lanes sum_one = lanes_all(0.0), sum_two = lanes_all(0.0);
#pragma GCC unroll 8
            for (int v = 0; v < vectors; ++v) {
                const lanes cap_one = lanes_add(one, wide[v]), cap_two = lanes_add(two, wide[v]);
                const lanes first = lanes_max(one, lanes_min(cap_one, play[v]));
                const lanes floor = lanes_max(two, lanes_min(cap_two, one));
                const lanes cap = lanes_max(two, lanes_min(cap_two, cap_one));
                play[v] = lanes_max(floor, lanes_min(cap, play[v]));
                sum_one = v == 0 ? lanes_mul(gain[v], first) : lanes_fma(gain[v], first, sum_one);
                sum_two = v == 0 ? lanes_mul(gain[v], play[v]) : lanes_fma(gain[v], play[v], sum_two);
                if (moved && v == vectors - 1) {
                    lanes_store_first(moved + k + j, first);
                    lanes_store_first(moved + k + j + 1, play[v]);
                }
            }
            sums[j] = lanes_fold(sum_one);
            sums[j + 1] = lanes_fold(sum_two);
        }
        const lanes sum = lanes_sums(sums);
        lanes_store(y + k, lanes_add(add ? lanes_load(y + k) : lanes_all(base), sum));
    }
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
        lanes_store(p + 8 * v, play[v]);
    }
}

/* y_k (samples, a multiple of 8) = base + sum_i weight_i p_i; the p of operator i stands in lane 7 - i % 8 of its vector.
 * `moved` (samples,), or a null pointer, receives that of the last operator. */
void LANES_NAME(engine_dense)(int32_t vectors, double *p, const double *width, const double *weight, int64_t samples,
                              const double *x, double *y, double base, double *moved, const engine_ahead *ahead)
{
    int add = 0;
    int32_t groups = (vectors + MOST - 1) / MOST;
    while (vectors > 0) {
        const int32_t some = (vectors + groups - 1) / groups;
        double *const last = some == vectors ? moved : (double *)0;
        switch (some) {
#define CASE(number)                                                                 \
    case number:                                                                     \
        if (number <= COMPOSE) {                                                     \
            composed(number, p, width, weight, samples, x, y, base, add, last, ahead);           \
        } else {                                                                     \
            plain(number, p, width, weight, samples, x, y, base, add, last, ahead);              \
        }                                                                            \
        break;
            CASE(1)
            CASE(2)
#if MOST >= 4
            CASE(3)
            CASE(4)
#endif
#if MOST >= 8
            CASE(5)
            CASE(6)
            CASE(7)
            CASE(8)
#endif
        default:
            break;
        }
        p += 8 * some;
        width += 8 * some;
        weight += 8 * some;
        vectors -= some;
        --groups;
        add = 1;
    }
}

/* u = x - center while |x| <= limit; returns the number of samples until one is not. */
int64_t LANES_NAME(engine_centre)(int64_t samples, const double *x, double center, double limit, double *u)
{
    const lanes centers = lanes_all(center), low = lanes_all(-limit), high = lanes_all(limit);
    int64_t k = 0;
    for (; k + 8 <= samples; k += 8) {
        const lanes now = lanes_load(x + k);
        lanes_store(u + k, lanes_sub(now, centers));
        if ((lanes_le(low, now) & lanes_le(now, high)) != 0xff) {
            break;
        }
    }
    for (; k < samples && -limit <= x[k] && x[k] <= limit; ++k) {
        u[k] = x[k] - center;
    }
    return k;
}

/* y = a + b */
void LANES_NAME(engine_sum)(int64_t samples, const double *a, const double *b, double *y)
{
    int64_t k = 0;
    for (; k + 8 <= samples; k += 8) {
        lanes_store(y + k, lanes_add(lanes_load(a + k), lanes_load(b + k)));
    }
    for (; k < samples; ++k) {
        y[k] = a[k] + b[k];
    }
}
