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
    f->work = malloc(2 * padded(f->room) * sizeof(double));
    return f->rows && f->z && f->work ? 0 : -1;
}

void cholesky_free(cholesky *f)
{
    free(f->rows);
    free(f->z);
    free(f->work);
}

static int grow(cholesky *f)
{
    const int32_t room = 2 * f->room;
    double *rows = realloc(f->rows, offset(room) * sizeof(double));
    f->rows = rows ? rows : f->rows;
    double *z = realloc(f->z, padded(room) * sizeof(double));
    f->z = z ? z : f->z;
    double *work = realloc(f->work, 2 * padded(room) * sizeof(double));
    f->work = work ? work : f->work;
    if (!rows || !z || !work) {
        return -1;
    }
    f->room = room;
    return 0;
}

double cholesky_append(cholesky *f, const double *row, double diagonal, double b, double least)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    if (f->size == f->room && grow(f)) {
        return -1e300;
    }
    const int32_t n = f->size;
    double *l = f->rows + offset(n);
    memset(l, 0, padded(n + 1) * sizeof *l);
    for (int32_t i = 0; i < n; ++i) {
        const double *li = f->rows + offset(i);
        l[i] = (row[i] - kernels->dot((int64_t)padded(i), li, l)) / li[i];
    }
    const double square = diagonal - kernels->dot((int64_t)padded(n), l, l);
    if (square > least) {
        l[n] = sqrt(square);
        f->z[n] = (b - kernels->dot(n, l, f->z)) / l[n];
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
        memset(l + i, 0, (padded(i) - (size_t)i) * sizeof *l);
        carried = z[i - 1];
        z[i - 1] = c * carried + s * z[i];
        z[i] = c * z[i] - s * carried;
    }
    --f->size;
}

void cholesky_back(const cholesky *f, const double *y, double *x)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    if (x != y) {
        memcpy(x, y, (size_t)f->size * sizeof *x);
    }
    for (int32_t i = f->size - 1; i >= 0; --i) {
        const double *l = f->rows + offset(i);
        x[i] /= l[i];
        kernels->subtract(i, x[i], l, x);
    }
}

void cholesky_forward(const cholesky *f, const double *b, double *x)
{
    for (int32_t i = 0; i < f->size; ++i) {
        const double *l = f->rows + offset(i);
        x[i] = (b[i] - engine_kernels_in_use()->dot(i, l, x)) / l[i];
    }
}

double cholesky_pivot(const cholesky *f, int32_t position)
{
    return f->rows[offset(position) + (size_t)position];
}
