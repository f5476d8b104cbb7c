/* A PID on the angle that knows no model of the joint: neither its characteristic, nor load or inertia. */
#include "reviewed.h"

reviewed_wish reviewed_pid_law(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                               const reviewed_state *own, dehyst_real mean, dehyst_real compensated)
{
    const reviewed_pid *gain = &law->pid;
    const dehyst_joint_reference *desired = &state->reference;
    const dehyst_real hysteresis = compensated + reviewed_direct_torque(state) / state->at.b;
    reviewed_wish wish;
    wish.known = gain->slope * desired->angle + hysteresis;
    wish.difference = wish.known + gain->proportional * (desired->angle - own->angle) +
                      gain->derivative * (desired->velocity - own->speed) + own->integrator.value;
    wish.torque = state->at.b * wish.difference;
    wish.integrator = state->at.b * own->integrator.value;
    (void)joint;
    (void)mean;
    return wish;
}
