#include "dehyst.h"

/* Two indices of direction are used throughout: 0 falling, 1 rising, s = -1, +1. Mirrored means times s: a limit `reach`
 * is passed as soon as s x > reach.
 *
 * Cost of a step with n operators. Every segment owns an operator, so there are at most n of them beside the floor.
 *   survivor           at most floor(log2 n) + 2 comparisons
 *   first_held         floor(log2 n) + 2 comparisons
 *   first_held_floor   floor(log2 n) + 1 comparisons, instead of first_held
 * and all else is straight line. So a step has a bound that grows like 2 log2 n, whatever the signal did before. */

/* Beyond every input; finite, and sums with it are finite too. */
#ifdef DEHYST_FLOAT
#define FAR 1e38f
#else
#define FAR 1e300
#endif

static inline dehyst_real sign_of(int32_t rising)
{
    return rising ? (dehyst_real)1 : (dehyst_real)-1;
}

/* sum + low += term, all digits (Knuth's two-sum): tables of 10 000 rows are as exact as those of 10. */
static void accumulate(dehyst_real *sum, dehyst_real *low, dehyst_real term)
{
    const dehyst_real total = *sum + term;
    const dehyst_real part = total - *sum;
    *low += (*sum - (total - part)) + (term - part);
    *sum = total;
}

void dehyst_stack_prepare(const dehyst_model *model, dehyst_real *threshold, dehyst_real *slope, dehyst_real *loading,
                          dehyst_stack_model *stack)
{
    const dehyst_pi *pi = &model->hysteresis;
    const int32_t added = pi->threshold[0] > 0 ? 1 : 0;
    dehyst_real total = 0; /* S_i, summed in the order of dehyst_pi_output */
    dehyst_real phi = 0;
    dehyst_real low = 0;
    stack->n = pi->n + added;
    stack->half = 1;
    for (int32_t i = 0; i < stack->n; ++i) {
        threshold[i] = i < added ? (dehyst_real)0 : pi->threshold[i - added];
        if (i > 0) {
            accumulate(&phi, &low, total * (threshold[i] - threshold[i - 1]));
        }
        total += i < added ? (dehyst_real)0 : pi->weight[i - added];
        slope[i] = total;
        loading[i] = phi + low;
        stack->half = stack->half <= (i + 1) / 2 ? 2 * stack->half : stack->half;
    }
    threshold[stack->n] = FAR;
    stack->added = added;
    stack->threshold = threshold;
    stack->slope = slope;
    stack->loading = loading;
    stack->center = pi->center;
    stack->offset = pi->offset;
    stack->before = model->before;
    stack->after = model->after;
}

/* Highest segment below `top` of which something is left at `reach`; the floor always counts as left. Whoever takes a
 * segment takes those above it, because |z_i - z_j| <= |r_i - r_j|. */
static int32_t survivor(const dehyst_real *bound, int32_t top, dehyst_real reach)
{
    uint32_t left = 0; /* the answer lies in left .. left + count */
    uint32_t count = (uint32_t)top - 1u;
    if (count == 0 || !(reach > bound[count])) {
        return top - 1; /* nearly always, so it is asked first */
    }
    --count;
    while (count > 0) {
        const uint32_t half = (count + 1u) >> 1;
        left = reach > bound[left + half] ? left : left + half;
        count -= half;
    }
    return (int32_t)left;
}

/* First operator from `from` on whose threshold is not below `reach`, at most `last`. Bisection of the whole table:
 * always the same number of rounds (Shar), of which the first ones read what is in the cache, none of them a branch. */
static int32_t first_held(const dehyst_stack_model *model, int32_t from, int32_t last, dehyst_real reach)
{
    const dehyst_real *r = model->threshold;
    if (from >= last || !(reach > r[from])) {
        return from;
    }
    uint32_t half = (uint32_t)model->half; /* largest power of two that is not above n */
    uint32_t below = reach > r[half - 1u] ? (uint32_t)model->n + 1u - half : 0u; /* thresholds known to be below */
    for (half >>= 1; half > 0; half >>= 1) {
        below = reach > r[below + half - 1u] ? below + half : below;
    }
    return (int32_t)below < last ? (int32_t)below : last;
}

