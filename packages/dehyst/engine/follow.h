/* The output y that follows an input u, from the direct inverse u = D[y], solved sample by sample. D is that of
 * dehyst_direct (packages/dehyst/core/dehyst.h), but for what lies beyond the identified range of y: a compensator holds its polynomials
 * there, which leaves nothing to solve; here they go on along their tangents. */
#ifndef DEHYST_ENGINE_FOLLOW_H
#define DEHYST_ENGINE_FOLLOW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ENGINE_SETS = 6 }; /* most sets of weights */

/* Which factor multiplies a set of terms. */
enum { ENGINE_FACTOR_GIVEN = 0, ENGINE_FACTOR_FALLING = 1, ENGINE_FACTOR_RISING = 2 };

typedef struct engine_direct {
    int32_t sets, stops, paths, lags, powers;
    const double *radius;        /* (stops,) */
    const double *length;        /* (paths,) of path [output] */
    const double *time_constant; /* (lags,) [s] */
    const double *stop_weight;   /* (sets, stops) */
    const double *path_weight;   /* (sets, paths) */
    const double *creep_weight;  /* (sets, lags) */
    const double *polynomial;    /* (sets, powers) of powers 0, 1, ... of y - center */
    const double *viscous;       /* (sets,) */
    const int32_t *factor;       /* (sets,) ENGINE_FACTOR_: given at each sample, or 1 - xi or xi of the output itself */
    const double *low, *high;    /* (sets,) xi = (y - low) / (high - low), clipped to 0 ... 1 */
    double center;
    double held_low, held_high;  /* beyond it polynomials go on along their tangents, schedules of the output are held */
    double y_low, y_high;        /* where y is looked for */
} engine_direct;

/* Outputs y (samples,) with D[y]_k = u_k. The first one is given, and the memory after it: lowest and highest plays
 * (stops,), path lags (paths,); creep is at rest there. `given` (samples, sets) holds the factors of sets of the first
 * kind; NULL: all 1. The nearest crossing from below counts; where there is none the bound is taken. Returns the number
 * of such samples, or -1 if memory is short. */
int64_t engine_follow(const engine_direct *d, int64_t samples, const double *u, const double *time,
                      const double *given, double *lowest, double *highest, double *path, double *y);

#ifdef __cplusplus
}
#endif

#endif
