/* LuGre friction over a curve: bristles that give way the more the slower they rub.
 *
 *     z' = v - |v| z / L(v),   L(v) = length (1 + (ratio - 1) exp(-(v / stribeck)^2))
 *     y = curve(x) + sigma0 z + sigma1 z' + sigma2 v
 *
 * The speed v is constant from sample to sample, so that z is solved exactly. */
#ifndef DEHYST_LUGRE_H
#define DEHYST_LUGRE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct engine_lugre {
    int32_t coefficients;
    const double *curve; /* (coefficients,): engine_curve() */
    double sigma[3], length, ratio, stribeck;
} engine_lugre;

/* Along x (samples,), dt (samples,) after the sample before, 0 for a move of no speed: y (samples,), and z, z', v at
 * each sample (samples, 3) unless null. memory (2,) holds x and z before the first sample; moved to the last one. */
void engine_lugre_run(const engine_lugre *p, int64_t samples, const double *x, const double *dt, double *memory,
                      double *y, double *columns);

/* x (samples,) for y (samples,), where y rises with x. */
void engine_lugre_invert(const engine_lugre *p, int64_t samples, const double *y, const double *dt, double farthest,
                         double *memory, double *x);

#ifdef __cplusplus
}
#endif

#endif
