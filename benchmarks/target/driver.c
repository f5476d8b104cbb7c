/* Runs blocks over signals, on a microcontroller or on the host: job.bin in, answer.bin out, 32-bit words throughout.
 *
 *   job:    number of cases, then for each: words of the image of its parameters, the image, number of samples,
 *           then for each sample: x as IEEE words, 1 on or 0 off
 *   answer: for each case and sample: output as IEEE words, flags; after a case its play states
 *
 * steps() is the only caller of dehyst_block_step, so that a tracer can tell the step from the rest. */
#include "dehyst.h"
#include "io.h"

enum { WORDS = 60000, REALS = 24000, OPERATORS = 4096 };

static uint32_t image[WORDS];
static dehyst_real memory[REALS];
static dehyst_real z[OPERATORS];
static dehyst_block block;
static dehyst_block_state state;

static uint32_t word(void)
{
    uint32_t value = 0;
    io_read(&value, sizeof value);
    return value;
}

static void load(void)
{
    const uint32_t words = word();
    if (words > WORDS) io_end(4);
    io_read(image, words * (uint32_t)sizeof *image);
    const int32_t fault = dehyst_block_load(image, (int32_t)words, memory, REALS, &block);
    if (fault != DEHYST_IMAGE_GOOD) io_end(10 + fault);
    if (block.model.hysteresis.n > OPERATORS) io_end(5);
    state.model.z = z;
    dehyst_block_reset(&block, &state);
}

__attribute__((noinline)) static void steps(uint32_t samples)
{
    for (uint32_t k = 0; k < samples; ++k) {
        struct {
            dehyst_real x;
            uint32_t on;
        } __attribute__((packed)) in;
        struct {
            dehyst_real y;
            uint32_t flags;
        } __attribute__((packed)) out;
        io_read(&in, sizeof in);
        out.y = dehyst_block_step(&block, &state, in.x, (int)in.on);
        out.flags = state.flags;
        io_write(&out, sizeof out);
    }
}

int main(void)
{
    const uint32_t cases = word();
    for (uint32_t i = 0; i < cases; ++i) {
        load();
        steps(word());
        io_write(z, (uint32_t)block.model.hysteresis.n * (uint32_t)sizeof *z);
    }
    return 0;
}
