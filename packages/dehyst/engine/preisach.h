/* Preisach operator by its Everett function on a grid of turning values: outputs, inputs for wanted outputs, and the
 * regressor of its cells.
 *
 * E(a, b), a >= b, is half the change of the output from a turn at b up to a, or from a turn at a down to b. Between knots
 * it is bilinear; in the cells on the diagonal it is E(a, b) = E(upper, lower) (a - b)/(upper - lower): what they weigh is
 * reversible. So along a branch the output is piecewise linear in the input. The memory is the stack of those turning
 * values that no later one passed (wiping out), a lowest, a highest, a lowest ... in turn.
 */
#ifndef DEHYST_ENGINE_PREISACH_H
#define DEHYST_ENGINE_PREISACH_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct engine_preisach {
    int32_t n;             /* cells on a side */
    const double *knot;    /* (n + 1,) strictly increasing; the operator saturates beyond the first and the last */
    const double *everett; /* (n + 1, n + 1) row-major, E(knot[a], knot[b]); only a > b is read */
    double below, above;   /* slopes of the output beyond the first and the last knot */
} engine_preisach;

typedef struct preisach_turn {
    double x, y;
} preisach_turn;

/* The lowest turn is the first knot with the output of negative saturation. */
typedef struct preisach_memory {
    preisach_turn now;   /* present input, held inside the knots, and the output there */
    int32_t depth;       /* turns on the stack, >= 1 */
    preisach_turn *turn; /* room for depth + samples of them */
} preisach_memory;

/* Outputs y (samples,) along x (samples,), finite; the memory goes on. x may be y. */
void engine_preisach_run(const engine_preisach *p, preisach_memory *memory, int64_t samples, const double *x, double *y);
/* Inputs x (samples,) at which the output is y (samples,). Outputs must strictly follow inputs: E rises with a and falls
 * with b, below and above are positive. */
void engine_preisach_invert(const engine_preisach *p, preisach_memory *memory, int64_t samples, const double *y, double *x);
/* States of the cells, out (samples, n (n + 1)/2) row-major, -1 down to 1 up: output = offset + sum of masses times states.
 * Cell (i, j), j <= i, is number i (i + 1)/2 + j; everett must be zeros, scratch has room for (n + 2)^2. */
void engine_preisach_cells(const engine_preisach *p, preisach_memory *memory, int64_t samples, const double *x,
                           double *scratch, double *out);

#ifdef __cplusplus
}
#endif

#endif
