/* Creep: first-order branches z' = (x - z)/tau on contraction and pressure, exact for x that moves linearly in a step.
 * The gap e = x - z follows e <- exp(-T/tau) e + (1 - exp(-T/tau)) tau/T dx. */
#include "parts.h"

void plant_creep_prepare(const plant_muscle *muscle, plant_cache *cache, double period)
{
    for (int32_t j = 0; j < PLANT_CREEP; ++j) {
        const int used = j < muscle->creep_branches;
        const double z = used ? period / muscle->creep_time[j] : 1.0, settled = plant_settled(z);
        cache->creep_decay[j] = used ? 1.0 - settled : 0.0;
        cache->creep_ramp[j] = used ? settled / z : 0.0;
    }
}

double plant_creep_step(const plant_muscle *muscle, plant_muscle_state *state, double kappa_change, double p_change)
{
    const double *decay = state->cache.creep_decay, *ramp = state->cache.creep_ramp;
    double term[PLANT_CREEP];
    for (int32_t j = 0; j < PLANT_CREEP; ++j) { /* all branches: unused ones are zero, and the loop has a fixed length */
        const double e = decay[j] * state->creep_contraction[j] + ramp[j] * kappa_change;
        const double d = decay[j] * state->creep_pressure[j] + ramp[j] * p_change;
        state->creep_contraction[j] = e;
        state->creep_pressure[j] = d;
        term[j] = muscle->creep_force[j] * e + muscle->creep_pressure[j] * d;
    }
    return ((term[0] + term[1]) + (term[2] + term[3])) + ((term[4] + term[5]) + (term[6] + term[7]));
}
