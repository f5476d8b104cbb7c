/* The dense prefix of the Gram pass: its plays one by one, sums of products of its cells. */
#include "kernels.h"
#include "lanes.h"

void LANES_NAME(engine_cells)(int64_t samples, int32_t prefix, const double *r, double *z, const double *x, double *cells,
                              double *drive);
void LANES_NAME(engine_products)(int64_t samples, int32_t prefix, const double *a, const double *b, const double *f,
                                 double *out, double *with, int64_t lost);
void LANES_NAME(engine_row_sums)(int64_t samples, int32_t prefix, const double *rows, const double *f, double *out,
                                 int64_t lost);
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high);

static inline lanes play(lanes low, lanes high, lanes z) { return lanes_max(low, lanes_min(high, z)); }

/* `vectors` times eight plays driven by x; before: the play in front of the first. Cells are differences of neighbours. */
static inline __attribute__((always_inline)) void cells_of(const int vectors, int64_t samples, int32_t stride, const double *r, double *z, const double *x,
                            const double *before, double *cells, double *drive)
{
    lanes radius[4], state[4];
    for (int j = 0; j < vectors; ++j) {
        radius[j] = lanes_load(r + 8 * j);
        state[j] = lanes_load(z + 8 * j);
    }
    for (int64_t k = 0; k < samples; ++k) {
        const lanes u = lanes_all(x[k]);
        lanes left = lanes_all(before[k]);
        for (int j = 0; j < vectors; ++j) {
            state[j] = play(lanes_sub(u, radius[j]), lanes_add(u, radius[j]), state[j]);
            lanes_store(cells + k * stride + 8 * j, lanes_sub(lanes_shift(state[j], left), state[j]));
            left = state[j];
        }
        lanes_store_last(drive + k, state[vectors - 1]);
    }
    for (int j = 0; j < vectors; ++j) {
        lanes_store(z + 8 * j, state[j]);
    }
}

/* One or two times eight plays, two samples a step: clamps compose, and only the composed one has to wait for the state. */
static inline __attribute__((always_inline)) void cells_in_pairs(const int vectors, int64_t samples, int32_t stride, const double *r, double *z,
                                  const double *x, const double *before, double *cells, double *drive)
{
    lanes radius[2], state[2];
    for (int j = 0; j < vectors; ++j) {
        radius[j] = lanes_load(r + 8 * j);
        state[j] = lanes_load(z + 8 * j);
    }
    int64_t k = 0;
    for (; k + 2 <= samples; k += 2) {
        const lanes u = lanes_all(x[k]), v = lanes_all(x[k + 1]);
        lanes left = lanes_all(before[k]), next_left = lanes_all(before[k + 1]);
        for (int j = 0; j < vectors; ++j) {
            const lanes low = lanes_sub(u, radius[j]), high = lanes_add(u, radius[j]);
            const lanes next_low = lanes_sub(v, radius[j]), next_high = lanes_add(v, radius[j]);
            const lanes z1 = play(low, high, state[j]);
            state[j] = play(play(next_low, next_high, low), play(next_low, next_high, high), state[j]);
            lanes_store(cells + k * stride + 8 * j, lanes_sub(lanes_shift(z1, left), z1));
            lanes_store(cells + (k + 1) * stride + 8 * j, lanes_sub(lanes_shift(state[j], next_left), state[j]));
            left = z1;
            next_left = state[j];
        }
        lanes_store_last(drive + k, left);
        lanes_store_last(drive + k + 1, next_left);
    }
    for (int j = 0; j < vectors; ++j) {
        lanes_store(z + 8 * j, state[j]);
    }
    if (k < samples) {
        cells_of(vectors, 1, stride, r, z, x + k, before + k, cells + k * stride, drive + k);
    }
}

/* Cells (samples, prefix) of operators 0 .. prefix, of which the first is x itself; drive: the outputs of the last. */
void LANES_NAME(engine_cells)(int64_t samples, int32_t prefix, const double *r, double *z, const double *x, double *cells,
                              double *drive)
{
    const double *before = x;
    for (int32_t first = 0; first < prefix;) {
        const int32_t left = (prefix - first) / 8;
        const double *radius = r + first;
        double *state = z + first, *out = cells + first;
        if (left >= 4) {
            cells_of(4, samples, prefix, radius, state, x, before, out, drive);
        } else if (left == 3) {
            cells_of(3, samples, prefix, radius, state, x, before, out, drive);
        } else if (left == 2) {
            cells_in_pairs(2, samples, prefix, radius, state, x, before, out, drive);
        } else {
            cells_in_pairs(1, samples, prefix, radius, state, x, before, out, drive);
        }
        first += left >= 4 ? 32 : 8 * left;
        before = drive; /* read before it is written, sample by sample */
    }
}

