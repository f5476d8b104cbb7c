#include "dehyst.h"

void dehyst_play_step(int32_t n, const dehyst_real *threshold, dehyst_real x, dehyst_real *z)
{
    for (int32_t i = 0; i < n; ++i) {
        const dehyst_real low = x - threshold[i];
        const dehyst_real high = x + threshold[i];
        const dehyst_real capped = z[i] < high ? z[i] : high;
        z[i] = capped > low ? capped : low;
    }
}

dehyst_real dehyst_pi_output(const dehyst_pi *pi, const dehyst_real *z)
{
    /* sum_i w_i z_i = sum_{i<n} S_i (z_i - z_{i+1}) + S_n z_n,  S_i = w_1 + ... + w_i (Abel).
     * An inverse has weights far larger than its slopes S: the left side loses the digits that the right side keeps. */
    const dehyst_real *r = pi->threshold;
    const int32_t last = pi->n - 1;
    dehyst_real slope = 0;
    dehyst_real sum = 0;
    int32_t i = 0;
    if (last > 0) {
        /* Plays dragged by the present input lie r_{i+1} - r_i apart; z_i - z_{i+1} knows that only up to the
         * rounding of the input. With r_1 = 0 that input is z_1. */
        const dehyst_real side = z[1] < z[0] ? (dehyst_real)1 : (dehyst_real)-1;
        while (i < last && z[i + 1] == z[0] - side * r[i + 1]) {
            slope += pi->weight[i];
            sum += slope * (side * (r[i + 1] - r[i]));
            ++i;
        }
    }
    while (i < last) {
        slope += pi->weight[i];
        sum += slope * (z[i] - z[i + 1]);
        ++i;
    }
    slope += pi->weight[last];
    return pi->offset + (sum + slope * z[last]);
}
