/* Sums over the samples of a run: of d = x - origin and of a column f, while only one cell moves. */
#include <float.h>
#include <math.h>

#include "kernels.h"
#include "lanes.h"

/* Bounds of one sample after another; the monotone ones follow the samples. */
typedef struct bounds {
    lanes low, high, rise, fall, before;
} bounds;

static inline bounds bounds_of(const engine_window *w)
{
    const bounds b = {lanes_all(w->low), lanes_all(w->high), lanes_all(w->monotone > 0 ? 0.0 : -INFINITY),
                      lanes_all(w->monotone < 0 ? 0.0 : INFINITY), lanes_all(w->last)};
    return b;
}

/* How many of eight samples belong to the run, from the first on. */
static inline int inside(bounds *b, lanes x, unsigned begin)
{
    const lanes before = lanes_shift(x, b->before);
    const lanes low = lanes_max(b->low, lanes_add(before, b->rise)), high = lanes_min(b->high, lanes_add(before, b->fall));
    b->before = x;
    const unsigned mask = (lanes_le(low, x) & lanes_le(x, high)) | begin;
    return __builtin_ctz(~mask);
}

int64_t LANES_NAME(engine_run)(int64_t samples, const double *x, const double *f, const engine_window *window, double *sums);
int64_t LANES_NAME(engine_scan)(int64_t samples, const double *x, const engine_window *window);
void LANES_NAME(engine_moments)(int64_t samples, const double *x, const double *f, double origin, double *sums);
void LANES_NAME(engine_add_to_rows)(int64_t n, const double *from, double factor_1, double *row_1, double factor_2,
                                    double *row_2);
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high);

/* Samples from the first on that lie in the window; adds their sums of d, d^2, f, d f to sums. */
int64_t LANES_NAME(engine_run)(int64_t samples, const double *x, const double *f, const engine_window *window, double *sums)
{
    bounds b = bounds_of(window);
    const lanes origin = lanes_all(window->origin);
    lanes s1 = lanes_all(0.0), s2 = s1, f1 = s1, fd = s1;
    unsigned begin = (unsigned)window->begin;
    int64_t k = 0;
    int count = 8;
    while (count == 8 && k < samples) {
        const int there = samples - k < 8 ? (int)(samples - k) : 8;
        lanes u = there == 8 ? lanes_load(x + k) : lanes_load_first(x + k, there);
        lanes v = there == 8 ? lanes_load(f + k) : lanes_load_first(f + k, there);
        count = inside(&b, u, begin);
        count = count < there ? count : there;
        u = lanes_sub(u, origin);
        if (count < 8) {
            u = lanes_keep(u, count);
            v = lanes_keep(v, count);
        }
        s1 = lanes_add(s1, u);
        s2 = lanes_fma(u, u, s2);
        f1 = lanes_add(f1, v);
        fd = lanes_fma(u, v, fd);
        k += count;
        begin = 0;
    }
    sums[0] += lanes_sum(s1);
    sums[1] += lanes_sum(s2);
    sums[2] += lanes_sum(f1);
    sums[3] += lanes_sum(fd);
    return k;
}

/* Number of samples from the first on that lie in the window. */
int64_t LANES_NAME(engine_scan)(int64_t samples, const double *x, const engine_window *window)
{
    bounds b = bounds_of(window);
    unsigned begin = (unsigned)window->begin;
    int64_t k = 0;
    while (k < samples) {
        const int there = samples - k < 8 ? (int)(samples - k) : 8;
        const lanes u = there == 8 ? lanes_load(x + k) : lanes_load_first(x + k, there);
        int count = inside(&b, u, begin);
        count = count < there ? count : there;
        k += count;
        begin = 0;
        if (count < 8) {
            break;
        }
    }
    return k;
}

/* Adds sum f, sum d f and sum d^2 f to sums. */
void LANES_NAME(engine_moments)(int64_t samples, const double *x, const double *f, double origin, double *sums)
{
    const lanes from = lanes_all(origin);
    lanes f0 = lanes_all(0.0), f1 = f0, f2 = f0;
    for (int64_t k = 0; k < samples; k += 8) {
        const int there = samples - k < 8 ? (int)(samples - k) : 8;
        const lanes d = lanes_sub(there == 8 ? lanes_load(x + k) : lanes_load_first(x + k, there), from);
        const lanes v = there == 8 ? lanes_load(f + k) : lanes_load_first(f + k, there);
        const lanes moving = lanes_mul(d, v);
        f0 = lanes_add(f0, v);
        f1 = lanes_add(f1, moving);
        f2 = lanes_fma(d, moving, f2);
    }
    sums[0] += lanes_sum(f0);
    sums[1] += lanes_sum(f1);
    sums[2] += lanes_sum(f2);
}

/* row_1 += factor_1 from, row_2 += factor_2 from; n is rounded up to a multiple of 8, which all three have. */
void LANES_NAME(engine_add_to_rows)(int64_t n, const double *from, double factor_1, double *row_1, double factor_2,
                                    double *row_2)
{
    const lanes a = lanes_all(factor_1), b = lanes_all(factor_2);
    for (int64_t k = 0; k < n; k += 8) {
        const lanes u = lanes_load(from + k);
        lanes_store(row_1 + k, lanes_fma(a, u, lanes_load(row_1 + k)));
        lanes_store(row_2 + k, lanes_fma(b, u, lanes_load(row_2 + k)));
    }
}

/* Number of samples from the first on with low <= x <= high: NaN is not. */
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high)
{
    const lanes l = lanes_all(low), h = lanes_all(high);
    int64_t k = 0;
    for (; k + 8 <= samples; k += 8) {
        const lanes u = lanes_load(x + k);
        if ((lanes_le(l, u) & lanes_le(u, h)) != 255) {
            break;
        }
    }
    while (k < samples && x[k] >= low && x[k] <= high) {
        ++k;
    }
    return k;
}
