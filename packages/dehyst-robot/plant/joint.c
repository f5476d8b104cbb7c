/* The muscle, and the joint: two muscles that pull on it. */
#include <string.h>

#include "parts.h"

#define LIMIT 1e6 /* no angle, speed or command is larger; NaN is not smaller */

static int usable(double x) { return x >= -LIMIT && x <= LIMIT; }

/* Where the spool is to go: the command, `age` periods late if that is not negative, in steps, after its play, seen from its
 * true mid-position. */
static double target(const plant_unit *unit, plant_muscle_state *state, double command, double age, double period)
{
    const plant_valve *valve = unit->valve;
    double u = command == command ? plant_clip(command, -1.0, 1.0) : 0.0; /* NaN: closed */
    if (valve->step > 0.0) u = floor(u / valve->step + 0.5) * valve->step;
    if (age >= 0.0 || valve->delay > 0.0)
        u = plant_delayed(&state->command, u, (age > 0.0 ? age : 0.0) + valve->delay / period);
    state->target =
        valve->hysteresis > 0.0 ? plant_clip(state->target, u - valve->hysteresis, u + valve->hysteresis) : u;
    return state->target - valve->middle;
}

/* Contraction of a muscle whose ends are kappa apart: fitted with a shift, and pulling at its tendon. */
static double shortened(const plant_unit *unit, const plant_muscle_state *state, double kappa)
{
    return kappa + unit->muscle->shift + state->stretch / unit->muscle->length;
}

/* A tendon is a spring with a damper in parallel that the muscle pulls at, k s + k tau s' = F: no stiff mode. */
static void give_way(const plant_unit *unit, plant_muscle_state *state, double period)
{
    const plant_muscle *muscle = unit->muscle;
    if (muscle->tendon > 0.0)
        state->stretch += plant_settled(period / muscle->tendon_time) * (state->force / muscle->tendon - state->stretch);
}

static void prepare(const plant_unit *unit, plant_muscle_state *state, double period)
{
    give_way(unit, state, period);
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
    const double change = kappa - state->contraction;
    const double creep = plant_creep_step(muscle, state, change, p_change);
    const double hysteresis = plant_hysteresis_step(&muscle->hysteresis, state, kappa, p, period);
    const double viscous = muscle->viscous_force * v / (muscle->viscous_speed + fabs(v));
    const double warm = 1.0 + muscle->warm_stiffness * state->warmth;
    const double force = plant_muscle_force(muscle, p, kappa) * warm - hysteresis - creep - viscous;
    if (muscle->warming_time > 0.0) { /* by the power that the losses take, [W] */
        const double power = hysteresis * change * muscle->length / period + viscous * v;
        state->warmth += plant_settled(period / muscle->warming_time) * (muscle->warming * power - state->warmth);
    }
    state->force = force > 0.0 ? force : 0.0;
    return state->force;
}

void plant_muscle_reset(const plant_unit *unit, plant_muscle_state *state, double kappa, double p)
{
    memset(state, 0, sizeof *state);
    for (int k = 0; k < 100; ++k) { /* until the tendon is in balance; without one, at once */
        const double force = plant_muscle_force(unit->muscle, p, shortened(unit, state, kappa));
        state->force = force > 0.0 ? force : 0.0;
        if (!(unit->muscle->tendon > 0.0)) break;
        state->stretch += 0.5 * (state->force / unit->muscle->tendon - state->stretch);
    }
    plant_hysteresis_reset(&unit->muscle->hysteresis, state, shortened(unit, state, kappa), p);
    state->pressure = p + unit->air->ambient;
    state->supply = unit->air->supply;
}

double plant_muscle_step(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double command,
                         double period)
{
    const double p = state->pressure;
    prepare(unit, state, period);
    const double shorter = shortened(unit, state, kappa);
    plant_chamber_step(unit, state, shorter, target(unit, state, command, -1.0, period), period);
    return pull(unit, state, shorter, v, state->pressure - p, period);
}

double plant_muscle_impose(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double p,
                           double period)
{
    const double before = state->pressure;
    prepare(unit, state, period);
    if (usable(p / 1e6)) state->pressure = p + unit->air->ambient;
    state->drawn = 0.0;
    return pull(unit, state, shortened(unit, state, kappa), v, state->pressure - before, period);
}

