/* Elements of dry friction along a path, without time (Dahl, Bouc-Wen, generalised Bouc-Wen):
 *
 *     dz/dx = slope - psi(sgn dx, sgn z, sgn x) |z|^power
 *
 * psi is a table of eight numbers, so the equation is separable between changes of a sign. Power 1 is solved exactly
 * by exponentials; other powers by Runge-Kutta steps of fifth order that end at each change of a sign. */
#ifndef DEHYST_FRICTION_H
#define DEHYST_FRICTION_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of an element: slope > 0, power >= 1, psi (8,). psi stands at 4 (dx > 0) + 2 (z > 0) + (x > 0). */
enum { ENGINE_FRICTION = 10, ENGINE_PHASES = 8 };

/* Steepness of d(dz/dx)/dz where dz/dx = 0, limit (elements, ENGINE_PHASES): what every step of an element looks up. */
void engine_friction_limits(int32_t elements, const double *element, double *limit);

/* y = curve(x) + sum of weight z. */
typedef struct engine_bank {
    int32_t coefficients, elements;
    const double *curve;   /* (coefficients,): engine_curve() */
    const double *element; /* (elements, ENGINE_FRICTION) */
    const double *weight;  /* (elements,) */
    const double *limit;   /* (elements, ENGINE_PHASES): engine_friction_limits() */
} engine_bank;

/* Along x (samples,): y (samples,), and the states z (samples, elements) unless null. memory (1 + elements,) holds the
 * x before the first sample and the states there; it is moved to the last sample. */
void engine_bank_run(const engine_bank *bank, int64_t samples, const double *x, double *memory, double *y, double *z);

/* x (samples,) for y (samples,), where y rises with x in every state; memory as above, power (elements,) is for its use. */
void engine_bank_invert(const engine_bank *bank, int64_t samples, const double *y, double farthest, double *memory,
                        double *power, double *x);

#ifdef __cplusplus
}
#endif

#endif
