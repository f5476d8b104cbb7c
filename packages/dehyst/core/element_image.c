#include "dehyst.h"

#define STATE (UINT32_C(0x64684500) + (uint32_t)sizeof(dehyst_real)) /* dhE, with the precision */
#define HEAD 5
#define REST 6 /* numbers behind memory and ring */
#define FLAGS                                                                                                         \
    ((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER | (uint32_t)DEHYST_LIMITED |                          \
     (uint32_t)DEHYST_LIMITED_EVER)

int32_t dehyst_element_block_save(const dehyst_element_block *block, const dehyst_element_block_state *state,
                                  uint32_t *image, int32_t words)
{
    const dehyst_real rest[REST] = {state->sum.last, state->sum.step, state->share,
                                    state->output,   state->least,    state->most};
    if (words != DEHYST_ELEMENT_WORDS(block->sum.n, block->delay)) {
        return DEHYST_IMAGE_SIZE;
    }
    image[0] = STATE;
    image[1] = (uint32_t)block->sum.n;
    image[2] = block->fingerprint;
    image[3] = state->flags;
    image[4] = (uint32_t)state->started;
    uint32_t *at = dehyst_image_put(image + HEAD, state->sum.z, block->sum.n);
    at = dehyst_image_put(at, state->delay.ring + state->delay.at, block->delay - state->delay.at);
    at = dehyst_image_put(at, state->delay.ring, state->delay.at);
    (void)dehyst_image_put(at, rest, REST);
    image[words - 1] = dehyst_image_sum(image, words - 1);
    return DEHYST_IMAGE_GOOD;
}

/* All of it, number by number: nothing is changed until all is good. Inputs that are remembered are such as
 * dehyst_element_block_check lets come: else what follows them could be saved, but not restored. */
static int32_t checked(const dehyst_element_block *block, const uint32_t *image, int32_t words, dehyst_real *rest)
{
    const int32_t n = block->sum.n;
    if (words != DEHYST_ELEMENT_WORDS(n, block->delay)) {
        return DEHYST_IMAGE_SIZE;
    }
    if (image[0] != STATE) {
        return DEHYST_IMAGE_KIND;
    }
    if (image[words - 1] != dehyst_image_sum(image, words - 1)) {
        return DEHYST_IMAGE_DAMAGED;
    }
    if (image[1] != (uint32_t)n || image[2] != block->fingerprint) {
        return DEHYST_IMAGE_FOREIGN;
    }
    int good = dehyst_image_get(image + HEAD + DEHYST_REAL_WORDS * (n + block->delay), rest, REST) != 0 &&
               dehyst_accept(2 * rest[0]) && rest[2] >= 0 && rest[2] <= 1 && rest[3] >= block->output_low &&
               rest[3] <= block->output_high && (image[3] & ~FLAGS) == 0 && image[4] <= 1 &&
               (image[4] == 1 || !(rest[2] > 0)) && rest[4] <= rest[0] && rest[5] >= rest[0] &&
               dehyst_accept(2 * rest[4]) && dehyst_accept(2 * rest[5]);
    for (int32_t k = 0; good && k < n + block->delay; ++k) {
        dehyst_elements one = block->sum;
        dehyst_real value;
        one.n = 1;
        one.element += k < n ? k : 0;
        good = dehyst_image_get(image + HEAD + DEHYST_REAL_WORDS * k, &value, 1) != 0 &&
               (k < n ? dehyst_elements_memory_check(&one, &value, rest[0]) == DEHYST_IMAGE_GOOD
                      : image[4] == 0 || dehyst_accept(2 * dehyst_map_value(&one.before, value)));
    }
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}

int32_t dehyst_element_block_restore(const dehyst_element_block *block, dehyst_element_block_state *state,
                                     const uint32_t *image, int32_t words)
{
    dehyst_real rest[REST];
    const int32_t fault = checked(block, image, words, rest);
    if (fault == DEHYST_IMAGE_GOOD) {
        const uint32_t *at = dehyst_image_get(image + HEAD, state->sum.z, block->sum.n);
        (void)dehyst_image_get(at, state->delay.ring, block->delay);
        state->delay.n = block->delay;
        state->delay.at = 0;
        state->sum.last = rest[0];
        state->sum.step = rest[1];
        state->share = rest[2];
        state->output = rest[3];
        state->least = rest[4];
        state->most = rest[5];
        state->flags = image[3];
        state->started = (int32_t)image[4];
    }
    return fault;
}
