/* A joint controller with a compensator, or with -DDIRECT with a direct inverse that learns: any readings, references and switches in any sequence. Parameters are the
 * defaults of dehyst.JointControllerParameters. */
#include "parameters.h"
#ifdef DIRECT
#include "direct.h"
#endif

#include "__fc_builtin.h"

/*@ assigns \result \from \nothing; */
extern dehyst_real any_real(void);

#define LOW ((dehyst_real)0.2e5)
#define HIGH ((dehyst_real)6e5)

static dehyst_joint joint;
static dehyst_joint_state state;
static dehyst_joint_sensors sensors;
static dehyst_joint_reference reference;
static dehyst_joint_output output;

static void set_joint(void)
{
    static const dehyst_joint given = {
        .period = 5e-4, .inertia = 4, .pole = 6, .observer_pole = 60, .pressure_gain = 60, .windup_gain = 5,
        .a = {0, -62.09e-5, 0, 23.13e-5, 0, -3.78e-5}, .b = {34.88e-5, 0, -3.88e-5, 0, -1.26e-5},
        .c = {0, -4.32, 0, -14.66, 0, -42.37},
        .volume = {{8.20e-4, 2.28e-4, -7.05e-5, 3.30e-6}, {8.20e-4, -2.28e-4, -7.05e-5, -3.30e-6}},
        .angle_low = -0.7, .angle_high = 0.7, .pressure_low = LOW, .pressure_high = HIGH, .ramp = 0.5,
        .shear = 1e5, .compensator_unit = 1e5,
#ifdef DIRECT
        .direct = &direct, .adaptation = ADAPTATION, .most_acceleration = 0.5, .least_speed = 0.002, .disturbance_pole = 5,
#else
        .compensator = &block.model,
#endif
        .pneumatics = {8.013e5, 1.013e5, 287.0 * 293.0, 1.26, 1.185, 2e-8, 0.3, 0.03},
        .angle_jump = 0.05, .pressure_jump = 0.3e5, .angle_step = 2 * 3.141592653589793 / 131072,
        .frozen_samples = 400, .hold_samples = 40,
    };
    joint = given;
}

static void sense(void)
{
    sensors.angle = any_real();
    sensors.pressure[0] = any_real();
    sensors.pressure[1] = any_real();
}

static void refer(void)
{
    reference.angle = any_real();
    reference.velocity = any_real();
    reference.acceleration = any_real();
    reference.load = any_real();
    reference.mean_pressure = any_real();
    reference.pressure_difference = any_real();
    reference.extra = any_real();
}

int main(void)
{
    set_joint();
#ifdef DIRECT
    static dehyst_real wanted[MEMORY];
    static dehyst_real seen[MEMORY];
    state.wanted.memory = wanted;
    state.seen.memory = seen;
#endif
    state.compensator.z = z;
    sense();
    dehyst_joint_reset(&joint, &state, &sensors, start);
    while (Frama_C_nondet(0, 1)) {
        const uint32_t switches = Frama_C_unsigned_int_interval(0, UINT32_MAX);
        sense();
        refer();
        dehyst_joint_step(&joint, &state, &sensors, &reference, switches, &output);
        for (int32_t i = 0; i < 2; ++i) {
            //@ assert valve: \is_finite(output.valve[i]) && -1 <= output.valve[i] <= 1;
            //@ assert desired: \is_finite(output.desired[i]) && LOW <= output.desired[i] <= HIGH;
        }
        //@ assert rest: \is_finite(output.torque) && \is_finite(output.integrator) && \is_finite(output.compensation);
        //@ assert seen: \is_finite(output.angle) && \is_finite(output.velocity) && \is_finite(output.load);
        //@ assert scale: \is_finite(state.fit.scale) && 0 <= state.fit.scale <= 1;
        //@ assert difference: \is_finite(output.pressure_difference);
#ifdef DIRECT
        for (int32_t g = 0; g < 4; ++g) {
            //@ assert scale: \is_finite(state.learning.scale[g]) && 0 <= state.learning.scale[g] <= 2;
        }
        //@ assert offset: \is_finite(state.learning.offset) && -2 <= state.learning.offset <= 2;
        //@ assert contact: \is_finite(output.contact);
        //@ assert torque: \is_finite(state.torque_direct) && -1e6 <= state.torque_direct <= 1e6;
#endif
    }
    return 0;
}
