/* Images of states: as they are, or with a good head and checksum; what is let in must be safe to go on from. */
#include "common.h"
#include "parameters.h"

#define WORDS DEHYST_STATE_WORDS(N)

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    uint32_t image[WORDS + 2];
    uint32_t again[WORDS];
    dehyst_real untouched[N];
    dehyst_block_state state = {{z, 0, 0}, 0, 0, 0, 0};
    dehyst_block_reset(&block, &state);
    (void)dehyst_block_save(&block, &state, image, WORDS);
    const uint8_t how = take_byte(&from);
    for (uint8_t changes = take_byte(&from) % 32; changes; --changes) { /* of words, or of the reals in them */
        const uint8_t where = take_byte(&from);
        if (where < 128) {
            take(&from, &image[where % WORDS], sizeof image[0]);
        } else {
            const dehyst_real value = take_real(&from);
            (void)dehyst_image_put(image + 5 + DEHYST_REAL_WORDS * (where % (N + 3)), &value, 1);
        }
    }
    if (how & 1) {
        image[WORDS - 1] = dehyst_image_sum(image, WORDS - 1);
    }
    memcpy(untouched, z, sizeof z);
    const int32_t words = how & 2 ? WORDS : WORDS - 2 + (how >> 6);
    if (dehyst_block_restore(&block, &state, image, words) != DEHYST_IMAGE_GOOD) {
        CLAIM(memcmp(untouched, z, sizeof z) == 0);
    } else {
        CLAIM(words == WORDS && dehyst_block_save(&block, &state, again, WORDS) == DEHYST_IMAGE_GOOD);
        CLAIM(memcmp(image, again, sizeof again) == 0);
    }
    while (from.left) {
        const uint8_t on = take_byte(&from);
        CLAIM(within(dehyst_block_step(&block, &state, take_real(&from), on & 1), OUTPUT_LOW, OUTPUT_HIGH));
    }
    return 0;
}
