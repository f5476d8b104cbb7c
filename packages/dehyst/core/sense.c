#include "dehyst.h"

#define HALF ((dehyst_real)0.5)
#define STEPS_UNSEEN 20 /* resolutions that a frozen encoder must have missed: friction that holds a light joint fakes ten */

/* A pressure sensor in use always dithers, except at the stop of its range: vented, it reads exactly zero. */
static uint32_t take_pressures(const dehyst_joint *joint, dehyst_joint_state *state,
                               const dehyst_joint_sensors *sensors)
{
    uint32_t flags = 0;
    for (int32_t i = 0; i < 2; ++i) {
        dehyst_sensor *sensor = &state->muscle[i];
        const dehyst_real p = state->pressure[i];
        const dehyst_real reading = sensors->pressure[i];
        const int strange = dehyst_sensor_fault(sensor, reading, p, joint->pressure_jump);
        const int vented = sensor->last >= 0 && sensor->last <= 0;
        const int frozen = joint->frozen_samples > 0 && sensor->equal >= joint->frozen_samples && !vented;
        if (strange || frozen) { /* as if the valve did what it was told to */
            state->pressure[i] = dehyst_bounded(p + joint->period * state->expected[i], joint->pneumatics.supply);
            flags |= i == 0 ? (uint32_t)DEHYST_PRESSURE_FAULT_1 : (uint32_t)DEHYST_PRESSURE_FAULT_2;
        } else {
            state->pressure[i] = reading;
        }
        if (dehyst_sensor_failed(sensor, strange || frozen, joint->hold_samples)) {
            flags |= (uint32_t)DEHYST_FAILED;
        }
    }
    return flags;
}

/* A joint may stand still; a frozen encoder is one that misses a way the observer saw. The observer follows the frozen
 * reading before long, so that the largest way counts; slow drift of the observer is forgotten. At the ends of the
 * range a joint is stopped by something the observer does not know. */
static int angle_frozen(const dehyst_joint *joint, dehyst_joint_state *state)
{
    const dehyst_observer *seen = &state->observer;
    if (joint->frozen_samples <= 0) {
        return 0;
    }
    if (state->angle.equal == 0 || seen->angle <= joint->angle_low || seen->angle >= joint->angle_high) {
        state->travel = 0;
        state->travel_most = 0;
        return 0;
    }
    state->travel += joint->period * seen->velocity - state->travel / (dehyst_real)joint->frozen_samples;
    const dehyst_real size = state->travel < 0 ? -state->travel : state->travel;
    state->travel_most = size > state->travel_most ? size : state->travel_most;
    return state->angle.equal >= joint->frozen_samples && state->travel_most > STEPS_UNSEEN * joint->angle_step;
}

static uint32_t take_angle(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors)
{
    dehyst_observer *seen = &state->observer;
    const dehyst_real mean = HALF * (state->pressure[0] + state->pressure[1]);
    const dehyst_real difference = state->pressure[0] - state->pressure[1];
    const dehyst_real load = state->reference.load;
    const dehyst_real torque = dehyst_characteristic_torque(&state->at, mean, difference) - load;
    if (!state->started) { /* at rest: what the muscles pull and the reference does not know is load */
        seen->load = torque;
        state->torque = torque;
    }
    dehyst_observer_predict(joint, seen, HALF * (state->torque + torque));
    const int strange = dehyst_sensor_fault(&state->angle, sensors->angle, seen->angle, joint->angle_jump);
    const int faulty = angle_frozen(joint, state) || strange;
    if (!faulty) {
        dehyst_observer_correct(joint, seen, sensors->angle);
    }
    if (!dehyst_accept(seen->angle) || !dehyst_accept(seen->velocity) || !dehyst_accept(seen->load)) {
        seen->angle = state->angle.last; /* only inputs beyond all physics lead here */
        seen->velocity = 0;
        seen->load = 0;
    }
    dehyst_characteristic_at(joint, seen->angle, &state->at);
    state->torque =
        dehyst_bounded(dehyst_characteristic_torque(&state->at, mean, difference) - load, DEHYST_INPUT_LIMIT);
    return (faulty ? (uint32_t)DEHYST_ANGLE_FAULT : 0u) |
           (dehyst_sensor_failed(&state->angle, faulty, joint->hold_samples) ? (uint32_t)DEHYST_FAILED : 0u);
}

uint32_t dehyst_joint_sense(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors)
{
    const uint32_t pressures = take_pressures(joint, state, sensors); /* first: they predict the angle */
    return pressures | take_angle(joint, state, sensors);
}
