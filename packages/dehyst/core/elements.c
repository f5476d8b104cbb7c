#include "dehyst.h"

/* An element at an input x: its value, its memory after x, and its slope with an input that goes up from x, or down. */
typedef struct reading {
    dehyst_real value, memory, slope;
} reading;

/* z between two edges `reach` from x that drag it along, with the slope `low` or `high` of the edge that it meets. At
 * an edge it is met by an input that goes on, and not by one that turns. */
static inline reading dragged(dehyst_real z, dehyst_real x, dehyst_real reach, int rising, dehyst_real low,
                              dehyst_real high)
{
    const dehyst_real from = x - reach;
    const dehyst_real to = x + reach;
    reading t;
    t.value = z < to ? z : to;
    t.value = t.value > from ? t.value : from;
    t.memory = t.value;
    if (rising) {
        t.slope = (z <= from ? low : (dehyst_real)0) + (z > to ? high : (dehyst_real)0);
    } else {
        t.slope = (z < from ? low : (dehyst_real)0) + (z >= to ? high : (dehyst_real)0);
    }
    return t;
}

/* A radius that grows with the way makes the edge in front slower than the input, and the one behind faster. */
static inline reading widened(const dehyst_element *q, dehyst_real z, dehyst_real x, dehyst_real way, int rising)
{
    const int ahead = way > 0 || (rising && !(way < 0));
    const dehyst_real growth = ahead ? q->gain : -q->gain;
    return dragged(z, x, q->radius + q->gain * (way < 0 ? -way : way), rising, 1 - growth, 1 + growth);
}

/* Dahl's lag. The decay is 1/S(s)^8, s an eighth of its argument, so its slope is that of exp times S'/S. */
static inline reading along(dehyst_real z, dehyst_real way, dehyst_real length, int rising)
{
    const dehyst_real end = way < 0 ? -length : length; /* where a long way in this direction leads */
    const dehyst_real parts = (way < 0 ? -way : way) / length;
    const dehyst_real left = dehyst_decay(parts);
    const dehyst_real s = (dehyst_real)0.125 * parts;
    const dehyst_real first = 1 + s * (1 + s * ((dehyst_real)0.5 + s * (dehyst_real)(1.0 / 6.0)));
    const dehyst_real last = s * s * s * s * (dehyst_real)(1.0 / 24.0);
    const int up = way > 0 || (rising && !(way < 0));
    reading e;
    e.value = end + left * (z - end);
    e.memory = e.value;
    e.slope = left * (first / (first + last)) * (up ? 1 - z / length : 1 + z / length);
    return e;
}

/* `held` is the memory from this element on: a product reads that of the next one, too. */
static inline reading element_at(const dehyst_element *q, const dehyst_real *held, dehyst_real x, dehyst_real way,
                                 int rising)
{
    const dehyst_real z = *held;
    reading e = {x, x, 1};
    switch (q->kind) {
    case DEHYST_PLAY:
        e = dragged(z, x, q->radius, rising, 1, 1);
        break;
    case DEHYST_STOP:
        e = dragged(z, x, q->radius, rising, 1, 1);
        e.value = x - e.value;
        e.slope = 1 - e.slope;
        break;
    case DEHYST_CREEP:
        e = dragged(z, x, q->radius, rising, q->gain, q->gain);
        e.value = z + q->gain * (e.value - z);
        e.memory = e.value;
        break;
    case DEHYST_RELAX:
        e = dragged(z, x, q->radius, rising, 1, 1);
        e.memory = z + q->gain * (e.value - z);
        e.value = x - z;
        e.slope = 1;
        break;
    case DEHYST_PAST:
        e = dragged(z, x, q->radius, rising, 1, 1);
        e.memory = z + q->gain * (e.value - z);
        e.value = z;
        e.slope = 0;
        break;
    case DEHYST_PATH:
        e = along(z, way, q->radius, rising);
        break;
    case DEHYST_WIDE:
        e = widened(q, z, x, way, rising);
        break;
    case DEHYST_PRODUCT:
        e.memory = z + (q->gain * (x - z));
        e.value = dehyst_within(z, -q->radius, q->radius) * dehyst_within(held[1], -q->radius, q->radius);
        e.slope = 0;
        break;
    default: /* the input itself */
        break;
    }
    return e;
}

/* f(e): piecewise linear, computed from the nearer end of a piece, so that pieces meet exactly. */
static inline reading through(const dehyst_map *map, reading e, int rising)
{
    int32_t left = 0;
    for (int32_t count = map->n - 1; count > 1;) { /* the piece is one of `count` from `left` on */
        const int32_t half = count / 2;
        const dehyst_real u = map->u[left + half];
        left = (rising ? u <= e.value : u < e.value) ? left + half : left;
        count -= half;
    }
    const dehyst_real *u = &map->u[left];
    const dehyst_real *v = &map->v[left];
    const dehyst_real past = e.value - u[0];
    const dehyst_real ahead = u[1] - e.value;
    const dehyst_real slope = (v[1] - v[0]) / (u[1] - u[0]);
    e.value = past <= ahead ? v[0] + slope * past : v[1] - slope * ahead;
    e.slope *= slope;
    return e;
}

/* w f(e), without h. */
static inline reading term_at(const dehyst_element *q, const dehyst_real *held, dehyst_real x, dehyst_real way,
                              int rising)
{
    const reading e = element_at(q, held, x, way, rising);
    return q->map.n < 2 ? e : through(&q->map, e, rising);
}

