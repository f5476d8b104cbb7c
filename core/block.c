#include "dehyst.h"

dehyst_real dehyst_within(dehyst_real x, dehyst_real low, dehyst_real high)
{
    return x >= low ? (x <= high ? x : high) : low;
}

static dehyst_real bounded_output(const dehyst_block *block, dehyst_real output)
{
    return dehyst_within(output, block->output_low, block->output_high);
}

void dehyst_block_reset(const dehyst_block *block, dehyst_block_state *state)
{
    dehyst_model_reset(&block->model, &state->model, block->start);
    state->share = 0;
    state->output = bounded_output(block, state->model.output);
    state->flags = 0;
    state->started = 0;
}

static dehyst_real faded(dehyst_real share, dehyst_real target, dehyst_real part)
{
    return share + part < target ? share + part : (share - part > target ? share - part : target);
}

/* Of a map that is there: most models have none. */
static inline dehyst_real mapped(const dehyst_map *map, dehyst_real u)
{
    return map->n < 2 ? u : dehyst_map_value(map, u);
}

static dehyst_real reject(dehyst_block_state *state)
{
    state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
    return state->output;
}

dehyst_real dehyst_block_step(const dehyst_block *block, dehyst_block_state *state, dehyst_real x, int on)
{
    const dehyst_model *model = &block->model;
    if (!dehyst_accept(x)) {
        return reject(state);
    }
    const dehyst_real taken = dehyst_within(x, block->input_low, block->input_high);
    const dehyst_real argument = mapped(&model->before, taken);
    if (model->before.n > 0 && !dehyst_accept(argument)) {
        return reject(state);
    }
    int limited = x < taken || x > taken;
    dehyst_real h = 0;
    const int done = dehyst_pi_step(&model->hysteresis, state->model.z, argument - model->hysteresis.center,
                                    block->reach_low, block->reach_high, &h);
    if (done & DEHYST_MOVED) {
        state->model.output = mapped(&model->after, h);
    }
    limited |= done & DEHYST_HELD_BACK;
    const dehyst_real target = on ? (dehyst_real)1 : (dehyst_real)0;
    state->share = state->started ? faded(state->share, target, block->fade) : target;
    state->started = 1;
    dehyst_real output = bounded_output(block, state->model.output);
    limited |= output < state->model.output || output > state->model.output;
    if (state->share < 1) {
        const dehyst_real line = bounded_output(block, block->line_offset + block->line_slope * taken);
        output = bounded_output(block, line + state->share * (output - line)); /* rounding must not leave the range */
    }
    state->output = output;
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
    return output;
}
