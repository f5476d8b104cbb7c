/* Aschemann, Schindele (2008): flatness-based pressure loops, outer sliding mode on the position with the mean pressure
 * as second output, and an observer of reduced order for what the inverse dynamics does not know: friction, hysteresis.
 *
 *   s = ed + L e,  s' = -W tanh(s/phi)   =>   Q_d = M (qdd_d + L ed + W tanh(s/phi)) + Q_load + d
 *
 * A compensator's torque is fed forward and is no disturbance any more: the observer is told of it, else both would act
 * on the same hysteresis. */
#include <math.h>

#include "reviewed.h"

void reviewed_observe(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                      reviewed_state *own, dehyst_real known, int begin)
{
    const dehyst_real pole = law->sliding_mode.observer_pole;
    const dehyst_real moving = pole * joint->inertia * state->observer.velocity;
    if (begin) {
        own->memory = state->observer.load - known + moving;
    }
    own->disturbance = dehyst_bounded(own->memory - moving, DEHYST_TORQUE_LIMIT);
    const dehyst_real unknown = state->torque - known - own->disturbance; /* M qdd + d - d observed */
    own->memory += (1 - dehyst_decay(pole * joint->period)) * dehyst_bounded(unknown, DEHYST_TORQUE_LIMIT);
    own->memory = dehyst_bounded(own->memory, DEHYST_INPUT_LIMIT);
}

reviewed_wish reviewed_sliding_law(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                                   const reviewed_state *own, dehyst_real mean, dehyst_real compensated)
{
    const reviewed_sliding_mode *mode = &law->sliding_mode;
    const dehyst_joint_reference *desired = &state->reference;
    const dehyst_real slip = desired->velocity - state->observer.velocity;
    const dehyst_real surface = slip + mode->surface * (desired->angle - state->observer.angle);
    const dehyst_real reaching = mode->gain * tanh(surface / mode->boundary);
    const dehyst_real direct = reviewed_direct_torque(state);
    reviewed_wish wish;
    wish.integrator = own->share * own->disturbance;
    wish.torque = joint->inertia * (desired->acceleration + mode->surface * slip + reaching) + desired->load +
                  wish.integrator;
    wish.difference = dehyst_characteristic_difference(&state->at, mean, wish.torque + direct) + compensated;
    dehyst_characteristic at;
    dehyst_characteristic_at(joint, desired->angle, &at);
    const dehyst_real known = joint->inertia * desired->acceleration + desired->load + direct;
    wish.known = dehyst_characteristic_difference(&at, mean, known) + compensated;
    return wish;
}
