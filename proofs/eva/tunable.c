/* A unit with tunable numbers: from any state one sample, any real, with pages and their number that may be anything at
 * every read (they are volatile), leads to such a state. */
#include "parameters.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

static unit_state state;

int main(void)
{
    unit_reset(&state);
    if (Frama_C_nondet(0, 1)) {
        for (int32_t i = 0; i < UNIT_OPERATORS; ++i) {
            state.z[i] = any_real();
            //@ admit \is_finite(state.z[i]) && -DEHYST_INPUT_LIMIT <= state.z[i] <= DEHYST_INPUT_LIMIT;
        }
        state.block.model.output = any_real();
        //@ admit \is_finite(state.block.model.output);
        state.block.output = any_real();
        //@ admit \is_finite(state.block.output) && OUTPUT_LOW <= state.block.output <= OUTPUT_HIGH;
        state.block.share = any_real();
        //@ admit \is_finite(state.block.share) && 0 <= state.block.share <= 1;
        state.block.started = Frama_C_interval(0, 1);
        state.block.flags = Frama_C_unsigned_int_interval(0, 15);
        state.answer = any_real();
        state.page = Frama_C_unsigned_int_interval(0, 2);
    }
    const dehyst_real y = unit_step(&state, any_real(), Frama_C_nondet(0, 1));
    //@ assert answer: \is_finite(y) && OUTPUT_LOW <= y <= OUTPUT_HIGH;
    //@ assert page: 0 <= state.page <= 2;
    //@ assert block: \is_finite(state.block.output) && OUTPUT_LOW <= state.block.output <= OUTPUT_HIGH;
    //@ assert share: \is_finite(state.block.share) && 0 <= state.block.share <= 1;
    for (int32_t i = 0; i < UNIT_OPERATORS; ++i) {
        //@ assert state: \is_finite(state.z[i]);
    }
    return 0;
}
