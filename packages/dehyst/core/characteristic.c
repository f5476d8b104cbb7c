#include "dehyst.h"

#define SMALLEST_B ((dehyst_real)1e-9) /* [Nm/Pa], a ten-thousandth Nm a bar: no muscle is that weak */

void dehyst_characteristic_at(const dehyst_joint *joint, dehyst_real angle, dehyst_characteristic *at)
{
    const dehyst_real above = angle > joint->angle_low ? angle : joint->angle_low;
    const dehyst_real q = above < joint->angle_high ? above : joint->angle_high;
    dehyst_real a = 0;
    dehyst_real b = 0;
    dehyst_real c = 0;
    for (int32_t j = DEHYST_DEGREE - 1; j >= 0; --j) {
        a = a * q + joint->a[j];
        b = b * q + joint->b[j];
        c = c * q + joint->c[j];
    }
    at->a = dehyst_bounded(a, DEHYST_INPUT_LIMIT);
    b = dehyst_bounded(b, DEHYST_INPUT_LIMIT);
    at->b = b > SMALLEST_B ? b : SMALLEST_B;
    at->c = dehyst_bounded(c, DEHYST_INPUT_LIMIT);
}

dehyst_real dehyst_characteristic_torque(const dehyst_characteristic *at, dehyst_real mean, dehyst_real difference)
{
    return at->a * mean + at->b * difference + at->c;
}

dehyst_real dehyst_characteristic_difference(const dehyst_characteristic *at, dehyst_real mean, dehyst_real torque)
{
    return (torque - at->a * mean - at->c) / at->b;
}

int dehyst_pressures(const dehyst_joint *joint, dehyst_real mean, dehyst_real difference, dehyst_real *pressure)
{
    const dehyst_real low = joint->pressure_low;
    const dehyst_real high = joint->pressure_high > low ? joint->pressure_high : low;
    const dehyst_real dp = dehyst_bounded(difference, high - low);
    const dehyst_real half = (dehyst_real)0.5 * (dp < 0 ? -dp : dp);
    const dehyst_real above = mean > low + half ? mean : low + half;
    const dehyst_real p_m = above < high - half ? above : high - half;
    for (int32_t i = 0; i < 2; ++i) {
        const dehyst_real p = i == 0 ? p_m + (dehyst_real)0.5 * dp : p_m - (dehyst_real)0.5 * dp;
        pressure[i] = p > low ? (p < high ? p : high) : low; /* rounding must not leave the limits either */
    }
    return dp < difference || dp > difference || p_m < mean || p_m > mean;
}
