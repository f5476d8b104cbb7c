/* The sensors of the tables in sensors.h. The noise is a sum of integers: the same bits on every machine. */
#include "parts.h"

void plant_sensors_reset(const plant_joint *joint, plant_joint_state *state, double q, const double p[2], uint64_t seed)
{
    const uint64_t first = (seed ^ UINT64_C(0x6a09e667f3bcc909)) * UINT64_C(0xd1342543de82ef95); /* seeds lie far apart */
    for (int kind = 0; kind < PLANT_KIND_COUNT; ++kind) /* 2^56 draws and more from stream to stream */
        state->random[kind] = first + ((uint64_t)(kind ^ PLANT_KIND_pressure) << 56);
#define REST(name, kind, value) state->sensed[PLANT_SENSOR_##name] = (value);
    PLANT_SENSORS(REST)
#undef REST
    state->sensed[PLANT_SENSOR_pressure_1] = p[0]; /* without the rounding of absolute pressures */
    state->sensed[PLANT_SENSOR_pressure_2] = p[1];
    state->sensing = first + (UINT64_C(128) << 56);
    state->computing = first + (UINT64_C(129) << 56);
    uint64_t biases = first + (UINT64_C(130) << 56);
    for (int m = 0; m < 2; ++m) state->muscle[m].random = first + ((uint64_t)(131 + m) << 56);
#define BIAS(name, kind, value)                                                                                       \
    state->bias[PLANT_SENSOR_##name] = joint->sensors.kind.offset * plant_normal(&biases);                            \
    state->bias_goal[PLANT_SENSOR_##name] =                                                                           \
        state->bias[PLANT_SENSOR_##name] + joint->sensors.kind.drift * plant_normal(&biases);                         \
    plant_ring_fill(&state->ring[PLANT_SENSOR_##name], state->sensed[PLANT_SENSOR_##name]);
    PLANT_SENSORS(BIAS)
#undef BIAS
}

static double shown(const plant_kind *kind, plant_joint_state *state, int s, uint64_t *random, double value,
                    double period)
{
    double *sensed = &state->sensed[s];
    if (kind->delay + kind->jitter > 0.0) {
        state->age[s] = plant_age(kind->delay, kind->jitter, &state->sensing, state->age[s], period);
        value = plant_delayed(&state->ring[s], value, state->age[s]);
    }
    *sensed = kind->lag > 0.0 ? *sensed + plant_settled(period / kind->lag) * (value - *sensed) : value;
    double noisy = kind->noise > 0.0 ? *sensed + kind->noise * plant_normal(random) : *sensed;
    if (kind->offset + kind->drift > 0.0) {
        if (kind->drift_time > 0.0)
            state->bias[s] += plant_settled(period / kind->drift_time) * (state->bias_goal[s] - state->bias[s]);
        noisy += state->bias[s];
    }
    return kind->step > 0.0 ? floor(noisy / kind->step + 0.5) * kind->step : noisy;
}

void plant_joint_sense(const plant_joint *joint, plant_joint_state *state, double q, double period,
                       plant_reading *reading)
{
#define SHOW(name, kind, value)                                                                                       \
    reading->name = shown(&joint->sensors.kind, state, PLANT_SENSOR_##name, &state->random[PLANT_KIND_##kind], value,  \
                          period);
    PLANT_SENSORS(SHOW)
#undef SHOW
}
