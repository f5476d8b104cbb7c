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

dehyst_real dehyst_faded(dehyst_real share, dehyst_real target, dehyst_real part)
{
    return share + part < target ? share + part : (share - part > target ? share - part : target);
}

static dehyst_real reject(dehyst_block_state *state)
{
    state->flags &= ~(uint32_t)DEHYST_LIMITED; /* that was an earlier sample */
    state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
    return state->output;
}

/* The output while it is off, or on its way on or off; the first sample after a reset is there at once. */
static dehyst_real switched(const dehyst_block *block, dehyst_block_state *state, dehyst_real x, int on,
                            dehyst_real output)
{
    const dehyst_real target = on ? (dehyst_real)1 : (dehyst_real)0;
    state->share = state->started ? dehyst_faded(state->share, target, block->fade) : target;
    state->started = 1;
    if (!(state->share < 1)) {
        return output;
    }
    const dehyst_real line = bounded_output(block, block->line_offset + block->line_slope * x);
    return bounded_output(block, line + state->share * (output - line)); /* rounding must not leave the range */
}

dehyst_real dehyst_block_step(const dehyst_block *block, dehyst_block_state *state, dehyst_real x, int on)
{
    const dehyst_model *model = &block->model;
    if (!dehyst_accept(x)) {
        return reject(state);
    }
    int limited = 0;
    if (x < block->input_low) {
        x = block->input_low;
        limited = 1;
    } else if (x > block->input_high) {
        x = block->input_high;
        limited = 1;
    }
    dehyst_real argument = x;
    if (model->before.n > 1) {
        argument = dehyst_map_value(&model->before, x);
        if (!dehyst_accept(argument)) {
            return reject(state);
        }
    }
    dehyst_real *held = &state->model.output;
    const int done = dehyst_pi_step(&model->hysteresis, state->model.z, argument - model->hysteresis.center,
                                    block->reach_low, block->reach_high, held);
    if ((done & DEHYST_MOVED) && model->after.n > 1) {
        *held = dehyst_map_value(&model->after, *held);
    }
    limited |= done & DEHYST_HELD_BACK;
    dehyst_real output = *held;
    if (!(output >= block->output_low && output <= block->output_high)) {
        output = bounded_output(block, output);
        limited = 1;
    }
    if (!on || state->share < 1) {
        output = switched(block, state, x, on, output);
    }
    state->output = output;
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    state->flags |= limited ? (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER : 0u;
    return output;
}
