#include "dehyst.h"

#define PARTS 64    /* of the stroke to the first sample: the decay of a short one is exact */
#define DOUBLINGS 6 /* 2^6 parts */
#define LINES 20    /* first rounds to the x of the first sample; four to eight are usual */
#define LEARNT ((dehyst_real)0.25) /* of what is missing in an observed sample: noise is averaged over some of them */

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
    state->least = 0;
    state->most = 0;
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

/* The ring takes the input, and gives that of `delay` samples ago; before the first one there was no other. */
static dehyst_real late(const dehyst_element_block *block, dehyst_element_block_state *state, dehyst_real scaled)
{
    for (int32_t i = 0; !state->started && i < block->delay; ++i) {
        state->delay.ring[i] = scaled;
    }
    return dehyst_delay_step(&state->delay, scaled);
}

static void nothing_known(dehyst_element_block_state *state)
{
    state->least = state->sum.last;
    state->most = state->sum.last;
}

/* The actuator was at the last x: a stroke from end to end of 2r leaves one state of a play of radius r. */
static inline void known_from(dehyst_element_block_state *state)
{
    const dehyst_real x = state->sum.last;
    state->least = x < state->least ? x : state->least;
    state->most = x > state->most ? x : state->most;
}

/* The first sample: x, or the value of the sum. */
static void begin(const dehyst_element_block *block, dehyst_element_block_state *state, const dehyst_real *given,
                  dehyst_real argument, int value)
{
    if (value != 0) {
        arrive_at_value(block, &state->sum, given, argument);
    } else {
        arrive(block, &state->sum, argument);
    }
    nothing_known(state);
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
    dehyst_real mixed = scaled;
    if (block->delay > 0) {
        mixed = block->echo * late(block, state, scaled) + (1 - block->echo) * scaled;
    }
    const dehyst_real argument = dehyst_map_value(&sum->before, mixed);
    if (!state->started) {
        begin(block, state, given, argument, block->solves);
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
        nothing_known(state); /* the actuator got something else */
    } else {
        known_from(state);
    }
    state->started = 1;
    state->output = output;
    state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
    return output;
}

/* Slope of f at e. */
static dehyst_real map_slope(const dehyst_map *map, dehyst_real e)
{
    if (map->n < 2) {
        return 1;
    }
    int32_t left = 0;
    while (left < map->n - 2 && map->u[left + 1] <= e) {
        ++left;
    }
    return (map->v[left + 1] - map->v[left]) / (map->u[left + 1] - map->u[left]);
}

/* Slope of the sum with the state of an element that is not known, and how far its bounds are apart; 0 where it is. */
static dehyst_real unknown_part(const dehyst_element_block *block, const dehyst_element_block_state *state,
                                const dehyst_real *share, int32_t k, dehyst_real *apart)
{
    const dehyst_element *q = &block->sum.element[k];
    const int stop = q->kind == DEHYST_STOP;
    *apart = 2 * q->radius - (state->most - state->least);
    if (!(*apart > 0) || (q->kind != DEHYST_PLAY && !stop)) {
        return 0;
    }
    const dehyst_real weight = share[q->schedule] * q->weight;
    const dehyst_real z = state->sum.z[k];
    return stop ? -weight * map_slope(&q->map, state->sum.last - z) : weight * map_slope(&q->map, z);
}

/* A step towards the states that make good what is missing in the sum. */
static void put_right(const dehyst_element_block *block, dehyst_element_block_state *state, const dehyst_real *share,
                  dehyst_real miss)
{
    dehyst_real total = 0;
    dehyst_real apart;
    for (int32_t k = 0; k < block->sum.n; ++k) {
        const dehyst_real slope = unknown_part(block, state, share, k, &apart);
        total += slope * slope * apart;
    }
    const dehyst_real step = total > 0 ? LEARNT * miss / total : (dehyst_real)0;
    const int32_t n = dehyst_accept(step) != 0 ? block->sum.n : 0;
    for (int32_t k = 0; k < n; ++k) {
        const dehyst_real slope = unknown_part(block, state, share, k, &apart);
        if (slope < 0 || slope > 0) {
            const dehyst_real r = block->sum.element[k].radius;
            dehyst_real *z = &state->sum.z[k];
            *z = dehyst_within(*z + slope * apart * step, state->most - r, state->least + r);
        }
    }
}

/* An observed sample as the sum has it; what is not known is 0. */
typedef struct sighting {
    dehyst_real x;
    dehyst_real value;
    int has_x;
    int has_value;
} sighting;

/* Memory follows the x or, where that is not known, the x that solves the sum. */
static void observe_sum(const dehyst_element_block *block, dehyst_element_block_state *state, const dehyst_real *given,
                        const sighting *seen)
{
    const dehyst_elements *sum = &block->sum;
    dehyst_real share[DEHYST_SHARES];
    if (!state->started) {
        begin(block, state, given, seen->has_x ? seen->x : seen->value, !seen->has_x);
    }
    dehyst_elements_shares(sum, &state->sum, given, share);
    if (seen->has_x != 0) {
        const dehyst_real said = dehyst_elements_follow(sum, &state->sum, share, seen->x);
        known_from(state);
        if (seen->has_value != 0) {
            put_right(block, state, share, seen->value - said);
        }
    } else {
        dehyst_elements_advance(sum, &state->sum, dehyst_elements_solve(sum, &state->sum, share, seen->value));
        nothing_known(state);
    }
}

void dehyst_element_block_observe(const dehyst_element_block *block, dehyst_element_block_state *state,
                                  dehyst_real input, dehyst_real output, const dehyst_real given[DEHYST_GIVEN])
{
    const dehyst_elements *sum = &block->sum;
    const dehyst_map back = {sum->after.n, sum->after.v, sum->after.u};
    const dehyst_real went_in = dehyst_within(input, block->input_low, block->input_high);
    const dehyst_real came_out = dehyst_within(output, block->output_low, block->output_high);
    const dehyst_real answer = dehyst_map_value(&back, (came_out - block->level) / block->amplitude);
    const int in = dehyst_accept(input);
    const int out = dehyst_accept(output) && dehyst_accept(answer);
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    /* a ring begins with an input */
    if (!dehyst_accept_given(given) || !(in || (out && (state->started || block->delay == 0)))) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return;
    }
    dehyst_real argument = 0;
    if (in != 0) {
        const dehyst_real scaled = (went_in - block->center) / block->half_range;
        const dehyst_real delayed = late(block, state, scaled);
        /* a shaper is for references: what was measured is the output itself */
        argument = dehyst_map_value(&sum->before, block->echo < 1 ? scaled : delayed);
    }
    const int beyond_in = in && (went_in < input || went_in > input);
    const int beyond_out = out && (came_out < output || came_out > output);
    /* beyond a limit it is not known what the sum should be */
    const sighting solved_one = {dehyst_within(answer, sum->low, sum->high), argument, out, in && (!out || !beyond_in)};
    const sighting evaluated_one = {argument, answer, in, out && (!in || !beyond_out)};
    observe_sum(block, state, given, block->solves ? &solved_one : &evaluated_one);
    state->output = out ? came_out : state->output;
    state->share = 1;
    state->started = 1;
    state->flags |= beyond_in || beyond_out ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
}
