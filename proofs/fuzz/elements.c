/* Sums of elements out of bytes. Whatever they are: parameters that are let in lead to no undefined behaviour, a solution
 * lies within the range and ends in time, and memory stays one that an input leaves. */
#include "sum.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    drawn made;
    dehyst_real z[2][MOST], column[MOST], ring[3] = {0};
    take_sum(&from, &made);
    const dehyst_elements sum = made.sum;
    if (dehyst_elements_check(&sum) != DEHYST_IMAGE_GOOD) {
        return 0;
    }
    dehyst_elements_state forward = {.z = z[0]}, inverse = {.z = z[1]};
    dehyst_delay delay = {take_byte(&from) % 4, 0, ring};
    dehyst_real start = take_real(&from);
    start = dehyst_accept(start) ? start : 0;
    dehyst_elements_reset(&sum, &forward, start, 0);
    dehyst_elements_reset(&sum, &inverse, start, 0);
    while (from.left > 0) {
        const dehyst_real given[DEHYST_GIVEN] = {take_real(&from), take_real(&from), take_real(&from)}, x = take_real(&from);
        const dehyst_real y = dehyst_elements_step(&sum, &forward, x, given);
        dehyst_elements_solve_step(&sum, &inverse, take_byte(&from) % 2 ? y : take_real(&from), given);
        CLAIM(inverse.rounds >= 0 && inverse.rounds <= DEHYST_ROUNDS);
        CLAIM((inverse.flags & DEHYST_REJECTED) || within(inverse.last, sum.low, sum.high));
        CLAIM(dehyst_elements_memory_check(&sum, forward.z, forward.last) == DEHYST_IMAGE_GOOD);
        CLAIM(dehyst_elements_memory_check(&sum, inverse.z, inverse.last) == DEHYST_IMAGE_GOOD);
        dehyst_delay_step(&delay, x);
    }
    dehyst_elements_columns(&sum, &forward, start, column);
    return 0;
}
