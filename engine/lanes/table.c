/* The kernels of one level; compiled once per level. */
#include "kernels.h"
#include "lanes.h"

int64_t LANES_NAME(engine_events)(struct machine *m, int64_t samples, const double *x, double *y, double center);
double LANES_NAME(engine_dot)(int64_t n, const double *a, const double *b);
void LANES_NAME(engine_dot_eight)(int64_t n, const double *const *row, const double *v, double *out);
void LANES_NAME(engine_subtract)(int64_t n, double factor, const double *row, double *out);
void LANES_NAME(engine_subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out);

const engine_kernels LANES_NAME(engine_kernels) = {
    .events = LANES_NAME(engine_events),
    .dot = LANES_NAME(engine_dot),
    .dot_eight = LANES_NAME(engine_dot_eight),
    .subtract = LANES_NAME(engine_subtract),
    .subtract_rows = LANES_NAME(engine_subtract_rows),
};
