#include "dehyst.h"

#define FAULTS                                                                                                        \
    ((uint32_t)DEHYST_ANGLE_FAULT | (uint32_t)DEHYST_PRESSURE_FAULT_1 | (uint32_t)DEHYST_PRESSURE_FAULT_2 |           \
     (uint32_t)DEHYST_REFERENCE_FAULT)
#define SMOOTHING ((dehyst_real)1e-3) /* of the derivative of desired pressures, [s] */
#define MARGIN 4                      /* dp_d beyond this many pressure ranges says no more than this many */

static uint32_t take_reference(dehyst_joint_state *state, const dehyst_joint_reference *reference)
{
    const int good = dehyst_accept(reference->angle) && dehyst_accept(reference->velocity) &&
                     dehyst_accept(reference->acceleration) && dehyst_accept(reference->load) &&
                     dehyst_accept(reference->mean_pressure) && dehyst_accept(reference->pressure_difference) &&
                     dehyst_accept(reference->extra);
    if (!good) {
        return DEHYST_REFERENCE_FAULT;
    }
    state->reference.angle = reference->angle; /* one by one: a copy of the whole may become a call of memcpy */
    state->reference.velocity = reference->velocity;
    state->reference.acceleration = reference->acceleration;
    state->reference.load = reference->load;
    state->reference.mean_pressure = reference->mean_pressure;
    state->reference.pressure_difference = reference->pressure_difference;
    state->reference.extra = reference->extra;
    return 0;
}

/* Torque that is added to Q_d: of the direct inverse, and what else disturbs. */
static dehyst_real known_torque(const dehyst_joint_state *state)
{
    return state->compensator_share * state->torque_direct + state->disturbance_share * state->disturbance;
}

/* Compensator's term of dp_d; its plays move with q_d whether it is on or not. */
static inline dehyst_real compensation(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches)
{
    if (joint->compensator) {
        (void)dehyst_model_step(joint->compensator, &state->compensator, state->reference.angle);
    }
    const dehyst_real term =
        dehyst_compensator_term(joint, state, state->fit.scale) + state->exchanged.value + state->reference.extra;
    const dehyst_real share = state->compensator_share;
    state->compensator_share =
        dehyst_share_step(share, (switches & (uint32_t)DEHYST_COMPENSATOR) != 0, dehyst_fade_part(joint));
    dehyst_fade_step(&state->exchanged);
    dehyst_joint_direct(joint, state, switches);
    return dehyst_bounded(share * term, MARGIN * dehyst_pressure_range(joint));
}

/* Integrator of the position loop, with back-calculation of the torque that limits took away, and only then. */
static void integrate(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches, uint32_t flags)
{
    const uint32_t both = (uint32_t)DEHYST_POSITION | (uint32_t)DEHYST_INTEGRATOR;
    if ((switches & both) != both) {
        dehyst_fade_step(&state->integrator);
        return;
    }
    const dehyst_real l = joint->pole;
    const dehyst_real error = state->reference.angle - state->observer.angle;
    dehyst_real integral = state->integrator.value + joint->period * (joint->inertia * l * l * l * error);
    if (flags & ((uint32_t)DEHYST_PRESSURE_LIMIT | (uint32_t)DEHYST_VALVE_LIMIT)) {
        const dehyst_real *p = (flags & (uint32_t)DEHYST_VALVE_LIMIT) ? state->pressure : state->desired;
        const dehyst_real lost = state->at.b * (state->pressure_difference - (p[0] - p[1]));
        integral -= dehyst_bounded(joint->windup_gain * joint->period, 1) * lost;
    }
    /* No limit in normal use: twice the torque that all pressure there is can make. */
    const dehyst_real most = dehyst_bounded(2 * state->at.b * dehyst_pressure_range(joint), DEHYST_INPUT_LIMIT);
    dehyst_fade_start(&state->integrator, dehyst_bounded(integral, most), dehyst_fade_part(joint));
}

/* Pressure loop of one muscle: mass flow, then opening, then command. Returns 1 if the valve is at its limit. */
static int drive(const dehyst_joint *joint, dehyst_joint_state *state, int32_t i, dehyst_real *valve)
{
    const dehyst_pneumatics *air = &joint->pneumatics;
    dehyst_real volume;
    dehyst_real slope;
    dehyst_volume_at(joint, i, state->observer.angle, &volume, &slope);
    const dehyst_real volume_rate = slope * state->observer.velocity;
    const dehyst_real p = state->pressure[i] + air->ambient;
    const dehyst_real rate = state->rate[i] + joint->pressure_gain * (state->desired[i] - state->pressure[i]);
    const dehyst_real flow = dehyst_chamber_flow(air, volume, volume_rate, p, rate);
    const dehyst_real opening = dehyst_valve_opening(air, flow, p);
    const dehyst_real command = dehyst_valve_command(air, dehyst_bounded(opening, 2));
    const int limited = command > 1 || command < -1;
    const dehyst_real most = opening < 0 ? -flow / opening : flow / opening; /* with the valve fully open */
    const dehyst_real expected = limited ? dehyst_chamber_rate(air, volume, volume_rate, p, most) : rate;
    state->expected[i] = dehyst_bounded(expected, DEHYST_INPUT_LIMIT);
    *valve = dehyst_bounded(command, 1);
    return limited;
}

/* Derivative of the desired pressures from that part of them which carries no sensor noise: all references, with the
 * characteristic at q_d. `jumped`: the part is another one than before. */
