#include "dehyst.h"

/* Kinds of an image, with the precision. */
#define STATE (UINT32_C(0x64685300) + (uint32_t)sizeof(dehyst_real))      /* dhS */
#define PARAMETERS (UINT32_C(0x64685000) + (uint32_t)sizeof(dehyst_real)) /* dhP */
#define MOST 100000 /* operators or points: sizes stay far from those of an int32_t */
#define FLAGS                                                                                                         \
    ((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER | (uint32_t)DEHYST_LIMITED |                          \
     (uint32_t)DEHYST_LIMITED_EVER)

int32_t dehyst_block_save(const dehyst_block *block, const dehyst_block_state *state, uint32_t *image, int32_t words)
{
    const int32_t n = block->model.hysteresis.n;
    /* What lies beyond all limits answers like the limits, and would not be read back. */
    const dehyst_real model_output = dehyst_within(state->model.output, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT);
    const dehyst_real rest[3] = {state->share, state->output, model_output};
    if (words != DEHYST_STATE_WORDS(n)) {
        return DEHYST_IMAGE_SIZE;
    }
    image[0] = STATE;
    image[1] = (uint32_t)n;
    image[2] = block->fingerprint;
    image[3] = state->flags;
    image[4] = (uint32_t)state->started;
    (void)dehyst_image_put(dehyst_image_put(image + 5, state->model.z, n), rest, 3);
    image[words - 1] = dehyst_image_sum(image, words - 1);
    return DEHYST_IMAGE_GOOD;
}

/* All of it but the states, which are checked where they are: they may be many. */
static int32_t checked_state(const dehyst_block *block, const uint32_t *image, int32_t words, dehyst_real *rest)
{
    const int32_t n = block->model.hysteresis.n;
    const dehyst_pi *pi = &block->model.hysteresis;
    if (words != DEHYST_STATE_WORDS(n)) {
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
    const uint32_t *at = image + 5;
    dehyst_real pair[2] = {0, 0};
    for (int32_t i = 0; i < n; ++i) { /* two neighbours at a time are an operator of their own */
        pair[0] = pair[1];
        if (!dehyst_image_get(at, &pair[1], 1)) {
            return DEHYST_IMAGE_INVALID;
        }
        at += DEHYST_REAL_WORDS;
        if (i > 0 && !dehyst_admissible(2, pi->threshold + (i - 1), pair)) {
            return DEHYST_IMAGE_INVALID;
        }
    }
    const int good = dehyst_image_get(at, rest, 3) != 0 && rest[0] >= 0 && rest[0] <= 1 &&
                     rest[1] >= block->output_low && rest[1] <= block->output_high && (image[3] & ~FLAGS) == 0 &&
                     image[4] <= 1 && (image[4] == 1 || !(rest[0] > 0));
    return good ? DEHYST_IMAGE_GOOD : DEHYST_IMAGE_INVALID;
}

int32_t dehyst_block_restore(const dehyst_block *block, dehyst_block_state *state, const uint32_t *image,
                             int32_t words)
{
    dehyst_real rest[3];
    const int32_t fault = checked_state(block, image, words, rest);
    if (fault == DEHYST_IMAGE_GOOD) {
        (void)dehyst_image_get(image + 5, state->model.z, block->model.hysteresis.n);
        state->share = rest[0];
        state->output = rest[1];
        state->model.output = rest[2];
        state->model.flags = 0;
        state->flags = image[3];
        state->started = (int32_t)image[4];
    }
    return fault;
}

int32_t dehyst_block_dump(const dehyst_block *block, uint32_t *image, int32_t words)
{
    const dehyst_model *model = &block->model;
    const dehyst_pi *pi = &model->hysteresis;
    const dehyst_real rest[11] = {pi->center,         pi->offset,         block->input_low,  block->input_high,
                                  block->output_low,  block->output_high, block->reach_low,  block->reach_high,
                                  block->line_slope,  block->line_offset, block->fade};
    if (words != DEHYST_BLOCK_WORDS(pi->n, model->before.n, model->after.n)) {
        return DEHYST_IMAGE_SIZE;
    }
    image[0] = PARAMETERS;
    image[1] = (uint32_t)pi->n;
    image[2] = (uint32_t)model->before.n;
    image[3] = (uint32_t)model->after.n;
    image[4] = block->fingerprint;
    uint32_t *at = image + 5;
    at = dehyst_image_put(at, pi->threshold, pi->n);
    at = dehyst_image_put(at, pi->slope, pi->n);
    at = dehyst_image_put(at, pi->loading, pi->n);
    at = dehyst_image_put(at, block->start, pi->n);
    at = dehyst_image_put(at, model->before.u, model->before.n);
    at = dehyst_image_put(at, model->before.v, model->before.n);
    at = dehyst_image_put(at, model->after.u, model->after.n);
    at = dehyst_image_put(at, model->after.v, model->after.n);
    (void)dehyst_image_put(at, rest, 11);
    image[words - 1] = dehyst_image_sum(image, words - 1);
    return DEHYST_IMAGE_GOOD;
}

static void point_into(dehyst_block *block, const dehyst_real *memory, int32_t n, int32_t before, int32_t after)
{
    dehyst_pi *pi = &block->model.hysteresis;
    pi->n = n;
    pi->threshold = memory;
    pi->slope = memory + n;
    pi->loading = memory + 2 * n;
    block->start = memory + 3 * n;
    const dehyst_real *maps = memory + 4 * n;
    block->model.before.n = before;
    block->model.before.u = maps;
    block->model.before.v = maps + before;
    block->model.after.n = after;
    block->model.after.u = maps + 2 * before;
    block->model.after.v = maps + 2 * before + after;
}

static void take_rest(dehyst_block *block, const dehyst_real *rest)
{
    block->model.hysteresis.center = rest[0];
    block->model.hysteresis.offset = rest[1];
    block->input_low = rest[2];
    block->input_high = rest[3];
    block->output_low = rest[4];
    block->output_high = rest[5];
    block->reach_low = rest[6];
    block->reach_high = rest[7];
    block->line_slope = rest[8];
    block->line_offset = rest[9];
    block->fade = rest[10];
}

int32_t dehyst_block_load(const uint32_t *image, int32_t words, dehyst_real *memory, int32_t reals,
                          dehyst_block *block)
{
    if (words < 6) {
        return DEHYST_IMAGE_SIZE;
    }
    if (image[0] != PARAMETERS) {
        return DEHYST_IMAGE_KIND;
    }
    if (image[words - 1] != dehyst_image_sum(image, words - 1)) {
        return DEHYST_IMAGE_DAMAGED;
    }
    if (image[1] < 1 || image[1] > MOST || image[2] > MOST || image[3] > MOST) {
        return DEHYST_IMAGE_INVALID;
    }
    const int32_t n = (int32_t)image[1];
    const int32_t before = (int32_t)image[2];
    const int32_t after = (int32_t)image[3];
    const int32_t needed = DEHYST_BLOCK_REALS(n, before, after);
    if (words != DEHYST_BLOCK_WORDS(n, before, after) || reals < needed) {
        return DEHYST_IMAGE_SIZE;
    }
    dehyst_real rest[11];
    dehyst_block loaded;
    const int numbers = dehyst_image_get(image + 5, memory, needed) != 0 &&
                        dehyst_image_get(image + 5 + DEHYST_REAL_WORDS * needed, rest, 11) != 0;
    if (!numbers) {
        return DEHYST_IMAGE_INVALID;
    }
    point_into(&loaded, memory, n, before, after);
    take_rest(&loaded, rest);
    loaded.fingerprint = image[4];
    if (dehyst_block_check(&loaded) != DEHYST_IMAGE_GOOD) {
        return DEHYST_IMAGE_INVALID;
    }
    *block = loaded;
    return DEHYST_IMAGE_GOOD;
}
