/* Inside the evaluator: one operator evaluated by events. Private to engine/. */
#ifndef DEHYST_MACHINE_H
#define DEHYST_MACHINE_H

#include <math.h>

#include "stack.h"

/* With slopes S_i = w_1 + ... + w_i and the loading curve phi_i = sum_{j<i} S_j (r_{j+1} - r_j) the output is
 *   y = (s phi_{b-1} + Y_b) + S_{b-1} (x - x_r),   x_r = s r_{b-1} + z_b,   Y_b = sum of the cells from b on,
 * operators counted from 0. Y_b is never accumulated over time: it follows from the sum stored with the segment below. */
typedef struct machine {
    stack_grid grid;
    stack stack;
    double *slope;    /* (n,) S */
    double *phi;      /* (n,) */
    double *rest_sum; /* (n + 1,) sum of the cells from i on while all operators rest */
    double *frozen;   /* (n + 2,) of a segment below the top: sum of the cells from its last one (b - 1) on */
    double offset;    /* added to the output */
    double above;     /* Y_b of the top */
    double base, gain, origin; /* of the present line y = base + gain (x - origin) */
    int64_t events;
    int64_t crawled;  /* of them: the boundary moved on by an operator or a few, as on smooth signals */
    double reach;     /* largest |x| at a turning point */
    double size;      /* largest |y - offset| at one */
    uint32_t *depth;  /* (n / 8 + 1,) events that changed (8 i, 8 i + 8] operators, since machine_forget */
    double *memory;   /* one block for all arrays */
    double *r;        /* (n,) thresholds */
    double *rest;     /* (n,) states in the beginning */
} machine;

/* Tables of n operators, r_0 = 0, or -1 if memory is short. |x| <= limit. The state is not set yet. */
int machine_make(machine *m, int32_t n, const double *r, const double *w, double limit);
void machine_free(machine *m);
/* Start at admissible states z (n,); x = z_0 was the last sample. */
void machine_start(machine *m, const double *z);
/* Present states (n,). */
void machine_state(const machine *m, double *z);
/* Forget the depths of past events. */
void machine_forget(machine *m);

/* The line of the present top segment. */
static inline void machine_line(machine *m)
{
    const stack *k = &m->stack;
    const stack_segment *top = &k->segment[k->top], *below = top - 1;
    const int32_t b = top->b;
    const double z = stack_below(&m->grid, k);
    m->above = k->top == 1 ? m->rest_sum[b] : m->frozen[k->top - 1] + below->s * (m->phi[below->b - 1] - m->phi[b]);
    m->base = (top->s * m->phi[b - 1] + m->above) + m->offset;
    m->gain = m->slope[b - 1];
    m->origin = top->s * m->grid.r[b - 1] + z;
}

/* Put x on the stack; the top's e is the sample before. */
static inline void machine_event(machine *m, double x)
{
    stack *k = &m->stack;
    const stack_segment *top = &k->segment[k->top];
    if (top->b > 1 && top->s != stack_direction(k, x)) {
        const double moving = m->gain * (top->e - m->origin);
        m->frozen[k->top] = m->above + moving;
        const double reach = fabs(top->e), size = fabs(m->base - m->offset + moving);
        m->reach = reach > m->reach ? reach : m->reach;
        m->size = size > m->size ? size : m->size;
    }
    stack_event(&m->grid, k, x);
    machine_line(m);
    ++m->events;
    ++m->depth[(k->depth - 1) >> 3];
}

#endif
