/* What a long signal boils down to: its turning points, and the few samples that decide the state of every play. */
#ifndef DEHYST_SIGNAL_H
#define DEHYST_SIGNAL_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Indices where x (samples,) turns by more than `swing`: the first sample, every extreme between two swings larger than
 * that, the last sample. point (samples + 2,); returns how many. x must be finite. */
int64_t engine_turning_points(int64_t samples, const double *x, double swing, int64_t *point);

/* Indices of the samples of x that leave every play, whatever its threshold and its state before the first sample, at
 * the same value at each of the rows (rows,), increasing, below `samples`: the first sample, the rows, and between two
 * rows the extremes that nothing wiped out. kept (row[rows - 1] + 1,); place (rows,): where each row stands among them.
 * Returns how many are kept. Exact: clamps are monotone, also in rounding. */
int64_t engine_essential(const double *x, int64_t rows, const int64_t *row, int64_t *kept, int64_t *place);

/* Sums of weight (1, t, t^2, y, t y) over the samples of each of `bins` equal bins over [low, high], t the place in the
 * bin from 0 to 1; beyond the ends t stays 0 or 1. They are added to sums (bins, 5); weight may be a null pointer. */
void engine_bin_sums(int64_t samples, const double *x, const double *y, const double *weight, int32_t bins, double low,
                     double high, double *sums);

#ifdef __cplusplus
}
#endif

#endif
