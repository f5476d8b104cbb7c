/* Sums over the samples of a run: of d = x - origin and of a column f, while only one cell moves. */
#ifndef DEHYST_MOMENTS_H
#define DEHYST_MOMENTS_H

#include <math.h>

#include "lanes.h"

/* Where only one cell moves: low <= x <= high and, if monotone is +1 (-1), x never falls (rises) from `last` on. */
typedef struct run_window {
    double low, high, last, origin;
    int monotone;
    int begin; /* 1: the first sample belongs to the run whatever the bounds say */
} run_window;

/* Bounds of one sample after another; the monotone ones follow the samples. */
typedef struct bounds {
    lanes low, high, rise, fall, before;
} bounds;

static inline bounds bounds_of(const run_window *w)
{
    const bounds b = {lanes_all(w->low), lanes_all(w->high), lanes_all(w->monotone > 0 ? 0.0 : -INFINITY),
                      lanes_all(w->monotone < 0 ? 0.0 : INFINITY), lanes_all(w->last)};
    return b;
}

/* Which of eight samples lie in the window. */
static inline unsigned inside(bounds *b, lanes x)
{
    const lanes before = lanes_shift(x, b->before);
    const lanes low = lanes_max(b->low, lanes_add(before, b->rise)), high = lanes_min(b->high, lanes_add(before, b->fall));
    b->before = x;
    return lanes_le(low, x) & lanes_le(x, high);
}

/* The first of `there` samples that is not in the mask. */
static inline int first_outside(unsigned mask, int64_t there)
{
    const int count = __builtin_ctz(~mask);
    return count < there ? count : (int)there;
}

typedef struct sums_of_run {
    lanes d, dd, f, df;
} sums_of_run;

static inline void add_samples(sums_of_run *s, lanes d, lanes f)
{
    s->d = lanes_add(s->d, d);
    s->dd = lanes_fma(d, d, s->dd);
    s->f = lanes_add(s->f, f);
    s->df = lanes_fma(d, f, s->df);
}

enum { FREE, RISING, FALLING, AHEAD = 1024 };

/* Whole eights from k on that lie in the window of a long run; x[k - 1] does. Returns where they end. */
static inline __attribute__((always_inline)) int64_t follow(const int way, const int with_sums, int64_t k, int64_t samples,
                                                            const double *x, const double *f, const run_window *window,
                                                            sums_of_run *s)
{
    const lanes low = lanes_all(window->low), high = lanes_all(window->high), origin = lanes_all(window->origin);
    for (; k + 8 <= samples; k += 8) {
        const lanes u = lanes_load(x + k), before = lanes_load(x + k - 1);
        const unsigned mask = way == RISING    ? lanes_le(before, u) & lanes_le(u, high)
                              : way == FALLING ? lanes_le(u, before) & lanes_le(low, u)
                                               : lanes_le(low, u) & lanes_le(u, high);
        if (mask != 255) {
            break;
        }
        if (with_sums) {
            __builtin_prefetch(x + k + AHEAD);
            __builtin_prefetch(f + k + AHEAD);
            add_samples(s, lanes_sub(u, origin), lanes_load(f + k));
        }
    }
    return k;
}

static inline __attribute__((always_inline)) int64_t follow_any(const int with_sums, int64_t k, int64_t samples,
                                                                const double *x, const double *f, const run_window *window,
                                                                sums_of_run *s)
{
    return window->monotone > 0   ? follow(RISING, with_sums, k, samples, x, f, window, s)
           : window->monotone < 0 ? follow(FALLING, with_sums, k, samples, x, f, window, s)
                                  : follow(FREE, with_sums, k, samples, x, f, window, s);
}

/* Samples from the first on that lie in the window; adds their sums of d, d^2, f, d f to sums. The first eight are treated
 * alike in every kind of run, for noise ends it there and its kind could not be predicted. */
static inline int64_t sum_run(int64_t samples, const double *x, const double *f, const run_window *window, double *sums)
{
    bounds b = bounds_of(window);
    const lanes origin = lanes_all(window->origin), none = lanes_all(0.0);
    sums_of_run s = {none, none, none, none};
    int64_t k = 0, there = samples < 8 ? samples : 8;
    lanes u = lanes_load_first(x, there);
    int count = first_outside(inside(&b, u) | (unsigned)window->begin, there);
    add_samples(&s, lanes_keep(lanes_sub(u, origin), count), lanes_load_first(f, count));
    k = count;
    if (count == 8) {
        k = follow_any(1, k, samples, x, f, window, &s);
        there = samples - k < 8 ? samples - k : 8;
        u = lanes_load_first(x + k, there);
        b.before = lanes_all(x[k - 1]);
        count = first_outside(inside(&b, u), there);
        add_samples(&s, lanes_keep(lanes_sub(u, origin), count), lanes_load_first(f + k, count));
        k += count;
    }
    lanes_add_sums(s.d, s.dd, s.f, s.df, sums);
    return k;
}

/* Number of samples from the first on that lie in the window. */
static inline int64_t scan_run(int64_t samples, const double *x, const run_window *window)
{
    bounds b = bounds_of(window);
    int64_t k, there = samples < 8 ? samples : 8;
    k = first_outside(inside(&b, lanes_load_first(x, there)) | (unsigned)window->begin, there);
    if (k == 8) {
        k = follow_any(0, k, samples, x, x, window, 0);
        there = samples - k < 8 ? samples - k : 8;
        b.before = lanes_all(x[k - 1]);
        k += first_outside(inside(&b, lanes_load_first(x + k, there)), there);
    }
    return k;
}

/* Adds sum f, sum d f and sum d^2 f to sums. */
static inline void add_moments(int64_t samples, const double *x, const double *f, double origin, double *sums)
{
    const lanes from = lanes_all(origin);
    lanes f0 = lanes_all(0.0), f1 = f0, f2 = f0;
    for (int64_t k = 0; k < samples; k += 8) {
        const int64_t there = samples - k < 8 ? samples - k : 8;
        const lanes d = lanes_sub(lanes_load_first(x + k, there), from), v = lanes_load_first(f + k, there);
        const lanes moving = lanes_mul(d, v);
        f0 = lanes_add(f0, v);
        f1 = lanes_add(f1, moving);
        f2 = lanes_fma(d, moving, f2);
    }
    sums[0] += lanes_sum(f0);
    sums[1] += lanes_sum(f1);
    sums[2] += lanes_sum(f2);
}

#endif
