/* Evaluation by events: one line of arithmetic a sample between them. */
#include "dehyst.h"
#include "kernels.h"
#include "lanes.h"
#include "machine.h"

int64_t LANES_NAME(engine_events)(machine *m, int64_t samples, const double *x, double *y, double center, int stream);

void LANES_NAME(engine_fence)(void);

enum { FREE, RISING, FALLING };
enum {
    FAR = 6,         /* samples between events from which on each is followed by eight at once */
    PATIENCE = 8,     /* samples without an event after which eight at once pay */
    AHEAD = 4096,     /* samples that are fetched ahead: a branch that was not foreseen waits for what it looked at */
    STREAM_FAR = 64   /* samples between events from which on outputs of the next line go past the caches */
};

/* 1 if u, after `last`, is within the window and, off a single operator, does not turn. */
static inline __attribute__((always_inline)) int on_line(int way, double low, double high, double last, double u)
{
    return way == RISING ? last <= u && u <= high : way == FALLING ? low <= u && u <= last : low <= u && u <= high;
}

/* What a line needs, in registers. */
typedef struct straight {
    lanes base, gain, origin, low, high, center;
} straight;

/* Outputs of eight samples from x on, and bits of those on the line. */
static inline __attribute__((always_inline)) lanes eight(int way, const straight *l, const double *x, unsigned *on)
{
    const lanes now = lanes_sub(lanes_load(x), l->center), before = lanes_sub(lanes_load(x - 1), l->center);
    *on = way == RISING    ? lanes_le(before, now) & lanes_le(now, l->high)
          : way == FALLING ? lanes_le(now, before) & lanes_le(l->low, now)
                           : lanes_le(l->low, now) & lanes_le(now, l->high);
    return lanes_fma(l->gain, lanes_sub(now, l->origin), l->base);
}

/* Samples [k, ...) on the present line. `last` is the sample before k, and the last one on the line on return. y is written
 * up to eight samples beyond the line; with `stream` past the caches, to multiples of 64 bytes. */
static inline __attribute__((always_inline)) int64_t line(int way, int stream, const machine *m, int64_t k, int64_t samples,
                                                          const double *x, double *y, double center, double *last)
{
    const double low = m->stack.low, high = m->stack.high;
    double u = x[k] - center;
    if (!on_line(way, low, high, *last, u)) {
        return k;
    }
    y[k] = lanes_fma_one(m->gain, u - m->origin, m->base);
    *last = u;
    ++k;
    const straight l = {lanes_all(m->base), lanes_all(m->gain), lanes_all(m->origin),
                        lanes_all(low),     lanes_all(high),    lanes_all(center)};
    unsigned on = 0xff;
    if (stream && k + 8 <= samples) {
        const int some = (int)((64 - ((uintptr_t)(y + k) & 63)) & 63) / 8;
        const lanes out = eight(way, &l, x + k, &on);
        lanes_store_some(y + k, out, some);
        on = (on | 0xffu << some) & 0xff;
        k += on == 0xff ? some : __builtin_ctz(~on);
    }
    while (on == 0xff && k + 8 <= samples) {
        __builtin_prefetch(x + k + AHEAD, 0, 2);
        const lanes out = eight(way, &l, x + k, &on);
        if (on != 0xff || !stream) {
            lanes_store(y + k, out);
        } else {
            lanes_stream(y + k, out);
        }
        k += on == 0xff ? 8 : __builtin_ctz(~on);
    }
    *last = x[k - 1] - center;
    if (on != 0xff) {
        return k;
    }
    for (; k < samples; ++k) {
        u = x[k] - center;
        if (!on_line(way, low, high, *last, u)) {
            break;
        }
        y[k] = lanes_fma_one(m->gain, u - m->origin, m->base);
        *last = u;
    }
    return k;
}

/* Samples [k, ...) while x goes on in direction `sign` and the boundary moves on within the segment below, one or a few
 * operators at a time: machine_event without what cannot happen there. Leaves `patience` samples after the last event. */
