/* Evaluation by events: one line of arithmetic a sample between them. */
#include "dehyst.h"
#include "kernels.h"
#include "lanes.h"
#include "machine.h"

int64_t LANES_NAME(engine_events)(machine *m, int64_t samples, const double *x, double *y, double center, int stream);

enum { FREE, RISING, FALLING };
enum {
    FAR = 12,         /* samples between events from which on each is followed by eight at once */
    PATIENCE = 8,     /* samples without an event after which eight at once pay */
    AHEAD = 512,      /* samples that are fetched ahead: a branch that was not foreseen waits for what it looked at */
    STREAM_AFTER = 32 /* samples of a line after which its outputs go past the caches */
};

/* 1 if u, after `last`, is within the window and, off a single operator, does not turn. */
static inline __attribute__((always_inline)) int on_line(int way, double low, double high, double last, double u)
{
    return way == RISING ? last <= u && u <= high : way == FALLING ? low <= u && u <= last : low <= u && u <= high;
}

/* Samples [k, ...) on the present line. `last` is the sample before k, and the last one on the line on return. y is written
 * up to eight samples beyond the line. */
static inline __attribute__((always_inline)) int64_t line(int way, int stream, const machine *m, int64_t k, int64_t samples,
                                                          const double *x, double *y, double center, double *last)
{
    const double base = m->base, gain = m->gain, origin = m->origin, low = m->stack.low, high = m->stack.high;
    const lanes bases = lanes_all(base), gains = lanes_all(gain), origins = lanes_all(origin), lows = lanes_all(low),
                highs = lanes_all(high), centers = lanes_all(center);
    int64_t singly = k + 1; /* the sample before eight must be on the line */
    int past = 0;           /* 1: store past the caches, to multiples of 64 bytes */
    for (;;) {
        for (; k < singly; ++k) {
            const double u = x[k] - center;
            if (!on_line(way, low, high, *last, u)) {
                return k;
            }
            y[k] = lanes_fma_one(gain, u - origin, base);
            *last = u;
        }
        const int64_t pause = stream && !past && k + STREAM_AFTER < samples ? k + STREAM_AFTER : samples;
        for (; k + 8 <= pause; k += 8) {
            __builtin_prefetch(x + k + AHEAD);
            const lanes now = lanes_sub(lanes_load(x + k), centers);
            const lanes before = lanes_sub(lanes_load(x + k - 1), centers);
            const unsigned on = way == RISING    ? lanes_le(before, now) & lanes_le(now, highs)
                                : way == FALLING ? lanes_le(now, before) & lanes_le(lows, now)
                                                 : lanes_le(lows, now) & lanes_le(now, highs);
            const lanes out = lanes_fma(gains, lanes_sub(now, origins), bases);
            if (on != 0xff) {
                lanes_store(y + k, out);
                k += __builtin_ctz(~on);
                *last = x[k - 1] - center;
                return k;
            }
            if (past) {
                lanes_stream(y + k, out);
            } else {
                lanes_store(y + k, out);
            }
        }
        *last = x[k - 1] - center;
        if (k == samples) {
            return k;
        }
        if (pause == samples) { /* less than eight are left */
            singly = samples;
        } else {
            singly = k + (int64_t)((64 - ((uintptr_t)(y + k) & 63)) & 63) / 8;
            singly = singly < samples ? singly : samples;
            past = 1;
        }
    }
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
        __builtin_prefetch(x + k + AHEAD);
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
    while (k < samples) {
        const stack_segment *top = &m->stack.segment[m->stack.top];
        k = top->b == 1   ? line(FREE, stream, m, k, samples, x, y, center, &last)
            : top->s > 0  ? line(RISING, stream, m, k, samples, x, y, center, &last)
                          : line(FALLING, stream, m, k, samples, x, y, center, &last);
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
        event = k;
    }
    m->stack.segment[m->stack.top].e = last;
    if (stream) {
        lanes_fence();
    }
    return rejected;
}
