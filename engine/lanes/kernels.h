/* What differs between instruction sets, as one table of functions per level. */
#ifndef DEHYST_KERNELS_H
#define DEHYST_KERNELS_H

#include <stdint.h>

struct machine;

typedef struct engine_kernels {
    /* Evaluation by events: y (samples,) of x (samples,), centred by `center`, continuing the machine; they do not overlap.
     * Returns the number of samples that were rejected: the last output is held for them. */
    int64_t (*events)(struct machine *m, int64_t samples, const double *x, double *y, double center);
    /* Of the solver: sum a_k b_k; the same for eight rows, n a multiple of 8; out_k -= factor row_k;
     * out_k -= sum_r factor_r row_r,k. */
    double (*dot)(int64_t n, const double *a, const double *b);
    void (*dot_eight)(int64_t n, const double *const *row, const double *v, double *out);
    void (*subtract)(int64_t n, double factor, const double *row, double *out);
    void (*subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out);
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