/* The same in the floor, whose operators held start_i before: taken while reach > s start_i + r_i. */
static int32_t first_held_floor(const dehyst_stack_model *model, const dehyst_real *start, int32_t from,
                                dehyst_real s, dehyst_real reach)
{
    const dehyst_real *r = model->threshold;
    uint32_t half = (uint32_t)model->half;
    uint32_t taken = reach > s * start[half - 1u] + r[half - 1u] ? (uint32_t)model->n + 1u - half : 0u;
    for (half >>= 1; half > 0; half >>= 1) {
        const uint32_t probe = taken + half - 1u;
        taken = reach > s * start[probe] + r[probe] ? taken + half : taken;
    }
    return (int32_t)taken > from ? (int32_t)taken : from;
}

/* Let a top segment hold the operators 0 .. end - 1 above segment `below`: z_i = x - s r_i. */
static inline void place(const dehyst_stack_model *model, dehyst_stack_state *state, int32_t below, int32_t end,
                         int32_t rising, dehyst_real s, dehyst_real x)
{
    const dehyst_stack_segment *q = &state->segment[below];
    const dehyst_real last = model->threshold[end - 1];
    const dehyst_real next = model->threshold[end]; /* beyond every input after the last operator */
    dehyst_real ahead;                              /* operator `end` moves beyond it, going on, */
    dehyst_real behind;                             /* and going back */
    if (below == 0) {
        const dehyst_real z = state->start[end]; /* 0 after the last operator */
        state->pivot = z;
        state->shift = s * last;
        state->rest = state->start_sum[end];
        ahead = next + s * z;
        behind = next - s * z;
    } else {
        const dehyst_real e = s * q->turn;
        const dehyst_real phi = s * model->loading[end];
        state->pivot = q->turn;
        if (q->rising == rising) {
            state->shift = s * (last - next);
            state->rest = q->rest + (q->loading - phi);
            ahead = e;
            behind = 2 * next - e;
        } else {
            state->shift = s * (last + next);
            state->rest = q->rest + (q->loading + phi);
            ahead = 2 * next + e;
            behind = -e;
        }
    }
    state->input = x;
    state->rising = rising;
    state->end = end;
    state->depth = below + 1;
    state->slope = model->slope[end - 1];
    state->loading = s * model->loading[end - 1];
    /* Operator 0 alone has no memory (its threshold is 0): x may turn as it likes until operator 1 moves. */
    state->reach[rising] = ahead;
    state->reach[1 - rising] = end > 1 ? -s * x : behind;
}

/* The top segment becomes segment `depth`: what a new one will lie on. */
static inline void freeze(const dehyst_stack_model *model, dehyst_stack_state *state)
{
    dehyst_stack_segment *q = &state->segment[state->depth];
    const dehyst_real e = state->input;
    const dehyst_real diameter = 2 * model->threshold[state->end - 1];
    q->turn = e;
    q->rest = state->rest + state->slope * ((e - state->pivot) - state->shift);
    q->loading = state->loading;
    q->end = state->end;
    q->rising = state->rising;
    state->bound[0][state->depth] = state->rising ? diameter - e : -e;
    state->bound[1][state->depth] = state->rising ? e : diameter + e;
}

