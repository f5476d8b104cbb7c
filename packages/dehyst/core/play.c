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
