/* The dense prefix of the Gram pass, allocated. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gram.h"

int gram_dense_start(gram_dense *d, int32_t prefix, int32_t n, const double *threshold, const double *state,
                     int32_t targets)
{
    memset(d, 0, sizeof *d);
    d->prefix = prefix;
    d->width = (prefix + 7) / 8 * 8;
    d->targets = targets;
    const size_t k = (size_t)d->width;
    d->r = malloc((k + 1) * sizeof *d->r);
    d->z = malloc((k + 1) * sizeof *d->z);
    d->rows = malloc((k * GRAM_DENSE_SAMPLES + 1) * sizeof *d->rows);
    d->weighted = malloc((k * GRAM_DENSE_SAMPLES + 1) * sizeof *d->weighted);
    d->drive = malloc(GRAM_DENSE_SAMPLES * sizeof *d->drive);
    d->products = calloc(2 * k * k + 1, sizeof *d->products);
    d->with = calloc(2 * k * (size_t)targets + 1, sizeof *d->with);
    d->ones = calloc(2 * k + 1, sizeof *d->ones);
    if (d->r == NULL || d->z == NULL || d->rows == NULL || d->weighted == NULL || d->drive == NULL ||
        d->products == NULL || d->with == NULL || d->ones == NULL) {
        return -1;
    }
    for (int32_t i = 0; i < d->width; ++i) {
        const int there = i < prefix && i + 1 < n;
        d->r[i] = there ? threshold[i + 1] : INFINITY;
        d->z[i] = there ? state[i + 1] : 0.0;
    }
    return 0;
}

void gram_dense_free(gram_dense *d)
{
    free(d->r);
    free(d->z);
    free(d->rows);
    free(d->weighted);
    free(d->drive);
    free(d->products);
    free(d->with);
    free(d->ones);
    memset(d, 0, sizeof *d);
}

void gram_dense_clear(gram_dense *d)
{
    const size_t k = (size_t)d->width;
    memset(d->products, 0, 2 * k * k * sizeof *d->products);
    memset(d->with, 0, 2 * k * (size_t)d->targets * sizeof *d->with);
    memset(d->ones, 0, 2 * k * sizeof *d->ones);
}
