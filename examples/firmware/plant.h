/* A simulated stage for firmware.c: an actuator of relays behind a 12-bit DAC, read by a 12-bit ADC. On your board these
 * three functions are yours: what writes the DAC, what reads the ADC, and the clock. */
#ifndef PLANT_H
#define PLANT_H

#include <stdint.h>

enum { CODES = 4096 };             /* of both converters */
#define VOLT_PER_CODE (150.0 / (CODES - 1)) /* the amplifier turns 0 .. 4095 into 0 .. 150 V */
#define UM_PER_CODE (60.0 / (CODES - 1))    /* the strain gauge turns 0 .. 60 um into 0 .. 4095 */

void plant_reset(void);
void plant_write(uint16_t code); /* the DAC holds it for a millisecond */
uint16_t plant_read(void);       /* the ADC, at the end of that millisecond */
double plant_position(void);     /* [um], what no sensor tells: to judge by */

#endif
