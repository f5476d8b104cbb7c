#include "dehyst.h"

/* Directions have an index, 0 falling and 1 rising, and a sign s = -1, +1. Limits are mirrored: x has passed one once
 * s x is above it.
 *
 * Cost of a step with n operators. Every segment owns an operator, so there are at most n of them beside the floor.
 *   survivor           at most floor(log2 n) + 2 comparisons
 *   first_held         floor(log2 n) + 2 comparisons
 *   first_held_floor   floor(log2 n) + 1 comparisons, instead of first_held
 * and all else is straight line. So a step has a bound that grows like 2 log2 n, whatever the signal did before. */

static inline dehyst_real sign_of(int32_t rising)
{
    return rising ? (dehyst_real)1 : (dehyst_real)-1;
}

void dehyst_stack_prepare(const dehyst_model *model, dehyst_real *threshold, dehyst_real *slope, dehyst_real *loading,
                          dehyst_stack_model *stack)
{
    const dehyst_pi *pi = &model->hysteresis;
    const int32_t added = pi->threshold[0] > 0 ? 1 : 0;
    stack->n = pi->n + added;
    stack->half = 1;
    for (int32_t i = 0; i < stack->n; ++i) { /* an added operator without weight changes nothing but the numbering */
        threshold[i] = i < added ? (dehyst_real)0 : pi->threshold[i - added];
        slope[i] = i < added ? (dehyst_real)0 : pi->slope[i - added];
        loading[i] = i < added ? (dehyst_real)0 : pi->loading[i - added];
        stack->half = stack->half <= (i + 1) / 2 ? 2 * stack->half : stack->half;
    }
    threshold[stack->n] = DEHYST_FAR;
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
    if (!(reach > bound[count])) {
        return top - 1; /* nearly always, so it is asked first */
    }
    --count; /* not the floor */
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
    uintptr_t half = (uintptr_t)model->half;
    const dehyst_real *at = reach > r[half - 1u] ? r + (model->n + 1 - model->half) : r; /* all before it are below */
    for (half >>= 1; half > 0; half >>= 1) {
        const dehyst_real *probe = at + half;
        at = reach > probe[-1] ? probe : at;
    }
    const int32_t found = (int32_t)(at - r);
    return found < last ? found : last;
}

/* The same in the floor, whose operators held start_i before: taken while reach > s start_i + r_i. */
static int32_t first_held_floor(const dehyst_stack_model *model, const dehyst_real *start, int32_t from,
                                dehyst_real s, dehyst_real reach)
{
    const dehyst_real *r = model->threshold;
    uintptr_t half = (uintptr_t)model->half;
    uintptr_t at = reach > s * start[half - 1u] + r[half - 1u] ? (uintptr_t)(model->n + 1 - model->half) : 0u;
    for (half >>= 1; half > 0; half >>= 1) {
        const uintptr_t probe = at + half;
        at = reach > s * start[probe - 1u] + r[probe - 1u] ? probe : at;
    }
    return (int32_t)at > from ? (int32_t)at : from;
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
        if (q->side == s) {
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

/* The top segment, of direction s, becomes segment `depth`: what a new one will lie on. Its edge cell
 * (e - pivot) - shift will be part of many sums, so it gets back what rounding took from both differences (Knuth). */
static inline void freeze(const dehyst_stack_model *model, dehyst_stack_state *state, dehyst_real s)
{
    dehyst_stack_segment *q = &state->segment[state->depth];
    const int32_t end = state->end;
    const dehyst_real e = state->input;
    const dehyst_real radius = model->threshold[end - 1];
    const dehyst_real last = s * radius;
    const dehyst_real next = q[-1].side * model->threshold[end]; /* pivot - next is where operator `end` stays */
    const dehyst_real swing = e - state->pivot;
    const dehyst_real from = swing - e;
    const dehyst_real part = state->shift - last;
    const dehyst_real lost = ((e - (swing - from)) - (state->pivot + from)) -
                             ((last - (state->shift - part)) - (next + part));
    q->turn = e;
    q->rest = state->rest + state->slope * ((swing - state->shift) + lost);
    q->loading = state->loading;
    q->side = s;
    q->end = end;
    state->bound[state->rising][state->depth] = s * e;
    state->bound[1 - state->rising][state->depth] = 2 * radius - s * e;
}

/* x has left the window: it turned, or it takes operators that it had not reached before. */
static inline void rearrange(const dehyst_stack_model *model, dehyst_stack_state *state, int32_t rising, dehyst_real x)
{
    const dehyst_real s = sign_of(rising);
    int32_t top = state->depth;
    int32_t end = state->end;
    if (end > 1 && state->rising != rising) { /* a turning point: all but operator 0 stay behind */
        freeze(model, state, -s);
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
    } else if (!(q->side == s)) { /* of its own direction a segment goes as a whole or not at all */
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
    state->segment[0].side = 0; /* the floor is no segment: nothing else of it is read */
    state->bound[0][0] = DEHYST_FAR;
    state->bound[1][0] = DEHYST_FAR;
    state->start[model->n] = 0;
    state->start_sum[model->n] = 0;
    for (int32_t i = model->n - 1; i >= 0; --i) {
        state->start[i] = i < model->added ? z[0] : z[i - model->added]; /* an added one rests beside its neighbour */
        dehyst_accumulate(&sum, &low, model->slope[i] * (state->start[i] - state->start[i + 1]));
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
        freeze(model, state, sign_of(state->rising));
    }
    place(model, state, below, end, rising, sign_of(rising), turn);
    state->output = dehyst_stack_output(model, state);
}

/* Centre and map a sample; 0 if it is not to be used. A map may make infinity of a good one. */
static inline int take(const dehyst_stack_model *model, dehyst_real *x)
{
    if (!dehyst_accept(*x)) {
        return 0;
    }
    if (model->before.n > 1) {
        *x = dehyst_map_value(&model->before, *x);
        if (!dehyst_accept(*x * (DEHYST_INPUT_LIMIT / DEHYST_FAR))) {
            return 0;
        }
    }
    *x -= model->center;
    return 1;
}

dehyst_real dehyst_stack_step(const dehyst_stack_model *model, dehyst_stack_state *state, dehyst_real x)
{
    if (!take(model, &x)) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return state->output;
    }
    const int32_t above = x > state->reach[1] ? 1 : 0;
    if (above || -x > state->reach[0]) {
        rearrange(model, state, above, x);
    } else { /* only the cell at the edge of the top segment moves */
        state->input = x;
        if (state->end > 1) {
            state->reach[1 - state->rising] = state->rising ? -x : x;
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
        const dehyst_real s = top ? sign_of(state->rising) : q->side;
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
