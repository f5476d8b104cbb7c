/* The sensors of the tables in sensors.h. The noise is a sum of integers: the same bits on every machine. */
#include "parts.h"

/* splitmix64, Steele, Lea, Flood, OOPSLA 2014. */
static uint64_t draw(uint64_t *random)
{
    uint64_t z = (*random += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Sum of twelve uniform 16-bit numbers, which has variance 2^32 - 1: normal to 2 % of the density within 3 sigma. */
static double normal(uint64_t *random)
{
    int64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
        const uint64_t bits = draw(random);
        sum += (int64_t)((bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48));
    }
    return (double)(2 * sum - 12 * 65535) * (0.5 / 65536.0);
}

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
}

static double shown(double *sensed, uint64_t *random, double value, double period, double step, double noise, double lag)
{
    *sensed = lag > 0.0 ? *sensed + plant_settled(period / lag) * (value - *sensed) : value;
    const double noisy = noise > 0.0 ? *sensed + noise * normal(random) : *sensed;
    return step > 0.0 ? floor(noisy / step + 0.5) * step : noisy;
}

void plant_joint_sense(const plant_joint *joint, plant_joint_state *state, double q, double period,
                       plant_reading *reading)
{
    const plant_sensors *sensors = &joint->sensors;
#define SHOW(name, kind, value)                                                                                       \
    reading->name = shown(&state->sensed[PLANT_SENSOR_##name], &state->random[PLANT_KIND_##kind], value, period,       \
                          sensors->kind##_step, sensors->kind##_noise, sensors->kind##_lag);
    PLANT_SENSORS(SHOW)
#undef SHOW
}
