#include "dehyst.h"

static dehyst_real line_at(const dehyst_direct_block *block, dehyst_real y)
{
    const dehyst_direct *direct = &block->direct;
    const dehyst_real inside = dehyst_within(y, direct->input_low, direct->input_high);
    return dehyst_within(block->line_offset + block->line_slope * inside, direct->output_low, direct->output_high);
}

void dehyst_direct_block_reset(const dehyst_direct_block *block, dehyst_direct_block_state *state)
{
    const dehyst_direct *direct = &block->direct;
    const dehyst_real start = dehyst_within(0, direct->input_low, direct->input_high);
    dehyst_direct_reset(direct, &state->direct, start);
    state->share = 0;
    state->output = line_at(block, start);
    state->flags = 0;
    state->started = 0;
}

/* The output while it is off, or on its way on or off; the first sample after a reset is there at once. */
static dehyst_real between_both(const dehyst_direct_block *block, dehyst_direct_block_state *state, dehyst_real y,
                                int on, int first, dehyst_real output)
{
    const dehyst_real target = on ? (dehyst_real)1 : (dehyst_real)0;
    state->share = first ? target : dehyst_faded(state->share, target, block->fade);
    if (!(state->share < 1)) {
        return output;
    }
    const dehyst_real line = line_at(block, y);
    /* rounding must not leave the range */
    return dehyst_within(line + state->share * (output - line), block->direct.output_low, block->direct.output_high);
}

dehyst_real dehyst_direct_block_step(const dehyst_direct_block *block, dehyst_direct_block_state *state, dehyst_real y,
                                     dehyst_real rate, const dehyst_real given[DEHYST_GIVEN], int on)
{
    const dehyst_direct *direct = &block->direct;
    state->flags &= ~((uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_LIMITED);
    if (!dehyst_accept(y) || !dehyst_accept(rate) || !dehyst_accept_given(given)) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return state->output;
    }
    const int first = !state->started;
    if (first) {
        dehyst_direct_reset(direct, &state->direct, y);
        state->started = 1;
    }
    dehyst_direct_step(direct, &state->direct, y, rate, given);
    const dehyst_real needed = dehyst_direct_output(direct, &state->direct, 0);
    const int inside = needed > direct->output_low && needed < direct->output_high;
    if (!inside || (state->direct.flags & (uint32_t)DEHYST_LIMITED) != 0u) {
        state->flags |= (uint32_t)DEHYST_LIMITED | (uint32_t)DEHYST_LIMITED_EVER;
    }
    state->output = on && !(state->share < 1) ? needed : between_both(block, state, y, on, first, needed);
    return state->output;
}
