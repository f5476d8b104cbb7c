/* Cholesky factor L of a growing and shrinking symmetric matrix, with z = L^-1 b carried along.
 *
 * Rows are stored one after the other and padded to eight numbers with zeros, so all sweeps run along rows. */
#ifndef DEHYST_ENGINE_CHOLESKY_H
#define DEHYST_ENGINE_CHOLESKY_H

#include <stdint.h>

typedef struct cholesky {
    int32_t size, room;
    double *rows;    /* L, padded */
    double *z;       /* (room,) L^-1 b */
    double *inverse; /* (room,) of the pivots */
    double *work;    /* (2 room,) rotations */
} cholesky;

int cholesky_make(cholesky *f, int32_t room); /* 0, or -1 if memory is short */
void cholesky_free(cholesky *f);
/* Append a row (size,) with its diagonal and right-hand side. Returns the squared pivot; where it is not above `least`
 * nothing is appended. -1.0e300 if memory is short. */
double cholesky_append(cholesky *f, const double *row, double diagonal, double b, double least);
/* Remove the unknown at `position` by plane rotations. */
void cholesky_remove(cholesky *f, int32_t position);
/* x (size,) = L'^-1 y; x may be y. */
void cholesky_back(const cholesky *f, const double *y, double *x);
/* x (size,) = L^-1 b; x may be b. */
void cholesky_forward(const cholesky *f, const double *b, double *x);

#endif
