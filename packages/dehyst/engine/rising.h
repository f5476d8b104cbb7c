/* Where a rising function of one variable is zero, and monotone polynomials with straight ends: for host models. */
#ifndef DEHYST_RISING_H
#define DEHYST_RISING_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* value(context, x), rising in x. */
typedef double (*engine_rising)(const void *context, double x);

/* The x at which f is zero, from a guess; the nearest end of +-farthest where there is none. The first bracket is as wide
 * as f at the guess asks for, f being scaled. Then inverse quadratic interpolation, to the last bits of x. */
double engine_root(engine_rising f, const void *context, double guess, double farthest);

/* c[0] + c[1] x + ... of `size` coefficients within [-1, 1], beyond it straight on along the tangent. */
double engine_curve(int32_t size, const double *c, double x);

#ifdef __cplusplus
}
#endif

#endif
