/* Maxwell slip: springs of stiffness k_i that slip at a force W_i which grows with pressure.
 *   f_i <- clip(f_i + k_i dkappa, -W_i^down, W_i^up),  k_i = size share_i/strain_i,  W_i = share_i g(p) size (1 +- asymmetry)
 * Falling pressure lets a loaded element slip at rest; the energy of its spring is lost, never gained. */
#include "parts.h"

double plant_maxwell_slip(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up,
                          double down)
{
    const int32_t n = (hysteresis->n + 3) / 4 * 4; /* arrays are zero beyond n */
    const double *restrict stiffness = state->cache.stiffness;
    const double *restrict share = hysteresis->share;
    double *restrict f = state->element;
    for (int32_t i = 0; i < n; ++i) {
        const double tried = f[i] + stiffness[i] * change;
        const double high = share[i] * up, low = share[i] * -down;
        const double capped = tried < high ? tried : high;
        f[i] = capped > low ? capped : low;
    }
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    for (int32_t i = 0; i < n; i += 4)
        for (int32_t j = 0; j < 4; ++j) sum[j] += f[i + j];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}
