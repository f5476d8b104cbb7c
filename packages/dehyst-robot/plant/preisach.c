/* Preisach: all of the memory is a stack of reversals, all of the material is one Everett function.
 *   P[x] = P(turn) +- E(turn, x)     on the branch that started at the last remembered reversal
 *   P[x] = +- E(2 x_0 - x, x)/2      on the virgin curve from the demagnetised state at x_0
 * A loop that is closed is wiped out. Here, as in every force that opposes motion, the force is reversible at first and
 * then saturates, so the density nu = d^2 E/(da db) >= 0 is taken away from a reversible part:
 *   E(a, b) = 2/N sum_j c_j (1 - exp(-|G_j(b) - G_j(a)|)),   G_j(x) = g_j x (1 + e_j x^2/3)
 * nu is positive (loops dissipate), smooth, and no product of a function of a and a function of b; since the G_j bend
 * differently, loops of one width differ from place to place, in no single changed coordinate alike: no
 * Prandtl-Ishlinskii model, plain or with a map of its input, has this E. */
#include "parts.h"

#define TERMS 2
static const double kShare[TERMS] = {0.5, 0.5}; /* c_j */
static const double kSlope[TERMS] = {8.0, 5.0}; /* g_j: virgin curve in the middle 1 - exp(-12.8 x) to 0.01 */
static const double kBend[TERMS] = {3.0, -0.8}; /* e_j: G_j increase on -1..1 */

static inline double bent(int j, double x) { return kSlope[j] * x * (1.0 + kBend[j] * (1.0 / 3) * x * x); }

double plant_everett(double from, double to)
{
    const double a = plant_clip(from, -1.0, 1.0), b = plant_clip(to, -1.0, 1.0);
    /* N = sum_j c_j (1 - exp(-2 G_j(1))) makes E(-1, 1) = 2. */
    const double norm = 1.0 / 0.99967330401006;
    double sum = 0.0;
    for (int j = 0; j < TERMS; ++j) sum += kShare[j] * plant_settled(fabs(bent(j, b) - bent(j, a)));
    return 2.0 * norm * sum;
}

static double virgin(double start, double x)
{
    const double half = 0.5 * plant_everett(2.0 * start - x, x);
    return x > start ? half : -half;
}

static void remember(plant_muscle_state *state, double x, double level)
{
    state->turn[state->turns] = x;
    state->level[state->turns] = level;
    ++state->turns;
}

/* Open a branch if the motion from `old` to x is a reversal. */
static void reverse(plant_muscle_state *state, double start, double old, double x)
{
    const double output = state->element[0];
    if (state->turns == 0) {
        if ((x - old) * (old - start) >= 0.0) return; /* still on the virgin curve */
        remember(state, plant_clip(2.0 * start - old, -1.0, 1.0), -output);
        remember(state, old, output);
        return;
    }
    const int rising = state->turn[state->turns - 1] < state->turn[state->turns - 2];
    /* With the stack full the innermost loop is retraced without loss: no jump, no energy. */
    if ((x > old) != rising && state->turns < PLANT_TURNS) remember(state, old, output);
}

/* Forget the loops that x has closed. */
static void wipe(plant_muscle_state *state, double x)
{
    while (state->turns > 1) {
        const double last = state->turn[state->turns - 1], other = state->turn[state->turns - 2];
        const int rising = last < other;
        if (rising ? x >= other : x <= other)
            state->turns -= 2;
        else if (rising ? x < last : x > last) /* behind the start of a retraced branch */
            state->turns -= 1;
        else
            break;
    }
    if (state->turns == 1) state->turns = 0; /* the first one is the mirror image of the second, not a reversal */
}

double plant_preisach(const plant_hysteresis *hysteresis, plant_muscle_state *state, double input)
{
    const double half = hysteresis->strain[hysteresis->n - 1], center = hysteresis->center;
    const double x = plant_clip((input - center) / half, -1.0, 1.0);
    const double old = plant_clip((state->input - center) / half, -1.0, 1.0);
    const double start = plant_clip((state->start - center) / half, -1.0, 1.0);
    if (x == old) return state->element[0];
    reverse(state, start, old, x);
    wipe(state, x);
    if (state->turns == 0) {
        state->element[0] = virgin(start, x);
    } else {
        const double turn = state->turn[state->turns - 1], change = plant_everett(turn, x);
        state->element[0] = state->level[state->turns - 1] + (x > turn ? change : -change);
    }
    return state->element[0];
}
