#include "cholesky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lanes/kernels.h"

static size_t padded(int32_t n)
{
    return ((size_t)n + 7) & ~(size_t)7;
}

/* Start of row i: the rows before it have padded(1) + ... + padded(i) numbers. */
static size_t offset(int32_t i)
{
    const size_t eights = (size_t)i / 8, rest = (size_t)i % 8;
    return 32 * eights * (eights + 1) + 8 * rest * (eights + 1);
}

int cholesky_make(cholesky *f, int32_t room)
{
    f->size = 0;
    f->room = room < 32 ? 32 : room;
    f->rows = malloc(offset(f->room) * sizeof(double));
    f->z = malloc(padded(f->room) * sizeof(double));
    f->inverse = malloc(padded(f->room) * sizeof(double));
    f->work = malloc(2 * padded(f->room) * sizeof(double));
    return f->rows && f->z && f->inverse && f->work ? 0 : -1;
}

void cholesky_free(cholesky *f)
{
    free(f->rows);
    free(f->z);
    free(f->inverse);
    free(f->work);
}

static int grow_one(double **numbers, size_t size)
{
    double *grown = realloc(*numbers, size * sizeof(double));
    *numbers = grown ? grown : *numbers;
    return grown ? 0 : -1;
}

static int grow(cholesky *f)
{
    const int32_t room = 2 * f->room;
    const size_t one = padded(room);
    if (grow_one(&f->rows, offset(room)) || grow_one(&f->z, one) || grow_one(&f->inverse, one) ||
        grow_one(&f->work, 2 * one)) {
        return -1;
    }
    f->room = room;
    return 0;
}

static void point_at(const cholesky *f, int32_t first, int32_t rows, const double **row)
{
    const double *l = f->rows + offset(first); /* eight rows from a multiple of eight are equally long */
    for (int32_t r = 0; r < rows; ++r, l += padded(first + 1)) {
        row[r] = l;
    }
}

/* Eight unknowns from i on; each is taken out of those after it as soon as it is known, so that these do not wait. */
static void eight_down(const double *const *l, int32_t i, const double *b, const double *inverse, double *x)
{
    double sum[8];
    engine_kernels_in_use()->dot_eight(i, l, x, sum);
    for (int r = 0; r < 8; ++r) {
        sum[r] = b[r] - sum[r];
    }
    for (int c = 0; c < 8; ++c) {
        const double known = sum[c] * inverse[c];
        for (int r = c + 1; r < 8; ++r) {
            sum[r] -= l[r][i + c] * known;
        }
        x[i + c] = known;
    }
}

/* Eight rows at a time: what lies left of their triangle in one sweep, then the triangle. */
void cholesky_forward(const cholesky *f, const double *b, double *x)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    for (int32_t i = 0; i < f->size; i += 8) {
        const int32_t rows = f->size - i < 8 ? f->size - i : 8;
        const double *l[8];
        point_at(f, i, rows, l);
        if (rows == 8) {
            eight_down(l, i, b + i, f->inverse + i, x);
            continue;
        }
        for (int32_t r = 0; r < rows; ++r) {
            x[i + r] = (b[i + r] - kernels->dot(i + r, l[r], x)) * f->inverse[i + r];
        }
    }
}

void cholesky_back(const cholesky *f, const double *y, double *x)
{
    if (x != y) {
        memcpy(x, y, (size_t)f->size * sizeof *x);
    }
    for (int32_t i = (f->size - 1) & ~7; i >= 0; i -= 8) {
        const int32_t rows = f->size - i < 8 ? f->size - i : 8;
        const double *l[8];
        point_at(f, i, rows, l);
        for (int32_t r = rows - 1; r >= 0; --r) {
            x[i + r] *= f->inverse[i + r];
            for (int32_t c = 0; c < r; ++c) {
                x[i + c] -= x[i + r] * l[r][i + c];
            }
        }
        engine_kernels_in_use()->subtract_rows(i, rows, l, x + i, x);
    }
}

double cholesky_append(cholesky *f, const double *row, double diagonal, double b, double least)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    if (f->size == f->room && grow(f)) {
        return -1e300;
    }
    const int32_t n = f->size;
    double *l = f->rows + offset(n);
    memset(l + (n & ~7), 0, 8 * sizeof *l);
    cholesky_forward(f, row, l);
    const double square = diagonal - kernels->dot(n, l, l);
    if (square > least) {
        l[n] = sqrt(square);
        f->inverse[n] = 1.0 / l[n];
        f->z[n] = (b - kernels->dot(n, l, f->z)) * f->inverse[n];
        f->size = n + 1;
    }
    return square;
}

/* Without its row at `position` the factor has one number too many in each row below: rotate it into the column before. */
void cholesky_remove(cholesky *f, int32_t position)
{
    double *cosine = f->work, *sine = f->work + padded(f->room), *z = f->z;
    for (int32_t i = position + 1; i < f->size; ++i) {
        const double *old = f->rows + offset(i);
        double *l = f->rows + offset(i - 1);
        double carried = old[position];
        memcpy(l, old, (size_t)position * sizeof *l);
        for (int32_t j = position; j < i - 1; ++j) {
            const double next = old[j + 1];
            l[j] = cosine[j] * carried + sine[j] * next;
            carried = cosine[j] * next - sine[j] * carried;
        }
        const double norm = sqrt(carried * carried + old[i] * old[i]), c = carried / norm, s = old[i] / norm;
        cosine[i - 1] = c;
        sine[i - 1] = s;
        l[i - 1] = norm;
        f->inverse[i - 1] = 1.0 / norm;
        memset(l + i, 0, (padded(i) - (size_t)i) * sizeof *l);
        carried = z[i - 1];
        z[i - 1] = c * carried + s * z[i];
        z[i] = c * z[i] - s * carried;
    }
    --f->size;
}
