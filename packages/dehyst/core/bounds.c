#include "dehyst.h"

dehyst_real dehyst_bounded(dehyst_real x, dehyst_real limit)
{
    if (dehyst_accept(x) && x <= limit && x >= -limit) {
        return x;
    }
    return x > 0 ? limit : (x < 0 ? -limit : (dehyst_real)0);
}

void dehyst_fade_start(dehyst_fade *fade, dehyst_real value, dehyst_real part)
{
    const dehyst_real step = value * part;
    fade->value = step < 0 || step > 0 ? value : (dehyst_real)0; /* a step that rounds to nothing would never end */
    fade->step = step;
}

void dehyst_fade_step(dehyst_fade *fade)
{
    const dehyst_real value = fade->value < 0 ? -fade->value : fade->value;
    const dehyst_real step = fade->step < 0 ? -fade->step : fade->step;
    const dehyst_real left = value > step ? value - step : (dehyst_real)0; /* never grows, whatever the signs */
    fade->value = fade->value < 0 ? -left : left;
}

dehyst_real dehyst_fade_part(const dehyst_joint *joint)
{
    return joint->ramp > joint->period ? dehyst_bounded(joint->period / joint->ramp, 1) : (dehyst_real)1;
}

dehyst_real dehyst_pressure_range(const dehyst_joint *joint)
{
    return joint->pressure_high > joint->pressure_low ? joint->pressure_high - joint->pressure_low : (dehyst_real)0;
}
