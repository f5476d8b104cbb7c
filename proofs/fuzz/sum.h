/* A sum of elements out of bytes: any numbers, also such as no check lets in. */
#ifndef SUM_H
#define SUM_H

#include "common.h"

enum { MOST = 6, POINTS = 4 };

/* A sum, and the memory that it points to. */
typedef struct drawn {
    dehyst_elements sum;
    dehyst_element element[MOST];
    dehyst_real u[MOST + 2][POINTS], v[MOST + 2][POINTS];
} drawn;

static void take_map(bytes *from, dehyst_map *map, dehyst_real *u, dehyst_real *v)
{
    const int32_t n = take_byte(from) % (POINTS + 1);
    for (int32_t i = 0; i < n; ++i) {
        u[i] = take_real(from);
        v[i] = take_real(from);
    }
    map->n = n;
    map->u = u;
    map->v = v;
}

static void take_sum(bytes *from, drawn *to)
{
    dehyst_elements *sum = &to->sum;
    sum->n = take_byte(from) % (MOST + 1);
    sum->element = to->element;
    take_map(from, &sum->before, to->u[MOST], to->v[MOST]);
    take_map(from, &sum->after, to->u[MOST + 1], to->v[MOST + 1]);
    sum->offset = take_real(from);
    sum->low = take_real(from);
    sum->high = take_real(from);
    sum->schedules = take_byte(from) % (DEHYST_SCHEDULES + 2);
    for (int32_t i = 0; i < DEHYST_SCHEDULES; ++i) {
        sum->source[i] = take_byte(from) % (DEHYST_GIVEN + 2) - 1;
        sum->schedule_low[i] = take_real(from);
        sum->schedule_high[i] = take_real(from);
    }
    for (int32_t k = 0; k < sum->n; ++k) {
        dehyst_element *q = &to->element[k];
        q->kind = take_byte(from) % (DEHYST_KINDS + 1);
        q->schedule = take_byte(from) % (DEHYST_SHARES + 1);
        q->radius = take_real(from);
        q->gain = take_real(from);
        q->weight = take_real(from);
        take_map(from, &q->map, to->u[k], to->v[k]);
    }
}

#endif
