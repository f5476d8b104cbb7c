/* What differs between instruction sets, as one table of functions per level. */
#ifndef DEHYST_KERNELS_H
#define DEHYST_KERNELS_H

#include <stdint.h>

typedef struct engine_kernels {
    /* Samples k of x that stay on one line: from k = 0 while low <= x_k <= high and, if `monotone` is +1 (-1), x never
     * falls (rises); `last` is the sample before the first. Writes y_k = base + slope (x_k - origin). Returns their number. */
    int64_t (*line)(int64_t samples, const double *x, double *y, double center, double low, double high, int monotone,
                    double last, double base, double slope, double origin);
    /* Of the solver: sum a_k b_k; out_k -= factor row_k; out_k -= sum_r factor_r row_r,k. */
    double (*dot)(int64_t n, const double *a, const double *b);
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
