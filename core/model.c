#include "dehyst.h"

dehyst_real dehyst_model_output(const dehyst_model *model, const dehyst_real *z)
{
    return dehyst_map_value(&model->after, dehyst_pi_output(&model->hysteresis, z));
}

void dehyst_model_reset(const dehyst_model *model, dehyst_state *state, const dehyst_real *z0)
{
    for (int32_t i = 0; i < model->hysteresis.n; ++i) {
        state->z[i] = z0[i];
    }
    state->output = dehyst_model_output(model, state->z);
    state->flags = 0;
}

dehyst_real dehyst_model_step(const dehyst_model *model, dehyst_state *state, dehyst_real x)
{
    const dehyst_pi *pi = &model->hysteresis;
    if (!dehyst_accept(x)) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return state->output;
    }
    state->flags &= ~(uint32_t)DEHYST_REJECTED;
    dehyst_play_step(pi->n, pi->threshold, dehyst_map_value(&model->before, x) - pi->center, state->z);
    state->output = dehyst_model_output(model, state->z);
    return state->output;
}
