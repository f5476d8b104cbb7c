#include "dehyst.h"

/* Series of exp(x/8), to the eighth power: no branch, no loop, and never below 1. */
dehyst_real dehyst_decay(dehyst_real x)
{
    const dehyst_real s = x > 0 ? (dehyst_real)0.125 * x : (dehyst_real)0;
    const dehyst_real series =
        1 + s * (1 + s * ((dehyst_real)0.5 + s * ((dehyst_real)(1.0 / 6.0) + s * (dehyst_real)(1.0 / 24.0))));
    const dehyst_real one = 1 / series;
    const dehyst_real two = one * one;
    const dehyst_real four = two * two;
    return four * four;
}

static dehyst_real *path_values(const dehyst_direct *direct, const dehyst_direct_state *state)
{
    return state->memory + 2 * direct->stops;
}

static dehyst_real *creep_values(const dehyst_direct *direct, const dehyst_direct_state *state)
{
    return state->memory + 2 * (direct->stops + direct->paths);
}

static void clear(dehyst_direct_state *state)
{
    state->curve = 0;
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        state->part[g] = 0;
        state->doubt[g] = 0;
    }
}

/* Memory follows y beyond the identified range, where only curve and schedule end, but not to where no actuator goes. */
static dehyst_real followed(const dehyst_direct *direct, dehyst_real y)
{
    const dehyst_real width = direct->input_high - direct->input_low;
    return dehyst_within(y, direct->input_low - width, direct->input_high + width);
}

/* A path lag and its half width after a way of y. */
static inline void walk(dehyst_real x, dehyst_real way, dehyst_real *value, dehyst_real *doubt)
{
    const dehyst_real size = way < 0 ? -way : way;
    const dehyst_real left = dehyst_decay(size / x);
    const dehyst_real end = way < 0 ? -x : x; /* where a long way in this direction leads */
    *value = end + left * (*value - end);
    *doubt = left * *doubt;
}

/* Stops and path lags after strokes over the whole range, from `first` to `turn`, and from there to y. */
static void after_strokes(const dehyst_direct *direct, dehyst_direct_state *state, dehyst_real first, dehyst_real turn,
                          dehyst_real y)
{
    dehyst_real *low = state->memory;
    dehyst_real *high = low + direct->stops;
    dehyst_real *value = path_values(direct, state);
    dehyst_real *doubt = value + direct->paths;
    for (int32_t i = 0; i < direct->stops; ++i) {
        const dehyst_real r = direct->radius[i];
        low[i] = dehyst_within(dehyst_within(first, turn - r, turn + r), y - r, y + r);
        high[i] = low[i];
    }
    for (int32_t k = 0; k < direct->paths; ++k) {
        walk(direct->length[k], turn - first, &value[k], &doubt[k]);
        walk(direct->length[k], y - turn, &value[k], &doubt[k]);
    }
}

void dehyst_direct_reset(const dehyst_direct *direct, dehyst_direct_state *state, dehyst_real y)
{
    const int unknown = direct->past == DEHYST_PAST_UNKNOWN;
    const dehyst_real start = followed(direct, y);
    const dehyst_real above = direct->input_high - start;
    const dehyst_real below = start - direct->input_low;
    const dehyst_real most = above > below ? above : below;
    const dehyst_real farthest = most > 0 ? most : (dehyst_real)0;
    dehyst_real *low = state->memory;
    dehyst_real *high = low + direct->stops;
    dehyst_real *path = path_values(direct, state);
    dehyst_real *lag = creep_values(direct, state);
    for (int32_t i = 0; i < direct->stops; ++i) {
        const dehyst_real r = unknown ? direct->radius[i] : (dehyst_real)0;
        low[i] = start - r;
        high[i] = start + r;
    }
    for (int32_t k = 0; k < direct->paths; ++k) {
        path[k] = 0;
        path[direct->paths + k] = unknown ? direct->length[k] : (dehyst_real)0;
    }
    for (int32_t j = 0; j < direct->creeps; ++j) {
        lag[j] = start;
        lag[direct->creeps + j] = unknown ? farthest : (dehyst_real)0;
    }
    if (direct->past == DEHYST_PAST_RISING) {
        after_strokes(direct, state, direct->input_high, direct->input_low, start);
    }
    if (direct->past == DEHYST_PAST_FALLING) {
        after_strokes(direct, state, direct->input_low, direct->input_high, start);
    }
    state->last = start;
    state->flags = 0;
    clear(state);
}

void dehyst_direct_follow(const dehyst_direct *direct, dehyst_direct_state *state, const dehyst_direct_state *other)
{
    const int32_t reals = DEHYST_DIRECT_REALS(direct->stops, direct->paths, direct->creeps);
    for (int32_t i = 0; i < reals; ++i) {
        state->memory[i] = other->memory[i];
    }
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        state->part[g] = other->part[g];
        state->doubt[g] = other->doubt[g];
    }
    state->last = other->last;
    state->curve = other->curve;
    state->flags = other->flags;
}

