/* Pinched: a Bouc-Wen spring that is soft where it takes up slack. With the load u = f/W in the direction of motion,
 *   df/dkappa = k h(u) (1 - max(u, 0)),   h(u) = 1 - d exp(-((u - q)/s)^2),   k = size/strain
 * After a reversal the spring is soft once, just past the zero of its force. The slack lies after that zero, q > 0, so
 * that a stroke never gives back more than it took. Baber and Noori, J. Vibration and Acoustics 108(4), 1986; h of Foliente, J. Structural Engineering
 * 121(6), 1995; the three numbers are assumptions. */
#include "parts.h"

#define DEPTH 0.8   /* d */
#define PLACE 0.1   /* q */
#define WIDTH 0.3   /* s */
#define STEP 0.05   /* of u where the spring is stiffest, in one step of the integration */
#define STEPS 4096.0

static double slope(double u)
{
    const double at = (u - PLACE) / WIDTH, h = 1.0 - DEPTH * exp(-at * at);
    return h * (u > 0.0 ? 1.0 - u : 1.0);
}

double plant_pinched(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up,
                     double down)
{
    const double way = change > 0.0 ? 1.0 : -1.0;
    const double slip = change > 0.0 ? up : down;
    const double distance = fabs(change) / hysteresis->strain[0] * hysteresis->size / slip;
    const int32_t steps = 1 + (int32_t)plant_clip(distance / STEP, 0.0, STEPS);
    const double h = distance / steps, begin = way * state->element[0] / slip;
    double u = begin;
    for (int32_t i = 0; i < steps && distance > 0.0; ++i) { /* the classical method of Runge and Kutta */
        const double a = slope(u), b = slope(u + 0.5 * h * a), c = slope(u + 0.5 * h * b), d = slope(u + h * c);
        u += h * (1.0 / 6) * (a + 2.0 * (b + c) + d);
    }
    /* A load goes to 1 and not beyond it, however large the steps are. */
    if (distance > 0.0) state->element[0] = way * slip * plant_clip(u, begin < 1.0 ? begin : 1.0, begin > 1.0 ? begin : 1.0);
    return state->element[0];
}
