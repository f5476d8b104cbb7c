/* Samples and switching of any kind; in between the state is saved, restored elsewhere, and goes on there. */
#include "common.h"
#include "parameters.h"

static dehyst_real other[N];

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes from = {data, size};
    uint32_t image[DEHYST_STATE_WORDS(N)];
    dehyst_block_state state = {{z, 0, 0}, 0, 0, 0, 0};
    dehyst_block_state copy = {{other, 0, 0}, 0, 0, 0, 0};
    dehyst_block_reset(&block, &state);
    while (from.left) {
        const uint8_t what = take_byte(&from);
        if (what == 255) {
            CLAIM(dehyst_block_save(&block, &state, image, DEHYST_STATE_WORDS(N)) == DEHYST_IMAGE_GOOD);
            CLAIM(dehyst_block_restore(&block, &copy, image, DEHYST_STATE_WORDS(N)) == DEHYST_IMAGE_GOOD);
            CLAIM(memcmp(state.model.z, copy.model.z, sizeof z) == 0);
            const dehyst_real x = take_real(&from);
            CLAIM(same(dehyst_block_step(&block, &state, x, 1), dehyst_block_step(&block, &copy, x, 1)));
            CLAIM(state.flags == copy.flags);
        }
        CLAIM(within(dehyst_block_step(&block, &state, take_real(&from), what & 1), OUTPUT_LOW, OUTPUT_HIGH));
    }
    CLAIM(dehyst_admissible(block.model.hysteresis.n, block.model.hysteresis.threshold, z));
    return 0;
}