/* Factors of the sets at the present scheduling variables; returns how many sets there are. */
static int32_t shares(const dehyst_direct *direct, dehyst_real y, const dehyst_real *given, dehyst_real *share)
{
    if (direct->schedules == 0) {
        share[0] = 1;
        return 1;
    }
    for (int32_t v = 0; v < direct->schedules; ++v) {
        const dehyst_real sigma = direct->source[v] == DEHYST_BY_OUTPUT ? y : given[direct->source[v]];
        const dehyst_real inside = dehyst_within(sigma, direct->low[v], direct->high[v]);
        share[2 * v + 1] = (inside - direct->low[v]) / (direct->high[v] - direct->low[v]);
        share[2 * v] = 1 - share[2 * v + 1];
    }
    return 2 * direct->schedules;
}

typedef struct blend {
    const dehyst_real *weight;
    int32_t sets, terms;
    dehyst_real share[2 * DEHYST_SCHEDULES];
} blend;

static inline dehyst_real weight_at(const blend *mix, int32_t term)
{
    dehyst_real sum = mix->share[0] * mix->weight[term];
    for (int32_t c = 1; c < mix->sets; ++c) {
        sum += mix->share[c] * mix->weight[c * mix->terms + term];
    }
    return sum;
}

static inline void add(const dehyst_direct *direct, dehyst_direct_state *state, const blend *mix, int32_t term,
                       dehyst_real value, dehyst_real doubt)
{
    const int32_t g = direct->group[term - direct->coefficients];
    const dehyst_real weight = weight_at(mix, term);
    state->part[g] += weight * value;
    state->doubt[g] += weight * doubt;
}

static void add_curve(const dehyst_direct *direct, dehyst_direct_state *state, const blend *mix, dehyst_real y)
{
    const dehyst_real x = y - direct->center;
    dehyst_real sum = 0;
    for (int32_t j = direct->coefficients - 1; j >= 0; --j) {
        sum = sum * x + weight_at(mix, j);
    }
    state->curve = sum;
}

static void add_stops(const dehyst_direct *direct, dehyst_direct_state *state, const blend *mix, dehyst_real y)
{
    dehyst_real *low = state->memory;
    dehyst_real *high = low + direct->stops;
    for (int32_t i = 0; i < direct->stops; ++i) {
        const dehyst_real r = direct->radius[i];
        low[i] = dehyst_within(low[i], y - r, y + r);
        high[i] = dehyst_within(high[i], y - r, y + r);
        const dehyst_real half = (dehyst_real)0.5 * (high[i] - low[i]);
        add(direct, state, mix, direct->coefficients + i, y - (low[i] + half), half);
    }
}

static void add_paths(const dehyst_direct *direct, dehyst_direct_state *state, const blend *mix, dehyst_real way)
{
    dehyst_real *value = path_values(direct, state);
    dehyst_real *doubt = value + direct->paths;
    for (int32_t k = 0; k < direct->paths; ++k) {
        walk(direct->length[k], way, &value[k], &doubt[k]);
        add(direct, state, mix, direct->coefficients + direct->stops + k, value[k], doubt[k]);
    }
}

static void add_creeps(const dehyst_direct *direct, dehyst_direct_state *state, const blend *mix, dehyst_real y)
{
    dehyst_real *lag = creep_values(direct, state);
    dehyst_real *doubt = lag + direct->creeps;
    const int32_t first = direct->coefficients + direct->stops + direct->paths;
    for (int32_t j = 0; j < direct->creeps; ++j) {
        lag[j] += direct->gain[j] * (y - lag[j]);
        doubt[j] -= direct->gain[j] * doubt[j];
        add(direct, state, mix, first + j, y - lag[j], doubt[j]);
    }
}

void dehyst_direct_step(const dehyst_direct *direct, dehyst_direct_state *state, dehyst_real y, dehyst_real rate,
                        const dehyst_real given[DEHYST_GIVEN])
{
    if (!dehyst_accept(y) || !dehyst_accept(rate) || !dehyst_accept_given(given)) {
        state->flags &= ~(uint32_t)DEHYST_LIMITED;
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return;
    }
    const dehyst_real inside = dehyst_within(y, direct->input_low, direct->input_high);
    const dehyst_real there = followed(direct, y);
    const int limited = inside < y || inside > y;
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
    blend mix;
    mix.weight = direct->weight;
    mix.terms = DEHYST_DIRECT_TERMS(direct->coefficients, direct->stops, direct->paths, direct->creeps);
    mix.sets = shares(direct, inside, given, mix.share);
    clear(state);
    add_curve(direct, state, &mix, inside);
    add_stops(direct, state, &mix, there);
    add_paths(direct, state, &mix, there - state->last);
    add_creeps(direct, state, &mix, there);
    add(direct, state, &mix, mix.terms - 1, rate, 0);
    state->last = there;
}

dehyst_real dehyst_direct_output(const dehyst_direct *direct, const dehyst_direct_state *state,
                                 const dehyst_real *scale)
{
    dehyst_real sum = state->curve;
    for (int32_t g = 0; g < direct->groups; ++g) {
        sum += scale ? scale[g] * state->part[g] : state->part[g];
    }
    return dehyst_within(sum, direct->output_low, direct->output_high);
}

dehyst_real dehyst_direct_doubt(const dehyst_direct *direct, const dehyst_direct_state *state,
                                const dehyst_real *scale)
{
    dehyst_real sum = 0;
    for (int32_t g = 0; g < direct->groups; ++g) {
        sum += scale ? scale[g] * state->doubt[g] : state->doubt[g];
    }
    return sum;
}
