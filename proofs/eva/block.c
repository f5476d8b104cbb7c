/* Any sequence of samples, each of them any real, NaN and the infinities among them, and any switching. */
#include "parameters.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

static dehyst_block_state state;

int main(void)
{
    state.model.z = z;
    dehyst_block_reset(&block, &state);
#ifdef ANY_STATE /* what dehyst_block_restore lets in, and more: states need not be admissible */
    for (int32_t i = 0; i < N; ++i) {
        z[i] = any_real();
        //@ admit \is_finite(z[i]) && -DEHYST_INPUT_LIMIT <= z[i] <= DEHYST_INPUT_LIMIT;
    }
    state.model.output = any_real();
    //@ admit \is_finite(state.model.output);
    state.output = any_real();
    //@ admit \is_finite(state.output) && OUTPUT_LOW <= state.output <= OUTPUT_HIGH;
    state.share = any_real();
    //@ admit \is_finite(state.share) && 0 <= state.share <= 1;
    state.started = Frama_C_interval(0, 1);
    state.flags = Frama_C_unsigned_int_interval(0, 15);
#endif
    while (Frama_C_nondet(0, 1)) {
        const dehyst_real y = dehyst_block_step(&block, &state, any_real(), Frama_C_nondet(0, 1));
        //@ assert output: \is_finite(y) && OUTPUT_LOW <= y <= OUTPUT_HIGH;
        //@ assert share: \is_finite(state.share) && 0 <= state.share <= 1;
        for (int32_t i = 0; i < N; ++i) {
            //@ assert state: \is_finite(z[i]);
        }
    }
    return 0;
}
