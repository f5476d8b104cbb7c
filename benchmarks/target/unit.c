/* Runs an exported block over samples: job.bin in, answer.bin out.
 *
 *   job:    number of samples, then for each: INPUTS inputs as IEEE words, 1 on or 0 off
 *   answer: for each sample: output as IEEE words
 *
 * steps() is the only caller of unit_step. */
#include "io.h"
#include "unit.h"

static unit_state unit;

#if INPUTS == 1
#define GIVEN(x) x[0]
#elif INPUTS == 2
#define GIVEN(x) x[0], x[1]
#elif INPUTS == 3
#define GIVEN(x) x[0], x[1], x[2]
#else
#define GIVEN(x) x[0], x[1], x[2], x[3]
#endif

typedef struct sample {
    dehyst_real x[INPUTS];
    uint32_t on;
} __attribute__((packed)) sample;

__attribute__((noinline)) static void steps(uint32_t samples)
{
    unit_reset(&unit);
#ifdef TUNED /* a page whose limits are a bit narrower: all that a step may have to do */
    unit_page[1].output_high = unit_page[1].output_high - (unit_page[1].output_high - unit_page[1].output_low) / 65536;
    unit_page_number = 1;
#endif
    for (uint32_t k = 0; k < samples; ++k) {
        sample in;
        io_read(&in, sizeof in);
        const dehyst_real y = unit_step(&unit, GIVEN(in.x), (int)in.on);
        io_write(&y, sizeof y);
    }
}

int main(void)
{
    uint32_t samples = 0;
    io_read(&samples, sizeof samples);
    steps(samples);
    return 0;
}
