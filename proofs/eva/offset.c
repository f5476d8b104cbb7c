/* An offset that follows the last cycle: from a reset and from any state within its bounds one sample, of any reals, NaN
 * and the infinities among them, leads to such a state. */
#include "dehyst.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

#define LIMIT ((dehyst_real)0.5)
#define MOST 1000000000
#ifdef DEHYST_FLOAT
#define FAR 0x1p50f
#else
#define FAR 0x1p333
#endif /* a power of two just beyond DEHYST_INPUT_LIMIT */

static const dehyst_offset offset = {LIMIT, (dehyst_real)0.125, (dehyst_real)0.25, 1};
static dehyst_offset_state state;

static dehyst_real any_within(dehyst_real low, dehyst_real high)
{
    const dehyst_real x = any_real();
    //@ admit \is_finite(x) && low <= x <= high;
    return x;
}

int main(void)
{
    dehyst_offset_reset(&state);
    if (Frama_C_nondet(0, 1)) {
        state.target = any_within(-LIMIT, LIMIT);
        state.applied = any_within(-LIMIT, LIMIT);
        state.last = any_within(-FAR, FAR);
        state.extreme = any_within(-FAR, FAR);
        state.mean[0] = any_within(-FAR, FAR);
        state.mean[1] = any_within(-FAR, FAR);
        state.good[0] = Frama_C_interval(0, MOST);
        state.good[1] = Frama_C_interval(0, MOST);
        state.bad = Frama_C_interval(0, MOST);
        state.phase = Frama_C_interval(0, 3);
    }
    const dehyst_real x = any_real();
    const int on = Frama_C_nondet(0, 1);
    const dehyst_real next = dehyst_offset_next(&offset, &state, x, on);
    //@ assert next: \is_finite(next);
    const uint32_t flags = Frama_C_unsigned_int_interval(0, 15);
    (void)dehyst_offset_step(&offset, &state, x, any_real(), any_real(), any_real(), flags, on);
    //@ assert target: \is_finite(state.target) && -LIMIT <= state.target <= LIMIT;
    //@ assert applied: \is_finite(state.applied) && -LIMIT <= state.applied <= LIMIT;
    //@ assert last: \is_finite(state.last) && -FAR <= state.last <= FAR;
    //@ assert extreme: \is_finite(state.extreme) && -FAR <= state.extreme <= FAR;
    //@ assert mean: \is_finite(state.mean[0]) && -FAR <= state.mean[0] <= FAR;
    //@ assert before: \is_finite(state.mean[1]) && -FAR <= state.mean[1] <= FAR;
    //@ assert good: 0 <= state.good[0] <= MOST && 0 <= state.good[1] <= MOST;
    //@ assert bad: 0 <= state.bad <= MOST;
    //@ assert phase: 0 <= state.phase <= 3;
    return 0;
}