/* Eight rows of a'b and, if it is asked for, f'b: `wide` times eight columns. */
static inline __attribute__((always_inline)) void block(const int wide, const int with_f, int64_t samples, int32_t stride,
                                                        const double *a, const double *b, const double *f, double *out,
                                                        double *with, int64_t lost)
{
    enum { ROWS = LANES_LEVEL == 2 ? 8 : 4 }; /* as many as there are registers */
    for (int half = 0; half < 8; half += ROWS) {
        const int f_now = with_f && half == 0;
        lanes sum[ROWS][2], sum_f[2] = {lanes_all(0.0), lanes_all(0.0)};
        for (int i = 0; i < ROWS; ++i) {
            for (int j = 0; j < wide; ++j) {
                sum[i][j] = lanes_all(0.0);
            }
        }
        for (int64_t k = 0; k < samples; ++k) {
            lanes right[2];
            for (int j = 0; j < wide; ++j) {
                right[j] = lanes_load(b + k * stride + 8 * j);
            }
            for (int j = 0; f_now && j < wide; ++j) {
                sum_f[j] = lanes_fma(lanes_all(f[k]), right[j], sum_f[j]);
            }
            for (int i = 0; i < ROWS; ++i) {
                const lanes left = lanes_all(a[k * stride + half + i]);
                for (int j = 0; j < wide; ++j) {
                    sum[i][j] = lanes_fma(left, right[j], sum[i][j]);
                }
            }
        }
        for (int i = 0; i < ROWS; ++i) {
            for (int j = 0; j < wide; ++j) {
                double *here = out + (half + i) * stride + 8 * j;
                lanes_add_exactly(here, here + (int64_t)stride * stride, sum[i][j]);
            }
        }
        for (int j = 0; f_now && j < wide; ++j) {
            lanes_add_exactly(with + 8 * j, with + lost + 8 * j, sum_f[j]);
        }
    }
}

/* out (prefix, prefix) += a'b, blocks of eight on and below the diagonal; with (prefix,) += f'b, f a null pointer for none.
 * What rounding takes from these sums is added up behind them: prefix^2 and `lost` numbers further on. */
void LANES_NAME(engine_products)(int64_t samples, int32_t prefix, const double *a, const double *b, const double *f,
                                 double *out, double *with, int64_t lost)
{
    for (int32_t i = 0; i < prefix; i += 8) {
        int32_t j = 0;
        for (; LANES_LEVEL == 2 && j + 8 <= i; j += 16) { /* two at once: a number is fetched for two products */
            if (f != 0 && j + 8 == i) {
                block(2, 1, samples, prefix, a + i, b + j, f, out + i * prefix + j, with + j, lost);
            } else {
                block(2, 0, samples, prefix, a + i, b + j, f, out + i * prefix + j, with + j, lost);
            }
        }
        for (; j <= i; j += 8) {
            if (f != 0 && j == i && (LANES_LEVEL != 2 || i + 8 == prefix)) {
                block(1, 1, samples, prefix, a + i, b + j, f, out + i * prefix + j, with + j, lost);
            } else {
                block(1, 0, samples, prefix, a + i, b + j, f, out + i * prefix + j, with + j, lost);
            }
        }
    }
}

/* out (prefix,) += sum over samples of f times the row; of the row alone if f is a null pointer. */
void LANES_NAME(engine_row_sums)(int64_t samples, int32_t prefix, const double *rows, const double *f, double *out,
                                 int64_t lost)
{
    for (int32_t first = 0; first < prefix; first += 8) {
        const double *u = rows + first;
        lanes even = lanes_all(0.0), odd = even;
        int64_t k = 0;
        for (; k + 2 <= samples; k += 2, u += 2 * (int64_t)prefix) {
            const lanes a = lanes_load(u), b = lanes_load(u + prefix);
            even = f == 0 ? lanes_add(even, a) : lanes_fma(lanes_all(f[k]), a, even);
            odd = f == 0 ? lanes_add(odd, b) : lanes_fma(lanes_all(f[k + 1]), b, odd);
        }
        if (k < samples) {
            const lanes a = lanes_load(u);
            even = f == 0 ? lanes_add(even, a) : lanes_fma(lanes_all(f[k]), a, even);
        }
        lanes_add_exactly(out + first, out + lost + first, lanes_add(even, odd));
    }
}

/* Number of samples from the first on with low <= x <= high: NaN is not. */
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high)
{
    const lanes l = lanes_all(low), h = lanes_all(high);
    int64_t k = 0;
    for (; k + 8 <= samples; k += 8) {
        const lanes u = lanes_load(x + k);
        if ((lanes_le(l, u) & lanes_le(u, h)) != 255) {
            break;
        }
    }
    while (k < samples && x[k] >= low && x[k] <= high) {
        ++k;
    }
    return k;
}
