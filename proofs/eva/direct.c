/* A direct inverse and its learning, each on its own: any samples in any sequence, any torque that was measured. */
#include "dehyst.h"

#include "direct.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

static const dehyst_adaptation adaptation = ADAPTATION;
static dehyst_real memory[MEMORY];
static dehyst_direct_state state;
static dehyst_learning learning;

int main(void)
{
    dehyst_direct begun = direct;
    begun.past = Frama_C_interval(DEHYST_PAST_UNKNOWN, DEHYST_PAST_FALLING);
    state.memory = memory;
    dehyst_direct_reset(&begun, &state, dehyst_within(any_real(), -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT));
    dehyst_learning_reset(&adaptation, &learning);
    while (Frama_C_nondet(0, 1)) {
        const dehyst_real given[DEHYST_GIVEN] = {any_real(), any_real(), any_real()};
        dehyst_real part[DEHYST_GROUPS];
        for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
            part[g] = any_real();
        }
        const dehyst_real share = dehyst_within(any_real(), 0, 1);
        dehyst_direct_step(&direct, &state, any_real(), any_real(), given);
        (void)dehyst_learning_step(&adaptation, &learning, direct.groups, (dehyst_real)5e-4, any_real(), part, any_real(),
                                   share, Frama_C_nondet(0, 1));
        const dehyst_real u = dehyst_direct_output(&direct, &state, learning.applied);
        //@ assert output: \is_finite(u) && -60 <= u <= 60;
        for (int32_t i = 0; i < 2 * STOPS; ++i) {
            //@ assert memory: \is_finite(memory[i]) && -2 <= memory[i] <= 2;
        }
        for (int32_t g = 0; g < 4; ++g) {
            //@ assert scale: \is_finite(learning.scale[g]) && 0 <= learning.scale[g] <= 2;
        }
        //@ assert offset: \is_finite(learning.offset) && -2 <= learning.offset <= 2;
    }
    return 0;
}
