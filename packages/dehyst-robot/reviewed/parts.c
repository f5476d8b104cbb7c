/* What several laws share with the core's controller and the core keeps to itself: compensator, integrators, pressures. */
#include "reviewed.h"

#define SMOOTHING ((dehyst_real)1e-3) /* of the derivative of desired pressures, [s] */
#define MARGIN 4                      /* dp_d beyond this many pressure ranges says no more than this many */
#define LIMITED ((uint32_t)DEHYST_PRESSURE_LIMIT | (uint32_t)DEHYST_VALVE_LIMIT)

dehyst_real reviewed_sane(const dehyst_joint *joint, dehyst_real difference)
{
    return dehyst_bounded(difference, MARGIN * dehyst_pressure_range(joint));
}

dehyst_real reviewed_compensation(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches)
{
    if (joint->compensator) {
        (void)dehyst_model_step(joint->compensator, &state->compensator, state->reference.angle);
    }
    const dehyst_real term = dehyst_compensator_term(joint, state, state->fit.scale) + state->exchanged.value + state->reference.extra;
    const dehyst_real share = state->compensator_share;
    state->compensator_share =
        dehyst_share_step(share, (switches & (uint32_t)DEHYST_COMPENSATOR) != 0, dehyst_fade_part(joint));
    dehyst_fade_step(&state->exchanged);
    dehyst_joint_direct(joint, state, switches);
    return reviewed_sane(joint, share * term);
}

/* What limits took away of dp_d: of the pressures that are if a valve is at its limit, else of those that are asked for. */
static dehyst_real lost(const dehyst_joint_state *state, uint32_t flags)
{
    const dehyst_real *p = (flags & (uint32_t)DEHYST_VALVE_LIMIT) ? state->pressure : state->desired;
    return state->pressure_difference - (p[0] - p[1]);
}

void reviewed_integrate(const dehyst_joint *joint, const dehyst_joint_state *state, reviewed_state *own,
                        dehyst_real gain, uint32_t switches, uint32_t flags)
{
    if (!(switches & (uint32_t)DEHYST_INTEGRATOR)) {
        dehyst_fade_step(&own->integrator);
        return;
    }
    dehyst_real integral = own->integrator.value + joint->period * gain * (state->reference.angle - own->angle);
    if (flags & LIMITED) {
        integral -= dehyst_bounded(joint->windup_gain * joint->period, 1) * lost(state, flags);
    }
    dehyst_fade_start(&own->integrator, dehyst_bounded(integral, 2 * dehyst_pressure_range(joint)),
                      dehyst_fade_part(joint));
}

void reviewed_integrate_torque(const dehyst_joint *joint, dehyst_joint_state *state, dehyst_real pole,
                               uint32_t switches, uint32_t flags)
{
    const uint32_t both = (uint32_t)DEHYST_POSITION | (uint32_t)DEHYST_INTEGRATOR;
    if ((switches & both) != both) {
        dehyst_fade_step(&state->integrator);
        return;
    }
    const dehyst_real error = state->reference.angle - state->observer.angle;
    dehyst_real integral = state->integrator.value + joint->period * (joint->inertia * pole * pole * pole * error);
    if (flags & LIMITED) {
        integral -= dehyst_bounded(joint->windup_gain * joint->period, 1) * state->at.b * lost(state, flags);
    }
    const dehyst_real most = dehyst_bounded(2 * state->at.b * dehyst_pressure_range(joint), DEHYST_INPUT_LIMIT);
    dehyst_fade_start(&state->integrator, dehyst_bounded(integral, most), dehyst_fade_part(joint));
}

/* Pressure loop of one muscle, the core's: mass flow, then opening, then command. 1 if the valve is at its limit. */
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
    const dehyst_real most = opening < 0 ? -flow / opening : flow / opening;
    const dehyst_real expected = limited ? dehyst_chamber_rate(air, volume, volume_rate, p, most) : rate;
    state->expected[i] = dehyst_bounded(expected, DEHYST_INPUT_LIMIT);
    *valve = dehyst_bounded(command, 1);
    return limited;
}

/* Derivative of the desired pressures from that part of them which carries no sensor noise. */
static void feed_forward(const dehyst_joint *joint, dehyst_joint_state *state, dehyst_real mean, dehyst_real known,
                         int jumped)
{
    dehyst_real pressure[2];
    (void)dehyst_pressures(joint, mean, known + state->difference.value, pressure);
    for (int32_t i = 0; i < 2; ++i) {
        const dehyst_real change = pressure[i] - state->feedforward[i];
        if (!jumped) {
            state->rate[i] += (change - joint->period * state->rate[i]) / (joint->period + SMOOTHING);
            state->rate[i] = dehyst_bounded(state->rate[i], DEHYST_INPUT_LIMIT);
        }
        state->feedforward[i] = pressure[i];
    }
}

void reviewed_press(const dehyst_joint *joint, dehyst_joint_state *state, const reviewed_wish *wish, dehyst_real mean,
                    int jumped, dehyst_joint_output *output)
{
    const dehyst_real wanted = reviewed_sane(joint, wish->difference);
    if (jumped) { /* go on from the pressures that were last desired */
        const dehyst_real last = dehyst_bounded(state->pressure_difference, dehyst_pressure_range(joint));
        dehyst_fade_start(&state->difference, last - wanted, dehyst_fade_part(joint));
    }
    state->pressure_difference = reviewed_sane(joint, wanted + state->difference.value);
    feed_forward(joint, state, mean, reviewed_sane(joint, wish->known), jumped);
    if (dehyst_pressures(joint, mean, state->pressure_difference, state->desired)) {
        output->flags |= (uint32_t)DEHYST_PRESSURE_LIMIT;
    }
    dehyst_fade_step(&state->difference);
    dehyst_fade_step(&state->mean);
    const int limited_1 = drive(joint, state, 0, &output->valve[0]);
    const int limited_2 = drive(joint, state, 1, &output->valve[1]);
    output->flags |= limited_1 || limited_2 ? (uint32_t)DEHYST_VALVE_LIMIT : 0u;
}
