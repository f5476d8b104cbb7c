/* dehyst reviewed: controllers of a pneumatic joint that the literature has tried, on the same joint as the core's own.
 *
 * Host only: nothing here is exported to a machine. Each law sees what dehyst_joint_step sees, in the same call, and has
 * the same parts of the core where its publication has an equal one: sensor guard and observer (dehyst_joint_sense),
 * static characteristic, compensators, air and valve (dehyst_chamber_flow, dehyst_valve_opening). They differ in what
 * makes the pressure difference out of angle and reference, and one of them in the valves. SI units.
 *
 *   pid            dp_d = s q_d + k_p e + k_i int e + k_d de/dt                                         e = q_d - q
 *   vo-minh        dp_d = (Q_load + Q_h[q_d] - A(q_d) p_m - C(q_d))/B(q_d) + k_p e + k_i int e
 *   sliding-mode   Q_d = M (qdd_d + L ed + W tanh(s/phi)) + Q_load + d,  s = ed + L e,  d observed
 *   one-valve      one spool for both muscles: dp has a rate that is imposed, p_m goes where the air takes it
 *
 * Without DEHYST_POSITION the first three are dehyst_joint_step, to the bit: homing, calibration and identification do
 * not know which of them is in charge. Q_h is what the compensator says, whichever is given to the joint.
 */
#ifndef REVIEWED_H
#define REVIEWED_H

#include "dehyst.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { /* which law */
    REVIEWED_PID = 1,
    REVIEWED_VO_MINH = 2,
    REVIEWED_SLIDING_MODE = 3,
    REVIEWED_ONE_VALVE = 4
};

typedef struct reviewed_pid {
    dehyst_real proportional; /* k_p, [Pa/rad] */
    dehyst_real integral;     /* k_i, [Pa/(rad s)] */
    dehyst_real derivative;   /* k_d, [Pa s/rad] */
    dehyst_real slope;        /* s, constant slope d(dp)/dq of the joint at rest, 0 for none, [Pa/rad] */
    dehyst_real filter;       /* time constant of the derivative, [s] */
} reviewed_pid;

typedef struct reviewed_vo_minh {
    dehyst_real proportional; /* k_p, [Pa/rad] */
    dehyst_real integral;     /* k_i, [Pa/(rad s)] */
} reviewed_vo_minh;

typedef struct reviewed_sliding_mode {
    dehyst_real surface;       /* L, pole of the error on the surface, [1/s] */
    dehyst_real gain;          /* W, acceleration that reaches it, [rad/s^2] */
    dehyst_real boundary;      /* phi, half width of the layer in which it is smooth, > 0, [rad/s] */
    dehyst_real observer_pole; /* of the disturbance observer, [1/s] */
} reviewed_sliding_mode;

typedef struct reviewed_one_valve {
    dehyst_real pole;          /* all poles of the position error lie at minus this, [1/s] */
    dehyst_real pressure_gain; /* pole of the error of dp, [1/s] */
    dehyst_real mean_time;     /* over which the mean pressure is averaged for the feedforward, [s] */
} reviewed_one_valve;

typedef struct reviewed_law {
    int32_t kind; /* which of them is in charge; the others are not looked at */
    reviewed_pid pid;
    reviewed_vo_minh vo_minh;
    reviewed_sliding_mode sliding_mode;
    reviewed_one_valve one_valve;
} reviewed_law;

typedef struct reviewed_state {
    dehyst_fade integrator; /* of pid and vo-minh; it runs out while the integrator is off, [Pa] */
    dehyst_real angle;      /* last reading, [rad] */
    dehyst_real speed;      /* its filtered derivative, [rad/s] */
    dehyst_real memory;     /* of the disturbance observer, d + L_o M qd, [Nm] */
    dehyst_real disturbance; /* d, observed torque that is not known, [Nm] */
    dehyst_real share;      /* of it that is fed back, 0 off .. 1 on */
    dehyst_real mean;       /* averaged mean pressure of one-valve, gauge, [Pa] */
    dehyst_real known;      /* last part of dp_d that references alone decide, of one-valve, [Pa] */
    dehyst_real rate;       /* its smoothed derivative, [Pa/s] */
    int32_t started;        /* 0 until the first period after the reset */
} reviewed_state;

/* Start where dehyst_joint_reset has just started `state`. */
void reviewed_reset(const dehyst_joint_state *state, reviewed_state *own);

/* One period, in the place of dehyst_joint_step: same sensors, reference, switches and output. DEHYST_INTEGRATOR
 * switches the integrator, of the sliding mode its disturbance observer's feedback; DEHYST_DISTURBANCE nothing. */
void reviewed_step(const dehyst_joint *joint, const reviewed_law *law, dehyst_joint_state *state, reviewed_state *own,
                   const dehyst_joint_sensors *sensors, const dehyst_joint_reference *reference, uint32_t switches,
                   dehyst_joint_output *output);

/* ---- Parts of it. */

typedef struct reviewed_wish {
    dehyst_real difference; /* dp_d before limits, [Pa] */
    dehyst_real known;      /* part of it that references alone decide: no sensor noise in its derivative, [Pa] */
    dehyst_real torque;     /* what that is as a torque of the joint, for the log, [Nm] */
    dehyst_real integrator; /* its integrating part, for the log, [Nm] */
} reviewed_wish;

/* What the laws ask for. `compensated` is the compensator's part of dp [Pa]; what it adds as a torque is in `state`. */
reviewed_wish reviewed_pid_law(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                               const reviewed_state *own, dehyst_real mean, dehyst_real compensated);
reviewed_wish reviewed_vo_minh_law(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                                   const reviewed_state *own, dehyst_real mean, dehyst_real compensated);
reviewed_wish reviewed_sliding_law(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                                   const reviewed_state *own, dehyst_real mean, dehyst_real compensated);

/* Disturbance observer of reduced order: d' = L_o (Q - Q_load - known - M qdd - d), `known` a torque that is fed forward
 * already. `begin`: from what the core's observer saw. */
void reviewed_observe(const dehyst_joint *joint, const reviewed_law *law, const dehyst_joint_state *state,
                      reviewed_state *own, dehyst_real known, int begin);

/* Integral of the angle's error in the units of dp, with back-calculation of what limits took away, and only then. */
void reviewed_integrate(const dehyst_joint *joint, const dehyst_joint_state *state, reviewed_state *own,
                        dehyst_real gain, uint32_t switches, uint32_t flags);

/* The same in torque, M L^3 int e, for a law that imposes the poles L. */
void reviewed_integrate_torque(const dehyst_joint *joint, dehyst_joint_state *state, dehyst_real pole,
                               uint32_t switches, uint32_t flags);

/* One valve for both muscles. */
void reviewed_one_valve_step(const dehyst_joint *joint, const reviewed_law *law, dehyst_joint_state *state,
                             reviewed_state *own, uint32_t switches, dehyst_joint_output *output);

/* Compensator's part of dp, its memories moved by the reference; the torque of a direct inverse is in `state`. */
dehyst_real reviewed_compensation(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches);

/* Torque of a direct inverse that is switched on. */
dehyst_real reviewed_direct_torque(const dehyst_joint_state *state);

/* A wish for dp without anything beyond all pressure there is. */
dehyst_real reviewed_sane(const dehyst_joint *joint, dehyst_real difference);

/* Limits, their derivative and both pressure loops of two valves. `jumped`: the wish is of another kind than before. */
void reviewed_press(const dehyst_joint *joint, dehyst_joint_state *state, const reviewed_wish *wish, dehyst_real mean,
                    int jumped, dehyst_joint_output *output);

#ifdef __cplusplus
}
#endif

#endif
