#include "dehyst.h"

#define BAD                                                                                                           \
    ((uint32_t)DEHYST_ANGLE_FAULT | (uint32_t)DEHYST_PRESSURE_FAULT_1 | (uint32_t)DEHYST_PRESSURE_FAULT_2 |           \
     (uint32_t)DEHYST_REFERENCE_FAULT | (uint32_t)DEHYST_FAILED)

dehyst_real dehyst_share_step(dehyst_real share, int on, dehyst_real part)
{
    const dehyst_real target = on ? (dehyst_real)1 : (dehyst_real)0;
    return share + part < target ? share + part : (share - part > target ? share - part : target);
}

static void delay(dehyst_real *lag, dehyst_real gain, dehyst_real x)
{
    lag[0] += gain * (x - lag[0]);
    lag[1] += gain * (lag[0] - lag[1]);
    lag[2] += gain * (lag[1] - lag[2]);
}

/* The observer's answer to a torque is that torque behind three lags of its pole. */
static void delay_all(const dehyst_joint *joint, dehyst_joint_state *state)
{
    const dehyst_real x = joint->observer_pole > 0 ? joint->observer_pole * joint->period : (dehyst_real)0;
    const dehyst_real gain = state->started ? 1 - dehyst_decay(x) : (dehyst_real)1;
    delay(state->delayed.curve, gain, state->seen.curve);
    for (int32_t g = 0; g < joint->direct->groups; ++g) {
        delay(state->delayed.part[g], gain, state->seen.part[g]);
    }
}

static int teaches(const dehyst_joint *joint, const dehyst_joint_state *state, uint32_t switches, uint32_t flags)
{
    const dehyst_real acceleration = state->reference.acceleration;
    const int slow = acceleration <= joint->most_acceleration && acceleration >= -joint->most_acceleration;
    const dehyst_real velocity = state->reference.velocity;
    const int moves = !(switches & (uint32_t)DEHYST_POSITION) || velocity > joint->least_speed ||
                      velocity < -joint->least_speed; /* at rest every drift would fit to every term */
    const int inside = (state->seen.flags & ((uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_REJECTED)) == 0;
    return (switches & (uint32_t)DEHYST_ADAPT) && (flags & BAD) == 0u && slow && moves && inside && state->started;
}

/* Whether the model as it was identified still fits: a direct inverse along the measured angle, a compensator along q_d,
 * which nothing follows without position control. */
static uint32_t compare(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches, uint32_t flags)
{
    const int position = (switches & (uint32_t)DEHYST_POSITION) != 0;
    dehyst_compared now;
    now.torque = state->at.b * dehyst_compensator_term(joint, state, 1);
    if (joint->direct) {
        now.torque += state->seen.curve;
        for (int32_t g = 0; g < joint->direct->groups; ++g) {
            now.torque += state->seen.part[g];
        }
    }
    now.load = state->observer.load;
    now.angle = state->observer.angle;
    now.velocity = position ? state->reference.velocity : state->observer.velocity;
    now.largest = state->at.b * dehyst_pressure_range(joint);
    now.position = position;
    now.touched = joint->direct && state->learning.held > 0;
    const int followed = position && state->compensator_share >= 1; /* without it the joint leaves q_d, and its h */
    const int good = state->started && (flags & BAD) == 0u && (followed || joint->direct);
    dehyst_fit_step(joint, &state->fit, &now, good);
    return (state->fit.stale > 0 ? (uint32_t)DEHYST_STALE : 0u) |
           (state->fit.shifted > 0 ? (uint32_t)DEHYST_SHIFTED : 0u);
}

/* Torque of the direct inverse with what is in use of what was learned. */
static dehyst_real answer(const dehyst_direct *direct, const dehyst_direct_state *state, const dehyst_learning *learning)
{
    return dehyst_direct_output(direct, state, learning->applied) + learning->applied_offset +
           (learning->curve - 1) * state->curve;
}

uint32_t dehyst_joint_estimate(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches, uint32_t flags)
{
    const dehyst_direct *direct = joint->direct;
    if (!direct) {
        return joint->compensator ? compare(joint, state, switches, flags) : 0u;
    }
    const dehyst_real given[DEHYST_GIVEN] = {state->reference.mean_pressure, state->reference.load, 0};
    dehyst_direct_step(direct, &state->seen, state->observer.angle, state->observer.velocity, given);
    dehyst_learning *learning = &state->learning;
    if (!(switches & (uint32_t)DEHYST_POSITION)) { /* errors under pressures alone are no measure of those along a path */
        dehyst_learning_unsettle(learning);
    }
    const int shifted = state->fit.shifted > 0;
    const uint32_t told = compare(joint, state, switches, flags);
    if (!shifted && state->fit.shifted > 0) {
        dehyst_learning_forget(&joint->adaptation, learning); /* what took the offset for hysteresis */
    }
    delay_all(joint, state);
    dehyst_real part[DEHYST_GROUPS];
    dehyst_real explained = learning->curve * state->delayed.curve[2] + learning->applied_offset;
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        part[g] = state->delayed.part[g][2];
        explained += learning->applied[g] * part[g];
    }
    state->contact = dehyst_bounded(state->observer.load - explained, DEHYST_INPUT_LIMIT);
    const int learned = dehyst_learning_step(&joint->adaptation, learning, direct->groups, joint->period,
                                             state->delayed.curve[2], part,
                                             state->observer.load - (state->fit.shifted > 0 ? state->fit.offset : (dehyst_real)0),
                                             state->fit.scale, !teaches(joint, state, switches, flags));
    /* What the observer sees beyond what is fed forward: contact, and where the two memories have come apart. */
    const dehyst_real apart = answer(direct, &state->seen, learning) -
                              state->compensator_share * state->torque_direct;
    const dehyst_real pole = joint->disturbance_pole > 0 ? joint->disturbance_pole : (dehyst_real)0;
    state->disturbance += (1 - dehyst_decay(pole * joint->period)) *
                          (dehyst_bounded(state->contact + apart, DEHYST_TORQUE_LIMIT) - state->disturbance);
    state->disturbance_share = dehyst_share_step(state->disturbance_share, (switches & (uint32_t)DEHYST_DISTURBANCE) != 0,
                                                 dehyst_fade_part(joint));
    return told | (learned ? (uint32_t)DEHYST_LEARNED : 0u) | (learning->held > 0 ? (uint32_t)DEHYST_TOUCHED : 0u);
}

void dehyst_joint_direct(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches)
{
    const dehyst_direct *direct = joint->direct;
    if (!direct) {
        return;
    }
    if (switches & (uint32_t)DEHYST_POSITION) {
        const dehyst_real given[DEHYST_GIVEN] = {state->reference.mean_pressure, state->reference.load, 0};
        dehyst_direct_step(direct, &state->wanted, state->reference.angle, state->reference.velocity, given);
    } else {
        dehyst_direct_follow(direct, &state->wanted, &state->seen);
    }
    state->torque_direct = dehyst_bounded(answer(direct, &state->wanted, &state->learning), DEHYST_TORQUE_LIMIT);
}
