#include "dehyst.h"

void dehyst_stop_to_play(int32_t n, dehyst_real slope, const dehyst_real *stop_weight,
                         dehyst_real *weight)
{
    dehyst_real total = slope;
    for (int32_t i = 1; i < n; ++i) {
        total += stop_weight[i];
        weight[i] = -stop_weight[i];
    }
    weight[0] = total;
}
