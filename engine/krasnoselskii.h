/* Krasnosel'skii-Pokrovskii operator: a weighted sum of kernels, each a play between two ridges of finite slope.
 *
 * The ridge r(u) rises from -1 at u = 0 to 1 at u = ridge. Kernel (i, j), j <= i, follows
 *   z = max(r(x - line_i), min(r(x - line_j), z of the sample before)),
 * so it rises along the ridge of line i and falls along that of line j; it is number i (i + 1)/2 + j.
 */
#ifndef DEHYST_ENGINE_KRASNOSELSKII_H
#define DEHYST_ENGINE_KRASNOSELSKII_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct engine_kernels {
    int32_t n;            /* lines */
    const double *line;   /* (n,) strictly increasing: where a ridge begins */
    double ridge;         /* its width, > 0 */
    const double *weight; /* (n (n + 1)/2,) */
    double offset;
    double below, above;  /* slopes of the output below line_1 and above line_n + ridge */
} engine_kernels;

/* Outputs y (samples,) along x (samples,), finite; the states z (n (n + 1)/2,) go on. x may be y; scratch (n,). */
void engine_kernels_run(const engine_kernels *p, double *z, int64_t samples, const double *x, double *scratch, double *y);
/* Inputs x (samples,) at which the output is y (samples,). Outputs must strictly follow inputs. */
void engine_kernels_invert(const engine_kernels *p, double *z, int64_t samples, const double *y, double *scratch, double *x);
/* States of all kernels at every sample, out (samples, n (n + 1)/2) row-major; weights are not read. */
void engine_kernels_states(const engine_kernels *p, double *z, int64_t samples, const double *x, double *scratch,
                           double *out);

#ifdef __cplusplus
}
#endif

#endif
