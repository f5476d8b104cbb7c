/* Step 3, on the board: a loop at 1 kHz. Reference in um, out to the DAC; the compensator beside a feedback loop. */
#include <math.h>
#include <stdio.h>

#define STAGE_IMPLEMENTATION
#include "stage.h"

#include "plant.h"

#define TURN 6.283185307179586
enum { SAMPLES = 20000, START = 2000 }; /* 20 s, the first two of them are the way there */
enum { LINE, PI, COMPENSATOR, BOTH, WAYS };

static const char *const names[WAYS] = {"straight line", "line and PI", "compensator", "compensator and PI"};

typedef struct controller {
    stage_state unit; /* the exported compensator */
    double integral;  /* [V] */
    double due;       /* reference of the sample before: what is measured now answers that one [um] */
} controller;

/* Gains of the feedback: crossover near 25 Hz, a quarter of what delay and amplifier allow. */
static const double proportional = 0.4; /* [V/um] */
static const double integral = 0.25;    /* [V/um] a sample */

/* What one would do without a model: the straight line through both ends of the log. [V] */
static double line(double reference)
{
    return 150.0 * (reference - 4.3) / (49.4 - 4.3);
}

/* One period: the voltage for a reference and a measured position. */
static double control(controller *c, int way, double reference, double measured)
{
    const double compensated = (double)stage_step(&c->unit, (dehyst_real)reference, 1);
    const double forward = way == COMPENSATOR || way == BOTH ? compensated : line(reference);
    if (way == LINE || way == COMPENSATOR) {
        return forward;
    }
    const double error = c->due - measured;
    c->due = reference;
    const double wanted = forward + proportional * error + c->integral;
    if ((wanted < 150.0 || error < 0.0) && (wanted > 0.0 || error > 0.0)) { /* no winding up at a limit */
        c->integral += integral * error;
    }
    return wanted;
}

/* A reference that was never logged: two sines that stop now and then. [um] */
static double reference_at(long k)
{
    const double moving = 0.001 * (double)(k / 3000 * 2600 + (k % 3000 < 2600 ? k % 3000 : 2600));
    return 27.0 + 11.0 * sin(TURN * 0.9 * moving) + 5.0 * sin(TURN * 2.3 * moving);
}

static uint16_t code_of(double volt) /* rounded, within the DAC */
{
    const double code = volt / VOLT_PER_CODE + 0.5;
    return (uint16_t)(code < 0.0 ? 0.0 : code > CODES - 1 ? CODES - 1 : code);
}

/* Error of one way to control. [um rms] */
static double run(int way)
{
    controller c = {.due = reference_at(0)};
    double sum = 0.0;
    stage_reset(&c.unit);
    plant_reset();
    uint16_t seen = plant_read();
    for (long k = 0; k < SAMPLES; ++k) {
        const double reference = reference_at(k);
        plant_write(code_of(control(&c, way, reference, UM_PER_CODE * (double)seen)));
        seen = plant_read();
        const double error = reference - plant_position();
        sum += k < START ? 0.0 : error * error;
    }
    return sqrt(sum / (SAMPLES - START));
}

int main(void)
{
    for (int way = 0; way < WAYS; ++way) {
        printf("%-20s %5.2f um rms\n", names[way], run(way));
    }
    return 0;
}
