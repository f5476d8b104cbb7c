/* Images of parameters of any size; a block that is let in is run. Built so that the fuzzer need not guess checksums. */
#include <stdio.h>

#include "common.h"

#define MOST 6 /* operators, and points of a map */
#define REALS DEHYST_BLOCK_REALS(MOST, MOST, MOST)
#define WORDS DEHYST_BLOCK_WORDS(MOST, MOST, MOST)

/* Increasing or free reals. */
static uint32_t *put_row(bytes *from, uint32_t *at, int32_t n, int increasing)
{
    dehyst_real last = take_real(from);
    for (int32_t i = 0; i < n; ++i) {
        at = dehyst_image_put(at, &last, 1);
        const dehyst_real step = take_real(from);
        last = increasing ? last + (step > 0 ? step : 1 - step) : step;
    }
    return at;
}

/* Blocks of n operators that were let in: printed at the end, so that nobody takes refusals for proofs. */
static unsigned long let_in[MOST + 1];

__attribute__((destructor)) static void tell(void)
{
    for (int n = 1; n <= MOST; ++n) {
        fprintf(stderr, "let in %lu blocks of %d operators\n", let_in[n], n);
    }
}

/* The loading curve of the thresholds and slopes that the image holds: a table of any numbers would not be let in. */
static uint32_t *put_loading(uint32_t *at, const uint32_t *rows, int32_t n)
{
    dehyst_real threshold[MOST] = {0};
    dehyst_real slope[MOST] = {0};
    dehyst_real phi = 0;
    (void)dehyst_image_get(rows, threshold, n);
    (void)dehyst_image_get(rows + DEHYST_REAL_WORDS * n, slope, n);
    for (int32_t i = 0; i < n; ++i) {
        phi += i > 0 ? slope[i - 1] * (threshold[i] - threshold[i - 1]) : 0;
        at = dehyst_image_put(at, &phi, 1);
    }
    return at;
}

static int32_t build(bytes *from, uint32_t *image)
{
    const uint8_t how = take_byte(from);
    const int32_t n = take_byte(from) % MOST + 1;
    const int32_t before = take_byte(from) % (MOST + 1);
    const int32_t after = take_byte(from) % (MOST + 1);
    const int32_t words = DEHYST_BLOCK_WORDS(n, before, after);
    image[0] = UINT32_C(0x64685000) + (uint32_t)sizeof(dehyst_real);
    image[1] = (uint32_t)n;
    image[2] = (uint32_t)before;
    image[3] = (uint32_t)after;
    image[4] = how;
    uint32_t *at = put_row(from, image + 5, n, how & 1);
    at = put_row(from, at, n, 0);
    at = how & 32 ? put_row(from, at, n, 0) : put_loading(at, image + 5, n);
    const dehyst_real zero = 0;
    for (int32_t i = 0; i < n; ++i) {
        at = how & 2 ? dehyst_image_put(at, &zero, 1) : put_row(from, at, 1, 0);
    }
    at = put_row(from, at, before, how & 1);
    at = put_row(from, at, before, how & 1);
    at = put_row(from, at, after, how & 1);
    at = put_row(from, at, after, how & 1);
    at = put_row(from, at, 2, 0);
    for (int32_t i = 0; i < 3; ++i) {
        at = put_row(from, at, 2, 1);
    }
    at = put_row(from, at, 2, 0);
    const dehyst_real fade = (dehyst_real)(take_byte(from) + 1) / 256;
    at = dehyst_image_put(at, how & 4 ? &fade : &zero, 1);
    CLAIM(at == image + words - 1);
    if (how & 8) { /* anything in any word */
        take(from, &image[take_byte(from) % words], sizeof image[0]);
    }
    image[words - 1] = how & 16 ? 0 : dehyst_image_sum(image, words - 1);
    return words;
}

static void run(const dehyst_block *block, bytes *from, dehyst_real *z, dehyst_real *other)
{
    uint32_t image[DEHYST_STATE_WORDS(MOST)];
    const int32_t words = DEHYST_STATE_WORDS(block->model.hysteresis.n);
    dehyst_block_state state = {{z, 0, 0}, 0, 0, 0, 0};
    dehyst_block_state copy = {{other, 0, 0}, 0, 0, 0, 0};
    dehyst_block_reset(block, &state);
    CLAIM(within(state.output, block->output_low, block->output_high));
    while (from->left) {
        const uint8_t on = take_byte(from);
        const dehyst_real y = dehyst_block_step(block, &state, take_real(from), on & 1);
        CLAIM(within(y, block->output_low, block->output_high));
    }
    CLAIM(dehyst_block_save(block, &state, image, words) == DEHYST_IMAGE_GOOD);
    CLAIM(dehyst_block_restore(block, &copy, image, words) == DEHYST_IMAGE_GOOD);
    CLAIM(same(dehyst_block_step(block, &state, 1, 1), dehyst_block_step(block, &copy, 1, 1)));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    uint32_t image[WORDS];
    uint32_t again[WORDS];
    dehyst_real memory[REALS];
    dehyst_real z[MOST];
    dehyst_real other[MOST];
    dehyst_block block;
    memset(image, 0, sizeof image);
    if (data && size && data[0] == 255) { /* no image at all */
        take(&from, image, sizeof image);
        (void)dehyst_block_load(image, (int32_t)(size / 4 < WORDS ? size / 4 : WORDS), memory, REALS, &block);
        return 0;
    }
    const int32_t words = build(&from, image);
    const int32_t reals = take_byte(&from) % 8 ? REALS : take_byte(&from) % REALS;
    if (dehyst_block_load(image, words, memory, reals, &block) == DEHYST_IMAGE_GOOD) {
        ++let_in[block.model.hysteresis.n];
        CLAIM(dehyst_block_check(&block) == DEHYST_IMAGE_GOOD);
        CLAIM(dehyst_block_dump(&block, again, words) == DEHYST_IMAGE_GOOD);
        CLAIM(memcmp(image, again, (size_t)words * 4) == 0);
        run(&block, &from, z, other);
    }
    return 0;
}