/* x has left the window: it turned, or it takes operators that it had not reached before. */
static void rearrange(const dehyst_stack_model *model, dehyst_stack_state *state, dehyst_real x)
{
    const int32_t rising = x > state->reach[1] ? 1 : 0;
    const dehyst_real s = sign_of(rising);
    int32_t top = state->depth;
    int32_t end = state->end;
    if (end > 1 && state->rising != rising) { /* a turning point: all but operator 0 stay behind */
        freeze(model, state);
        ++top;
        end = 1;
    }
    const int32_t below = survivor(state->bound[rising], top, s * x);
    const dehyst_stack_segment *q = &state->segment[below];
    if (below + 1 < top) {
        end = q[1].end;
    }
    if (below == 0) {
        if (end < model->n) {
            end = first_held_floor(model, state->start, end, s, s * x);
        }
    } else if (q->rising != rising) { /* of its own direction a segment goes as a whole or not at all */
        end = first_held(model, end, q->end - 1, (dehyst_real)0.5 * s * (x - q->turn));
    }
    place(model, state, below, end, rising, s, x); /* whatever the searches found, this sample is done */
}

static inline dehyst_real mapped(const dehyst_map *map, dehyst_real u)
{
    return map->n < 2 ? u : dehyst_map_value(map, u);
}

dehyst_real dehyst_stack_output(const dehyst_stack_model *model, const dehyst_stack_state *state)
{
    const dehyst_real cell = (state->input - state->pivot) - state->shift;
    return mapped(&model->after, model->offset + ((state->rest + state->loading) + state->slope * cell));
}

void dehyst_stack_begin(const dehyst_stack_model *model, dehyst_stack_state *state, const dehyst_real *z)
{
    dehyst_real sum = 0;
    dehyst_real low = 0;
    state->start[model->n] = 0;
    state->start_sum[model->n] = 0;
    for (int32_t i = model->n - 1; i >= 0; --i) {
        state->start[i] = i < model->added ? z[0] : z[i - model->added]; /* an added one rests beside its neighbour */
        accumulate(&sum, &low, model->slope[i] * (state->start[i] - state->start[i + 1]));
        state->start_sum[i] = sum + low;
    }
}

void dehyst_stack_reset(const dehyst_stack_model *model, dehyst_stack_state *state, const dehyst_real *z0)
{
    dehyst_stack_begin(model, state, z0);
    dehyst_stack_push(model, state, 0, 1, 1, state->start[0]);
    state->flags = 0;
}

void dehyst_stack_push(const dehyst_stack_model *model, dehyst_stack_state *state, int32_t below, int32_t end,
                       int32_t rising, dehyst_real turn)
{
    if (below > 0) {
        freeze(model, state);
    }
    place(model, state, below, end, rising, sign_of(rising), turn);
    state->output = dehyst_stack_output(model, state);
}

dehyst_real dehyst_stack_step(const dehyst_stack_model *model, dehyst_stack_state *state, dehyst_real x)
{
    const int good = dehyst_accept(x);
    const dehyst_real v = good ? mapped(&model->before, x) - model->center : (dehyst_real)0;
    /* A map may make infinity of a good sample. */
    if (!good || (model->before.n > 1 && !dehyst_accept(v * (DEHYST_INPUT_LIMIT / FAR)))) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return state->output;
    }
    if (!(v <= state->reach[1] && -v <= state->reach[0])) {
        rearrange(model, state, v);
    } else { /* only the cell at the edge of the top segment moves */
        state->input = v;
        if (state->end > 1) {
            state->reach[1 - state->rising] = state->rising ? -v : v;
        }
    }
    state->flags &= ~(uint32_t)DEHYST_REJECTED;
    state->output = dehyst_stack_output(model, state);
    return state->output;
}

void dehyst_stack_play(const dehyst_stack_model *model, const dehyst_stack_state *state, dehyst_real *z)
{
    int32_t i = 0;
    for (int32_t k = state->depth; k > 0; --k) { /* from the top: every segment goes on where the one above it ends */
        const dehyst_stack_segment *q = &state->segment[k];
        const int top = k == state->depth;
        const dehyst_real e = top ? state->input : q->turn;
        const dehyst_real s = sign_of(top ? state->rising : q->rising);
        for (const int32_t end = top ? state->end : q->end; i < end; ++i) {
            if (i >= model->added) {
                z[i - model->added] = e - s * model->threshold[i];
            }
        }
    }
    for (; i < model->n; ++i) {
        z[i - model->added] = state->start[i];
    }
}