static inline __attribute__((always_inline)) int64_t crawl(double sign, machine *m, int64_t k, int64_t samples,
                                                           const double *x, double *y, double center, double *last, int64_t patience)
{
    stack *const stacked = &m->stack;
    const int32_t q = stacked->top - 1;
    if (q == 0 && !m->grid.rest_is_flat) {
        return k;
    }
    stack_segment *const top = &stacked->segment[q + 1];
    const stack_segment below = stacked->segment[q];
    if (below.s == sign) {
        return k;
    }
    const double *const r = m->grid.r;
    const double frozen = m->frozen[q], shift = m->phi[below.b - 1], share = below.s == 0 ? 1.0 : 0.5;
    double edge = sign > 0 ? stacked->high : stacked->low, base = m->base, gain = m->gain, origin = m->origin, u = *last;
    int32_t b = top->b;
    const int64_t start = m->events;
    int64_t patient = k + patience;
    for (; k < samples && k < patient; ++k) {
        __builtin_prefetch(x + k + AHEAD, 0, 2);
        const double next = x[k] - center;
        if (sign > 0 ? !(next >= u) : !(next <= u)) {
            break;
        }
        if (sign > 0 ? next > edge : next < edge) {
            if (!(__builtin_fabs(next) <= m->grid.limit)) {
                break;
            }
            const double value = share * (sign * (next - below.e));
            int32_t to = b;
            while (to < below.b && r[to] < value && to < b + 3) {
                ++to;
            }
            if (to == below.b || (to == b + 3 && r[to] < value)) {
                break;
            }
            b = to;
            const double z = below.e - below.s * r[b], ahead = z + sign * r[b];
            edge = sign > 0 ? (ahead < m->grid.limit ? ahead : m->grid.limit)
                            : (ahead > -m->grid.limit ? ahead : -m->grid.limit);
            m->above = frozen + below.s * (shift - m->phi[b]);
            base = (sign * m->phi[b - 1] + m->above) + m->offset;
            gain = m->slope[b - 1];
            origin = sign * r[b - 1] + z;
            ++m->events;
            ++m->depth[(b - 1) >> 3];
            patient = k + patience;
        }
        u = next;
        y[k] = lanes_fma_one(gain, u - origin, base);
    }
    if (m->events != start) {
        m->crawled += m->events - start;
        top->e = u;
        top->b = b;
        m->base = base;
        m->gain = gain;
        m->origin = origin;
        stacked->low = sign > 0 ? u : edge;
        stacked->high = sign > 0 ? edge : u;
    }
    *last = u;
    return k;
}

/* y (samples,) of x (samples,), which do not overlap; returns the number of rejected samples. */
int64_t LANES_NAME(engine_events)(machine *m, int64_t samples, const double *x, double *y, double center, int stream)
{
    int64_t k = 0, rejected = 0, event = -FAR;
    double last = m->stack.segment[m->stack.top].e;
    int64_t gap = samples; /* between the last two events */
    while (k < samples) {
        const int past = stream && gap >= STREAM_FAR;
        const stack_segment *top = &m->stack.segment[m->stack.top];
        k = top->b == 1   ? line(FREE, past, m, k, samples, x, y, center, &last)
            : top->s > 0  ? line(RISING, past, m, k, samples, x, y, center, &last)
                          : line(FALLING, past, m, k, samples, x, y, center, &last);
        if (k == samples) {
            break;
        }
        top = &m->stack.segment[m->stack.top];
        if (top->b > 1) { /* no turn: the boundary moves on */
            const int64_t from = k;
            if (top->s > 0 && x[k] - center > last) {
                k = crawl(1.0, m, k, samples, x, y, center, &last, k - event > FAR ? 1 : PATIENCE);
            } else if (top->s < 0 && x[k] - center < last) {
                k = crawl(-1.0, m, k, samples, x, y, center, &last, k - event > FAR ? 1 : PATIENCE);
            }
            if (k > from) {
                gap = from - event;
                event = k;
                continue;
            }
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
        gap = k - event;
        event = k;
    }
    m->stack.segment[m->stack.top].e = last;
    return rejected;
}

void LANES_NAME(engine_fence)(void) { lanes_fence(); }
