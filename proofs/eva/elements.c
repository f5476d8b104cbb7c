/* A sum of elements of every kind, forward and inverse: any samples in any sequence. */
#include "elements.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

static const dehyst_elements sum = SUM;
static dehyst_real ring[3];

int main(void)
{
    dehyst_elements_state state;
    dehyst_delay delay = {3, 0, ring};
    state.z = memory;
    dehyst_elements_reset(&sum, &state, 0, 0);
    while (Frama_C_nondet(0, 1)) {
        const dehyst_real given[DEHYST_GIVEN] = {any_real(), any_real(), any_real()};
        const dehyst_real x = dehyst_delay_step(&delay, any_real());
        dehyst_real share[DEHYST_SHARES];
        (void)dehyst_elements_step(&sum, &state, x, given);
        (void)dehyst_elements_solve_step(&sum, &state, x, given);
        dehyst_elements_shares(&sum, &state, given, share);
        for (int32_t i = 0; i < 5; ++i) {
            //@ assert share: 0 <= share[i] <= 1;
        }
        const dehyst_real found = dehyst_elements_solve(&sum, &state, share, any_real());
        //@ assert found: LOW <= found <= HIGH;
        //@ assert rounds: 0 <= state.rounds <= DEHYST_ROUNDS;
        dehyst_elements_advance(&sum, &state, found);
    }
    return 0;
}
