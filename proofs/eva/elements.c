/* A sum of elements of every kind, forward and inverse: any samples in any sequence. */
#include "dehyst.h"

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

enum { N = DEHYST_KINDS };

static const dehyst_real u[3] = {-1, 0, 1};
static const dehyst_real v[3] = {-1, (dehyst_real)0.25, 1};
static const dehyst_elements sum = {
    N,
    (const dehyst_element[N]){{DEHYST_INPUT, 0, 0, 0, 1, {0, 0, 0}},
                              {DEHYST_PLAY, 1, (dehyst_real)0.25, 0, 1, {3, u, v}},
                              {DEHYST_STOP, 2, (dehyst_real)0.25, 0, 1, {0, 0, 0}},
                              {DEHYST_CREEP, 0, (dehyst_real)0.25, (dehyst_real)0.5, 1, {0, 0, 0}},
                              {DEHYST_RELAX, 0, 0, (dehyst_real)0.5, 1, {3, u, v}},
                              {DEHYST_PAST, 0, 0, (dehyst_real)0.5, 1, {0, 0, 0}},
                              {DEHYST_PATH, 0, (dehyst_real)0.25, 0, 1, {0, 0, 0}},
                              {DEHYST_WIDE, 0, (dehyst_real)0.25, (dehyst_real)0.5, 1, {0, 0, 0}}},
    {3, u, v}, {3, u, v}, 0, -2, 2, 2, {DEHYST_BY_OUTPUT, 1, 0}, {-1, 0, 0}, {1, 1, 0}};
static dehyst_real memory[N];
static dehyst_real ring[3];

int main(void)
{
    dehyst_elements_state state;
    dehyst_delay delay = {3, 0, ring};
    state.z = memory;
    dehyst_elements_reset(&sum, &state, 0, 0);
    while (Frama_C_nondet(0, 1)) {
        const dehyst_real given[DEHYST_GIVEN] = {any_real(), any_real()};
        const dehyst_real x = dehyst_delay_step(&delay, any_real());
        dehyst_real share[DEHYST_SHARES];
        (void)dehyst_elements_step(&sum, &state, x, given);
        (void)dehyst_elements_solve_step(&sum, &state, x, given);
        dehyst_elements_shares(&sum, &state, given, share);
        for (int32_t i = 0; i < 5; ++i) {
            //@ assert share: 0 <= share[i] <= 1;
        }
        const dehyst_real found = dehyst_elements_solve(&sum, &state, share, any_real());
        //@ assert found: -2 <= found <= 2;
        //@ assert rounds: 0 <= state.rounds <= DEHYST_ROUNDS;
        dehyst_elements_advance(&sum, &state, found);
    }
    return 0;
}
