/* Reads lines of time, force, reading and temperature, corrects each reading, and compares it with the force. */
#include <math.h>
#include <stdio.h>

#include "cell.h"

static cell_state unit; /* one for each sensor */

int main(void)
{
    double time, force, reading, temperature, square = 0.0, last = 0.0;
    int samples = 0;

    scanf("%*[^\n]"); /* the names of the columns */
    cell_reset(&unit);
    while (scanf("%lf,%lf,%lf,%lf", &time, &force, &reading, &temperature) == 4) {
        last = cell_step(&unit, reading, temperature, 1);
        square += (last - force) * (last - force);
        samples++;
    }
    printf("%d samples, rms error %.3f N, last one %.4f N\n", samples, sqrt(square / samples), last);
    return samples == 0;
}
