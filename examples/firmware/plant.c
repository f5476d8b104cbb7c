/* An actuator that is no model of dehyst: 4 000 relays (Preisach), creep that follows them in 0.3 s and 3 s, an
 * amplifier of 300 Hz, noise of half a code. */
#include "plant.h"

enum { RELAYS = 4000 };

static double low[RELAYS], high[RELAYS]; /* [V] each relay falls below the one and rises above the other */
static int up[RELAYS];
static double voltage, slow[2], position;
static uint32_t seed;

static double uniform(void) /* within -1 .. 1 */
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / 8388607.5 - 1.0;
}

static double bell(void) /* nearly normal, standard deviation 1 */
{
    double sum = 0.0;
    for (int i = 0; i < 12; ++i) {
        sum += uniform();
    }
    return 0.5 * sum;
}

void plant_reset(void)
{
    seed = 7u;
    for (int i = 0; i < RELAYS; ++i) {
        const double middle = 75.0 + 45.0 * bell(), width = 14.0 * bell();
        low[i] = middle - (width < 0.0 ? -width : width);
        high[i] = middle + (width < 0.0 ? -width : width);
        up[i] = 0;
    }
    voltage = slow[0] = slow[1] = position = 0.0;
    for (int i = 0; i < 20000; ++i) { /* at rest at 0 V for a while */
        plant_write(0);
    }
}

void plant_write(uint16_t code)
{
    double sum = 0.0;
    voltage += 0.85 * (VOLT_PER_CODE * (double)code - voltage); /* 1 - exp(-2 pi 300 Hz 1 ms) */
    for (int i = 0; i < RELAYS; ++i) {
        up[i] = voltage > high[i] ? 1 : voltage < low[i] ? 0 : up[i];
        sum += (double)up[i];
    }
    const double fast = 38.0 * sum / RELAYS + 0.06 * voltage;
    slow[0] += (fast - slow[0]) * (0.001 / 0.3);
    slow[1] += (fast - slow[1]) * (0.001 / 3.0);
    position = 4.0 + 0.95 * fast + 0.03 * slow[0] + 0.02 * slow[1];
}

uint16_t plant_read(void)
{
    const double code = position / UM_PER_CODE + 0.5 * bell() + 0.5;
    return (uint16_t)(code < 0.0 ? 0.0 : code > CODES - 1 ? CODES - 1 : code);
}

double plant_position(void)
{
    return position;
}
