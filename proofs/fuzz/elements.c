/* Sums of elements out of bytes. Whatever they are: parameters that are let in lead to no undefined behaviour, a solution
 * lies within the range and ends in time, and memory stays one that an input leaves. */
#include "common.h"

enum { MOST = 6, POINTS = 4 };

static int32_t take_map(bytes *from, dehyst_map *map, dehyst_real *u, dehyst_real *v)
{
    const int32_t n = take_byte(from) % (POINTS + 1);
    for (int32_t i = 0; i < n; ++i) {
        u[i] = take_real(from);
        v[i] = take_real(from);
    }
    map->n = n;
    map->u = u;
    map->v = v;
    return n;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    dehyst_element element[MOST];
    dehyst_real u[MOST + 2][POINTS], v[MOST + 2][POINTS], z[2][MOST], column[MOST], ring[3] = {0};
    dehyst_elements sum = {.n = take_byte(&from) % (MOST + 1), .element = element};
    take_map(&from, &sum.before, u[MOST], v[MOST]);
    take_map(&from, &sum.after, u[MOST + 1], v[MOST + 1]);
    sum.offset = take_real(&from);
    sum.low = take_real(&from);
    sum.high = take_real(&from);
    sum.schedules = take_byte(&from) % (DEHYST_SCHEDULES + 2);
    for (int32_t i = 0; i < DEHYST_SCHEDULES; ++i) {
        sum.source[i] = take_byte(&from) % 4 - 1;
        sum.schedule_low[i] = take_real(&from);
        sum.schedule_high[i] = take_real(&from);
    }
    for (int32_t k = 0; k < sum.n; ++k) {
        dehyst_element *q = &element[k];
        q->kind = take_byte(&from) % (DEHYST_KINDS + 1);
        q->schedule = take_byte(&from) % (DEHYST_SHARES + 1);
        q->radius = take_real(&from);
        q->gain = take_real(&from);
        q->weight = take_real(&from);
        take_map(&from, &q->map, u[k], v[k]);
    }
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
        const dehyst_real given[DEHYST_GIVEN] = {take_real(&from), take_real(&from)}, x = take_real(&from);
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
