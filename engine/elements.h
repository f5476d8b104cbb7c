/* Elements in parallel: y_k = slope x_k + sum_i weight_i e_i, where every element is a play, a stop, a spring of one piece,
 * a damper, a creep or a rate. The families of hysteresis models that are sums of such elements are simulated, regressed and
 * inverted here. With x = x_k, x' = x_{k-1}, h the time between them and s the low-passed rate of the samples before k:
 *
 *   PLAY    z <- max(x - r, min(x + r, z)),  r = radius + extra |s|;       e = z
 *   STOP    e = clip(x - z, -r, r),  r as above;                           z <- x - e
 *   PIECE   e = clip(x - extra, -radius, radius)                           (a piece of a rising curve)
 *   DAMPER  e = clip((x - x') / h, -radius, radius), 0 where h = 0
 *   CREEP   z <- t + (z - t) exp(-h / extra), t = clip(z, x' - radius, x' + radius);   e = z
 *   RATE    e = s
 *
 * Creep and rate know past samples only, so what x_k must be for a wanted y_k is a rising piecewise linear equation. */
#ifndef DEHYST_ENGINE_ELEMENTS_H
#define DEHYST_ENGINE_ELEMENTS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ENGINE_PLAY, ENGINE_STOP, ENGINE_PIECE, ENGINE_DAMPER, ENGINE_CREEP, ENGINE_RATE, ENGINE_KINDS };
enum { ENGINE_ELEMENT_MEMORY = 2 }; /* numbers in front of the states */

typedef struct engine_elements {
    int32_t n;
    const int32_t *kind;           /* (n,) */
    const double *weight, *radius; /* (n,) radius >= 0 */
    const double *extra;           /* (n,) growth of the threshold [s], place of a piece, time constant of a creep [s] */
    double slope;
    double lag; /* time constant of the low-pass of the rate, > 0 [s] */
} engine_elements;

/* Outputs y (samples,) and, unless NULL, each element's e in bank (samples, n), for inputs x. dt (samples,) is the time from
 * the sample before, or NULL: 0 throughout. memory (2 + n,) is [x', s, z_1 .. z_n]. */
void engine_elements_run(const engine_elements *p, int64_t samples, const double *x, const double *dt, double *memory,
                         double *y, double *bank);

/* Inputs x (samples,) for outputs y, and the memory after them. The sum must not fall with x. Where y is out of reach within
 * |x| <= farthest the nearest such x is taken. */
void engine_elements_invert(const engine_elements *p, int64_t samples, const double *y, const double *dt, double farthest,
                            double *memory, double *x);

#ifdef __cplusplus
}
#endif

#endif
