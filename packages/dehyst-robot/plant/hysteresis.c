/* One entrance to all mechanisms: pressure, asymmetry, and which. */
#include "parts.h"

#define LIMIT 1e9 /* a force beyond it is a fault of a foreign mechanism, [N] */
#define TURN 5e-4 /* a stroke ends when the input is this far back from its tip: shaking ends none */
#define SPAN 5e-3 /* distance after which a new loop has 63 % of its new size: the force stays continuous */

void plant_hysteresis_reset(const plant_hysteresis *hysteresis, plant_muscle_state *state, double kappa, double p)
{
    for (int32_t i = 0; i < PLANT_ELEMENTS; ++i) {
        state->element[i] = 0.0;
        state->cache.stiffness[i] = 0.0;
        if (i < hysteresis->n && hysteresis->strain[i] > 0.0)
            state->cache.stiffness[i] = hysteresis->size * hysteresis->share[i] / hysteresis->strain[i];
    }
    state->turns = 0;
    state->contraction = kappa;
    state->start = state->input = state->tip = kappa + hysteresis->pressure_strain * p;
    state->loop = state->loop_goal = state->way = 1.0;
    state->age = 0.0;
    state->friction = 0.0;
}

/* No two strokes have one loop: its size is drawn at the tip. */
static double drawn_loop(const plant_hysteresis *hysteresis, plant_muscle_state *state, double input)
{
    const double back = (state->tip - input) * state->way;
    if (back > TURN) {
        state->way = -state->way;
        state->loop_goal = 1.0 + hysteresis->scatter * plant_clip(plant_normal(&state->random), -2.5, 2.5);
    }
    if (back <= 0.0 || back > TURN) state->tip = input;
    state->loop += plant_settled(fabs(input - state->input) / SPAN) * (state->loop_goal - state->loop);
    return state->loop;
}

static double force(const plant_hysteresis *hysteresis, plant_muscle_state *state, double input, double kappa,
                    double p, double period)
{
    const double grown = hysteresis->constant_share + hysteresis->pressure_share * p / hysteresis->reference_pressure;
    const double loop = hysteresis->scatter > 0.0 ? drawn_loop(hysteresis, state, input) : 1.0;
    const double warm = 1.0 + hysteresis->warm * state->warmth, factor = warm > 0.0 ? loop * warm : 0.0;
    const double slip = hysteresis->size * (grown > 0.0 ? grown : 0.0) * factor, a = hysteresis->asymmetry;
    const double change = input - state->input, up = slip * (1.0 + a), down = slip * (1.0 - a);
    switch (hysteresis->kind) {
    case PLANT_MAXWELL_SLIP: return plant_maxwell_slip(hysteresis, state, change, up, down);
    case PLANT_DAHL: return slip > 0.0 ? plant_dahl(hysteresis, state, change, up, down) : 0.0;
    case PLANT_BRAID: return plant_braid(hysteresis, state, input, up, down);
    case PLANT_LUGRE: return slip > 0.0 ? plant_lugre(hysteresis, state, change, up, down, period) : 0.0;
    case PLANT_PINCHED: return slip > 0.0 ? plant_pinched(hysteresis, state, change, up, down) : 0.0;
    case PLANT_AGEING: return plant_ageing(hysteresis, state, change, up, down, period);
    case PLANT_PREISACH: {
        /* y + a y^2 carries -1..1 to -(1 - a)..(1 + a) without a kink: reversals stay continuous, loops closed. */
        const double y = plant_preisach(hysteresis, state, input);
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
    const double input = kappa + hysteresis->pressure_strain * p;
    state->friction = force(hysteresis, state, input, kappa, p, period);
    state->input = input;
    state->contraction = kappa;
    return state->friction;
}
