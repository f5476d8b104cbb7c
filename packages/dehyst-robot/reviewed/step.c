/* The period that all laws have in common: reference, sensors, then a law, then the pressures. */
#include "reviewed.h"

#define FAULTS                                                                                                        \
    ((uint32_t)DEHYST_ANGLE_FAULT | (uint32_t)DEHYST_PRESSURE_FAULT_1 | (uint32_t)DEHYST_PRESSURE_FAULT_2 |           \
     (uint32_t)DEHYST_REFERENCE_FAULT)

void reviewed_reset(const dehyst_joint_state *state, reviewed_state *own)
{
    dehyst_fade_start(&own->integrator, 0, 1);
    own->angle = state->observer.angle;
    own->speed = 0;
    own->memory = 0;
    own->disturbance = 0;
    own->share = 0;
    own->mean = (dehyst_real)0.5 * (state->pressure[0] + state->pressure[1]);
    own->known = 0;
    own->rate = 0;
    own->started = 0;
}

static uint32_t take_reference(dehyst_joint_state *state, const dehyst_joint_reference *reference)
{
    const int good = dehyst_accept(reference->angle) && dehyst_accept(reference->velocity) &&
                     dehyst_accept(reference->acceleration) && dehyst_accept(reference->load) &&
                     dehyst_accept(reference->mean_pressure) && dehyst_accept(reference->pressure_difference) &&
                     dehyst_accept(reference->extra);
    if (good) {
        state->reference = *reference;
    }
    return good ? 0u : (uint32_t)DEHYST_REFERENCE_FAULT;
}

/* A PID that knows no model differentiates what the encoder says; a bridged sample says what the last good one said. */
static void differentiate(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                          reviewed_state *own)
{
    const dehyst_real angle = state->angle.last;
    const dehyst_real lag = law->pid.filter > 0 ? law->pid.filter : (dehyst_real)0;
    const dehyst_real change = own->started ? angle - own->angle : (dehyst_real)0;
    own->speed = dehyst_bounded(own->speed + (change - joint->period * own->speed) / (joint->period + lag), DEHYST_INPUT_LIMIT);
    own->angle = angle;
    own->started = 1;
}

dehyst_real reviewed_direct_torque(const dehyst_joint_state *state)
{
    return state->compensator_share * state->torque_direct;
}

/* Dispatch, then pressures, then integrators. */
static void control(const dehyst_joint *joint, const reviewed_law *law, dehyst_joint_state *state, reviewed_state *own,
                    uint32_t switches, dehyst_joint_output *output)
{
    const uint32_t position = (uint32_t)DEHYST_POSITION;
    const int jumped = !state->started || ((switches ^ state->switches) & position) != 0;
    const dehyst_real compensated = reviewed_compensation(joint, state, switches);
    const dehyst_real wanted_mean = dehyst_bounded(state->reference.mean_pressure, joint->pneumatics.supply);
    if (!state->started) {
        const dehyst_real last = (dehyst_real)0.5 * (state->desired[0] + state->desired[1]);
        dehyst_fade_start(&state->mean, last - wanted_mean, dehyst_fade_part(joint));
    }
    const dehyst_real mean = wanted_mean + state->mean.value;
    reviewed_wish wish;
    if (law->kind == REVIEWED_SLIDING_MODE) {
        reviewed_observe(joint, law, state, own, reviewed_direct_torque(state) + state->at.b * compensated, jumped);
        own->share = dehyst_share_step(own->share, (switches & (uint32_t)DEHYST_INTEGRATOR) != 0, dehyst_fade_part(joint));
        wish = reviewed_sliding_law(joint, law, state, own, mean, compensated);
    } else if (law->kind == REVIEWED_VO_MINH) {
        wish = reviewed_vo_minh_law(joint, law, state, own, mean, compensated);
    } else {
        wish = reviewed_pid_law(joint, law, state, own, mean, compensated);
    }
    output->torque = dehyst_bounded(wish.torque, DEHYST_INPUT_LIMIT);
    output->integrator = dehyst_bounded(wish.integrator, DEHYST_INPUT_LIMIT);
    output->compensation = compensated + reviewed_direct_torque(state) / state->at.b;
    reviewed_press(joint, state, &wish, mean, jumped, output);
    if (law->kind != REVIEWED_SLIDING_MODE) {
        const dehyst_real gain = law->kind == REVIEWED_PID ? law->pid.integral : law->vo_minh.integral;
        reviewed_integrate(joint, state, own, gain, switches, output->flags);
    }
}

static void tell(const dehyst_joint *joint, const dehyst_joint_state *state, dehyst_joint_output *output)
{
    output->desired[0] = state->desired[0];
    output->desired[1] = state->desired[1];
    output->pressure_difference = state->pressure_difference;
    output->angle = state->observer.angle;
    output->velocity = state->observer.velocity;
    output->load = state->observer.load;
    output->contact = joint->direct ? state->contact : (dehyst_real)0;
    output->doubt = joint->direct ? dehyst_direct_doubt(joint->direct, &state->wanted, state->learning.applied)
                                  : (dehyst_real)0;
    output->flags |= state->flags;
}

void reviewed_step(const dehyst_joint *joint, const reviewed_law *law, dehyst_joint_state *state, reviewed_state *own,
                   const dehyst_joint_sensors *sensors, const dehyst_joint_reference *reference, uint32_t switches,
                   dehyst_joint_output *output)
{
    if (!(switches & (uint32_t)DEHYST_POSITION) && law->kind != REVIEWED_ONE_VALVE) {
        dehyst_joint_step(joint, state, sensors, reference, switches, output);
        differentiate(joint, law, state, own);
        dehyst_fade_step(&own->integrator);
        own->share = 0;
        return;
    }
    output->flags = take_reference(state, reference);
    output->flags |= dehyst_joint_sense(joint, state, sensors);
    output->flags |= dehyst_joint_estimate(joint, state, switches, output->flags);
    state->flags |= output->flags & (uint32_t)DEHYST_FAILED;
    state->flags |= (output->flags & FAULTS) ? (uint32_t)DEHYST_FAULT_EVER : 0u;
    output->valve[0] = 0;
    output->valve[1] = 0;
    output->torque = 0;
    output->compensation = 0;
    output->integrator = 0;
    differentiate(joint, law, state, own);
    if (!(state->flags & (uint32_t)DEHYST_FAILED)) {
        if (law->kind == REVIEWED_ONE_VALVE) {
            reviewed_one_valve_step(joint, law, state, own, switches, output);
        } else {
            control(joint, law, state, own, switches, output);
        }
        state->switches = switches;
        state->started = 1;
    }
    tell(joint, state, output);
}
