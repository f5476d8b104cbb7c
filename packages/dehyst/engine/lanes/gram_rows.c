/* The dense prefix of the Gram pass: its plays one by one, sums of products of its cells. */
#include "kernels.h"
#include "lanes.h"

void LANES_NAME(engine_cells)(int64_t samples, int32_t prefix, const double *r, double *z, const double *x, double *cells,
                              double *drive);
void LANES_NAME(engine_products)(int64_t samples, int32_t prefix, const double *a, const double *b, const double *f,
                                 double *out, double *with, int64_t lost);
void LANES_NAME(engine_row_sums)(int64_t samples, int32_t width, const double *rows, const double *f, double *out,
                                 int64_t lost);
int64_t LANES_NAME(engine_between)(int64_t samples, const double *x, double low, double high);

static inline lanes play(lanes low, lanes high, lanes z) { return lanes_max(low, lanes_min(high, z)); }

/* `vectors` times eight plays driven by x; before: the play in front of the first. Cells are differences of neighbours; drive
 * is this lane of the last eight. */
static inline __attribute__((always_inline)) void cells_of(const int vectors, int lane, int64_t samples, int32_t stride,
                                                           const double *r, double *z, const double *x,
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
        lanes_store_one(drive + k, state[vectors - 1], lane);
    }
    for (int j = 0; j < vectors; ++j) {
        lanes_store(z + 8 * j, state[j]);
    }
}

/* One or two times eight plays, two samples a step: clamps compose, and only the composed one has to wait for the state. */
static inline __attribute__((always_inline)) void cells_in_pairs(const int vectors, int lane, int64_t samples, int32_t stride,
                                                                 const double *r, double *z, const double *x,
                                                                 const double *before, double *cells, double *drive)
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
        lanes_store_one(drive + k, left, lane);
        lanes_store_one(drive + k + 1, next_left, lane);
    }
    for (int j = 0; j < vectors; ++j) {
        lanes_store(z + 8 * j, state[j]);
    }
    if (k < samples) {
        cells_of(vectors, lane, 1, stride, r, z, x + k, before + k, cells + k * stride, drive + k);
    }
}

/* Cells (samples, width) of operators 0 .. prefix, of which the first is x itself; drive: the outputs of the last. The width
 * is the prefix, a multiple of 4, rounded up to a multiple of 8. */
void LANES_NAME(engine_cells)(int64_t samples, int32_t prefix, const double *r, double *z, const double *x, double *cells,
                              double *drive)
{
    const int32_t width = (prefix + 7) / 8 * 8;
    const double *before = x;
    for (int32_t first = 0; first < width;) {
        const int32_t left = (width - first) / 8;
        const int lane = left > 4 || prefix == width ? 7 : 3;
        const double *radius = r + first;
        double *state = z + first, *out = cells + first;
        if (left >= 4) {
            cells_of(4, lane, samples, width, radius, state, x, before, out, drive);
        } else if (left == 3) {
            cells_of(3, lane, samples, width, radius, state, x, before, out, drive);
        } else if (left == 2) {
            cells_in_pairs(2, lane, samples, width, radius, state, x, before, out, drive);
        } else {
            cells_in_pairs(1, lane, samples, width, radius, state, x, before, out, drive);
        }
        first += left >= 4 ? 32 : 8 * left;
        before = drive; /* read before it is written, sample by sample */
    }
}

/* `rows` rows of a'b and, if it is asked for, f'b: `wide` times eight columns; `ways` samples at once, for a sum waits for
 * itself. */
