#include "dehyst.h"

dehyst_real dehyst_compensator_term(const dehyst_joint *joint, const dehyst_joint_state *state,
                                     dehyst_real scale)
{
    return joint->compensator ? scale * (joint->compensator_unit * state->compensator.output -
                                         joint->shear * state->reference.angle)
                              : (dehyst_real)0;
}

static void reset_sensor(dehyst_sensor *sensor, dehyst_real reading)
{
    sensor->last = reading;
    sensor->equal = 0;
    sensor->faulty = 0;
}

static void reset_angle(const dehyst_joint *joint, dehyst_joint_state *state, dehyst_real angle)
{
    state->observer.angle = angle;
    state->observer.velocity = 0;
    state->observer.load = 0;
    reset_sensor(&state->angle, angle);
    state->travel = 0;
    state->travel_most = 0;
    state->torque = 0;
    dehyst_characteristic_at(joint, angle, &state->at);
}

static void reset_pressures(const dehyst_joint *joint, dehyst_joint_state *state, dehyst_real p_1, dehyst_real p_2)
{
    state->pressure[0] = p_1;
    state->pressure[1] = p_2;
    state->pressure_difference = dehyst_bounded(p_1 - p_2, dehyst_pressure_range(joint));
    (void)dehyst_pressures(joint, (dehyst_real)0.5 * (p_1 + p_2), state->pressure_difference, state->desired);
    for (int32_t i = 0; i < 2; ++i) {
        reset_sensor(&state->muscle[i], state->pressure[i]);
        state->feedforward[i] = state->desired[i];
        state->rate[i] = 0;
        state->expected[i] = 0;
    }
}

static void reset_direct(const dehyst_joint *joint, dehyst_joint_state *state)
{
    dehyst_learning_reset(&joint->adaptation, &state->learning);
    state->torque_direct = 0;
    state->contact = 0;
    state->disturbance = 0;
    state->disturbance_share = 0;
    for (int32_t i = 0; i < 3; ++i) {
        state->delayed.curve[i] = 0;
        for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
            state->delayed.part[g][i] = 0;
        }
    }
    if (joint->direct) {
        dehyst_direct_reset(joint->direct, &state->wanted, state->observer.angle);
        dehyst_direct_reset(joint->direct, &state->seen, state->observer.angle);
    }
}

/* Until the first good reference: stay. */
static void reset_reference(dehyst_joint_state *state)
{
    state->reference.angle = state->observer.angle;
    state->reference.velocity = 0;
    state->reference.acceleration = 0;
    state->reference.load = 0;
    state->reference.mean_pressure = (dehyst_real)0.5 * (state->desired[0] + state->desired[1]);
    state->reference.pressure_difference = state->pressure_difference;
    state->reference.extra = 0;
}

void dehyst_joint_reset(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors,
                        const dehyst_real *z0)
{
    const int good = dehyst_accept(sensors->angle) && dehyst_accept(sensors->pressure[0]) &&
                     dehyst_accept(sensors->pressure[1]);
    state->flags = good ? 0u : (uint32_t)DEHYST_FAILED | (uint32_t)DEHYST_FAULT_EVER;
    state->switches = 0;
    state->started = 0;
    reset_angle(joint, state, good ? sensors->angle : (dehyst_real)0);
    reset_pressures(joint, state, good ? sensors->pressure[0] : (dehyst_real)0,
                    good ? sensors->pressure[1] : (dehyst_real)0);
    reset_reference(state);
    reset_direct(joint, state);
    dehyst_fit_reset(&state->fit);
    dehyst_fade_start(&state->integrator, 0, 1);
    dehyst_fade_start(&state->difference, 0, 1);
    dehyst_fade_start(&state->mean, 0, 1);
    dehyst_fade_start(&state->exchanged, 0, 1);
    state->compensator_share = 0;
    state->compensator.output = 0;
    state->compensator.flags = 0;
    if (joint->compensator) {
        dehyst_model_reset(joint->compensator, &state->compensator, z0);
    }
}

void dehyst_joint_exchange(dehyst_joint *joint, dehyst_joint_state *state, const dehyst_model *compensator,
                           dehyst_real unit, dehyst_real shear, dehyst_real *z, const dehyst_real *z0)
{
    const dehyst_real before = dehyst_compensator_term(joint, state, state->fit.scale) + state->exchanged.value;
    joint->compensator = compensator;
    joint->compensator_unit = unit;
    joint->shear = shear;
    state->compensator.z = z;
    if (compensator) {
        dehyst_model_reset(compensator, &state->compensator, z0);
        (void)dehyst_model_step(compensator, &state->compensator, state->reference.angle);
    }
    dehyst_fade_start(&state->exchanged,
                      dehyst_bounded(before - dehyst_compensator_term(joint, state, state->fit.scale), 8 * dehyst_pressure_range(joint)), dehyst_fade_part(joint));
}
