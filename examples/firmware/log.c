/* Step 1, on the board: move the stage through loops of all sizes and log both converters at 250 Hz, in units.
 * The fourth sample of each four is written: the codes that were there at that moment. */
#include <stdio.h>

#include "plant.h"

static long sample;

static void move(double from, double to, long samples)
{
    for (long k = 1; k <= samples; ++k) {
        const double volt = from + (to - from) * (double)k / (double)samples;
        const uint16_t code = (uint16_t)(volt / VOLT_PER_CODE + 0.5);
        plant_write(code);
        const uint16_t seen = plant_read();
        if (++sample % 4 == 0) {
            printf("%.3f,%.5f,%.5f\n", 0.001 * (double)sample, VOLT_PER_CODE * (double)code, UM_PER_CODE * (double)seen);
        }
    }
}

int main(void)
{
    double at = 0.0;
    plant_reset();
    puts("time_s,voltage_V,position_um");
    for (int k = 0; k < 24; ++k) { /* strokes that shrink, and then grow, at 60 V/s */
        const double half = k < 12 ? 72.0 * (1.0 - k / 13.0) : 72.0 * (k - 10) / 13.0;
        const double to = 75.0 + (k % 2 ? -half : half);
        move(at, to, (long)((to > at ? to - at : at - to) / 0.06));
        at = to;
    }
    move(at, at, 2000); /* and a rest, which tells creep */
    return 0;
}
