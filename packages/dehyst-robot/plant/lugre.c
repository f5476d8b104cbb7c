/* LuGre: one bristle whose sliding force falls with speed (Stribeck).
 *   df/dkappa = k (1 -+ f/g(v)),   g(v) = W (1 + s exp(-(v/v_s)^2)),   k = size/strain
 * Without its micro damping it takes energy at every speed. Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans.
 * Automatic Control 40(3), 1995; its two numbers are assumptions. */
#include "parts.h"

#define STRIBECK 0.3       /* s: share of the sliding force that is gone at high speed */
#define STRIBECK_SPEED 0.02 /* v_s, 8 mm/s of a muscle of 0.4 m, [1/s] */

double plant_lugre(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up, double down,
                   double period)
{
    const double v = change / period / STRIBECK_SPEED;
    const double g = 1.0 + STRIBECK * exp(-v * v);
    return plant_dahl(hysteresis, state, change, g * up, g * down);
}
