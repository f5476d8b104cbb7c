/* Braid: Maxwell-slip springs whose slip force follows the contact of the strands. Two strands of one width that cross at
 * the angle 2 theta touch on an area in proportion to 1/sin(2 theta); cos(theta) = (1 - kappa) cos(theta_0).
 *   f_i <- clip(f_i + k_i dkappa, -w W_i^down, w W_i^up),   w = sin(2 theta(center))/sin(2 theta(kappa))
 * Loops are wide where the muscle is long. Davis and Caldwell, Int. J. Robotics Research 25(4), 2006: friction by the
 * contact of strands; 24 degrees are an assumption: the muscle's volume is
 * that of 28.6, with which the width would change less. */
#include "parts.h"

#define COS_AT_REST 0.9135 /* theta_0 = 24 degrees */
#define LARGEST_COS 0.978  /* 12 degrees: strands cannot lie closer to the axis */

/* sin(2 theta) at a contraction. */
static double crossing(double kappa)
{
    const double c = plant_clip((1.0 - kappa) * COS_AT_REST, 0.2, LARGEST_COS);
    return 2.0 * c * sqrt(1.0 - c * c);
}

double plant_braid(const plant_hysteresis *hysteresis, plant_muscle_state *state, double input, double up, double down)
{
    const double w = crossing(hysteresis->center) / crossing(input);
    return plant_maxwell_slip(hysteresis, state, input - state->input, w * up, w * down);
}
