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
    const dehyst_real argument = dehyst_accept(x) ? dehyst_map_value(&model->before, x) : x;
    if (!dehyst_accept(argument)) {
        state->flags |= (uint32_t)DEHYST_REJECTED | (uint32_t)DEHYST_REJECTED_EVER;
        return state->output;
    }
    state->flags &= ~(uint32_t)DEHYST_REJECTED;
    dehyst_real h = 0;
    if (dehyst_pi_step(pi, state->z, argument - pi->center, -DEHYST_FAR, DEHYST_FAR, &h) & DEHYST_MOVED) {
        state->output = dehyst_map_value(&model->after, h);
    }
    return state->output;
}
