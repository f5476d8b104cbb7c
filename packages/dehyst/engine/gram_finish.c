/* From differences at places to cells: sums over the places behind each cell, over rows and over columns. */
#include "gram.h"
#include "patience.h"

enum { GROUP = 8 }; /* rows at once: mirrored rows are columns of the packed triangle, read by cache lines */

static double gap(const gram_machine *m, int32_t c) { return c + 1 < m->n ? m->grid.r[c + 1] - m->grid.r[c] : 1.0; }

static double own(const gram_machine *m, int32_t p, int entry)
{
    const ptrdiff_t i = p * m->stride + entry;
    return m->sums.kept[i] + (m->sums.lost[i] + m->sums.place[i]);
}

/* g_p g_q with p and q in one group of rows, symmetric. */
static double within_group(const gram_machine *m, int32_t p, int32_t q)
{
    const int32_t high = p > q ? p : q, low = p > q ? q : p;
    const double cross = m->sums.cross[gram_row(high) + (size_t)low];
    if (high == low) {
        return 2 * cross + own(m, p, GRAM_SQUARE);
    }
    return high == low + 1 ? cross + own(m, high, GRAM_NEXT) : cross;
}

/* A column of sums over rows goes on upwards through the group, writing the cells of the lower triangle. */
static void add_column(const gram_machine *m, int32_t first, int32_t rows, int32_t q, const double *right, double *column,
                       double *out, ptrdiff_t stride)
{
    const double width = gap(m, q - 1);
    double sum = column[q];
    for (int32_t j = rows - 1; j >= 0 && first + j >= q; --j) {
        sum += right[j];
        if (first + j > 0) {
            out[(first + j - 1) * stride + q - 1] += sum * width * gap(m, first + j - 1);
        }
    }
    column[q] = sum;
}

/* Cells 0 .. n - 2: cell c sums places c + 1 .. n - 1. `column` (n,) carries the sums over the rows done so far. */
static void finish_group(const gram_machine *m, int32_t first, double *column, double *out, ptrdiff_t stride)
{
    const gram_sums *s = &m->sums;
    const int32_t n = m->n, rows = n - first < GROUP ? n - first : GROUP;
    double right[GROUP] = {0}; /* sums over columns from the right */
    for (int32_t q = n - 1; q >= first + GROUP; --q) {
        const double *row = s->cross + gram_row(q) + first;
        for (int32_t j = 0; j < GROUP; ++j) {
            right[j] += row[j];
        }
    }
    if (first + GROUP < n) {
        right[GROUP - 1] += own(m, first + GROUP, GRAM_NEXT);
    }
    for (int32_t q = first + rows - 1; q >= first && q > 0; --q) {
        for (int32_t j = 0; j < rows; ++j) {
            right[j] += within_group(m, first + j, q);
        }
        add_column(m, first, rows, q, right, column, out, stride);
    }
    right[0] += first > 0 ? own(m, first, GRAM_NEXT) : 0.0;
    for (int32_t q = first - 1; q > 0; --q) {
        for (int32_t j = 0; j < rows; ++j) {
            right[j] += s->cross[gram_row(first + j) + (size_t)q];
        }
        add_column(m, first, rows, q, right, column, out, stride);
    }
}

/* Adds sums over products of cells to the lower triangle of out (n, n) with rows of `stride`. `column` (n,) is scratch. */
void gram_finish_cells(const gram_machine *m, double *column, double *out, ptrdiff_t stride)
{
    const gram_sums *s = &m->sums;
    const int32_t n = m->n;
    for (int32_t q = 0; q < n; ++q) {
        column[q] = 0.0;
    }
    int64_t left = ENGINE_BETWEEN;
    for (int32_t first = (n - 1) / GROUP * GROUP; first >= 0 && !engine_stops(&left, (int64_t)GROUP * n); first -= GROUP) {
        finish_group(m, first, column, out, stride);
    }
    const double *row = s->cross + gram_row(n); /* the last cell */
    double *last = out + (n - 1) * stride, right = own(m, n, GRAM_NEXT);
    for (int32_t q = n - 1; q > 0; --q) {
        right += row[q];
        last[q - 1] += right * gap(m, q - 1);
    }
    last[n - 1] += own(m, n, GRAM_SQUARE);
}

/* Adds the sums of cells with ones or a column (an entry of a place) to out (n,), whose elements are `step` apart. */
void gram_finish_column(const gram_machine *m, int32_t entry, double *out, ptrdiff_t step)
{
    const int32_t n = m->n;
    double sum = 0.0;
    out[(n - 1) * step] += own(m, n, entry);
    for (int32_t p = n - 1; p > 0; --p) {
        sum += own(m, p, entry);
        out[(p - 1) * step] += sum * gap(m, p - 1);
    }
}
