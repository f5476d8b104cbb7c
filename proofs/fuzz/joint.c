/* Images of a joint controller's state, good ones and others, then periods with any inputs. */
#include "common.h"
#include "parameters.h"
#ifdef DIRECT
#include "direct.h"
#else
#define MEMORY -1
#endif

#define LOW ((dehyst_real)0.2e5)
#define HIGH ((dehyst_real)6e5)
#define WORDS DEHYST_JOINT_WORDS(PLAYS, MEMORY)
#define MARK 7u
#ifdef DIRECT
#define PLAYS 0
#define REALS (40 + DEHYST_FIT_REALS + 18 + 9 * DEHYST_GROUPS + 2 * MEMORY)
#else
#define PLAYS N
#define REALS (N + 40 + DEHYST_FIT_REALS)
#endif

static const dehyst_joint joint = {
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
    .angle_jump = 0.05, .pressure_jump = 0.3e5, .angle_step = 4.8e-5, .frozen_samples = 400, .hold_samples = 40,
};

static void step(dehyst_joint_state *state, bytes *from)
{
    dehyst_joint_output out;
    const uint8_t what = take_byte(from);
    const dehyst_joint_sensors sensors = {take_real(from),
                                          {3e5 + (what & 32 ? 1e4 : 1) * take_real(from), 3e5 + take_real(from)}};
    dehyst_joint_reference reference = {take_real(from), 0, 0, 0, 3e5, 0, 0};
    if (what & 64) {
        reference.velocity = take_real(from);
        reference.acceleration = take_real(from);
        reference.load = take_real(from);
        reference.mean_pressure = take_real(from);
        reference.pressure_difference = take_real(from);
        reference.extra = take_real(from);
    }
    dehyst_joint_step(&joint, state, &sensors, &reference, (what & 7u) | (what & 128 ? 24u : 0u), &out);
    for (int i = 0; i < 2; ++i) {
        CLAIM(within(out.valve[i], -1, 1) && within(out.desired[i], LOW, HIGH));
    }
    CLAIM(dehyst_accept(out.torque) && dehyst_accept(out.pressure_difference) && dehyst_accept(out.angle));
    CLAIM(dehyst_accept(out.contact) && dehyst_accept(out.doubt));
    for (int g = 0; g < DEHYST_GROUPS; ++g) {
        CLAIM(within(state->learning.scale[g], 0, 2));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    uint32_t image[WORDS];
    dehyst_joint_state state;
    memset(&state, 0, sizeof state);
    state.compensator.z = z;
#ifdef DIRECT
    dehyst_real wanted[MEMORY];
    dehyst_real seen[MEMORY];
    state.wanted.memory = wanted;
    state.seen.memory = seen;
#endif
    const dehyst_joint_sensors sensors = {0, {3e5, 3e5}};
    dehyst_joint_reset(&joint, &state, &sensors, start);
    for (uint8_t steps = take_byte(&from) % 4; steps; --steps) {
        step(&state, &from);
    }
    CLAIM(dehyst_joint_save(&joint, &state, MARK, image, WORDS) == DEHYST_IMAGE_GOOD);
    const uint8_t how = take_byte(&from);
    for (uint8_t changes = how & 2 ? take_byte(&from) % 8 : 0; changes; --changes) {
        const uint8_t where = take_byte(&from);
        if (where < 64) {
            take(&from, &image[where % WORDS], sizeof image[0]);
        } else {
            const dehyst_real value = take_real(&from) * (where & 32 ? 1e5 : 1);
            (void)dehyst_image_put(image + 15 + DEHYST_REAL_WORDS * ((where + 3 * (how >> 3)) % REALS), &value, 1);
        }
    }
    if (how & 1) {
        image[WORDS - 1] = dehyst_image_sum(image, WORDS - 1);
    }
    (void)dehyst_joint_restore(&joint, &state, MARK, image, WORDS - (how & 4 ? 1 : 0));
    while (from.left) {
        step(&state, &from);
    }
    return 0;
}
