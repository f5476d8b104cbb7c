/* A mass on a spring, a damper and elements with hysteresis, driven by a force: m y'' + c y' + k y + k3 y^3 + h = u.
 *
 *   h = z + sum_i (w_i + v_i y^2) s_i,
 *   z' = y' (alpha - beta (gamma s |z|^(nu-1) z + delta |z|^nu))   law ENGINE_BOUC_WEN, s the sign of y'
 *   z' = y' G(s z), G piecewise linear on a grid                   law ENGINE_SLOPES (a Duhem model with local memory)
 *   s_i = stop operator of y with threshold r_i (Maxwell slip; v_i lets its stiffness depend on the position)
 *
 * Runge-Kutta of order four on a grid that is several times finer than the samples. The laws have corners where y' (and,
 * in the first, z) changes its sign; a step never crosses one: it ends there and a new one starts, which keeps the order.
 * Saturation of a stop and knots of G are corners of small jumps and are stepped over.
 */
#ifndef DEHYST_OSCILLATOR_H
#define DEHYST_OSCILLATOR_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ENGINE_NO_LAW = 0, ENGINE_BOUC_WEN = 1, ENGINE_SLOPES = 2 };

typedef struct engine_oscillator {
    double mass, damping;           /* m > 0, c */
    double stiffness, cubic;        /* k, k3 */
    int32_t law;
    double alpha, beta, gamma, delta, nu; /* ENGINE_BOUC_WEN; nu >= 1 */
    int32_t knots;                  /* ENGINE_SLOPES: G at first + j spacing, continued by its end pieces; >= 2 */
    const double *slope;            /* (knots,) */
    double first, spacing;          /* spacing > 0 */
    int32_t stops;
    const double *threshold, *weight, *square; /* (stops,): r_i > 0, w_i, v_i */
} engine_oscillator;

/* Rows (y, y', h) at each of the samples, dt apart; force (2 steps (samples - 1) + 1,) holds u at every half step.
 * state (3 + stops,) = y, y', z, s_1, ..., in: at the first sample, out: at the last. Returns how many samples are
 * finite; the first one that is not ends the run. */
int64_t engine_oscillate(const engine_oscillator *o, int64_t samples, int32_t steps, double dt, const double *force,
                         double *state, double *rows);

#ifdef __cplusplus
}
#endif

#endif
