/* Two inputs and two outputs out of bytes. Whatever they are: parameters that are let in lead to no undefined behaviour,
 * inputs lie within their limits and are found in time, and memory stays one that an input leaves. */
#include <stdio.h>

#include "sum.h"

static unsigned long let_in; /* printed at the end, so that nobody takes refusals for proofs */

__attribute__((destructor)) static void tell(void)
{
    fprintf(stderr, "let in %lu blocks of two inputs\n", let_in);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    drawn made[2];
    dehyst_real z[2][4][MOST];
    dehyst_pair pair[2];
    dehyst_pair_state state[2];
    take_sum(&from, &made[0]);
    take_sum(&from, &made[1]);
    for (int k = 0; k < 2; ++k) {
        pair[0].center[k] = take_real(&from);
        pair[0].half_range[k] = take_real(&from);
        pair[0].level[k] = take_real(&from);
        pair[0].amplitude[k] = take_real(&from);
        pair[0].rest[k] = take_real(&from);
        for (int i = 0; i < 2; ++i) {
            pair[0].path[k][i] = made[k == i ? 0 : 1].sum;
        }
    }
    pair[0].solves = 0;
    pair[1] = pair[0];
    pair[1].solves = 1;
    if (dehyst_pair_check(&pair[0]) != DEHYST_IMAGE_GOOD) {
        return 0;
    }
    ++let_in;
    for (int which = 0; which < 2; ++which) {
        for (int p = 0; p < 4; ++p) {
            state[which].path[p / 2][p % 2].z = z[which][p];
        }
        dehyst_pair_reset(&pair[which], &state[which]);
    }
    while (from.left > 0) {
        const dehyst_real sample[2] = {take_real(&from), take_real(&from)};
        dehyst_real answer[2];
        for (int which = 0; which < 2; ++which) {
            dehyst_pair_step(&pair[which], &state[which], sample, answer);
            CLAIM(state[which].rounds >= 0 && state[which].rounds <= 12 + DEHYST_HALVINGS);
            for (int p = 0; p < 4; ++p) {
                const dehyst_elements *path = &pair[which].path[p / 2][p % 2];
                const dehyst_elements_state *at = &state[which].path[p / 2][p % 2];
                CLAIM(dehyst_elements_memory_check(path, at->z, at->last) == DEHYST_IMAGE_GOOD);
            }
        }
    }
    return 0;
}
