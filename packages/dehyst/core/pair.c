#include "dehyst.h"

#define NEWTON 12 /* first rounds; two to four are usual */

static const dehyst_real SHARE[DEHYST_SHARES] = {1};

/* What is missing to the first value where x_0 is x[0], and the slope of that sum with x_0. For every x_0 there is one
 * x_1 that gives the second value, since its path rises. An x_1 at its limit stays there, and its slopes do not count. */
static dehyst_real missing(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real value[2],
                           dehyst_real x[2], int rising, dehyst_real *slope)
{
    const dehyst_elements(*path)[2] = pair->path;
    dehyst_elements_state(*at)[2] = state->path;
    dehyst_real s[2][2];
    const dehyst_real crossed = dehyst_elements_value(&path[1][0], &at[1][0], SHARE, x[0], rising, &s[1][0]);
    x[1] = dehyst_elements_solve(&path[1][1], &at[1][1], SHARE, value[1] - crossed);
    const int second_rises = s[1][0] > 0 ? !rising : rising; /* when x_0 goes on */
    (void)dehyst_elements_value(&path[1][1], &at[1][1], SHARE, x[1], second_rises, &s[1][1]);
    const dehyst_real own = dehyst_elements_value(&path[0][0], &at[0][0], SHARE, x[0], rising, &s[0][0]);
    const dehyst_real other = dehyst_elements_value(&path[0][1], &at[0][1], SHARE, x[1], second_rises, &s[0][1]);
    const int moves = x[1] > path[1][1].low && x[1] < path[1][1].high && s[1][1] > 0;
    *slope = s[0][0] - (moves ? s[0][1] * s[1][0] / s[1][1] : (dehyst_real)0);
    return value[0] - (own + other);
}

/* Along these pairs the first sum rises with x_0 where the determinant of the four slopes is above 0. So Newton's method
 * finds it: the sums are piecewise linear but for elements along the path. It stays between two x_0; a step beyond one of
 * them where the sum is known, and every step after the first rounds, goes to their middle. */
void dehyst_pair_solve(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real value[2], dehyst_real x[2])
{
    const dehyst_elements_state *last = &state->path[0][0];
    const dehyst_real near = (pair->path[0][0].high - pair->path[0][0].low) * (dehyst_real)DEHYST_ROUNDING;
    dehyst_real bound[2] = {pair->path[0][0].low, pair->path[0][0].high};
    int known[2] = {0, 0}; /* whether the sum is known there */
    int up = last->step > 0;
    int open = 1;
    int32_t round = 0;
    x[0] = dehyst_within(last->last + last->step, bound[0], bound[1]);
    while (open && round < NEWTON + DEHYST_HALVINGS) {
        dehyst_real slope;
        const dehyst_real miss = missing(pair, state, value, x, up, &slope);
        up = miss > 0;
        bound[1 - up] = x[0];
        known[1 - up] = 1;
        const dehyst_real left = bound[up] - x[0]; /* as far as the solution can be */
        dehyst_real step = slope > 0 ? miss / slope : left;
        const int beyond = up ? !(step < left) : !(step > left);
        step = beyond ? left : step;
        step = round >= NEWTON || (beyond && known[up]) ? (dehyst_real)0.5 * left : step;
        open = (miss < 0 || miss > 0) && (step > near || step < -near);
        x[0] = dehyst_within(open ? x[0] + step : x[0], pair->path[0][0].low, pair->path[0][0].high);
        ++round;
    }
    state->rounds = round;
}

static dehyst_real summed(const dehyst_pair *pair, dehyst_pair_state *state, int32_t output, const dehyst_real x[2])
{
    return dehyst_elements_follow(&pair->path[output][0], &state->path[output][0], SHARE, x[0]) +
           dehyst_elements_follow(&pair->path[output][1], &state->path[output][1], SHARE, x[1]);
}

void dehyst_pair_reset(const dehyst_pair *pair, dehyst_pair_state *state)
{
    for (int32_t output = 0; output < 2; ++output) {
        for (int32_t input = 0; input < 2; ++input) {
            dehyst_elements_reset(&pair->path[output][input], &state->path[output][input], pair->rest[input], 0);
        }
    }
    for (int32_t k = 0; k < 2; ++k) {
        const dehyst_real value = summed(pair, state, k, pair->rest);
        state->answer[k] = pair->solves ? pair->center[k] + pair->half_range[k] * pair->rest[k]
                                        : pair->level[k] + pair->amplitude[k] * value;
    }
    state->rounds = 0;
    state->flags = 0;
}

/* Outputs of inputs, which are taken at most as far as their range goes. */
static int evaluated(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real input[2])
{
    dehyst_real x[2];
    int limited = 0;
    for (int32_t k = 0; k < 2; ++k) {
        const dehyst_real scaled = (input[k] - pair->center[k]) / pair->half_range[k];
        x[k] = dehyst_within(scaled, pair->path[k][k].low, pair->path[k][k].high);
        limited |= x[k] < scaled || x[k] > scaled;
    }
    for (int32_t k = 0; k < 2; ++k) {
        state->answer[k] = pair->level[k] + pair->amplitude[k] * summed(pair, state, k, x);
    }
    return limited;
}

/* Inputs that give outputs. */
static int solved(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real output[2])
{
    dehyst_real value[2];
    dehyst_real x[2] = {0, 0};
    int limited = 0;
    for (int32_t k = 0; k < 2; ++k) {
        value[k] = (output[k] - pair->level[k]) / pair->amplitude[k];
    }
    dehyst_pair_solve(pair, state, value, x);
    for (int32_t k = 0; k < 2; ++k) {
        limited |= x[k] <= pair->path[k][k].low || x[k] >= pair->path[k][k].high;
        state->answer[k] = pair->center[k] + pair->half_range[k] * x[k];
        dehyst_elements_advance(&pair->path[0][k], &state->path[0][k], x[k]);
        dehyst_elements_advance(&pair->path[1][k], &state->path[1][k], x[k]);
    }
    return limited;
}

void dehyst_pair_step(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real sample[2],
                      dehyst_real answer[2])
{
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    if (dehyst_accept(sample[0]) && dehyst_accept(sample[1])) {
        const int limited = pair->solves ? solved(pair, state, sample) : evaluated(pair, state, sample);
        state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
    } else {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
    }
    answer[0] = state->answer[0];
    answer[1] = state->answer[1];
}

int32_t dehyst_pair_check(const dehyst_pair *pair)
{
    int good = 1;
    for (int32_t k = 0; k < 2; ++k) {
        const dehyst_real number[] = {pair->center[k], pair->half_range[k], pair->level[k], pair->amplitude[k],
                                      pair->rest[k]};
        for (int32_t i = 0; i < (int32_t)(sizeof(number) / sizeof(number[0])); ++i) {
            good = good && dehyst_accept(number[i]);
        }
        good = good && (pair->half_range[k] < 0 || pair->half_range[k] > 0);
        good = good && (pair->amplitude[k] < 0 || pair->amplitude[k] > 0);
        for (int32_t i = 0; i < 2; ++i) {
            const dehyst_elements *path = &pair->path[k][i];
            good = good && dehyst_elements_check(path) == DEHYST_IMAGE_GOOD;
            good = good && path->schedules == 0 && path->before.n == 0 && path->after.n == 0;
        }
    }
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}
