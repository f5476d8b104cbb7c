/* What is measured of a joint, a row a sensor. The fields of `plant_sensors` and `plant_reading`, the states, the reading
 * itself and the names in Python follow from these tables:
 *   shown = lag[value, `delay` and at most `jitter` old] + noise + offset + drift (1 - exp(-t/drift_time)), rounded to
 *           a multiple of the step
 * A kind of sensor has the parameters NAME_step, NAME_noise (rms, white, a sample), NAME_offset and NAME_drift (rms from
 * sensor to sensor, drawn at the reset), all in the unit of the value, and NAME_lag (first order), NAME_delay,
 * NAME_jitter (largest further delay, drawn anew every reading) and NAME_drift_time, [s]; 0 for none. Its noise has a
 * stream of its own, so that a row at the end of a table leaves every other reading as it was, to the bit. The value is in SI, of `joint`, `state` and the angle q. */
#ifndef PLANT_SENSORS_H
#define PLANT_SENSORS_H

#define PLANT_QUALITIES(QUALITY) \
    QUALITY(step) QUALITY(noise) QUALITY(lag) QUALITY(delay) QUALITY(jitter) QUALITY(offset) QUALITY(drift) \
    QUALITY(drift_time)

#define PLANT_KINDS(KIND) \
    KIND(angle) \
    KIND(pressure) \

#define PLANT_SENSORS(SENSOR) \
    SENSOR(angle, angle, q) \
    SENSOR(pressure_1, pressure, state->muscle[0].pressure - joint->air.ambient) \
    SENSOR(pressure_2, pressure, state->muscle[1].pressure - joint->air.ambient) \

#endif
