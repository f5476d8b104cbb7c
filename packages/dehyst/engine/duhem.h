/* Duhem's model in the form of Coleman and Hodgdon, along x without time, over the curve f:
 *
 *     y = curve(x) - w,   dw/dx = h(x) - alpha sgn(dx) w
 *
 * h is a polynomial on [-1, 1] and constant beyond; then w has a closed form, a polynomial and an exponential. */
#ifndef DEHYST_DUHEM_H
#define DEHYST_DUHEM_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ENGINE_LOSSES = 16 }; /* most coefficients of h */

typedef struct engine_duhem {
    int32_t coefficients, losses;
    const double *curve; /* (coefficients,): engine_curve() */
    double alpha, low, high;                  /* h at -1 and at 1 */
    double particular[2][ENGINE_LOSSES];      /* polynomials that solve the equation for falling and for rising x */
} engine_duhem;

/* loss (losses,): coefficients of h, lowest first; alpha > 0. */
void engine_duhem_make(engine_duhem *p, int32_t coefficients, const double *curve, double alpha, int32_t losses,
                       const double *loss);

/* Along x (samples,): y (samples,). memory (2,) holds x and w before the first sample; moved to the last one. */
void engine_duhem_run(const engine_duhem *p, int64_t samples, const double *x, double *memory, double *y);

/* x (samples,) for y (samples,), where y rises with x. */
void engine_duhem_invert(const engine_duhem *p, int64_t samples, const double *y, double farthest, double *memory,
                         double *x);

#ifdef __cplusplus
}
#endif

#endif
