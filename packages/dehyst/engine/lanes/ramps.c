/* Columns of a sum of elements: ramps of cells and of the input. The compiler makes lanes of the loop over columns. */
#include "engine.h"
#include "kernels.h"
#include "lanes.h"

void LANES_NAME(engine_ramps)(int64_t samples, int64_t cells, const double *e, const engine_ramp_table *t, double *out);

static inline double ramp(double v, double low, double high)
{
    const double raised = v < low ? low : v, from = 0.0 < low ? low : 0.0;
    return (raised > high ? high : raised) - (from > high ? high : from);
}

void LANES_NAME(engine_ramps)(int64_t samples, int64_t cells, const double *e, const engine_ramp_table *t, double *out)
{
    const int64_t n = t->columns;
    for (int64_t k = 0; k < samples; ++k, e += cells, out += n) {
        for (int64_t j = 0; j < n; ++j) {
            out[j] = ramp(e[t->cell[j]], t->low[j], t->high[j]) * t->gain[j] + ramp(e[0], t->x_low[j], t->x_high[j]);
        }
    }
}
