/* What a real joint does beside its equations, a row an effect: the fields of the structs in plant.h and the names in Python
 * follow from these tables. 0 switches a row off, and then no bit of a run differs from that of a plant without it. */
#ifndef PLANT_LIFE_H
#define PLANT_LIFE_H

#define PLANT_AIR_LIFE(ROW) \
    ROW(supply_volume, not_negative)      /* shared by the joints of an arm; 0: the supply keeps its pressure, [m^3] */ \
    ROW(supply_conductance, not_negative) /* of the regulator before it, per droop, [m^3/(s Pa)]; 0: none refills it */

#define PLANT_HYSTERESIS_LIFE(ROW) \
    ROW(pressure_strain, any)  /* the mechanism is moved by kappa + pressure_strain p: loops at fixed length, [1/Pa] */ \
    ROW(scatter, not_negative) /* of the size from stroke to stroke, rms share */ \
    ROW(warm, any)             /* growth of the size with warmth, [1/K] */

#define PLANT_MUSCLE_LIFE(ROW) \
    ROW(shift, any)                 /* contraction at angle zero beside kappa_0: the muscle is fitted there */ \
    ROW(tendon, not_negative)       /* stiffness in series, [N/m]; 0: rigid */ \
    ROW(tendon_time, not_negative)  /* of its creepless relaxation, [s] */ \
    ROW(warming, not_negative)      /* warmth per dissipated power, [K/W] */ \
    ROW(warming_time, not_negative) /* [s]; 0: stays cold */ \
    ROW(warm_stiffness, any)        /* growth of the static force with warmth, [1/K] */

#define PLANT_VALVE_LIFE(ROW) \
    ROW(delay, not_negative)         /* from command to spool, [s] */ \
    ROW(step, not_negative)          /* of the quantised command, share of the stroke */ \
    ROW(hysteresis, not_negative)    /* half width of the spool's play, share of the stroke */ \
    ROW(middle, any)                 /* command at which the spool is in its true mid-position */ \
    ROW(tube_length, not_negative)   /* from valve to muscle, [m] */ \
    ROW(tube_diameter, not_negative) /* [m] */

#define PLANT_JOINT_LIFE(ROW) \
    ROW(command_delay, not_negative)   /* of the computer, [s] */ \
    ROW(command_jitter, not_negative)  /* largest further delay, drawn anew every period, [s] */ \
    ROW(backlash, not_negative)        /* half width of the play between pulley and link, [rad] */ \
    ROW(backlash_damping, not_negative) /* in the play, [Nm s/rad] */

#endif
