/* One entrance to all mechanisms: pressure, asymmetry, and which. */
#include "parts.h"

#define LIMIT 1e9 /* a force beyond it is a fault of a foreign mechanism, [N] */

void plant_hysteresis_reset(const plant_hysteresis *hysteresis, plant_muscle_state *state, double kappa)
{
    for (int32_t i = 0; i < PLANT_ELEMENTS; ++i) {
        state->element[i] = 0.0;
        state->cache.stiffness[i] = 0.0;
        if (i < hysteresis->n && hysteresis->strain[i] > 0.0)
            state->cache.stiffness[i] = hysteresis->size * hysteresis->share[i] / hysteresis->strain[i];
    }
    state->turns = 0;
    state->start = kappa;
    state->contraction = kappa;
    state->friction = 0.0;
}

static double force(const plant_hysteresis *hysteresis, plant_muscle_state *state, double kappa, double p,
                    double period)
{
    const double grown = hysteresis->constant_share + hysteresis->pressure_share * p / hysteresis->reference_pressure;
    const double slip = hysteresis->size * (grown > 0.0 ? grown : 0.0), a = hysteresis->asymmetry;
    const double change = kappa - state->contraction, up = slip * (1.0 + a), down = slip * (1.0 - a);
    switch (hysteresis->kind) {
    case PLANT_MAXWELL_SLIP: return plant_maxwell_slip(hysteresis, state, change, up, down);
    case PLANT_DAHL: return slip > 0.0 ? plant_dahl(hysteresis, state, change, up, down) : 0.0;
    case PLANT_PREISACH: {
        /* y + a y^2 carries -1..1 to -(1 - a)..(1 + a) without a kink: reversals stay continuous, loops closed. */
        const double y = plant_preisach(hysteresis, state, kappa);
        return slip * (y + a * y * y);
    }
    case PLANT_FOREIGN: {
        if (!hysteresis->foreign) return 0.0;
        const double f = hysteresis->foreign(hysteresis->context, kappa, p, period);
        return f >= -LIMIT && f <= LIMIT ? f : 0.0;
    }
    default: return 0.0;
    }
}

double plant_hysteresis_step(const plant_hysteresis *hysteresis, plant_muscle_state *state, double kappa, double p,
                             double period)
{
    state->friction = force(hysteresis, state, kappa, p, period);
    state->contraction = kappa;
    return state->friction;
}
