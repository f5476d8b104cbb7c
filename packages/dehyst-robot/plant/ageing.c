/* Ageing: Maxwell-slip springs whose contacts grow while they rest, and are worn away by motion.
 *   f_i <- clip(f_i + k_i dkappa, -a W_i^down, a W_i^up),   a = 1 + b ln(1 + theta/theta_0),
 *   d theta/dt = 1 - theta |dkappa/dt|/D,   exact for a step at one speed
 * After a rest the first stroke is stiffer than the second. Dieterich, J. Geophysical Research 84, 1979, and Ruina, 88,
 * 1983: logarithmic growth with the age of contacts; the three numbers are assumptions. */
#include "parts.h"

#define GROWTH 0.05     /* b: 12 % a decade of time */
#define SHORTEST 0.1    /* theta_0, [s] */
#define RENEWAL 0.02    /* D: contraction that renews the contacts, 8 mm of a muscle of 0.4 m */

double plant_ageing(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up, double down,
                    double period)
{
    const double worn = fabs(change) / RENEWAL, settled = plant_settled(worn);
    state->age = state->age * (1.0 - settled) + period * (worn > 0.0 ? settled / worn : 1.0);
    const double a = 1.0 + GROWTH * log1p(state->age / SHORTEST);
    return plant_maxwell_slip(hysteresis, state, change, a * up, a * down);
}
