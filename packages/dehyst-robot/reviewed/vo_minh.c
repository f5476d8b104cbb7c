/* Vo-Minh, Tjahjowidodo, Ramon, Van Brussel (AIM 2009; Mechatronics 2011): cascade of pressure loops and a PI on the
 * position, with the static model and the hysteresis of a Maxwell-slip model fed forward along the desired position.
 * The joint's own inertia torque is not fed forward: the model is static. */
#include "reviewed.h"

reviewed_wish reviewed_vo_minh_law(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                                   const reviewed_state *own, dehyst_real mean, dehyst_real compensated)
{
    const dehyst_joint_reference *desired = &state->reference;
    dehyst_characteristic at;
    dehyst_characteristic_at(joint, desired->angle, &at);
    const dehyst_real torque = desired->load + reviewed_direct_torque(state);
    reviewed_wish wish;
    wish.known = dehyst_characteristic_difference(&at, mean, torque) + compensated;
    wish.difference = wish.known + law->vo_minh.proportional * (desired->angle - own->angle) + own->integrator.value;
    wish.torque = dehyst_characteristic_torque(&at, mean, wish.difference);
    wish.integrator = at.b * own->integrator.value;
    return wish;
}