static plant_unit unit_of(const plant_joint *joint, int m)
{
    return (plant_unit){&joint->air, &joint->muscle[m], &joint->valve[m], joint->substeps};
}

/* Contraction of a muscle at angle q of the link, and its moment arm there, which is kept: s = int_0 r dq by Horner's rule. */
static double contraction(const plant_joint *joint, plant_joint_state *state, int m, double q)
{
    const double turned = q + state->gap;
    double arm = 0.0, mean = 0.0; /* r, and s/q */
    for (int j = PLANT_ARM - 1; j >= 0; --j) {
        arm = arm * turned + joint->arm[m][j];
        mean = mean * turned + joint->arm[m][j] / (j + 1);
    }
    state->arm[m] = arm;
    return joint->contraction + mean * turned / joint->muscle[m].length;
}

/* r_1 F_1 + r_2 F_2, written so that arms of one size lose nothing where the forces are nearly the same. */
static double torque(plant_joint_state *state)
{
    const double *arm = state->arm, second = state->muscle[1].force;
    return state->torque = arm[0] * (state->muscle[0].force - second) + (arm[0] + arm[1]) * second;
}

void plant_joint_reset(const plant_joint *joint, plant_joint_state *state, double q, const double p[2], uint64_t seed)
{
    memset(state, 0, sizeof *state);
    for (int m = 0; m < 2; ++m) {
        const plant_unit unit = unit_of(joint, m);
        plant_muscle_reset(&unit, &state->muscle[m], contraction(joint, state, m, q), p[m]);
    }
    (void)torque(state);
    plant_sensors_reset(joint, state, q, p, seed);
}

/* How far and how fast the muscles are contracted at the end of a step; an angle that is no number leaves the muscles where they are. The pulley
 * has no mass: in its play it moves against a damper, d gap' = Q, and hands on what it gets. */
static void end_of_step(const plant_joint *joint, plant_joint_state *state, double q, double qd, double period,
                        double kappa[2], double v[2])
{
    const int good = usable(q) && usable(qd);
    if (joint->backlash > 0.0)
        state->gap = plant_clip(state->gap + state->torque * period / joint->backlash_damping, -joint->backlash,
                                joint->backlash);
    for (int m = 0; m < 2; ++m) {
        const plant_unit unit = unit_of(joint, m);
        const plant_muscle_state *muscle = &state->muscle[m];
        kappa[m] = good ? contraction(joint, state, m, q + qd * period)
                        : muscle->contraction - shortened(&unit, muscle, 0.0);
        v[m] = good ? state->arm[m] * qd : 0.0;
    }
}

double plant_joint_step(const plant_joint *joint, plant_joint_state *state, double q, double qd,
                        const double command[2], double period)
{
    const plant_unit unit[2] = {unit_of(joint, 0), unit_of(joint, 1)};
    plant_muscle_state *muscle = state->muscle;
    double kappa[2], v[2], u[2], p[2], age = -1.0;
    if (joint->command_delay + joint->command_jitter > 0.0)
        age = state->command_age = plant_age(joint->command_delay, joint->command_jitter, &state->computing,
                                             state->command_age, period);
    end_of_step(joint, state, q, qd, period, kappa, v);
    for (int m = 0; m < 2; ++m) {
        prepare(&unit[m], &muscle[m], period);
        kappa[m] = shortened(&unit[m], &muscle[m], kappa[m]);
        u[m] = target(&unit[m], &muscle[m], command[m], age, period);
        p[m] = muscle[m].pressure;
    }
    plant_chambers_step(unit, muscle, kappa, u, period);
    for (int m = 0; m < 2; ++m) (void)pull(&unit[m], &muscle[m], kappa[m], v[m], muscle[m].pressure - p[m], period);
    return torque(state);
}

double plant_joint_impose(const plant_joint *joint, plant_joint_state *state, double q, double qd, const double p[2],
                          double period)
{
    double kappa[2], v[2];
    end_of_step(joint, state, q, qd, period, kappa, v);
    for (int m = 0; m < 2; ++m) {
        const plant_unit unit = unit_of(joint, m);
        (void)plant_muscle_impose(&unit, &state->muscle[m], kappa[m], v[m], p[m], period);
    }
    return torque(state);
}
