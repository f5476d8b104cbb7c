#include "dehyst.h"

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
    const uint32_t bad = (uint32_t)DEHYST_ANGLE_FAULT | (uint32_t)DEHYST_PRESSURE_FAULT_1 |
                         (uint32_t)DEHYST_PRESSURE_FAULT_2 | (uint32_t)DEHYST_REFERENCE_FAULT | (uint32_t)DEHYST_FAILED;
    const dehyst_real acceleration = state->reference.acceleration;
    const int slow = acceleration <= joint->most_acceleration && acceleration >= -joint->most_acceleration;
    const dehyst_real velocity = state->reference.velocity;
    const int moves = !(switches & (uint32_t)DEHYST_POSITION) || velocity > joint->least_speed ||
                      velocity < -joint->least_speed; /* at rest every drift would fit to every term */
    const int inside = (state->seen.flags & ((uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_REJECTED)) == 0;
    return (switches & (uint32_t)DEHYST_ADAPT) && !(flags & bad) && slow && moves && inside && state->started;
}

uint32_t dehyst_joint_estimate(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches, uint32_t flags)
{
    const dehyst_direct *direct = joint->direct;
    if (!direct) {
        return 0;
    }
    const dehyst_real given[DEHYST_GIVEN] = {state->reference.mean_pressure, state->reference.load};
    dehyst_direct_step(direct, &state->seen, state->observer.angle, state->observer.velocity, given);
    delay_all(joint, state);
    dehyst_learning *learning = &state->learning;
    dehyst_real part[DEHYST_GROUPS];
    dehyst_real explained = state->delayed.curve[2] + learning->applied_offset;
    for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
        part[g] = state->delayed.part[g][2];
        explained += learning->applied[g] * part[g];
    }
    state->contact = dehyst_bounded(state->observer.load - explained, DEHYST_INPUT_LIMIT);
    const int learned = dehyst_learning_step(&joint->adaptation, learning, direct->groups, joint->period,
                                             state->delayed.curve[2], part, state->observer.load,
                                             !teaches(joint, state, switches, flags));
    /* What the observer sees beyond what is fed forward: contact, and where the two memories have come apart. */
    const dehyst_real apart = dehyst_direct_output(direct, &state->seen, learning->applied) + learning->applied_offset -
                              state->compensator_share * state->torque_direct;
    const dehyst_real pole = joint->disturbance_pole > 0 ? joint->disturbance_pole : (dehyst_real)0;
    state->disturbance += (1 - dehyst_decay(pole * joint->period)) *
                          (dehyst_bounded(state->contact + apart, DEHYST_TORQUE_LIMIT) - state->disturbance);
    state->disturbance_share = dehyst_share_step(state->disturbance_share, (switches & (uint32_t)DEHYST_DISTURBANCE) != 0,
                                                 dehyst_fade_part(joint));
    return learned ? (uint32_t)DEHYST_LEARNED : 0u;
}

void dehyst_joint_direct(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches)
{
    const dehyst_direct *direct = joint->direct;
    if (!direct) {
        return;
    }
    if (switches & (uint32_t)DEHYST_POSITION) {
        const dehyst_real given[DEHYST_GIVEN] = {state->reference.mean_pressure, state->reference.load};
        dehyst_direct_step(direct, &state->wanted, state->reference.angle, state->reference.velocity, given);
    } else {
        dehyst_direct_follow(direct, &state->wanted, &state->seen);
    }
    const dehyst_real torque = dehyst_direct_output(direct, &state->wanted, state->learning.applied);
    state->torque_direct = dehyst_bounded(torque + state->learning.applied_offset, DEHYST_TORQUE_LIMIT);
}
