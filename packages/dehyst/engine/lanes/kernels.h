/* What differs between instruction sets, as one table of functions per level. */
#ifndef DEHYST_KERNELS_H
#define DEHYST_KERNELS_H

#include <stdint.h>

struct machine;
struct gram_machine;
struct engine_ramp_table;

/* Memory to be fetched meanwhile, as long as the samples. */
typedef struct engine_ahead {
    const double *read, *write;
} engine_ahead;

typedef struct engine_kernels {
    /* Evaluation by events: y (samples,) of x (samples,), centred by `center`, continuing the machine; they do not overlap.
     * Returns the number of samples that were rejected: the last output is held for them. `stream`: y is larger than caches;
     * the last of such calls is followed by fence(). */
    int64_t (*events)(struct machine *m, int64_t samples, const double *x, double *y, double center, int stream);
    void (*fence)(void);
    /* Dense evaluation (dense.c) and centred samples for it: the number until one is not within +-limit. */
    void (*dense)(int32_t vectors, double *p, const double *width, const double *weight, int64_t samples, const double *x,
                  double *y, double base, double *moved, const engine_ahead *ahead);
    int64_t (*centre)(int64_t samples, const double *x, double center, double limit, double *u);
    void (*sum)(int64_t samples, const double *a, const double *b, double *y);
    /* Of the solver: sum a_k b_k; the same for eight rows, n a multiple of 8; out_k -= factor row_k;
     * out_k -= sum_r factor_r row_r,k. */
    double (*dot)(int64_t n, const double *a, const double *b);
    void (*dot_eight)(int64_t n, const double *const *row, const double *v, double *out);
    void (*subtract)(int64_t n, double factor, const double *row, double *out);
    void (*subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out);
    /* Of the normal equations: gram_events.c and gram_rows.c say what they do. */
    int64_t (*gram_run)(struct gram_machine *m, int64_t samples, const double *x, const double *weight, const double *const *f,
                     const double *rows);
    void (*gram_pass_by)(struct gram_machine *m, int64_t samples, const double *x);
    void (*gram_empty)(struct gram_machine *m);
    void (*cells)(int64_t samples, int32_t prefix, const double *r, double *z, const double *x, double *cells, double *drive);
    void (*products)(int64_t samples, int32_t prefix, const double *a, const double *b, const double *f, double *out,
                     double *with, int64_t lost);
    void (*row_sums)(int64_t samples, int32_t width, const double *rows, const double *f, double *out, int64_t lost);
    /* engine_ramps of engine.h */
    void (*ramps)(int64_t samples, int64_t cells, const double *e, const struct engine_ramp_table *t, double *out);
    int64_t (*between)(int64_t samples, const double *x, double low, double high);
} engine_kernels;

const engine_kernels *engine_kernels_in_use(void);
extern const engine_kernels engine_kernels_portable;
#ifdef ENGINE_HAS_AVX2
extern const engine_kernels engine_kernels_avx2;
#endif
#ifdef ENGINE_HAS_AVX512
extern const engine_kernels engine_kernels_avx512;
#endif

#endif
