/* The joint: two muscles on one pulley. */
#include <string.h>

#include "parts.h"

#define LIMIT 1e6 /* no angle, speed or command is larger; NaN is not smaller */

static int usable(double x) { return x >= -LIMIT && x <= LIMIT; }

static double contraction(const plant_joint *joint, int m, double q)
{
    const double turned = joint->radius * q / joint->muscle[m].length;
    return joint->contraction + (m == 0 ? turned : -turned);
}

static void prepare(const plant_joint *joint, plant_joint_state *state, double period)
{
    for (int m = 0; m < 2; ++m) {
        plant_cache *cache = &state->muscle[m].cache;
        if (cache->period == period) continue;
        plant_creep_prepare(&joint->muscle[m], cache, period);
        plant_spool_prepare(&joint->valve[m], cache, period / joint->substeps);
        cache->period = period;
    }
}

void plant_joint_reset(const plant_joint *joint, plant_joint_state *state, double q, const double p[2], uint64_t seed)
{
    memset(state, 0, sizeof *state);
    for (int m = 0; m < 2; ++m) {
        plant_muscle_state *muscle = &state->muscle[m];
        plant_hysteresis_reset(&joint->muscle[m].hysteresis, muscle, contraction(joint, m, q));
        const double force = plant_muscle_force(&joint->muscle[m], p[m], muscle->contraction);
        muscle->pressure = p[m] + joint->air.ambient;
        muscle->force = force > 0.0 ? force : 0.0;
    }
    plant_sensors_reset(joint, state, q, p, seed);
}

/* Force of a muscle that moved to kappa with speed of contraction v while its pressure changed by p_change. */
static double pull(const plant_joint *joint, plant_muscle_state *state, int m, double kappa, double v, double p_change,
                   double period)
{
    const plant_muscle *muscle = &joint->muscle[m];
    const double p = state->pressure - joint->air.ambient;
    const double creep = plant_creep_step(muscle, state, kappa - state->contraction, p_change);
    const double hysteresis = plant_hysteresis_step(&muscle->hysteresis, state, kappa, p, period);
    const double viscous = muscle->viscous_force * v / (muscle->viscous_speed + fabs(v));
    const double force = plant_muscle_force(muscle, p, kappa) - hysteresis - creep - viscous;
    state->force = force > 0.0 ? force : 0.0;
    return state->force;
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
    double kappa[2], u[2], p[2];
    prepare(joint, state, period);
    const double v = end_of_step(joint, state, q, qd, period, kappa);
    for (int m = 0; m < 2; ++m) {
        u[m] = command[m] == command[m] ? plant_clip(command[m], -1.0, 1.0) : 0.0; /* NaN: closed */
        p[m] = state->muscle[m].pressure;
    }
    plant_chambers_step(joint, state, kappa, u, period);
    const double first = pull(joint, &state->muscle[0], 0, kappa[0], v, state->muscle[0].pressure - p[0], period);
    const double second = pull(joint, &state->muscle[1], 1, kappa[1], -v, state->muscle[1].pressure - p[1], period);
    return joint->radius * (first - second);
}

double plant_joint_impose(const plant_joint *joint, plant_joint_state *state, double q, double qd, const double p[2],
                          double period)
{
    double kappa[2], change[2];
    prepare(joint, state, period);
    const double v = end_of_step(joint, state, q, qd, period, kappa);
    for (int m = 0; m < 2; ++m) {
        const double next = usable(p[m] / 1e6) ? p[m] + joint->air.ambient : state->muscle[m].pressure;
        change[m] = next - state->muscle[m].pressure;
        state->muscle[m].pressure = next;
    }
    const double first = pull(joint, &state->muscle[0], 0, kappa[0], v, change[0], period);
    const double second = pull(joint, &state->muscle[1], 1, kappa[1], -v, change[1], period);
    return joint->radius * (first - second);
}
