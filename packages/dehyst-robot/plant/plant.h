/* dehyst plant: the physics of one pneumatic joint, simulated. Never exported, and nothing here is shared with
 * core/: the plant must not be the controller's own model.
 *
 * A joint is an antagonistic pair of pneumatic muscles, each with its own valve and pressure sensor:
 *   kappa_m = kappa_0 + s_m(q)/l_0,m      contraction of the muscles, s_m(0) = 0, q > 0 shortens muscle 1
 *   r_m(q) = ds_m/dq                      moment arms; on a round pulley r and -r
 *   Q = r_1(q) F_1 + r_2(q) F_2           torque on the joint, by virtual work
 *   F = max(0, F_map(p, kappa) - F_hysteresis - F_creep - F_viscous)
 *   F_creep = sum_j c_j (kappa - lag_j[kappa]) + d_j (p - lag_j[p])      under a constant load both let the muscle
 *                                                                        go on in the direction of a pressure step
 * SI units throughout: m, N, s, rad, K, kg; pressures in Pa, gauge in the muscle's force, absolute in the chamber.
 */
#ifndef PLANT_H
#define PLANT_H

#include <stdint.h>

#include "life.h"
#include "sensors.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PLANT_ELEMENTS 64 /* most elements of a hysteresis mechanism */
#define PLANT_CREEP 8     /* most branches of creep */
#define PLANT_TURNS 128   /* most remembered reversals of a Preisach mechanism */
#define PLANT_RING 64     /* periods that a delay reaches back, a power of two */
#define PLANT_ARM 8       /* coefficients of a moment arm: degree 7 */

#define PLANT_LIFE_FIELD(name, range) double name;

typedef struct plant_air {
    double supply;            /* supply pressure, absolute, [Pa] */
    double ambient;           /* ambient pressure, absolute, [Pa] */
    double temperature;       /* [K] */
    double gas_constant;      /* [J/(kg K)] */
    double polytropic;        /* exponent n, 1 (isothermal) .. 1.4 (adiabatic) */
    double reference_density; /* rho_0 of ISO 6358, [kg/m^3] */
    PLANT_AIR_LIFE(PLANT_LIFE_FIELD)
} plant_air;

enum {
    PLANT_MAP_TOOL = 0,        /* Fm (a0 (exp(-a1 k/km) - 1) + p/p_ref exp(-a3 (k/km)^2)): Fm a0 a1 a3 km p_ref */
    PLANT_MAP_EXPONENTIAL = 1, /* (a1 p + a2) exp(a3 k) + a4 k p + a5 p + a6:               a1 a2 a3 a4 a5 a6 */
    PLANT_MAP_GEOMETRIC = 2,   /* mu A0 p (a (1 - ke k)^2 - b) + c1 k + c2 (1 - exp(-c3 k)): mu A0 a b ke c1 c2 c3 */
    PLANT_MAP_SPRING = 3,      /* F0 - K k, a spring in the place of a muscle, whatever p:   F0 K */
    PLANT_MAP_TABLE = 4        /* s T(p, c k), T bilinear on an even grid and in lines beyond it, never rising with k
                                  there:
                                                                                            s c p_0 dp k_0 dk */
};

enum {
    PLANT_NONE = 0,
    PLANT_MAXWELL_SLIP = 1, /* springs that slip at a force growing with pressure */
    PLANT_PREISACH = 2,     /* Everett function of a smooth density that is not separable */
    PLANT_DAHL = 3,         /* Dahl elements: no return-point memory */
    PLANT_BRAID = 4,        /* springs whose slip force follows the angle of the braid */
    PLANT_LUGRE = 5,        /* a bristle whose sliding force falls with speed */
    PLANT_PINCHED = 6,      /* a Bouc-Wen spring that is soft where it takes up slack */
    PLANT_AGEING = 7,       /* springs whose contacts grow at rest */
    PLANT_FOREIGN = 8       /* a function of one's own */
};

/* Force of a foreign mechanism opposing contraction [N]: called once a step for each muscle. */
typedef double (*plant_foreign)(void *context, double contraction, double pressure, double period);

/* Force opposing contraction, [N], for the contraction kappa of the muscle at gauge pressure p. */
typedef struct plant_hysteresis {
    int32_t kind;                  /* PLANT_NONE .. PLANT_FOREIGN */
    int32_t n;                     /* elements in use, <= PLANT_ELEMENTS */
    double size;                   /* force when everything slips, at the reference pressure, [N] */
    double constant_share;         /* g(p) = constant_share + pressure_share p/reference_pressure */
    double pressure_share;
    double reference_pressure;     /* [Pa] */
    double asymmetry;              /* contraction is held back by (1 + asymmetry), elongation by (1 - asymmetry) */
    double center;                 /* PLANT_PREISACH, PLANT_BRAID: contraction in the middle */
    double strain[PLANT_ELEMENTS]; /* (n,) contraction at which an element slips, increasing; of a Preisach mechanism
                                      the last one is the half width of its range: beyond it, it saturates */
    double share[PLANT_ELEMENTS];  /* (n,) share of an element in `size`, sums to 1 */
    plant_foreign foreign;         /* PLANT_FOREIGN only */
    void *context;
    PLANT_HYSTERESIS_LIFE(PLANT_LIFE_FIELD)
} plant_hysteresis;

