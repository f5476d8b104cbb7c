/* The muscle, and the joint: two muscles on one pulley. */
#include <string.h>

#include "parts.h"

#define LIMIT 1e6 /* no angle, speed or command is larger; NaN is not smaller */

static int usable(double x) { return x >= -LIMIT && x <= LIMIT; }

/* Of a valve; what is no number closes it. */
static double usual(double command) { return command == command ? plant_clip(command, -1.0, 1.0) : 0.0; }

static void prepare(const plant_unit *unit, plant_muscle_state *state, double period)
{
    if (state->cache.period == period) return;
    plant_creep_prepare(unit->muscle, &state->cache, period);
    plant_spool_prepare(unit->valve, &state->cache, period / unit->substeps);
    state->cache.period = period;
}

/* Force of a muscle that moved to kappa with speed of contraction v while its pressure changed by p_change. */
static double pull(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double p_change,
                   double period)
{
    const plant_muscle *muscle = unit->muscle;
    const double p = state->pressure - unit->air->ambient;
    const double creep = plant_creep_step(muscle, state, kappa - state->contraction, p_change);
    const double hysteresis = plant_hysteresis_step(&muscle->hysteresis, state, kappa, p, period);
    const double viscous = muscle->viscous_force * v / (muscle->viscous_speed + fabs(v));
    const double force = plant_muscle_force(muscle, p, kappa) - hysteresis - creep - viscous;
    state->force = force > 0.0 ? force : 0.0;
    return state->force;
}

void plant_muscle_reset(const plant_unit *unit, plant_muscle_state *state, double kappa, double p)
{
    memset(state, 0, sizeof *state);
    plant_hysteresis_reset(&unit->muscle->hysteresis, state, kappa);
    const double force = plant_muscle_force(unit->muscle, p, kappa);
    state->pressure = p + unit->air->ambient;
    state->force = force > 0.0 ? force : 0.0;
}

double plant_muscle_step(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double command,
                         double period)
{
    const double p = state->pressure;
    prepare(unit, state, period);
    plant_chamber_step(unit, state, kappa, usual(command), period);
    return pull(unit, state, kappa, v, state->pressure - p, period);
}

double plant_muscle_impose(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double p,
                           double period)
{
    const double before = state->pressure;
    prepare(unit, state, period);
    if (usable(p / 1e6)) state->pressure = p + unit->air->ambient;
    return pull(unit, state, kappa, v, state->pressure - before, period);
}

static plant_unit unit_of(const plant_joint *joint, int m)
{
    return (plant_unit){&joint->air, &joint->muscle[m], &joint->valve[m], joint->substeps};
}

static double contraction(const plant_joint *joint, int m, double q)
{
    const double turned = joint->radius * q / joint->muscle[m].length;
    return joint->contraction + (m == 0 ? turned : -turned);
}

void plant_joint_reset(const plant_joint *joint, plant_joint_state *state, double q, const double p[2], uint64_t seed)
{
    memset(state, 0, sizeof *state);
    for (int m = 0; m < 2; ++m) {
        const plant_unit unit = unit_of(joint, m);
        plant_muscle_reset(&unit, &state->muscle[m], contraction(joint, m, q), p[m]);
    }
    plant_sensors_reset(joint, state, q, p, seed);
}

/* Contractions at the end of a step; an angle that is no number leaves them where they are. */
static double end_of_step(const plant_joint *joint, const plant_joint_state *state, double q, double qd, double period,
                          double kappa[2])
{
    const int good = usable(q) && usable(qd);
    for (int m = 0; m < 2; ++m)
        kappa[m] = good ? contraction(joint, m, q + qd * period) : state->muscle[m].contraction;
    return good ? joint->radius * qd : 0.0;
}

double plant_joint_step(const plant_joint *joint, plant_joint_state *state, double q, double qd,
                        const double command[2], double period)
{
    const plant_unit unit[2] = {unit_of(joint, 0), unit_of(joint, 1)};
    plant_muscle_state *muscle = state->muscle;
    double kappa[2], u[2], p[2];
    const double v = end_of_step(joint, state, q, qd, period, kappa);
    for (int m = 0; m < 2; ++m) {
        prepare(&unit[m], &muscle[m], period);
        u[m] = usual(command[m]);
        p[m] = muscle[m].pressure;
    }
    plant_chambers_step(unit, muscle, kappa, u, period);
    const double first = pull(&unit[0], &muscle[0], kappa[0], v, muscle[0].pressure - p[0], period);
    const double second = pull(&unit[1], &muscle[1], kappa[1], -v, muscle[1].pressure - p[1], period);
    return joint->radius * (first - second);
}

double plant_joint_impose(const plant_joint *joint, plant_joint_state *state, double q, double qd, const double p[2],
                          double period)
{
    double kappa[2], force[2];
    const double v = end_of_step(joint, state, q, qd, period, kappa);
    for (int m = 0; m < 2; ++m) {
        const plant_unit unit = unit_of(joint, m);
        force[m] = plant_muscle_impose(&unit, &state->muscle[m], kappa[m], m == 0 ? v : -v, p[m], period);
    }
    return joint->radius * (force[0] - force[1]);
}
