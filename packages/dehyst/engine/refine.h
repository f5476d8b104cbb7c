/* Solution on a given passive set, in the cells.
 *
 * Between two passive operators the slope is constant: the unknowns are the slopes S of such groups of cells, and the
 * matrix is made of block sums of G. Its factor has about the square root of the condition of that of the weights, which
 * are differences of neighbouring S. */
#ifndef DEHYST_ENGINE_REFINE_H
#define DEHYST_ENGINE_REFINE_H

#include "cholesky.h"
#include "columns.h"

typedef struct refinement {
    const columns *columns;
    int32_t size, room;
    int32_t *member;   /* (size,) unknowns; the steps among them in the order in which their weights add up to slopes */
    int32_t *from, *to; /* (size,) cells of each group */
    uint8_t *linked;   /* (size,) the slope contains that of the member before */
    double *matrix;    /* (size, size) scaled block sums */
    double *unit;      /* (size,) their scale */
    double *rhs, *slope, *work; /* (size,) */
    double *cells;     /* (size, N) sums of G's rows over each group */
    const double **row; /* (size,) pointers to them */
    cholesky factor;
} refinement;

void refinement_free(refinement *r);
/* Solve for the unknowns with passive_j = 1: x (N,), zero elsewhere, and the gradient T'(rhs - G T x) + ..., scaled.
 * Returns -1, or an unknown whose pivot vanished, or -2 if memory is short. */
int32_t refine(refinement *r, const columns *c, const uint8_t *passive, double *x, double *gradient);
/* sqrt(largest / smallest eigenvalue) of the matrix, by a few power iterations from each end. */
double refinement_condition(refinement *r);
/* What the scaled gradient of member i would become without it, all others solved again: below rounding, it is zero. */
double refinement_gain(refinement *r, int32_t i, double x);

#endif
