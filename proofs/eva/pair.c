/* Two inputs and two outputs with all kinds of elements, evaluated and solved: any samples in any sequence. */
#include "elements.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

#define PATH_SUM {ELEMENTS, element, {0, 0, 0}, {0, 0, 0}, 0, LOW, HIGH, 0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}

static const dehyst_pair pair = {
    {{PATH_SUM, PATH_SUM}, {PATH_SUM, PATH_SUM}}, {1, 0}, {2, 1}, {0, 1}, {1, -1}, {0, 0}, SOLVES};
static dehyst_real z[4][ELEMENTS];

int main(void)
{
    dehyst_pair_state state;
    state.path[0][0].z = z[0];
    state.path[0][1].z = z[1];
    state.path[1][0].z = z[2];
    state.path[1][1].z = z[3];
    dehyst_pair_reset(&pair, &state);
    while (Frama_C_nondet(0, 1)) {
        const dehyst_real sample[2] = {any_real(), any_real()};
        dehyst_real answer[2];
        dehyst_pair_step(&pair, &state, sample, answer);
        //@ assert rounds: 0 <= state.rounds <= 12 + DEHYST_HALVINGS;
        //@ assert flags: 0 <= state.flags <= 15;
#if SOLVES
        //@ assert first: 1 + 2 * LOW <= answer[0] <= 1 + 2 * HIGH;
        //@ assert second: LOW <= answer[1] <= HIGH;
#else
        //@ assert first: \is_finite(answer[0]);
        //@ assert second: \is_finite(answer[1]);
#endif
    }
    return 0;
}
