/* Krichel, Sawodny, Hildebrandt (2010): one 5/3-way valve for both muscles. Its spool fills one muscle while it exhausts
 * the other: commands are c and -c. Position is the flat output; the mean pressure is no second one, it follows from the
 * air: with the opening s (s > 0 fills the first muscle), n R T/V written as k,
 *
 *   dp' = k_1 g_fill(p_1) s + k_2 g_vent(p_2) s + drift           s > 0, drift = -n p_1 V_1'/V_1 + n p_2 V_2'/V_2
 *   dp' = k_1 g_vent(p_1) s + k_2 g_fill(p_2) s + drift           s < 0
 *
 * so that for each sign one opening gives the wanted dp'. The wanted one is that of the reference through the inverse
 * characteristic at the measured mean pressure, and a pole for the error of dp. */
#include "reviewed.h"

#define SMOOTHING ((dehyst_real)1e-3) /* of the derivative of the known part of dp_d, [s] */
#define HALF ((dehyst_real)0.5)

typedef struct chamber {
    dehyst_real pressure;    /* absolute, [Pa] */
    dehyst_real volume;      /* [m^3] */
    dehyst_real volume_rate; /* [m^3/s] */
} chamber;

static chamber chamber_of(const dehyst_joint *joint, const dehyst_joint_state *state, int32_t i)
{
    chamber c;
    dehyst_real slope;
    dehyst_volume_at(joint, i, state->observer.angle, &c.volume, &slope);
    c.volume_rate = slope * state->observer.velocity;
    c.pressure = state->pressure[i] + joint->pneumatics.ambient;
    return c;
}

/* Rate of the pressure at opening s. */
static dehyst_real rate_at(const dehyst_pneumatics *air, const chamber *c, dehyst_real s)
{
    const dehyst_real sign = s < 0 ? (dehyst_real)-1 : (dehyst_real)1;
    const dehyst_real flow = s * sign / dehyst_valve_opening(air, sign, c->pressure); /* opening 1 a kg/s */
    return dehyst_chamber_rate(air, c->volume, c->volume_rate, c->pressure, flow);
}

/* Opening of the spool that makes dp change at `rate`. */
static dehyst_real opening_for(const dehyst_pneumatics *air, const chamber *first, const chamber *second,
                               dehyst_real rate)
{
    const dehyst_real drift = rate_at(air, first, 0) - rate_at(air, second, 0);
    const dehyst_real sign = rate < drift ? (dehyst_real)-1 : (dehyst_real)1;
    const dehyst_real full = rate_at(air, first, sign) - rate_at(air, second, -sign) - drift; /* of the open spool */
    return sign * (rate - drift) / full;
}

static void drive(const dehyst_joint *joint, const reviewed_law *law, dehyst_joint_state *state, dehyst_real rate,
                  dehyst_joint_output *output)
{
    const dehyst_pneumatics *air = &joint->pneumatics;
    const chamber first = chamber_of(joint, state, 0);
    const chamber second = chamber_of(joint, state, 1);
    const dehyst_real error = state->desired[0] - state->desired[1] - (state->pressure[0] - state->pressure[1]);
    const dehyst_real opening = opening_for(air, &first, &second, rate + law->one_valve.pressure_gain * error);
    const dehyst_real command = dehyst_valve_command(air, dehyst_bounded(opening, 2));
    const dehyst_real made = dehyst_bounded(opening, 1);
    output->flags |= command > 1 || command < -1 ? (uint32_t)DEHYST_VALVE_LIMIT : 0u;
    output->valve[0] = dehyst_bounded(command, 1);
    output->valve[1] = -output->valve[0]; /* the other end of the same spool */
    state->expected[0] = dehyst_bounded(rate_at(air, &first, made), DEHYST_INPUT_LIMIT);
    state->expected[1] = dehyst_bounded(rate_at(air, &second, -made), DEHYST_INPUT_LIMIT);
}

/* dp_d of the position law at the mean pressure that is. */
static reviewed_wish follow(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                            const reviewed_state *own, dehyst_real mean, dehyst_real compensated)
{
    const dehyst_joint_reference *desired = &state->reference;
    const dehyst_real l = law->one_valve.pole;
    const dehyst_real direct = reviewed_direct_torque(state);
    reviewed_wish wish;
    wish.integrator = state->integrator.value;
    wish.torque = joint->inertia * (desired->acceleration + 3 * l * (desired->velocity - state->observer.velocity) +
                                    3 * l * l * (desired->angle - state->observer.angle)) +
                  wish.integrator + desired->load;
    wish.difference = dehyst_characteristic_difference(&state->at, mean, wish.torque + direct) + compensated;
    dehyst_characteristic at;
    dehyst_characteristic_at(joint, desired->angle, &at);
    const dehyst_real known = joint->inertia * desired->acceleration + desired->load + direct;
    wish.known = dehyst_characteristic_difference(&at, own->mean, known) + compensated;
    return wish;
}

void reviewed_one_valve_step(const dehyst_joint *joint, const reviewed_law *law, dehyst_joint_state *state,
                             reviewed_state *own, uint32_t switches, dehyst_joint_output *output)
{
    const int position = (switches & (uint32_t)DEHYST_POSITION) != 0;
    const int jumped = !state->started || ((switches ^ state->switches) & (uint32_t)DEHYST_POSITION) != 0;
    const dehyst_real range = dehyst_pressure_range(joint);
    const dehyst_real compensated = reviewed_compensation(joint, state, switches);
    const dehyst_real mean = HALF * (state->pressure[0] + state->pressure[1]);
    own->mean += (mean - own->mean) * joint->period / (joint->period + law->one_valve.mean_time);
    reviewed_wish wish = {reviewed_sane(joint, state->reference.pressure_difference), 0, 0, 0};
    wish.known = wish.difference;
    if (position) {
        wish = follow(joint, law, state, own, mean, compensated);
        output->compensation = compensated + reviewed_direct_torque(state) / state->at.b;
    }
    const dehyst_real wanted = reviewed_sane(joint, wish.difference);
    if (jumped) {
        const dehyst_real last = dehyst_bounded(state->pressure_difference, range);
        dehyst_fade_start(&state->difference, last - wanted, dehyst_fade_part(joint));
    }
    state->pressure_difference = reviewed_sane(joint, wanted + state->difference.value);
    const dehyst_real limited = dehyst_bounded(state->pressure_difference, range);
    if (limited < state->pressure_difference || limited > state->pressure_difference) {
        output->flags |= (uint32_t)DEHYST_PRESSURE_LIMIT;
    }
    const dehyst_real known = dehyst_bounded(reviewed_sane(joint, wish.known) + state->difference.value, range);
    if (!jumped) {
        own->rate += (known - own->known - joint->period * own->rate) / (joint->period + SMOOTHING);
        own->rate = dehyst_bounded(own->rate, DEHYST_INPUT_LIMIT);
    }
    own->known = known;
    dehyst_fade_step(&state->difference);
    state->desired[0] = mean + HALF * limited; /* what is asked for: the difference, at the mean pressure that is */
    state->desired[1] = mean - HALF * limited;
    drive(joint, law, state, own->rate, output);
    output->integrator = dehyst_bounded(wish.integrator, DEHYST_INPUT_LIMIT);
    output->torque = position ? dehyst_bounded(wish.torque, DEHYST_INPUT_LIMIT)
                              : dehyst_bounded(dehyst_characteristic_torque(&state->at, mean, state->pressure_difference),
                                               DEHYST_INPUT_LIMIT);
    reviewed_integrate_torque(joint, state, law->one_valve.pole, switches, output->flags);
}
