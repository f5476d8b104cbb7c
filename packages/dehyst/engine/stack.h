/* The state of all play operators as a stack of segments.
 *
 * With admissible states |z_i - z_{i+1}| <= r_{i+1} - r_i the sums z_i + r_i do not fall and z_i - r_i do not rise with i. So
 * a rising sample x drags exactly a prefix of the operators (those with x > z_i + r_i), which then hold z_i = x - r_i; a
 * falling one a prefix that then holds z_i = x + r_i. What is not overwritten stays: a stack of segments
 *   z_i = e - s r_i,   s = +1 dragged up, -1 dragged down,   top segment: operators [0, b), below it [b, b of the next), ...
 * whose lowest one is what the operators held in the beginning. Each segment owns an operator: n + 1 segments suffice.
 *
 * Operator 0 has r_0 = 0 (the caller adds one of weight 0 if there is none) and follows x. While the top segment owns
 * only it (b = 1), x may turn without consequence: noise below r_1 makes no events and no segments.
 */
#ifndef DEHYST_STACK_H
#define DEHYST_STACK_H

#include <stdint.h>

typedef struct stack_segment {
    double e;  /* turning point, or the present x for the top */
    double s;  /* +1, -1; 0 for the lowest */
    int32_t b; /* one past its last operator */
} stack_segment;

/* What does not change: thresholds and a table to find them by value. */
typedef struct stack_grid {
    int32_t n;
    const double *r;      /* (n,), r[0] = 0, strictly increasing */
    int32_t buckets;      /* of the guide, > 0 */
    const int32_t *guide; /* (buckets + 1,) operators with r < bucket / per_unit: where to begin a search */
    double per_unit;      /* buckets per unit of r */
    const double *rest;   /* (n,) states in the beginning */
    int rest_is_flat;     /* all of them equal rest[0] */
    double limit;         /* largest |x| */
} stack_grid;

typedef struct stack {
    int32_t top; /* index of the top segment, >= 1 */
    stack_segment *segment; /* (n + 2,) */
    int32_t depth; /* operators below which the last event changed nothing but e */
    double low, high; /* while low <= x <= high (and x goes on in direction s if b > 1) only the boundary cell moves */
} stack;

/* Operator i of segment q. */
static inline double stack_play(const stack_grid *g, const stack *k, int32_t q, int32_t i)
{
    return q == 0 ? g->rest[i] : k->segment[q].e - k->segment[q].s * g->r[i];
}

/* State of the operator just below the top segment's, 0 if there is none: the fixed end of the moving cell. */
static inline double stack_below(const stack_grid *g, const stack *k)
{
    const int32_t b = k->segment[k->top].b;
    return b == g->n ? 0.0 : stack_play(g, k, k->top - 1, b);
}

/* First operator in [from, to) with r_i >= value, or to. */
static inline int32_t stack_find(const stack_grid *g, int32_t from, int32_t to, double value)
{
    if (from >= to || g->r[from] >= value) {
        return from;
    }
    if (from + 1 >= to || g->r[from + 1] >= value) {
        return from + 1;
    }
    const double place = value * g->per_unit;
    int32_t i = place < g->buckets ? g->guide[(int32_t)place] : g->guide[g->buckets];
    i = i < from + 2 ? from + 2 : i;
    const int32_t near = i + 8; /* crowded thresholds share a place of the guide: gallop, then bisect */
    while (i < to && i < near && g->r[i] < value) {
        ++i;
    }
    if (i == near && i < to && g->r[i] < value) {
        int32_t low = i, high = i;
        for (int32_t step = 1; high < to && g->r[high] < value; step *= 2) {
            low = high;
            high = step < to - high ? high + step : to;
        }
        while (high - low > 1) {
            const int32_t middle = low + (high - low) / 2;
            if (g->r[middle] < value) {
                low = middle;
            } else {
                high = middle;
            }
        }
        i = high;
    }
    while (i > from + 2 && i <= to && g->r[i - 1] >= value) {
        --i; /* the guide was rounded up */
    }
    return i < to ? i : to;
}

/* First operator in [from, n) of the lowest segment that a sample x in direction sign does not move. */
static inline int32_t stack_find_rest(const stack_grid *g, int32_t from, double sign, double x)
{
    if (g->rest_is_flat) {
        return stack_find(g, from, g->n, sign * (x - g->rest[0]));
    }
    int32_t low = from - 1; /* moves (or is above) */
    int32_t high = from;
    for (int32_t step = 1; high < g->n && sign * (x - g->rest[high]) > g->r[high]; step *= 2) {
        low = high;
        high = step < g->n - high ? high + step : g->n;
    }
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        if (sign * (x - g->rest[middle]) > g->r[middle]) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return high;
}

/* The bounds between which only the moving cell moves. */
static inline void stack_window(const stack_grid *g, stack *k)
{
    const stack_segment *t = &k->segment[k->top];
    double up = g->limit, down = -g->limit;
    if (t->b < g->n) {
        const double z = stack_below(g, k), r = g->r[t->b];
        up = z + r < g->limit ? z + r : g->limit;
        down = z - r > -g->limit ? z - r : -g->limit;
    }
    if (t->b == 1) {
        k->low = down;
        k->high = up;
    } else if (t->s > 0) {
        k->low = t->e;
        k->high = up;
    } else {
        k->low = down;
        k->high = t->e;
    }
}

/* Direction of a sample that leaves the window or turns; the top's e is the sample before. Off a single operator that
 * decides alone: the bound ahead may be the limit's, not the operators'. */
static inline double stack_direction(const stack *k, double x)
{
    const stack_segment *t = &k->segment[k->top];
    if (t->b == 1) {
        return x > k->high ? 1.0 : -1.0;
    }
    return t->s > 0 ? (x < t->e ? -1.0 : 1.0) : (x > t->e ? 1.0 : -1.0);
}

/* Put x on the stack: an event. The top's e must be the sample before x. The sample counts as put whatever rounding says, so
 * that an event always ends. The window is renewed. */
static inline void stack_event(const stack_grid *g, stack *k, double x)
{
    const double sign = stack_direction(k, x);
    int32_t b = k->segment[k->top].b;
    if (b > 1 && k->segment[k->top].s != sign) { /* turned: the old top keeps [1, b), operator 0 leaves it */
        ++k->top;
        b = 1;
    }
    int32_t joined = 0, joined_at = 0; /* segment of the same sign that went on */
    while (b < g->n) {
        const int32_t q = k->top - 1;
        if (q == 0) {
            b = stack_find_rest(g, b, sign, x);
            break;
        }
        const stack_segment *below = &k->segment[q];
        const double way = sign * (x - below->e);
        int32_t first;
        if (below->s == sign) { /* 0 * r_i: all of its operators move, or none */
            first = way > 0 ? below->b : b;
            joined = first;
            joined_at = b;
        } else {
            first = stack_find(g, b, below->b, 0.5 * way);
        }
        b = first;
        if (first < below->b) {
            break;
        }
        --k->top; /* swallowed */
    }
    k->segment[k->top].e = x;
    k->segment[k->top].s = sign;
    k->segment[k->top].b = b;
    k->depth = b == joined ? joined_at : b;
    stack_window(g, k);
}

#endif
