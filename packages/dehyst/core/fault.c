#include "dehyst.h"

int dehyst_sensor_fault(dehyst_sensor *sensor, dehyst_real reading, dehyst_real expected, dehyst_real jump)
{
    if (!dehyst_accept(reading)) {
        return 1;
    }
    const int moved = reading < sensor->last || reading > sensor->last;
    const dehyst_real distance = reading > expected ? reading - expected : expected - reading;
    if (moved) {
        sensor->equal = 0;
    } else if (sensor->equal < INT32_MAX) {
        sensor->equal += 1;
    }
    sensor->last = reading;
    return jump > 0 && distance > jump;
}

int dehyst_sensor_failed(dehyst_sensor *sensor, int faulty, int32_t hold_samples)
{
    /* A sensor that is faulty every now and then is used; one that is faulty most of the time fails. */
    if (faulty) {
        sensor->faulty += sensor->faulty < INT32_MAX ? 1 : 0;
    } else {
        sensor->faulty -= sensor->faulty > 0 ? 1 : 0;
    }
    return sensor->faulty > hold_samples;
}
