#include "dehyst.h"

#define PARTS 64    /* of the stroke to the first sample: the decay of a short one is exact */
#define DOUBLINGS 6 /* 2^6 parts */
#define LINES 20    /* first rounds to the x of the first sample; four to eight are usual */

static dehyst_real line_inside(const dehyst_element_block *block, dehyst_real x)
{
    return dehyst_within(block->line_offset + block->line_slope * x, block->output_low, block->output_high);
}

void dehyst_element_block_reset(const dehyst_element_block *block, dehyst_element_block_state *state)
{
    dehyst_elements_reset(&block->sum, &state->sum, 0, 0);
    state->delay.n = block->delay;
    state->delay.at = 0;
    for (int32_t i = 0; i < block->delay; ++i) {
        state->delay.ring[i] = 0;
    }
    state->share = 0;
    state->output = line_inside(block, dehyst_within(0, block->input_low, block->input_high));
    state->flags = 0;
    state->started = 0;
}

/* Memory of an actuator that comes to x in one stroke from the start, and waits until all lags are there. */
static void arrive(const dehyst_element_block *block, dehyst_elements_state *state, dehyst_real x)
{
    const dehyst_elements *sum = &block->sum;
    dehyst_elements_reset(sum, state, x, 0);
    for (int32_t k = 0; block->start && k < sum->n; ++k) {
        const dehyst_element *q = &sum->element[k];
        const dehyst_real z = block->start[k];
        if (q->kind == DEHYST_PLAY || q->kind == DEHYST_STOP || q->kind == DEHYST_WIDE) {
            state->z[k] = dehyst_within(z, x - q->radius, x + q->radius);
        } else if (q->kind == DEHYST_PATH) {
            const dehyst_real way = x - block->origin;
            const dehyst_real end = way < 0 ? -q->radius : q->radius;
            dehyst_real left = dehyst_decay((way < 0 ? -way : way) / (PARTS * q->radius));
            for (int32_t i = 0; i < DOUBLINGS; ++i) {
                left *= left;
            }
            state->z[k] = end + left * (z - end);
        }
    }
}

/* What is missing to `value` in the sum of an actuator that came to x. */
static dehyst_real missed(const dehyst_element_block *block, dehyst_elements_state *state, const dehyst_real *given,
                          dehyst_real x, dehyst_real value)
{
    dehyst_real share[DEHYST_SHARES];
    dehyst_real slope;
    arrive(block, state, x);
    dehyst_elements_shares(&block->sum, state, given, share);
    return value - dehyst_elements_value(&block->sum, state, share, x, 1, &slope);
}

/* The same, to the x where the sum is `value`. The line between two bounds tells where to look next; the bound that
 * stays counts half, so that the other one does not creep (the Illinois method). The last rounds halve what is left,
 * which comes down to rounding whatever the sum. */
static void arrive_at_value(const dehyst_element_block *block, dehyst_elements_state *state, const dehyst_real *given,
                            dehyst_real value)
{
    const dehyst_elements *sum = &block->sum;
    const dehyst_real near = (sum->high - sum->low) * (dehyst_real)DEHYST_ROUNDING;
    dehyst_real low = sum->low;
    dehyst_real high = sum->high;
    dehyst_real miss_low = missed(block, state, given, low, value);
    dehyst_real miss_high = missed(block, state, given, high, value);
    dehyst_real x = miss_low > 0 ? high : low;
    int32_t side = 0; /* the bound that moved last: 1 low, -1 high */
    int32_t open = miss_low > 0 && miss_high < 0;
    for (int32_t round = 0; open && round < LINES + DEHYST_HALVINGS; ++round) {
        const dehyst_real part = round < LINES ? miss_low / (miss_low - miss_high) : (dehyst_real)0.5;
        x = dehyst_within(low + part * (high - low), sum->low, sum->high);
        const dehyst_real miss = missed(block, state, given, x, value);
        open = (miss < 0 || miss > 0) && x - low > near && high - x > near;
        if (miss > 0) {
            miss_high *= side > 0 ? (dehyst_real)0.5 : (dehyst_real)1;
            low = x;
            miss_low = miss;
            side = 1;
        } else {
            miss_low *= side < 0 ? (dehyst_real)0.5 : (dehyst_real)1;
            high = x;
            miss_high = miss;
            side = -1;
        }
    }
    arrive(block, state, x);
}

/* The sum at x. Where it would leave its reach, x is held back at the point where it meets it: memory follows that. */
static dehyst_real evaluated(const dehyst_element_block *block, dehyst_elements_state *state, const dehyst_real *share,
                             dehyst_real x, int *limited)
{
    const dehyst_elements *sum = &block->sum;
    if (!(block->reach_high < DEHYST_INPUT_LIMIT)) { /* there is none */
        return dehyst_elements_follow(sum, state, share, x);
    }
    dehyst_real slope;
    const dehyst_real found = dehyst_elements_value(sum, state, share, x, 1, &slope);
    const dehyst_real value = dehyst_within(found, block->reach_low, block->reach_high);
    const int held = !(found >= block->reach_low && found <= block->reach_high);
    *limited |= held;
    dehyst_elements_advance(sum, state, held ? dehyst_elements_solve(sum, state, share, value) : x);
    return value;
}

static dehyst_real solved(const dehyst_element_block *block, dehyst_elements_state *state, const dehyst_real *share,
                          dehyst_real value, int *limited)
{
    const dehyst_real x = dehyst_elements_solve(&block->sum, state, share, value);
    *limited |= x <= block->sum.low || x >= block->sum.high;
    dehyst_elements_advance(&block->sum, state, x);
    return x;
}

dehyst_real dehyst_element_block_step(const dehyst_element_block *block, dehyst_element_block_state *state,
                                      dehyst_real x, const dehyst_real given[DEHYST_GIVEN], int on)
{
    const dehyst_elements *sum = &block->sum;
    dehyst_real share[DEHYST_SHARES];
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    if (!dehyst_accept(x) || !dehyst_accept_given(given)) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return state->output;
    }
    const dehyst_real taken = dehyst_within(x, block->input_low, block->input_high);
    const dehyst_real scaled = (taken - block->center) / block->half_range;
    for (int32_t i = 0; !state->started && i < block->delay; ++i) {
        state->delay.ring[i] = scaled;
    }
    const dehyst_real delayed = dehyst_delay_step(&state->delay, scaled);
    const dehyst_real mixed = block->echo * delayed + (1 - block->echo) * scaled;
    const dehyst_real argument = dehyst_map_value(&sum->before, mixed);
    if (!state->started && block->solves) {
        arrive_at_value(block, &state->sum, given, argument);
    } else if (!state->started) {
        arrive(block, &state->sum, argument);
    }
    dehyst_elements_shares(sum, &state->sum, given, share);
    int limited = taken < x || taken > x;
    const dehyst_real answer = block->solves ? solved(block, &state->sum, share, argument, &limited)
                                             : evaluated(block, &state->sum, share, argument, &limited);
    const dehyst_real result = block->level + block->amplitude * dehyst_map_value(&sum->after, answer);
    dehyst_real output = dehyst_within(result, block->output_low, block->output_high);
    limited |= !(result >= block->output_low && result <= block->output_high);
    const dehyst_real target = on ? (dehyst_real)1 : (dehyst_real)0;
    state->share = state->started ? dehyst_faded(state->share, target, block->fade) : target;
    if (state->share < 1) {
        const dehyst_real line = line_inside(block, taken);
        /* rounding must not leave the range */
        output = dehyst_within(line + state->share * (output - line), block->output_low, block->output_high);
    }
    state->started = 1;
    state->output = output;
    state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
    return output;
}
