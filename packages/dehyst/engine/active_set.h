/* The active set method of Lawson and Hanson (Solving Least Squares Problems, 1974, ch. 23) on scaled normal equations. */
#ifndef DEHYST_ENGINE_ACTIVE_SET_H
#define DEHYST_ENGINE_ACTIVE_SET_H

#include "cholesky.h"
#include "columns.h"

/* Why an unknown may not enter now. */
enum { OPEN = 0, TRIED = 1, ALIKE = 2, BARRED = 3, GONE = 4 };

typedef struct active_set {
    columns columns;
    cholesky factor;
    uint8_t *passive;    /* the caller's */
    uint8_t *closed;     /* (N,) OPEN; TRIED, ALIKE until the passive set changes; BARRED until refined; GONE */
    int32_t *index;      /* unknowns in the order of the factor */
    double **row;        /* rows of Q formed so far, by unknown */
    const double **chosen; /* those of the factor */
    double *x;           /* (N,) solution, scaled and from the bounds: x_j >= 0 */
    double *next, *coefficient, *gather; /* (N,) work */
    double *gradient;    /* (N,) of the scaled unknowns */
    double *length;      /* (N,) what the free unknowns leave of the columns; 0: nothing */
    double tolerance;    /* of the gradient */
    double reference;    /* |y|, or the largest rhs of a scaled column: what rounding refers to */
    double target;       /* what the free unknowns leave of |y| */
    int32_t iterations, limit;
} active_set;

int active_set_make(active_set *a, const engine_program *program, uint8_t *passive);
void active_set_free(active_set *a);
/* Free unknowns into the factor, lengths and tolerance: 0, 1 if one of them vanished, or -1 if memory is short. */
int active_set_start(active_set *a);
/* Enter unknown j if that lowers the objective, then step until all passive unknowns are positive. 0; 1 if j cannot enter;
 * -1 if memory is short. */
int active_set_enter(active_set *a, int32_t j);
/* Enter unknowns until no gradient is above the tolerance: 0; 1 out of iterations; -1 if memory is short. */
int active_set_run(active_set *a);
/* Enter all marked unknowns at once (warm start) and drop those that turn negative. */
int active_set_warm(active_set *a, const uint8_t *marked);
/* Open unknown with the largest gradient by length, or -1 if none is above the tolerance. */
int32_t active_set_steepest(const active_set *a);
void active_set_drop(active_set *a, int32_t j, uint8_t closed);
void active_set_reopen(active_set *a, uint8_t most);

#endif
