/* Evaluation by events: one line of arithmetic a sample between them. */
#include "dehyst.h"
#include "kernels.h"
#include "lanes.h"
#include "machine.h"

int64_t LANES_NAME(engine_events)(machine *m, int64_t samples, const double *x, double *y, double center);

enum { FREE, RISING, FALLING };

/* Samples [k, ...) on the present line: within the window and, off a single operator, not turning. `last` is the sample
 * before k, and the last one on the line on return. y is written up to eight samples beyond the line. */
static inline __attribute__((always_inline)) int64_t line(int way, const machine *m, int64_t k, int64_t samples,
                                                          const double *x, double *y, double center, double *last)
{
    const double base = m->base, gain = m->gain, origin = m->origin, low = m->stack.low, high = m->stack.high;
    double u = x[k] - center;
    if (way == RISING ? !(*last <= u && u <= high) : way == FALLING ? !(low <= u && u <= *last) : !(low <= u && u <= high)) {
        return k;
    }
    y[k] = lanes_fma_one(gain, u - origin, base);
    ++k;
    const lanes bases = lanes_all(base), gains = lanes_all(gain), origins = lanes_all(origin), lows = lanes_all(low),
                highs = lanes_all(high), centers = lanes_all(center);
    while (k + 8 <= samples) {
        const lanes now = lanes_sub(lanes_load(x + k), centers);
        const lanes before = lanes_sub(lanes_load(x + k - 1), centers);
        lanes_store(y + k, lanes_fma(gains, lanes_sub(now, origins), bases));
        const unsigned on = way == RISING    ? lanes_le(before, now) & lanes_le(now, highs)
                            : way == FALLING ? lanes_le(now, before) & lanes_le(lows, now)
                                             : lanes_le(lows, now) & lanes_le(now, highs);
        if (on != 0xff) {
            k += __builtin_ctz(~on);
            *last = x[k - 1] - center;
            return k;
        }
        k += 8;
    }
    *last = x[k - 1] - center;
    for (; k < samples; ++k) {
        u = x[k] - center;
        if (way == RISING ? !(*last <= u && u <= high)
                          : way == FALLING ? !(low <= u && u <= *last) : !(low <= u && u <= high)) {
            return k;
        }
        y[k] = lanes_fma_one(gain, u - origin, base);
        *last = u;
    }
    return k;
}

/* y (samples,) of x (samples,), which do not overlap; returns the number of rejected samples. */
int64_t LANES_NAME(engine_events)(machine *m, int64_t samples, const double *x, double *y, double center)
{
    int64_t k = 0, rejected = 0;
    double last = m->stack.segment[m->stack.top].e;
    while (k < samples) {
        const stack_segment *top = &m->stack.segment[m->stack.top];
        k = top->b == 1   ? line(FREE, m, k, samples, x, y, center, &last)
            : top->s > 0  ? line(RISING, m, k, samples, x, y, center, &last)
                          : line(FALLING, m, k, samples, x, y, center, &last);
        if (k == samples) {
            break;
        }
        const double value = x[k];
        if (__builtin_fabs(value) <= DEHYST_INPUT_LIMIT) {
            m->stack.segment[m->stack.top].e = last;
            last = value - center;
            machine_event(m, last);
        } else { /* not a number, or out of bounds: hold */
            ++rejected;
        }
        y[k] = lanes_fma_one(m->gain, last - m->origin, m->base);
        ++k;
    }
    m->stack.segment[m->stack.top].e = last;
    return rejected;
}