static void feed_forward(const dehyst_joint *joint, dehyst_joint_state *state, dehyst_real mean, dehyst_real direct,
                         dehyst_real compensated, int position, int jumped)
{
    const dehyst_joint_reference *desired = &state->reference;
    dehyst_real difference = direct;
    if (position) {
        dehyst_characteristic at;
        dehyst_characteristic_at(joint, desired->angle, &at);
        const dehyst_real torque =
            joint->inertia * desired->acceleration + desired->load + state->compensator_share * state->torque_direct;
        difference = dehyst_bounded(dehyst_characteristic_difference(&at, mean, torque) + compensated,
                                    MARGIN * dehyst_pressure_range(joint));
    }
    dehyst_real pressure[2];
    (void)dehyst_pressures(joint, mean, difference + state->difference.value, pressure);
    for (int32_t i = 0; i < 2; ++i) {
        const dehyst_real change = pressure[i] - state->feedforward[i];
        if (!jumped) {
            state->rate[i] += (change - joint->period * state->rate[i]) / (joint->period + SMOOTHING);
            state->rate[i] = dehyst_bounded(state->rate[i], DEHYST_INPUT_LIMIT);
        }
        state->feedforward[i] = pressure[i];
    }
}

/* dp_d before limits, and with it the torque. */
static void decide(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches, dehyst_joint_output *output)
{
    const dehyst_joint_reference *desired = &state->reference;
    const dehyst_real range = dehyst_pressure_range(joint);
    const dehyst_real l = joint->pole;
    const int position = (switches & (uint32_t)DEHYST_POSITION) != 0;
    const int jumped = !state->started || ((switches ^ state->switches) & (uint32_t)DEHYST_POSITION) != 0;
    const dehyst_real compensated = compensation(joint, state, switches);
    const dehyst_real direct = dehyst_bounded(desired->pressure_difference, MARGIN * range);
    const dehyst_real wanted_mean = dehyst_bounded(desired->mean_pressure, joint->pneumatics.supply);
    if (!state->started) {
        const dehyst_real last = (dehyst_real)0.5 * (state->desired[0] + state->desired[1]);
        dehyst_fade_start(&state->mean, last - wanted_mean, dehyst_fade_part(joint));
    }
    const dehyst_real mean = wanted_mean + state->mean.value;
    dehyst_real wanted = direct;
    if (position) {
        const dehyst_real torque =
            joint->inertia * (desired->acceleration + 3 * l * (desired->velocity - state->observer.velocity) +
                              3 * l * l * (desired->angle - state->observer.angle)) +
            state->integrator.value + desired->load;
        output->torque = dehyst_bounded(torque, DEHYST_INPUT_LIMIT);
        wanted = dehyst_characteristic_difference(&state->at, mean, torque + known_torque(state)) + compensated;
        wanted = dehyst_bounded(wanted, MARGIN * range);
    }
    if (jumped) { /* go on from the pressures that were last desired */
        dehyst_fade_start(&state->difference, dehyst_bounded(state->pressure_difference, range) - wanted,
                          dehyst_fade_part(joint));
    }
    state->pressure_difference = dehyst_bounded(wanted + state->difference.value, MARGIN * range);
    if (!position) {
        output->torque = dehyst_bounded(
            dehyst_characteristic_torque(&state->at, mean, state->pressure_difference), DEHYST_INPUT_LIMIT);
    }
    output->compensation =
        position ? compensated + state->compensator_share * state->torque_direct / state->at.b : (dehyst_real)0;
    feed_forward(joint, state, mean, direct, compensated, position, jumped);
    if (dehyst_pressures(joint, mean, state->pressure_difference, state->desired)) {
        output->flags |= (uint32_t)DEHYST_PRESSURE_LIMIT;
    }
    dehyst_fade_step(&state->difference);
    dehyst_fade_step(&state->mean);
}

void dehyst_joint_step(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors,
                       const dehyst_joint_reference *reference, uint32_t switches, dehyst_joint_output *output)
{
    output->flags = take_reference(state, reference);
    output->flags |= dehyst_joint_sense(joint, state, sensors);
    output->flags |= dehyst_joint_estimate(joint, state, switches, output->flags);
    state->flags |= output->flags & (uint32_t)DEHYST_FAILED;
    state->flags |= (output->flags & FAULTS) ? (uint32_t)DEHYST_FAULT_EVER : 0u;
    output->valve[0] = 0;
    output->valve[1] = 0;
    output->torque = 0;
    output->compensation = 0;
    output->integrator = state->integrator.value;
    if (!(state->flags & (uint32_t)DEHYST_FAILED)) {
        decide(joint, state, switches, output);
        const int limited_1 = drive(joint, state, 0, &output->valve[0]);
        const int limited_2 = drive(joint, state, 1, &output->valve[1]);
        output->flags |= limited_1 || limited_2 ? (uint32_t)DEHYST_VALVE_LIMIT : 0u;
        integrate(joint, state, switches, output->flags);
        state->switches = switches;
        state->started = 1;
    }
    output->desired[0] = state->desired[0];
    output->desired[1] = state->desired[1];
    output->pressure_difference = state->pressure_difference;
    output->angle = state->observer.angle;
    output->velocity = state->observer.velocity;
    output->load = state->observer.load;
    output->contact = joint->direct ? state->contact : (dehyst_real)0;
    output->doubt = joint->direct ? dehyst_direct_doubt(joint->direct, &state->wanted, state->learning.applied) : (dehyst_real)0;
    output->flags |= state->flags;
}
