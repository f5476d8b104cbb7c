/* Blocks of any elements that the check lets in: samples and switching of any kind, their images, and images that are
 * changed and have a good checksum. Outputs keep to their range, and whatever state is saved is let in again. */
#include <stdio.h>

#include "sum.h"

enum { RING = 3, WORDS = DEHYST_ELEMENT_WORDS(MOST, RING) };

/* Blocks that were let in, printed at the end, so that nobody takes refusals for proofs. */
static unsigned long let_in[2];

__attribute__((destructor)) static void tell(void)
{
    fprintf(stderr, "let in %lu blocks that evaluate\nlet in %lu blocks that solve\n", let_in[0], let_in[1]);
}

typedef struct machine {
    dehyst_element_block_state state;
    dehyst_real z[MOST], ring[RING];
} machine;

static void take_block(bytes *from, drawn *made, dehyst_real *start, dehyst_element_block *block)
{
    const uint8_t how = take_byte(from);
    take_sum(from, made);
    block->sum = made->sum;
    block->solves = how & 1;
    block->delay = how / 2 % (RING + 1);
    block->start = how & 8 ? start : 0;
    for (int32_t k = 0; block->start && k < made->sum.n; ++k) {
        start[k] = take_real(from);
    }
    dehyst_real *numbers[] = {&block->echo,       &block->origin,      &block->center,     &block->half_range, &block->level,
                              &block->amplitude,  &block->input_low,   &block->input_high, &block->output_low,
                              &block->output_high, &block->reach_low,  &block->reach_high, &block->line_slope,
                              &block->line_offset, &block->fade};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        *numbers[i] = take_real(from);
    }
    if (how & 16) {
        block->reach_low = -DEHYST_FAR;
        block->reach_high = DEHYST_FAR;
    }
    block->fingerprint = how;
}

/* Outputs and images of both are the same; what is saved is let in. */
static void go_on_elsewhere(const dehyst_element_block *block, machine *here, bytes *from)
{
    uint32_t image[WORDS], again[WORDS];
    const int32_t words = DEHYST_ELEMENT_WORDS(block->sum.n, block->delay);
    machine there = {.state = {.sum = {.z = there.z}, .delay = {.ring = there.ring}}};
    CLAIM(dehyst_element_block_save(block, &here->state, image, words) == DEHYST_IMAGE_GOOD);
    CLAIM(dehyst_element_block_restore(block, &there.state, image, words) == DEHYST_IMAGE_GOOD);
    CLAIM(dehyst_element_block_save(block, &there.state, again, words) == DEHYST_IMAGE_GOOD);
    CLAIM(memcmp(image, again, (size_t)words * sizeof image[0]) == 0);
    const dehyst_real x = take_real(from), given[DEHYST_GIVEN] = {take_real(from), take_real(from), take_real(from)};
    CLAIM(same(dehyst_element_block_step(block, &here->state, x, given, 1),
               dehyst_element_block_step(block, &there.state, x, given, 1)));
    CLAIM(here->state.flags == there.state.flags);
}

/* An image with some words or reals of anything; a refused one changes nothing. */
static void take_image(const dehyst_element_block *block, machine *here, bytes *from)
{
    uint32_t image[WORDS];
    const int32_t words = DEHYST_ELEMENT_WORDS(block->sum.n, block->delay);
    const machine before = *here;
    (void)dehyst_element_block_save(block, &here->state, image, words);
    for (uint8_t changes = take_byte(from) % 8; changes; --changes) {
        const uint8_t where = take_byte(from);
        if (where < 128) {
            take(from, &image[where % words], sizeof image[0]);
        } else {
            const dehyst_real value = take_real(from) * (where & 64 ? DEHYST_INPUT_LIMIT : 1);
            (void)dehyst_image_put(image + 5 + DEHYST_REAL_WORDS * (where % (block->sum.n + block->delay + 4)), &value, 1);
        }
    }
    if (take_byte(from) % 8) {
        image[words - 1] = dehyst_image_sum(image, words - 1);
    }
    if (dehyst_element_block_restore(block, &here->state, image, words) != DEHYST_IMAGE_GOOD) {
        CLAIM(memcmp(&before, here, sizeof before) == 0);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    drawn made;
    dehyst_real start[MOST];
    dehyst_element_block block;
    take_block(&from, &made, start, &block);
    if (dehyst_element_block_check(&block) != DEHYST_IMAGE_GOOD) {
        return 0;
    }
    ++let_in[block.solves];
    machine here;
    memset(&here, 0, sizeof here);
    here.state.sum.z = here.z;
    here.state.delay.ring = here.ring;
    dehyst_element_block_reset(&block, &here.state);
    while (from.left) {
        const uint8_t what = take_byte(&from);
        if (what >= 240) {
            go_on_elsewhere(&block, &here, &from);
        } else if (what >= 224) {
            take_image(&block, &here, &from);
        }
        const dehyst_real x = take_real(&from), given[DEHYST_GIVEN] = {take_real(&from), take_real(&from), take_real(&from)};
        if (what >= 192 && what < 224) {
            dehyst_element_block_observe(&block, &here.state, x, take_real(&from), given);
            CLAIM(within(here.state.output, block.output_low, block.output_high));
            continue;
        }
        const dehyst_real y = dehyst_element_block_step(&block, &here.state, x, given, what & 1);
        CLAIM(within(y, block.output_low, block.output_high) && within(here.state.share, 0, 1));
        CLAIM(here.state.sum.rounds >= 0 && here.state.sum.rounds <= DEHYST_ROUNDS);
    }
    go_on_elsewhere(&block, &here, &from);
    return 0;
}