typedef struct plant_muscle {
    int32_t map;                        /* PLANT_MAP_... */
    double coefficient[8];              /* of the map, in the order given at its name */
    const double *table;                /* PLANT_MAP_TABLE only: T, row by row, a row a pressure, [N]; the caller's */
    int32_t rows, columns;              /* of the table, 2 or more */
    double length;                      /* l_0, [m] */
    double volume[4];                   /* V = l_0 sum_j volume[j] kappa^j + dead_volume, [m^2] */
    double dead_volume;                 /* hose and fitting, [m^3] */
    double viscous_force;               /* a in a v/(b + |v|), v speed of contraction, [N] */
    double viscous_speed;               /* b, [m/s] */
    int32_t creep_branches;             /* <= PLANT_CREEP */
    double creep_time[PLANT_CREEP];     /* time constants, [s] */
    double creep_force[PLANT_CREEP];    /* c_j in c_j (kappa - lag_j[kappa]), [N] */
    double creep_pressure[PLANT_CREEP]; /* d_j in d_j (p - lag_j[p]), [N/Pa] */
    plant_hysteresis hysteresis;
    PLANT_MUSCLE_LIFE(PLANT_LIFE_FIELD)
} plant_muscle;

/* One way of a 5/3-way proportional valve, ISO 6358: opening s in -1..1, s > 0 fills. */
typedef struct plant_valve {
    double conductance; /* C, [m^3/(s Pa)] */
    double ratio;       /* critical pressure ratio b */
    double dead_band;   /* half width around the mid-position, share of the stroke */
    double leak;        /* opening of both ways in the mid-position, share of full opening */
    double frequency;   /* of the spool, [rad/s] */
    double damping;     /* of the spool */
    PLANT_VALVE_LIFE(PLANT_LIFE_FIELD)
} plant_valve;

#define PLANT_QUALITY_FIELD(name) double name;
#define PLANT_KIND_FIELD(name) plant_kind name;
#define PLANT_KIND_INDEX(name) PLANT_KIND_##name,
#define PLANT_SENSOR_FIELD(name, kind, value) double name;
#define PLANT_SENSOR_INDEX(name, kind, value) PLANT_SENSOR_##name,

enum { PLANT_KINDS(PLANT_KIND_INDEX) PLANT_KIND_COUNT };
enum { PLANT_SENSORS(PLANT_SENSOR_INDEX) PLANT_SENSOR_COUNT };

typedef struct plant_kind {
    PLANT_QUALITIES(PLANT_QUALITY_FIELD) /* see sensors.h */
} plant_kind;

typedef struct plant_sensors {
    PLANT_KINDS(PLANT_KIND_FIELD)
} plant_sensors;

typedef struct plant_joint {
    plant_air air;
    plant_muscle muscle[2];
    plant_valve valve[2];
    plant_sensors sensors;
    double arm[2][PLANT_ARM]; /* r_m(q) = sum_j arm[m][j] q^j, positive where q shortens the muscle, [m/rad^j] */
    double contraction;       /* kappa_0 */
    int32_t substeps;         /* of valves and chambers in a step */
    PLANT_JOINT_LIFE(PLANT_LIFE_FIELD)
} plant_joint;

/* One muscle with its valve and the air around it: what a joint has two of. */
typedef struct plant_unit {
    const plant_air *air;
    const plant_muscle *muscle;
    const plant_valve *valve;
    int32_t substeps;
} plant_unit;

/* What follows from parameters and period; made anew when the period changes. */
typedef struct plant_cache {
    double period;                    /* that it belongs to, [s] */
    double creep_decay[PLANT_CREEP];  /* exp(-T/tau_j) */
    double creep_ramp[PLANT_CREEP];   /* (1 - exp(-T/tau_j)) tau_j/T */
    double spool[4];                  /* exact step of the spool over a substep, row by row */
    double stiffness[PLANT_ELEMENTS]; /* of the elements: size share/strain, [N] */
} plant_cache;

/* The last values of a signal, one a period. */
typedef struct plant_ring {
    double value[PLANT_RING];
    uint32_t at;
} plant_ring;

