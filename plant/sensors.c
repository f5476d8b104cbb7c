/* Encoder and pressure sensors. The noise is a sum of integers: the same bits on every machine. */
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

void plant_joint_sense(const plant_joint *joint, plant_joint_state *state, double q, double period,
                       plant_reading *reading)
{
    const plant_sensors *sensors = &joint->sensors;
    const double step = sensors->angle_step, lag = sensors->pressure_lag;
    const double settled = lag > 0.0 ? plant_settled(period / lag) : 1.0;
    reading->angle = step > 0.0 ? floor(q / step + 0.5) * step : q;
    for (int m = 0; m < 2; ++m) {
        plant_muscle_state *muscle = &state->muscle[m];
        muscle->sensed += settled * (muscle->pressure - joint->air.ambient - muscle->sensed);
        reading->pressure[m] = muscle->sensed + sensors->pressure_noise * normal(&state->random);
    }
}