static inline __attribute__((always_inline)) void block(const int rows, const int wide, const int ways, const int with_f,
                                                        int64_t samples, int32_t stride, const double *a, const double *b,
                                                        const double *f, double *out, double *with, int64_t lost)
{
    lanes sum[2][8][3], sum_f[2][3];
    for (int w = 0; w < ways; ++w) {
        for (int j = 0; j < wide; ++j) {
            sum_f[w][j] = lanes_all(0.0);
            for (int i = 0; i < rows; ++i) {
                sum[w][i][j] = lanes_all(0.0);
            }
        }
    }
    for (int64_t k = 0; k < samples; k += ways) {
        for (int w = 0; w < ways && k + w < samples; ++w) {
            lanes right[3];
            for (int j = 0; j < wide; ++j) {
                right[j] = lanes_load(b + (k + w) * stride + 8 * j);
                sum_f[w][j] = with_f ? lanes_fma(lanes_all(f[k + w]), right[j], sum_f[w][j]) : sum_f[w][j];
            }
            for (int i = 0; i < rows; ++i) {
                const lanes left = lanes_all(a[(k + w) * stride + i]);
                for (int j = 0; j < wide; ++j) {
                    sum[w][i][j] = lanes_fma(left, right[j], sum[w][i][j]);
                }
            }
        }
    }
    for (int j = 0; j < wide; ++j) {
        for (int i = 0; i < rows; ++i) {
            double *here = out + i * stride + 8 * j;
            lanes_add_exactly(here, here + (int64_t)stride * stride, ways == 2 ? lanes_add(sum[0][i][j], sum[1][i][j]) : sum[0][i][j]);
        }
        if (with_f) {
            lanes_add_exactly(with + 8 * j, with + lost + 8 * j, ways == 2 ? lanes_add(sum_f[0][j], sum_f[1][j]) : sum_f[0][j]);
        }
    }
}

#define BLOCK(rows, wide, ways) \
    (f != 0 ? block(rows, wide, ways, 1, samples, width, a + i, b + j, f, here, with + j, lost) \
            : block(rows, wide, ways, 0, samples, width, a + i, b + j, f, here, with + j, lost))

/* Rows i .. i + 7 (to i + 3 if `half`) of products up to the diagonal. A number that is fetched serves several columns at
 * once, as far as there are registers. */
static inline __attribute__((always_inline)) void rows_of(int half, int32_t i, int64_t samples, int32_t width, const double *a,
                                                          const double *b, const double *f, double *out, double *with,
                                                          int64_t lost)
{
    for (int32_t j = 0; j <= i;) {
        const int32_t left = (i - j) / 8 + 1;
        double *here = out + i * width + j;
#if LANES_LEVEL == 2
        if (half) {
            const int32_t wide = left >= 3 ? 3 : left;
            wide == 3 ? BLOCK(4, 3, 1) : wide == 2 ? BLOCK(4, 2, 1) : BLOCK(4, 1, 2);
            j += 8 * wide;
        } else {
            const int32_t wide = left >= 2 ? 2 : left;
            wide == 2 ? BLOCK(8, 2, 1) : BLOCK(8, 1, 1);
            j += 8 * wide;
        }
#else
        (void)left;
        BLOCK(4, 1, 1);
        j += 8;
        if (!half) {
            here += 4 * width;
            const double *top = a;
            const double *f_of_first = f;
            a += 4, f = 0;
            j -= 8;
            BLOCK(4, 1, 1);
            a = top, f = f_of_first;
            j += 8;
        }
#endif
    }
}

/* out (width, width) += a'b, blocks of eight on and below the diagonal, as far as rows of the prefix go; with (width,) += f'b,
 * f a null pointer for none. What rounding takes from these sums is added up behind them: width^2 and `lost` numbers on. */
void LANES_NAME(engine_products)(int64_t samples, int32_t prefix, const double *a, const double *b, const double *f,
                                 double *out, double *with, int64_t lost)
{
    const int32_t width = (prefix + 7) / 8 * 8;
    for (int32_t i = 0; i < width; i += 8) {
        const double *f_now = i + 8 == width ? f : 0; /* the last rows have all columns */
        rows_of(i + 4 == prefix, i, samples, width, a, b, f_now, out, with, lost);
    }
}

/* out (width,) += sum over samples of f times the row; of the row alone if f is a null pointer. */
void LANES_NAME(engine_row_sums)(int64_t samples, int32_t width, const double *rows, const double *f, double *out,
                                 int64_t lost)
{
    for (int32_t first = 0; first < width; first += 8) {
        const double *u = rows + first;
        lanes even = lanes_all(0.0), odd = even;
        int64_t k = 0;
        for (; k + 2 <= samples; k += 2, u += 2 * (int64_t)width) {
            const lanes a = lanes_load(u), b = lanes_load(u + width);
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
