#include "dehyst.h"

#define LAMINAR ((dehyst_real)0.999)   /* ratio above which the flow is taken as proportional to the rest */
#define SMALLEST_PSI ((dehyst_real)0.05) /* a valve with no pressure across it cannot be inverted */
#define ZONE ((dehyst_real)0.005)      /* opening below which the dead band is crossed in a straight line */
#define VACUUM ((dehyst_real)1)        /* [Pa] */

/* Half the exponent is a root within 4 %; bits are read as guard.c does. */
#ifdef DEHYST_FLOAT
#define BITS uint32_t
#define HALF_BIAS UINT32_C(0x1fbb4f2e)
#define SMALLEST_ROOT 1e-37f
#else
#define BITS uint64_t
#define HALF_BIAS UINT64_C(0x1ff7a3bea91d9b1c)
#define SMALLEST_ROOT 1e-300
#endif

typedef union pattern {
    dehyst_real real;
    BITS bits;
} pattern;

dehyst_real dehyst_root(dehyst_real x)
{
    if (!dehyst_accept(x) || !(x > SMALLEST_ROOT)) {
        return 0;
    }
    pattern guess;
    guess.real = x;
    guess.bits = (guess.bits >> 1) + HALF_BIAS;
    dehyst_real y = guess.real;
    for (int32_t i = 0; i < 4; ++i) { /* 4e-2, 8e-4, 3e-7, 5e-14, rounding */
        y = (dehyst_real)0.5 * (y + x / y);
    }
    return y;
}

dehyst_real dehyst_flow_function(dehyst_real ratio, dehyst_real critical)
{
    if (ratio <= critical) {
        return 1;
    }
    if (!(ratio < 1)) {
        return 0;
    }
    const dehyst_real turbulent = ratio < LAMINAR ? ratio : LAMINAR;
    const dehyst_real share = (turbulent - critical) / (1 - critical);
    const dehyst_real psi = dehyst_root((1 - share) * (1 + share)); /* 1 - share^2 without cancellation */
    return ratio < LAMINAR ? psi : psi * ((1 - ratio) / (1 - LAMINAR));
}

dehyst_real dehyst_valve_opening(const dehyst_pneumatics *air, dehyst_real flow, dehyst_real pressure)
{
    const dehyst_real p = pressure > VACUUM ? pressure : VACUUM;
    const dehyst_real up = flow > 0 ? air->supply : p;
    const dehyst_real down = flow > 0 ? p : air->ambient;
    const dehyst_real psi = dehyst_flow_function(down / (up > VACUUM ? up : VACUUM), air->ratio);
    return flow / (air->conductance * air->reference_density * up * (psi > SMALLEST_PSI ? psi : SMALLEST_PSI));
}

dehyst_real dehyst_valve_command(const dehyst_pneumatics *air, dehyst_real opening)
{
    const dehyst_real band = air->dead_band > 0 ? (air->dead_band < 1 ? air->dead_band : (dehyst_real)1) : (dehyst_real)0;
    const dehyst_real size = opening < 0 ? -opening : opening;
    if (size < ZONE) { /* noise of the pressure sensor must not throw the spool from one side to the other */
        return opening * (band / ZONE + (1 - band));
    }
    return (opening < 0 ? -band : band) + (1 - band) * opening;
}

void dehyst_volume_at(const dehyst_joint *joint, int32_t muscle, dehyst_real angle, dehyst_real *volume,
                      dehyst_real *slope)
{
    const dehyst_real *v = joint->volume[muscle];
    const int inside = angle > joint->angle_low && angle < joint->angle_high;
    const dehyst_real q = inside ? angle : (angle > joint->angle_low ? joint->angle_high : joint->angle_low);
    *volume = v[0] + q * (v[1] + q * (v[2] + q * v[3]));
    *slope = inside ? v[1] + q * (2 * v[2] + q * (3 * v[3])) : (dehyst_real)0;
}

dehyst_real dehyst_chamber_flow(const dehyst_pneumatics *air, dehyst_real volume, dehyst_real volume_rate,
                                dehyst_real pressure, dehyst_real rate)
{
    return (volume * rate / air->polytropic + pressure * volume_rate) / air->gas_temperature;
}

dehyst_real dehyst_chamber_rate(const dehyst_pneumatics *air, dehyst_real volume, dehyst_real volume_rate,
                                dehyst_real pressure, dehyst_real flow)
{
    return air->polytropic * (air->gas_temperature * flow - pressure * volume_rate) / volume;
}
