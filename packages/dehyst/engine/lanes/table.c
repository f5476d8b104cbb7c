/* The kernels of one level; compiled once per level. */
#include "kernels.h"
#include "lanes.h"

int64_t LANES_NAME(engine_events)(struct machine *m, int64_t samples, const double *x, double *y, double center, int stream);
void LANES_NAME(engine_fence)(void);
void LANES_NAME(engine_dense)(int32_t vectors, double *p, const double *width, const double *weight, int64_t samples,
                              const double *x, double *y, double base, double *moved, const engine_ahead *ahead);
int64_t LANES_NAME(engine_centre)(int64_t samples, const double *x, double center, double limit, double *u);
void LANES_NAME(engine_sum)(int64_t samples, const double *a, const double *b, double *y);
double LANES_NAME(engine_dot)(int64_t n, const double *a, const double *b);
void LANES_NAME(engine_dot_eight)(int64_t n, const double *const *row, const double *v, double *out);
void LANES_NAME(engine_subtract)(int64_t n, double factor, const double *row, double *out);
void LANES_NAME(engine_subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out);
int64_t LANES_NAME(engine_gram_run)(struct gram_machine *m, int64_t samples, const double *x, const double *weight,
                                 const double *const *f, const double *rows);
void LANES_NAME(engine_gram_pass_by)(struct gram_machine *m, int64_t samples, const double *x);
void LANES_NAME(engine_gram_empty)(struct gram_machine *m);
void LANES_NAME(engine_cells)(int64_t samples, int32_t prefix, const double *r, double *z, const double *x, double *cells,
                              double *drive);
void LANES_NAME(engine_products)(int64_t samples, int32_t prefix, const double *a, const double *b, const double *f,
                                 double *out, double *with, int64_t lost);
void LANES_NAME(engine_row_sums)(int64_t samples, int32_t width, const double *rows, const double *f, double *out,
                                 int64_t lost);
void LANES_NAME(engine_ramps)(int64_t samples, int64_t cells, const double *e, const struct engine_ramp_table *t, double *out);
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high);

const engine_kernels LANES_NAME(engine_kernels) = {
    .events = LANES_NAME(engine_events),
    .fence = LANES_NAME(engine_fence),
    .dense = LANES_NAME(engine_dense),
    .centre = LANES_NAME(engine_centre),
    .sum = LANES_NAME(engine_sum),
    .dot = LANES_NAME(engine_dot),
    .dot_eight = LANES_NAME(engine_dot_eight),
    .subtract = LANES_NAME(engine_subtract),
    .subtract_rows = LANES_NAME(engine_subtract_rows),
    .gram_run = LANES_NAME(engine_gram_run),
    .gram_pass_by = LANES_NAME(engine_gram_pass_by),
    .gram_empty = LANES_NAME(engine_gram_empty),
    .cells = LANES_NAME(engine_cells),
    .products = LANES_NAME(engine_products),
    .row_sums = LANES_NAME(engine_row_sums),
    .ramps = LANES_NAME(engine_ramps),
    .between = LANES_NAME(engine_between),
};
