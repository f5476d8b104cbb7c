#include "dehyst.h"

/* Newton's method on the sum at one sample, which rises with x. It is piecewise linear but for elements along the path,
 * so a step that stays on its piece is exact. Memory leaves the input at a corner of the sum, where slopes have two
 * sides: that of the last motion counts, until the sum tells where the solution lies.
 *
 * The solution stays between two inputs; a step beyond one of them where the sum is known goes to their middle instead,
 * and so does, after the first rounds, one that is not half as long as the step before. If all of that has not ended,
 * the last rounds halve what is left: from the whole range they come down to its rounding, whatever the sum. */
#define NEWTON 12 /* first rounds; one to four are usual */
#define LAST (DEHYST_ROUNDS - DEHYST_HALVINGS)

static dehyst_real magnitude(dehyst_real x) { return x < 0 ? -x : x; }

dehyst_real dehyst_elements_solve(const dehyst_elements *sum, dehyst_elements_state *state, const dehyst_real *share,
                                  dehyst_real value)
{
    const dehyst_real near = (sum->high - sum->low) * (dehyst_real)DEHYST_ROUNDING;
    dehyst_real bound[2] = {sum->low, sum->high};
    int32_t known[2] = {0, 0}; /* whether the sum is known there */
    dehyst_real x = dehyst_within(state->last + state->step, sum->low, sum->high);
    dehyst_real length = 0;
    int32_t up = state->step > 0 ? 1 : 0;
    int32_t close = 0;
    int32_t round = 0;
    while (close < 2 && round < DEHYST_ROUNDS) {
        const int32_t side = up;
        dehyst_real slope;
        const dehyst_real miss = value - dehyst_elements_value(sum, state, share, x, side, &slope);
        up = miss > 0 ? 1 : 0;
        const dehyst_real left = bound[up] - x; /* as far as the solution can be */
        const dehyst_real step = slope > 0 ? miss / slope : left;
        const int beyond = !(magnitude(step) < magnitude(left));
        const int slow = round >= NEWTON && !(2 * magnitude(step) < length);
        const int halves = slow || round >= LAST || (beyond && known[up]);
        const dehyst_real next = halves ? x + (dehyst_real)0.5 * left : beyond ? bound[up] : x + step;
        bound[1 - up] = x;
        known[1 - up] = 1;
        length = magnitude(next - x);
        if (!(miss < 0 || miss > 0)) {
            close = 2;
        } else {
            x = next;
            close = length > near ? 0 : up == side ? 2 : close + 1; /* a slope of the wrong side may be too steep */
        }
        ++round;
    }
    state->rounds = round;
    return dehyst_within(x, sum->low, sum->high);
}
