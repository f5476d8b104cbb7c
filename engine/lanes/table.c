/* The kernels of one level; compiled once per level. */
#include "kernels.h"
#include "lanes.h"

int64_t LANES_NAME(engine_events)(struct machine *m, int64_t samples, const double *x, double *y, double center, int stream);
void LANES_NAME(engine_dense)(int32_t vectors, double *p, const double *width, const double *weight, int64_t samples,
                              const double *x, double *y, double base, double *moved, const engine_ahead *ahead);
int64_t LANES_NAME(engine_centre)(int64_t samples, const double *x, double center, double limit, double *u);
void LANES_NAME(engine_sum)(int64_t samples, const double *a, const double *b, double *y);
double LANES_NAME(engine_dot)(int64_t n, const double *a, const double *b);
void LANES_NAME(engine_dot_eight)(int64_t n, const double *const *row, const double *v, double *out);
void LANES_NAME(engine_subtract)(int64_t n, double factor, const double *row, double *out);
void LANES_NAME(engine_subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out);
int64_t LANES_NAME(engine_run)(int64_t samples, const double *x, const double *f, const engine_window *window, double *sums);
int64_t LANES_NAME(engine_scan)(int64_t samples, const double *x, const engine_window *window);
void LANES_NAME(engine_moments)(int64_t samples, const double *x, const double *f, double origin, double *sums);
void LANES_NAME(engine_add_to_rows)(int64_t n, const double *from, double factor_1, double *row_1, double factor_2,
                                    double *row_2);
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high);

const engine_kernels LANES_NAME(engine_kernels) = {
    .events = LANES_NAME(engine_events),
    .dense = LANES_NAME(engine_dense),
    .centre = LANES_NAME(engine_centre),
    .sum = LANES_NAME(engine_sum),
    .dot = LANES_NAME(engine_dot),
    .dot_eight = LANES_NAME(engine_dot_eight),
    .subtract = LANES_NAME(engine_subtract),
    .subtract_rows = LANES_NAME(engine_subtract_rows),
    .run = LANES_NAME(engine_run),
    .scan = LANES_NAME(engine_scan),
    .moments = LANES_NAME(engine_moments),
    .add_to_rows = LANES_NAME(engine_add_to_rows),
    .between = LANES_NAME(engine_between),
};
