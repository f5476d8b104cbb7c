/* Unknowns u as columns over the cells: Q = T'G T + E without forming Q.
 *
 * Column j of T is one on an interval of cells and zero elsewhere, in all bases. So row j of Q is a running sum over
 * sum_{i in interval} G_i, and sums of G's rows up to every `stride`-th cell make that cheap: one pass over G, then only the
 * rows of unknowns that enter the passive set. Bounds are shifted away (u = lower + x) and columns have length one. */
#ifndef DEHYST_ENGINE_COLUMNS_H
#define DEHYST_ENGINE_COLUMNS_H

#include "engine.h"

typedef struct columns {
    const engine_program *program;
    int32_t first, last; /* cells of the plays */
    int32_t stride;
    double *kept;        /* (blocks + 1, N) sums of G's rows from the cell k stride to the open end of the intervals */
    double *lower;       /* (N,) zero where there is no bound */
    double *rhs;         /* (N,) g - G T lower, in cells */
    double *extra_rhs;   /* (N,) h - E lower, in u */
    double *target;      /* (N,) T' rhs + extra_rhs, scaled */
    double *scale;       /* (N,) 1 / |column|; 0 for a column of zeros */
    double *cells;       /* (N,) work */
    double *memory;
} columns;

int columns_make(columns *c, const engine_program *program); /* 0, or -1 if memory is short */
void columns_free(columns *c);
/* Cells [*from, *to) of unknown j. */
void columns_interval(const columns *c, int32_t j, int32_t *from, int32_t *to);
/* Row j of Q, scaled: (N,). */
void columns_row(const columns *c, int32_t j, double *row);
/* u_j = factor scale_j (T'v + extra)_j, extra may be null: the gradient in u from one in cells. */
void columns_transpose(const columns *c, const double *v, const double *extra, double factor, double *u);
/* v = T u */
void columns_apply(const columns *c, const double *u, double *v);

#endif
