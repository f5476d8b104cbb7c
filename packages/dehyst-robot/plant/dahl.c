/* Dahl: elements that approach their slipping force exponentially in kappa, and remember no reversal.
 *   df_i/dkappa = k_i (1 - f_i/W_i^up)    in contraction,
 *   df_i/dkappa = k_i (1 + f_i/W_i^down)  in elongation,   k_i = size share_i/strain_i
 * Exact for a step of kappa at one pressure. f dkappa = d(f^2/2k) + f^2/W |dkappa|: passive. */
#include "parts.h"

double plant_dahl(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up, double down)
{
    const double slip = change > 0.0 ? up : -down, distance = fabs(change / slip);
    double *f = state->element, sum = 0.0;
    for (int32_t i = 0; i < hysteresis->n; ++i) {
        if (distance > 0.0) {
            const double share = hysteresis->share[i];
            f[i] += (share * slip - f[i]) * plant_settled(state->cache.stiffness[i] / share * distance);
        }
        sum += f[i];
    }
    return sum;
}
