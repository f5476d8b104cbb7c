/* The elements are those of core/elements.c, term by term and in its order, so that every rounding is the same. */
#include "element_walk.h"

#include <math.h>

/* Newton's method is the core's own text, on the sum below. */
#define dehyst_elements_value walk_value
#define dehyst_elements_solve walk_solve
double walk_value(const dehyst_elements *sum, const dehyst_elements_state *state, const double *share, double x,
                  int rising, double *slope);
double walk_solve(const dehyst_elements *sum, dehyst_elements_state *state, const double *share, double value);
#include "element_inverse.c"

#define INLINE static inline __attribute__((always_inline))

/* An element: its value, its memory afterwards, and its slope with an input that goes up, or down. */
typedef struct reading {
    double value, memory, slope;
} reading;

INLINE reading dragged(double z, double x, double reach, int rising, double low, double high)
{
    const double from = x - reach, to = x + reach;
    reading t;
    t.value = z < to ? z : to;
    t.value = t.value > from ? t.value : from;
    t.memory = t.value;
    t.slope = rising ? (z <= from ? low : 0.0) + (z > to ? high : 0.0) : (z < from ? low : 0.0) + (z >= to ? high : 0.0);
    return t;
}

INLINE reading along(double z, double way, double length, int rising)
{
    const double end = way < 0 ? -length : length, parts = (way < 0 ? -way : way) / length;
    const double left = dehyst_decay(parts), s = 0.125 * parts;
    const double first = 1 + s * (1 + s * (0.5 + s * (1.0 / 6.0))), last = s * s * s * s * (1.0 / 24.0);
    const int up = way > 0 || (rising && !(way < 0));
    const double value = end + left * (z - end);
    return (reading){value, value, left * (first / (first + last)) * (up ? 1 - z / length : 1 + z / length)};
}

INLINE reading element_at(const dehyst_element *q, const double *held, double x, double way, int rising)
{
    const double z = *held;
    reading e = {x, x, 1};
    if (q->kind == DEHYST_PLAY) {
        return dragged(z, x, q->radius, rising, 1, 1);
    }
    switch (q->kind) {
    case DEHYST_STOP:
        e = dragged(z, x, q->radius, rising, 1, 1);
        e.value = x - e.value;
        e.slope = 1 - e.slope;
        break;
    case DEHYST_CREEP:
        e = dragged(z, x, q->radius, rising, q->gain, q->gain);
        e.value = e.memory = z + q->gain * (e.value - z);
        break;
    case DEHYST_RELAX:
        e = dragged(z, x, q->radius, rising, 1, 1);
        e = (reading){x - z, z + q->gain * (e.value - z), 1};
        break;
    case DEHYST_PAST:
        e = dragged(z, x, q->radius, rising, 1, 1);
        e = (reading){z, z + q->gain * (e.value - z), 0};
        break;
    case DEHYST_PATH:
        e = along(z, way, q->radius, rising);
        break;
    case DEHYST_WIDE: {
        const double growth = way > 0 || (rising && !(way < 0)) ? q->gain : -q->gain;
        e = dragged(z, x, q->radius + q->gain * (way < 0 ? -way : way), rising, 1 - growth, 1 + growth);
        break;
    }
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

INLINE int holds(const walk_piece *p, double value, int rising)
{
    return rising ? p->low <= value && value < p->high : p->low < value && value <= p->high;
}

/* f(e); the piece is looked for only where the last one is left. */
INLINE reading through(const element_walk *walk, int32_t k, reading e, int rising)
{
    const int32_t pieces = walk->sum.element[k].map.n - 1;
    if (pieces < 1) {
        return e;
    }
    const walk_piece *const all = walk->piece + walk->first[k], *p = all + walk->at[k];
    if (!holds(p, e.value, rising)) {
        int32_t left = 0;
        for (int32_t count = pieces; count > 1;) {
            const int32_t half = count / 2;
            const double low = all[left + half].low;
            left = (rising ? low <= e.value : low < e.value) ? left + half : left;
            count -= half;
        }
        walk->at[k] = left;
        p = all + left;
    }
    const double past = e.value - p->u[0], ahead = p->u[1] - e.value;
    e.value = past <= ahead ? p->v[0] + p->slope * past : p->v[1] - p->slope * ahead;
    e.slope *= p->slope;
    return e;
}

void walk_pieces(const dehyst_map *map, walk_piece *piece)
{
    const int32_t n = map->n;
    for (int32_t k = 0; k + 1 < n; ++k) {
        const double *u = map->u + k, *v = map->v + k;
        piece[k] = (walk_piece){k > 0 ? u[0] : -HUGE_VAL, k + 2 < n ? u[1] : HUGE_VAL, {u[0], u[1]}, {v[0], v[1]},
                                (v[1] - v[0]) / (u[1] - u[0])};
    }
}

INLINE double total(const element_walk *walk, const dehyst_elements_state *state, const double *share, double x,
                    int rising, double *slope)
{
    const dehyst_element *q = walk->sum.element;
    const double way = x - state->last;
    double value = walk->sum.offset, steep = 0;
    for (int32_t k = 0; k < walk->sum.n; ++k) {
        const reading f = through(walk, k, element_at(&q[k], &state->z[k], x, way, rising), rising);
        const double weight = share[q[k].schedule] * q[k].weight;
        value += weight * f.value;
        steep += weight * f.slope;
    }
    *slope = steep;
    return value;
}

double walk_value(const dehyst_elements *sum, const dehyst_elements_state *state, const double *share, double x,
                  int rising, double *slope)
{
    const element_walk *walk = (const element_walk *)sum; /* of which it is the first member */
    return rising ? total(walk, state, share, x, 1, slope) : total(walk, state, share, x, 0, slope);
}

static double follow(const element_walk *walk, dehyst_elements_state *state, const double *share, double x)
{
    const dehyst_element *q = walk->sum.element;
    const double way = x - state->last;
    double *z = state->z;
    double value = walk->sum.offset;
    for (int32_t k = 0; k < walk->sum.n; ++k) {
        const reading e = element_at(&q[k], &z[k], x, way, 1);
        value += share[q[k].schedule] * q[k].weight * through(walk, k, e, 1).value;
        z[k] = e.memory;
    }
    state->step = way;
    state->last = x;
    return value;
}

/* As in the core: 1 if a sample, what the map makes of it, and the scheduling variables are good. */
static int takes(const dehyst_elements *sum, const dehyst_map *map, dehyst_elements_state *state, double *sample,
                 const double *given)
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

double walk_step(const element_walk *walk, dehyst_elements_state *state, double u, const double *given)
{
    const dehyst_elements *sum = &walk->sum;
    double share[DEHYST_SHARES], x = u;
    if (takes(sum, &sum->before, state, &x, given)) {
        dehyst_elements_shares(sum, state, given, share);
        state->output = dehyst_map_value(&sum->after, follow(walk, state, share, x));
    }
    return state->output;
}

double walk_solve_step(const element_walk *walk, dehyst_elements_state *state, double y, const double *given)
{
    const dehyst_elements *sum = &walk->sum;
    const dehyst_map before = {sum->before.n, sum->before.v, sum->before.u};
    const dehyst_map after = {sum->after.n, sum->after.v, sum->after.u};
    double share[DEHYST_SHARES], value = y;
    if (takes(sum, &after, state, &value, given)) {
        dehyst_elements_shares(sum, state, given, share);
        const double x = walk_solve(sum, state, share, value);
        const int limited = x <= sum->low || x >= sum->high;
        state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
        state->output = dehyst_map_value(&before, x);
        dehyst_elements_advance(sum, state, x);
    }
    return state->output;
}
