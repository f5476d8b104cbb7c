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

enum { FREE, RISING, FALLING, AHEAD = 1024 };
enum { SCAN, PLAIN, WEIGHTED }; /* sum nothing; samples of weight 1; of weights w, with columns that are multiplied by them */

typedef struct sums_of_run {
    lanes w, d, dd, f, df, ff;
} sums_of_run;

static inline __attribute__((always_inline)) void add_samples(const int what, sums_of_run *s, lanes d, lanes f, lanes w)
{
    if (what == SCAN) {
        return;
    }
    const lanes wd = what == WEIGHTED ? lanes_mul(w, d) : d;
    s->w = what == WEIGHTED ? lanes_add(s->w, w) : s->w;
    s->ff = what == PLAIN ? lanes_fma(f, f, s->ff) : s->ff;
    s->d = lanes_add(s->d, wd);
    s->dd = lanes_fma(d, wd, s->dd);
    s->f = lanes_add(s->f, f);
    s->df = lanes_fma(d, f, s->df);
}

/* Samples of one run: x, and their column and weights if they are summed. */
typedef struct run_samples {
    int64_t count;
    const double *x, *f, *w;
} run_samples;

/* Whole eights from k on that lie in the window of a long run; x[k - 1] does. Returns where they end. */
static inline __attribute__((always_inline)) int64_t follow(const int way, const int what, int64_t k, run_samples r,
                                                            const run_window *window, sums_of_run *s)
{
    const lanes low = lanes_all(window->low), high = lanes_all(window->high), origin = lanes_all(window->origin);
    for (; k + 8 <= r.count; k += 8) {
        const lanes u = lanes_load(r.x + k), before = lanes_load(r.x + k - 1);
        const unsigned mask = way == RISING    ? lanes_le(before, u) & lanes_le(u, high)
                              : way == FALLING ? lanes_le(u, before) & lanes_le(low, u)
                                               : lanes_le(low, u) & lanes_le(u, high);
        if (mask != 255) {
            break;
        }
        if (what == PLAIN) {
            __builtin_prefetch(r.x + k + AHEAD);
            __builtin_prefetch(r.f + k + AHEAD);
        }
        add_samples(what, s, lanes_sub(u, origin), what == SCAN ? u : lanes_load(r.f + k),
                    what == WEIGHTED ? lanes_load(r.w + k) : u);
    }
    return k;
}

/* Fewer than nine samples from k on: how many of them lie in the window, and their sums. */
static inline __attribute__((always_inline)) int end_of(const int what, int64_t k, run_samples r, const run_window *window,
                                                        bounds *b, unsigned begin, sums_of_run *s)
{
    const int64_t there = r.count - k < 8 ? r.count - k : 8;
    const lanes u = lanes_load_first(r.x + k, there);
    const int count = first_outside(inside(b, u) | begin, there);
    if (what != SCAN) {
        add_samples(what, s, lanes_keep(lanes_sub(u, lanes_all(window->origin)), count), lanes_load_first(r.f + k, count),
                    what == WEIGHTED ? lanes_load_first(r.w + k, count) : u);
    }
    return count;
}

/* Samples from the first on that lie in the window, and their sums. The first eight are treated alike in every kind of run,
 * for noise ends it there and its kind could not be predicted. */
static inline __attribute__((always_inline)) int64_t follow_run(const int what, run_samples r, const run_window *window,
                                                                sums_of_run *s)
{
    bounds b = bounds_of(window);
    int64_t k = end_of(what, 0, r, window, &b, (unsigned)window->begin, s);
    if (k == 8) {
        k = window->monotone > 0   ? follow(RISING, what, k, r, window, s)
            : window->monotone < 0 ? follow(FALLING, what, k, r, window, s)
                                   : follow(FREE, what, k, r, window, s);
        b.before = lanes_all(r.x[k - 1]);
        k += end_of(what, k, r, window, &b, 0, s);
    }
    return k;
}

/* Adds sum f and sum d f to sums. */
static inline void add_moments(int64_t samples, const double *x, const double *f, double origin, double *sums)
{
    const lanes from = lanes_all(origin);
    lanes f0 = lanes_all(0.0), f1 = f0;
    for (int64_t k = 0; k < samples; k += 8) {
        const int64_t there = samples - k < 8 ? samples - k : 8;
        const lanes d = lanes_sub(lanes_load_first(x + k, there), from), v = lanes_load_first(f + k, there);
        f0 = lanes_add(f0, v);
        f1 = lanes_fma(d, v, f1);
    }
    sums[0] += lanes_sum(f0);
    sums[1] += lanes_sum(f1);
}

#endif