void dehyst_elements_reset(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real x, dehyst_real output)
{
    for (int32_t k = 0; k < sum->n; ++k) {
        state->z[k] = sum->element[k].kind == DEHYST_PATH ? (dehyst_real)0 : x;
    }
    state->last = x;
    state->output = output;
    state->step = 0;
    state->rounds = 0;
    state->flags = 0;
}

void dehyst_elements_shares(const dehyst_elements *sum, const dehyst_elements_state *state, const dehyst_real *given,
                            dehyst_real share[DEHYST_SHARES])
{
    share[0] = 1;
    for (int32_t v = 0; v < sum->schedules; ++v) {
        const dehyst_real sigma = sum->source[v] == DEHYST_BY_OUTPUT ? state->last : given[sum->source[v]];
        const dehyst_real inside = dehyst_within(sigma, sum->schedule_low[v], sum->schedule_high[v]);
        share[2 * v + 2] = (inside - sum->schedule_low[v]) / (sum->schedule_high[v] - sum->schedule_low[v]);
        share[2 * v + 1] = 1 - share[2 * v + 2];
    }
}

static inline dehyst_real total(const dehyst_elements *sum, const dehyst_elements_state *state,
                                const dehyst_real *share, dehyst_real x, int rising, dehyst_real *slope)
{
    const dehyst_element *q = sum->element;
    const dehyst_real *z = state->z;
    const dehyst_real way = x - state->last;
    dehyst_real value = sum->offset;
    dehyst_real steep = 0;
    for (int32_t k = 0; k < sum->n; ++k) {
        const reading f = term_at(&q[k], &z[k], x, way, rising);
        const dehyst_real weight = share[q[k].schedule] * q[k].weight;
        value += weight * f.value;
        steep += weight * f.slope;
    }
    *slope = steep;
    return value;
}

dehyst_real dehyst_elements_value(const dehyst_elements *sum, const dehyst_elements_state *state,
                                  const dehyst_real *share, dehyst_real x, int rising, dehyst_real *slope)
{
    return rising ? total(sum, state, share, x, 1, slope) : total(sum, state, share, x, 0, slope);
}

static inline void moved(dehyst_elements_state *state, dehyst_real x)
{
    state->step = x - state->last;
    state->last = x;
}

dehyst_real dehyst_elements_follow(const dehyst_elements *sum, dehyst_elements_state *state, const dehyst_real *share,
                                   dehyst_real x)
{
    const dehyst_element *q = sum->element;
    dehyst_real *z = state->z;
    dehyst_real value = sum->offset;
    for (int32_t k = 0; k < sum->n; ++k) {
        const reading f = term_at(&q[k], &z[k], x, x - state->last, 1);
        value += share[q[k].schedule] * q[k].weight * f.value;
        z[k] = f.memory;
    }
    moved(state, x);
    return value;
}

void dehyst_elements_columns(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real x,
                             dehyst_real *column)
{
    for (int32_t k = 0; k < sum->n; ++k) {
        const reading e = element_at(&sum->element[k], &state->z[k], x, x - state->last, 1);
        column[k] = e.value;
        state->z[k] = e.memory;
    }
    moved(state, x);
}

void dehyst_elements_advance(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real x)
{
    const dehyst_element *q = sum->element;
    dehyst_real *z = state->z;
    const dehyst_real way = x - state->last;
    for (int32_t k = 0; k < sum->n; ++k) {
        z[k] = element_at(&q[k], &z[k], x, way, 1).memory;
    }
    moved(state, x);
}

/* 1 if a sample and the scheduling variables are good and what the map makes of the sample is; flags say it. */
static int takes(const dehyst_elements *sum, const dehyst_map *map, dehyst_elements_state *state, dehyst_real *sample,
                 const dehyst_real *given)
{
    int good = dehyst_accept(*sample);
    for (int32_t v = 0; v < sum->schedules; ++v) {
        good = good && (sum->source[v] == DEHYST_BY_OUTPUT || dehyst_accept(given[sum->source[v]]));
    }
    if (good) {
        *sample = dehyst_map_value(map, *sample);
        good = dehyst_accept(*sample);
    }
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    state->flags |= good ? 0u : (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
    return good;
}

dehyst_real dehyst_elements_step(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real u,
                                 const dehyst_real *given)
{
    dehyst_real share[DEHYST_SHARES];
    dehyst_real x = u;
    if (takes(sum, &sum->before, state, &x, given)) {
        dehyst_elements_shares(sum, state, given, share);
        state->output = dehyst_map_value(&sum->after, dehyst_elements_follow(sum, state, share, x));
    }
    return state->output;
}

static dehyst_map swapped(const dehyst_map *map)
{
    const dehyst_map back = {map->n, map->v, map->u};
    return back;
}

dehyst_real dehyst_elements_solve_step(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real y,
                                       const dehyst_real *given)
{
    const dehyst_map before = swapped(&sum->before);
    const dehyst_map after = swapped(&sum->after);
    dehyst_real share[DEHYST_SHARES];
    dehyst_real value = y;
    if (takes(sum, &after, state, &value, given)) {
        dehyst_elements_shares(sum, state, given, share);
        const dehyst_real x = dehyst_elements_solve(sum, state, share, value);
        const int limited = x <= sum->low || x >= sum->high;
        state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
        state->output = dehyst_map_value(&before, x);
        dehyst_elements_advance(sum, state, x);
    }
    return state->output;
}

dehyst_real dehyst_delay_step(dehyst_delay *delay, dehyst_real x)
{
    if (delay->n == 0) {
        return x;
    }
    const dehyst_real old = delay->ring[delay->at];
    delay->ring[delay->at] = x;
    delay->at = delay->at + 1 < delay->n ? delay->at + 1 : 0;
    return old;
}
