#include "dehyst.h"

/* The sampled chain of integrators, with all three poles of the error at exp(-w T) = z:
 *   q += T qd + T^2/2 a,  qd += T a,  a = (Q - Q_load - load)/M
 *   q += (1 - z^3) e,  qd += 3/2 (1 - z)^2 (1 + z)/T e,  load -= M (1 - z)^3/T^2 e,  e = measured - predicted angle */

#define SMALLEST ((dehyst_real)1e-9) /* inertia [kg m^2] and period [s] that no joint has */

void dehyst_observer_predict(const dehyst_joint *joint, dehyst_observer *observer, dehyst_real torque)
{
    const dehyst_real period = joint->period;
    const dehyst_real inertia = joint->inertia > SMALLEST ? joint->inertia : SMALLEST;
    const dehyst_real change = period * ((torque - observer->load) / inertia);
    observer->angle += period * (observer->velocity + (dehyst_real)0.5 * change);
    observer->velocity += change;
}

void dehyst_observer_correct(const dehyst_joint *joint, dehyst_observer *observer, dehyst_real angle)
{
    const dehyst_real period = joint->period > SMALLEST ? joint->period : SMALLEST;
    const dehyst_real x = joint->observer_pole > 0 ? joint->observer_pole * period : (dehyst_real)0;
    /* exp(-x) without a library: the reciprocal of a short series lies in (0, 1] for every x >= 0, so that the
     * observer is stable whatever its pole; 2e-7 off at x = 0.1, 2e-4 at 0.5. */
    const dehyst_real series =
        1 + x * (1 + x * ((dehyst_real)0.5 + x * ((dehyst_real)(1.0 / 6.0) + x * (dehyst_real)(1.0 / 24.0))));
    const dehyst_real z = 1 / series;
    const dehyst_real rest = 1 - z;
    const dehyst_real error = angle - observer->angle;
    observer->angle += (1 - z * z * z) * error;
    observer->velocity += (dehyst_real)1.5 * rest * rest * (1 + z) / period * error;
    observer->load -= joint->inertia * (rest / period) * (rest / period) * rest * error;
}
