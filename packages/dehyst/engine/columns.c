#include "columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lanes/kernels.h"

enum { FEW = 4 }; /* bounds off zero that are shifted one by one */

static const double *gram_row(const columns *c, int32_t i)
{
    return c->program->gram + (size_t)i * (size_t)c->program->unknowns;
}

static double *kept_row(const columns *c, int32_t block)
{
    return c->kept + (size_t)block * (size_t)c->program->unknowns;
}

static int is_step(const columns *c, int32_t j)
{
    return c->program->basis != ENGINE_SLOPES && j >= c->first && j < c->last;
}

void columns_interval(const columns *c, int32_t j, int32_t *from, int32_t *to)
{
    const int stops = c->program->basis == ENGINE_STOPS;
    *from = is_step(c, j) && stops ? c->first : j;
    *to = !is_step(c, j) ? j + 1 : stops && j > c->first ? j : c->last;
}

/* out += rows [from, to) of G */
static void add_rows(const columns *c, int32_t from, int32_t to, double *out)
{
    static const double minus[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
    const double *row[8];
    while (from < to) {
        const int32_t count = to - from < 8 ? to - from : 8;
        for (int32_t r = 0; r < count; ++r) {
            row[r] = gram_row(c, from + r);
        }
        engine_kernels_in_use()->subtract_rows(c->program->unknowns, count, row, minus, out);
        from += count;
    }
}

/* Running sums of `in`, walking by step; four at a time, so that one addition in four waits for the one before. */
static double running(int32_t n, const double *in, double *out, int step)
{
    double sum = 0.0;
    int32_t k = 0;
    for (; k + 4 <= n; k += 4, in += 4 * step, out += 4 * step) {
        const double a = in[0], b = a + in[step], d = b + in[2 * step], e = d + in[3 * step];
        out[0] = sum + a;
        out[step] = sum + b;
        out[2 * step] = sum + d;
        sum += e;
        out[3 * step] = sum;
    }
    for (; k < n; ++k, in += step, out += step) {
        sum += *in;
        *out = sum;
    }
    return sum;
}

void columns_transpose(const columns *c, const double *v, const double *extra, double factor, double *u)
{
    const int32_t n = c->last - c->first, unknowns = c->program->unknowns;
    memcpy(u, v, (size_t)unknowns * sizeof *u);
    if (n > 0 && c->program->basis == ENGINE_WEIGHTS) {
        running(n, v + c->last - 1, u + c->last - 1, -1);
    } else if (n > 0 && c->program->basis == ENGINE_STOPS) {
        const double most = running(n - 1, v + c->first, u + c->first + 1, 1);
        u[c->first] = most + v[c->last - 1];
    }
    for (int32_t j = 0; j < unknowns; ++j) {
        u[j] = (extra ? u[j] + extra[j] : u[j]) * (factor * c->scale[j]);
    }
}

void columns_apply(const columns *c, const double *u, double *v)
{
    const int32_t n = c->last - c->first;
    memcpy(v, u, (size_t)c->program->unknowns * sizeof *v);
    if (n > 0 && c->program->basis == ENGINE_WEIGHTS) {
        running(n, u + c->first, v + c->first, 1);
    } else if (n > 0 && c->program->basis == ENGINE_STOPS) {
        double sum = u[c->first];
        for (int32_t i = c->last - 1; i >= c->first; --i) {
            v[i] = sum;
            sum += u[i];
        }
    }
}

/* sum of G's rows over the cells of unknown j: a row of G, or the work array */
static const double *cell_row(const columns *c, int32_t j)
{
    if (!is_step(c, j)) {
        return gram_row(c, j);
    }
    int32_t from, to;
    columns_interval(c, j, &from, &to);
    const int stops = c->program->basis == ENGINE_STOPS;
    const int32_t cell = (stops ? to : from) - c->first, plays = c->last - c->first;
    const int32_t block = stops ? cell / c->stride : (cell + c->stride - 1) / c->stride;
    const int32_t open = block * c->stride < plays ? block * c->stride : plays;
    memcpy(c->cells, kept_row(c, block), (size_t)c->program->unknowns * sizeof *c->cells);
    add_rows(c, c->first + (stops ? open : cell), c->first + (stops ? cell : open), c->cells);
    return c->cells;
}

void columns_row(const columns *c, int32_t j, double *row)
{
    const double *extra = c->program->extra;
    columns_transpose(c, cell_row(c, j), extra ? extra + (size_t)j * (size_t)c->program->unknowns : NULL, c->scale[j], row);
}

/* Kept sums, and with them the squared lengths of the steps: the square over an interval grows by one row and column. */
static void keep_weights(const columns *c, int32_t blocks, double *length)
{
    const int32_t unknowns = c->program->unknowns;
    double square = 0.0;
    memset(kept_row(c, blocks), 0, (size_t)unknowns * sizeof *c->kept);
    for (int32_t block = blocks - 1; block >= 0; --block) {
        const int32_t from = c->first + block * c->stride, to = from + c->stride < c->last ? from + c->stride : c->last;
        const double *sums = kept_row(c, block + 1);
        memcpy(kept_row(c, block), sums, (size_t)unknowns * sizeof *sums);
        add_rows(c, from, to, kept_row(c, block));
        for (int32_t i = to - 1; i >= from; --i) {
            double cross = sums[i];
            for (int32_t a = i + 1; a < to; ++a) {
                cross += gram_row(c, a)[i];
            }
            square += 2.0 * cross + gram_row(c, i)[i];
            length[i] = square;
        }
    }
}

static void keep_stops(const columns *c, int32_t blocks, double *length)
{
    const int32_t unknowns = c->program->unknowns;
    double square = 0.0;
    memset(kept_row(c, 0), 0, (size_t)unknowns * sizeof *c->kept);
    for (int32_t block = 0; block < blocks; ++block) {
        const int32_t from = c->first + block * c->stride, to = from + c->stride < c->last ? from + c->stride : c->last;
        const double *sums = kept_row(c, block);
        for (int32_t i = from; i < to; ++i) {
            double cross = sums[i];
            for (int32_t a = from; a < i; ++a) {
                cross += gram_row(c, a)[i];
            }
            square += 2.0 * cross + gram_row(c, i)[i];
            length[i + 1 < c->last ? i + 1 : c->first] = square;
        }
        memcpy(kept_row(c, block + 1), sums, (size_t)unknowns * sizeof *sums);
        add_rows(c, from, to, kept_row(c, block + 1));
    }
}

/* rhs = g - G T lower, extra_rhs = h - E lower: a few bounds by the kept sums, many by all cells at once. */
static void shift(const columns *c)
{
    const engine_program *p = c->program;
    const engine_kernels *kernels = engine_kernels_in_use();
    const int32_t unknowns = p->unknowns;
    int32_t bounds = 0;
    for (int32_t j = 0; j < unknowns; ++j) {
        c->lower[j] = j < p->free ? 0.0 : p->lower[j];
        bounds += c->lower[j] != 0.0;
        c->rhs[j] = p->rhs[j];
        c->extra_rhs[j] = p->extra_rhs ? p->extra_rhs[j] : 0.0;
    }
    for (int32_t j = 0; j < unknowns; ++j) {
        if (p->extra && c->lower[j] != 0.0) {
            kernels->subtract(unknowns, c->lower[j], p->extra + (size_t)j * (size_t)unknowns, c->extra_rhs);
        }
        if (bounds <= FEW && c->lower[j] != 0.0) {
            kernels->subtract(unknowns, c->lower[j], cell_row(c, j), c->rhs);
        }
    }
    if (bounds > FEW) {
        columns_apply(c, c->lower, c->cells);
        for (int32_t i = 0; i < unknowns; ++i) {
            kernels->subtract(unknowns, c->cells[i], gram_row(c, i), c->rhs);
        }
    }
}

int columns_make(columns *c, const engine_program *program)
{
    const size_t unknowns = (size_t)program->unknowns;
    const int steps = program->basis != ENGINE_SLOPES && program->plays > 0;
    c->program = program;
    c->first = program->free;
    c->last = program->free + program->plays;
    c->stride = 8 * (1 + (int32_t)(sqrt((double)program->plays) / 16.0));
    const int32_t blocks = steps ? (program->plays + c->stride - 1) / c->stride : 0;
    c->memory = malloc((6 + (size_t)blocks + 1) * unknowns * sizeof(double));
    if (!c->memory) {
        return -1;
    }
    c->lower = c->memory;
    c->rhs = c->lower + unknowns;
    c->extra_rhs = c->rhs + unknowns;
    c->target = c->extra_rhs + unknowns;
    c->scale = c->target + unknowns;
    c->cells = c->scale + unknowns;
    c->kept = c->cells + unknowns;
    for (int32_t j = 0; j < program->unknowns; ++j) {
        c->scale[j] = gram_row(c, j)[j];
    }
    if (steps && program->basis == ENGINE_WEIGHTS) {
        keep_weights(c, blocks, c->scale);
    } else if (steps) {
        keep_stops(c, blocks, c->scale);
    }
    for (int32_t j = 0; j < program->unknowns; ++j) {
        const double square = c->scale[j] + (program->extra ? program->extra[(size_t)j * unknowns + (size_t)j] : 0.0);
        c->scale[j] = square > 0.0 ? 1.0 / sqrt(square) : 0.0;
    }
    shift(c);
    columns_transpose(c, c->rhs, c->extra_rhs, 1.0, c->target);
    return 0;
}

void columns_free(columns *c)
{
    free(c->memory);
}
