/* Sums of symmetric matrices of which the lower triangles are stored, for some of their rows and columns. */
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "lanes/kernels.h"

/* Where row i of a triangle begins. */
static size_t row_of(int64_t i)
{
    return (size_t)i * ((size_t)i + 1) / 2;
}

void engine_triangle(int32_t n, const double *matrix, double *out)
{
    for (int32_t i = 0; i < n; ++i) {
        memcpy(out + row_of(i), matrix + (size_t)i * (size_t)n, ((size_t)i + 1) * sizeof *out);
    }
}

/* Row i of the sums, its first i + 1 numbers. */
static void sum_row(int32_t matrices, const double *const *matrix, const double *minus, const int64_t *chosen, int32_t i,
                    const double **row, double *sums)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    for (int32_t from = 0, to; from <= i; from = to) {
        for (to = from + 1; to <= i && chosen[to] == chosen[to - 1] + 1; ++to) { /* neighbours lie side by side */
        }
        for (int32_t m = 0; m < matrices; ++m) {
            row[m] = matrix[m] + row_of(chosen[i]) + chosen[from];
        }
        kernels->subtract_rows(to - from, matrices, row, minus, sums + from);
    }
}

static void mirror(int32_t n, double *matrix)
{
    for (int32_t i = 0; i < n; ++i) {
        for (int32_t j = 0; j < i; ++j) {
            matrix[(size_t)j * (size_t)n + (size_t)i] = matrix[(size_t)i * (size_t)n + (size_t)j];
        }
    }
}

int engine_sums_of_triangles(int32_t matrices, int64_t size, const double *triangles, int32_t sums, const double *factors,
                             int32_t n, const int64_t *chosen, double *out)
{
    const size_t all = (size_t)matrices, square = (size_t)n * (size_t)n;
    const double **row = malloc((1 + (1 + (size_t)sums) * all) * sizeof *row), **matrix = row + all;
    double *minus = malloc((1 + (size_t)sums * all) * sizeof *minus);
    int32_t *counted = calloc((size_t)sums + 1, sizeof *counted);
    const int failed = row == NULL || minus == NULL || counted == NULL;
    for (size_t s = 0; !failed && s < (size_t)sums; ++s) {
        for (size_t m = 0; m < all; ++m) {
            if (factors[s * all + m] != 0.0) {
                const size_t place = s * all + (size_t)counted[s]++;
                matrix[place] = triangles + m * (size_t)size;
                minus[place] = -factors[s * all + m];
            }
        }
    }
    if (!failed) {
        memset(out, 0, (size_t)sums * square * sizeof *out);
    }
    for (int32_t i = 0; !failed && i < n; ++i) { /* row by row: each is read once for all sums */
        for (size_t s = 0; s < (size_t)sums; ++s) {
            sum_row(counted[s], matrix + s * all, minus + s * all, chosen, i, row, out + s * square + (size_t)i * (size_t)n);
        }
    }
    for (size_t s = 0; !failed && s < (size_t)sums; ++s) {
        mirror(n, out + s * square);
    }
    free(row);
    free(minus);
    free(counted);
    return failed ? -1 : 0;
}
