#include "dehyst.h"

/* Largest relative change of a weight by error feedback: far below what any measurement sees. */
#ifdef DEHYST_FLOAT
#define FEEDBACK 1e-4f
#else
#define FEEDBACK 1e-10
#endif

int32_t dehyst_pi_invert(int32_t n, const dehyst_real *threshold, const dehyst_real *weight,
                         const dehyst_real *z, dehyst_real *inverse_threshold,
                         dehyst_real *inverse_weight, dehyst_real *inverse_z)
{
    if (n < 1 || threshold[0] > 0 || threshold[0] < 0) {
        return -1; /* without r_1 = 0 the model has a dead zone: many inputs give one output */
    }
    const dehyst_real sign = weight[0] < 0 ? (dehyst_real)-1 : (dehyst_real)1;
    dehyst_real sum = 0;    /* S_i */
    dehyst_real before = 0; /* S_{i-1} */
    dehyst_real radius = 0; /* r'_i */
    dehyst_real slope = 0;  /* w'_1 + ... + w'_i as the core will sum it; exactly it would be 1/S_i */
    for (int32_t i = 0; i < n; ++i) {
        before = sum;
        sum += weight[i];
        if (!(sign * sum > 0)) {
            return i + 1;
        }
        /* r'_i - r'_{i-1} = S_{i-1} (r_i - r_{i-1}): the sum of the header without its cancellation */
        if (i > 0) {
            radius += sign * before * (threshold[i] - threshold[i - 1]);
        }
        inverse_threshold[i] = radius;
        inverse_weight[i] = i == 0 ? 1 / sum : -weight[i] / sum / before;
        /* Hand the rounding of the earlier weights to this one if it is small beside it: with w_1 = 0.001 the
         * first weight is 1000 and its last digit would be felt in every later slope. */
        const dehyst_real missing = 1 / sum - (slope + inverse_weight[i]);
        const dehyst_real room = (inverse_weight[i] < 0 ? -inverse_weight[i] : inverse_weight[i]) * FEEDBACK;
        if (missing <= room && missing >= -room) {
            inverse_weight[i] += missing;
        }
        slope += inverse_weight[i];
        inverse_z[i] = sum; /* S_i, kept here until the second pass replaces it */
    }
    /* z'_n = S_n z_n and z'_i - z'_{i+1} = S_i (z_i - z_{i+1}) */
    dehyst_real state = sum * z[n - 1];
    inverse_z[n - 1] = state;
    for (int32_t i = n - 2; i >= 0; --i) {
        state += inverse_z[i] * (z[i] - z[i + 1]);
        inverse_z[i] = state;
    }
    return 0;
}
