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

dehyst_real dehyst_weighted_sum(int32_t n, const dehyst_real *weight, const dehyst_real *z)
{
    dehyst_real part[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    const int32_t whole = n - n % 8;
    for (int32_t i = 0; i < whole; i += 8) {
        for (int32_t j = 0; j < 8; ++j) {
            part[j] += weight[i + j] * z[i + j];
        }
    }
    for (int32_t i = whole; i < n; ++i) {
        part[i - whole] += weight[i] * z[i];
    }
    return ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
}