typedef struct plant_muscle_state {
    double contraction;             /* kappa of the last step */
    double input;                   /* what moves the hysteresis: kappa + pressure_strain p, at the last step */
    double start;                   /* the same at the reset */
    double pressure;                /* absolute, [Pa] */
    double mass;                    /* air that went in since the reset, for balances, [kg] */
    double spool;                   /* s, -1..1 */
    double spool_speed;             /* [1/s] */
    double element[PLANT_ELEMENTS]; /* forces of the elements, [N]; of a Preisach mechanism its output */
    double turn[PLANT_TURNS];       /* remembered reversals, alternating maxima and minima, [largest strain] */
    double level[PLANT_TURNS];      /* output of the Preisach mechanism at them, -1..1 */
    int32_t turns;
    double creep_contraction[PLANT_CREEP]; /* kappa - lag_j[kappa] */
    double creep_pressure[PLANT_CREEP];    /* p - lag_j[p], [Pa] */
    double force;                       /* of the last step, [N] */
    double friction;                    /* hysteresis force of the last step, [N] */
    double stretch;                     /* of the tendon, [m] */
    double warmth;                      /* above the room, [K] */
    double loop, loop_goal;             /* factor of the loop's size in this stroke, and where it is going */
    double tip, way;                    /* furthest input of this stroke, and its direction */
    double age;                         /* of the contacts of PLANT_AGEING, [s] */
    double target;                      /* of the spool */
    double arriving;                    /* flow out of the tube in the next step, [kg/s] */
    double supply;                      /* absolute pressure before the valve, [Pa] */
    double drawn;                       /* air taken from the supply in the last step, [kg] */
    plant_ring command, tube;
    uint64_t random;                    /* of the strokes */
    plant_cache cache;
} plant_muscle_state;

typedef struct plant_joint_state {
    plant_muscle_state muscle[2];
    double sensed[PLANT_SENSOR_COUNT]; /* lagged values */
    uint64_t random[PLANT_KIND_COUNT]; /* states of the noise generators */
    plant_ring ring[PLANT_SENSOR_COUNT];
    double age[PLANT_SENSOR_COUNT];    /* of the last readings, [periods] */
    double bias[PLANT_SENSOR_COUNT], bias_goal[PLANT_SENSOR_COUNT];
    double command_age;                /* of the last command, [periods] */
    uint64_t sensing, computing;       /* states of the generators of jitter */
    double gap;                        /* of the pulley before the link, within +- backlash, [rad] */
    double arm[2];                     /* moment arms at the end of the last step, [m] */
    double torque;                     /* of the last step, [Nm] */
} plant_joint_state;

typedef struct plant_reading {
    PLANT_SENSORS(PLANT_SENSOR_FIELD) /* encoder [rad], gauge pressures [Pa], ... */
} plant_reading;

/* Static force of the map at gauge pressure p and contraction kappa, [N]; may be negative: the muscle would push. */
double plant_muscle_force(const plant_muscle *muscle, double p, double kappa);

/* Volume, [m^3], and its derivative by kappa, [m^3]. */
double plant_muscle_volume(const plant_muscle *muscle, double kappa, double *slope);

/* Mass flow into the muscle, [kg/s], for spool position s and absolute pressure p of the muscle. */
double plant_valve_flow(const plant_valve *valve, const plant_air *air, double s, double p);

/* Nothing remembered, at contraction kappa and gauge pressure p: the force is zero, the virgin curve starts here. */
void plant_hysteresis_reset(const plant_hysteresis *hysteresis, plant_muscle_state *state, double kappa, double p);

/* Hysteresis force opposing contraction after moving to kappa at gauge pressure p, [N]. */
double plant_hysteresis_step(const plant_hysteresis *hysteresis, plant_muscle_state *state, double kappa, double p,
                             double period);

/* Everett function of the Preisach mechanism, 0..2: change of its normalised output (-1..1) from reversal `from`
 * to `to`, both in units of the largest strain. */
double plant_everett(double from, double to);

/* A muscle at rest at contraction kappa and gauge pressure p; nothing remembered. */
void plant_muscle_reset(const plant_unit *unit, plant_muscle_state *state, double kappa, double p);

/* Advance by `period` with the contraction moving linearly to kappa, at its end with speed v [m/s], and the valve
 * commanded to `command` in -1..1. Returns the pull at the end of the step, [N]; a joint is two of these. */
double plant_muscle_step(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double command,
                         double period);

/* The same with an ideal pressure source: gauge pressure p at the end of the step. */
double plant_muscle_impose(const plant_unit *unit, plant_muscle_state *state, double kappa, double v, double p,
                           double period);

/* At rest at angle q with both muscles at gauge pressure p[2]; nothing remembered; noise from `seed`. */
void plant_joint_reset(const plant_joint *joint, plant_joint_state *state, double q, const double p[2], uint64_t seed);

/* What the sensors say now; advances their noise and lag by `period`. */
void plant_joint_sense(const plant_joint *joint, plant_joint_state *state, double q, double period,
                       plant_reading *reading);

/* Advance by `period` with the angle moving as q + qd t and the valves commanded to command[2] in -1..1.
 * Returns the torque Q at the end of the step, [Nm]. */
double plant_joint_step(const plant_joint *joint, plant_joint_state *state, double q, double qd,
                        const double command[2], double period);

/* The same with ideal pressure sources in place of valves and chambers: gauge pressure p[2] at the end of the step. */
double plant_joint_impose(const plant_joint *joint, plant_joint_state *state, double q, double qd, const double p[2],
                          double period);

/* Absolute pressure of the supply a period after `drawn` [kg] were taken from it in that period, by all of its joints;
 * `failing`: nothing comes through the regulator. */
double plant_supply_step(const plant_air *air, double supply, double drawn, double period, int failing);

#ifdef __cplusplus
}
#endif

#endif
