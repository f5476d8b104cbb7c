/* Rows of matrices: inner products and sums of many rows at once. */
#include "kernels.h"
#include "lanes.h"

double LANES_NAME(engine_dot)(int64_t n, const double *a, const double *b);
void LANES_NAME(engine_dot_eight)(int64_t n, const double *const *row, const double *v, double *out);
void LANES_NAME(engine_subtract)(int64_t n, double factor, const double *row, double *out);
void LANES_NAME(engine_subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out);

double LANES_NAME(engine_dot)(int64_t n, const double *a, const double *b)
{
    lanes even = lanes_all(0.0), odd = lanes_all(0.0);
    int64_t k = 0;
    for (; k + 16 <= n; k += 16) {
        even = lanes_fma(lanes_load(a + k), lanes_load(b + k), even);
        odd = lanes_fma(lanes_load(a + k + 8), lanes_load(b + k + 8), odd);
    }
    if (k + 8 <= n) {
        even = lanes_fma(lanes_load(a + k), lanes_load(b + k), even);
        k += 8;
    }
    double sum = lanes_sum(lanes_add(even, odd));
    for (; k < n; ++k) {
        sum += a[k] * b[k];
    }
    return sum;
}

void LANES_NAME(engine_dot_eight)(int64_t n, const double *const *row, const double *v, double *out)
{
    for (int r = 0; r < 8; r += 4) {
        lanes a = lanes_all(0.0), b = a, c = a, d = a;
        for (int64_t k = 0; k < n; k += 8) {
            const lanes vk = lanes_load(v + k);
            a = lanes_fma(lanes_load(row[r] + k), vk, a);
            b = lanes_fma(lanes_load(row[r + 1] + k), vk, b);
            c = lanes_fma(lanes_load(row[r + 2] + k), vk, c);
            d = lanes_fma(lanes_load(row[r + 3] + k), vk, d);
        }
        out[r] = lanes_sum(a);
        out[r + 1] = lanes_sum(b);
        out[r + 2] = lanes_sum(c);
        out[r + 3] = lanes_sum(d);
    }
}

void LANES_NAME(engine_subtract)(int64_t n, double factor, const double *row, double *out)
{
    const lanes f = lanes_all(-factor);
    int64_t k = 0;
    for (; k + 8 <= n; k += 8) {
        lanes_store(out + k, lanes_fma(f, lanes_load(row + k), lanes_load(out + k)));
    }
    for (; k < n; ++k) {
        out[k] -= factor * row[k];
    }
}

/* Eight rows a sweep: one load and one store of `out` for eight products. */
static void eight(int64_t n, const double *const *row, const double *factor, double *out)
{
    lanes f[8];
    for (int r = 0; r < 8; ++r) {
        f[r] = lanes_all(-factor[r]);
    }
    int64_t k = 0;
    for (; k + 8 <= n; k += 8) {
        lanes a = lanes_load(out + k), b = lanes_mul(f[4], lanes_load(row[4] + k));
        a = lanes_fma(f[0], lanes_load(row[0] + k), a);
        b = lanes_fma(f[5], lanes_load(row[5] + k), b);
        a = lanes_fma(f[1], lanes_load(row[1] + k), a);
        b = lanes_fma(f[6], lanes_load(row[6] + k), b);
        a = lanes_fma(f[2], lanes_load(row[2] + k), a);
        b = lanes_fma(f[7], lanes_load(row[7] + k), b);
        a = lanes_fma(f[3], lanes_load(row[3] + k), a);
        lanes_store(out + k, lanes_add(a, b));
    }
    for (; k < n; ++k) {
        for (int r = 0; r < 8; ++r) {
            out[k] -= factor[r] * row[r][k];
        }
    }
}

void LANES_NAME(engine_subtract_rows)(int64_t n, int32_t rows, const double *const *row, const double *factor, double *out)
{
    int32_t r = 0;
    for (; r + 8 <= rows; r += 8) {
        eight(n, row + r, factor + r, out);
    }
    for (; r < rows; ++r) {
        LANES_NAME(engine_subtract)(n, factor[r], row[r], out);
    }
}
