#include "refine.h"
#include "patience.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lanes/kernels.h"

enum { ROUNDS = 3 };
static const double vanishing = 1e-13; /* squared pivot of columns of length one */

static int make(refinement *r, int32_t size, int32_t unknowns)
{
    const size_t m = (size_t)size, n = (size_t)unknowns;
    memset(r, 0, sizeof *r);
    r->size = size;
    r->member = malloc((3 * sizeof(int32_t) + 1) * (m + 1));
    r->matrix = malloc((m * m + 4 * (m + 8) + m * n) * sizeof(double));
    r->row = malloc((m + 1) * sizeof(double *));
    if (!r->member || !r->matrix || !r->row || cholesky_make(&r->factor, size)) {
        return -1;
    }
    r->from = r->member + m;
    r->to = r->from + m;
    r->linked = (uint8_t *)(r->to + m);
    r->unit = r->matrix + m * m;
    r->rhs = r->unit + m + 8;
    r->slope = r->rhs + m + 8;
    r->work = r->slope + m + 8;
    r->cells = r->work + m + 8;
    for (size_t i = 0; i < m; ++i) {
        r->row[i] = r->cells + i * n;
    }
    return 0;
}

void refinement_free(refinement *r)
{
    free(r->member);
    free(r->matrix);
    free(r->row);
    cholesky_free(&r->factor);
    memset(r, 0, sizeof *r);
}

/* Members in order; cells of member i: those that no later member of the chain changes. */
static void collect(refinement *r, const uint8_t *passive)
{
    const columns *c = r->columns;
    const engine_program *p = c->program;
    const int stops = p->basis == ENGINE_STOPS, steps = p->basis != ENGINE_SLOPES;
    int32_t count = 0, ends = -1; /* last member of the chain so far */
    for (int32_t k = 0; k < p->unknowns; ++k) {
        const int play = k >= c->first && k < c->last;
        const int32_t j = play && stops && k > c->first ? c->last - (k - c->first) : k;
        if (!passive[j]) {
            continue;
        }
        columns_interval(c, j, &r->from[count], &r->to[count]);
        r->member[count] = j;
        r->linked[count] = (uint8_t)(play && steps && ends >= 0);
        if (r->linked[count]) {
            *(stops ? &r->from[ends] : &r->to[ends]) = j;
        }
        ends = play && steps ? count : ends;
        ++count;
    }
}

static double total(const double *v, int32_t from, int32_t to)
{
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
    for (; from + 4 <= to; from += 4) {
        a += v[from];
        b += v[from + 1];
        c += v[from + 2];
        d += v[from + 3];
    }
    for (; from < to; ++from) {
        a += v[from];
    }
    return (a + b) + (c + d);
}

/* (D'E D)_ij for the slopes: x_i = S_i - S_{i-1} where linked */
static double in_slopes(const refinement *r, int32_t i, int32_t j)
{
    const engine_program *p = r->columns->program;
    const size_t n = (size_t)p->unknowns;
    double sum = 0.0;
    for (int32_t a = i; a < r->size && (a == i || (a == i + 1 && r->linked[a])); ++a) {
        for (int32_t b = j; b < r->size && (b == j || (b == j + 1 && r->linked[b])); ++b) {
            const double e = p->extra[(size_t)r->member[a] * n + (size_t)r->member[b]];
            sum += (a == i) == (b == j) ? e : -e;
        }
    }
    return sum;
}

static void form(refinement *r)
{
    static const double minus[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
    const columns *c = r->columns;
    const engine_program *p = c->program;
    const size_t n = (size_t)p->unknowns, m = (size_t)r->size;
    for (int32_t i = 0; i < r->size; ++i) {
        double *sums = r->cells + (size_t)i * n;
        memcpy(sums, p->gram + (size_t)r->from[i] * n, n * sizeof *sums);
        for (int32_t a = r->from[i] + 1; a < r->to[i]; a += 8) {
            const double *row[8];
            const int32_t rows = r->to[i] - a < 8 ? r->to[i] - a : 8;
            for (int32_t k = 0; k < rows; ++k) {
                row[k] = p->gram + (size_t)(a + k) * n;
            }
            engine_kernels_in_use()->subtract_rows(p->unknowns, rows, row, minus, sums);
        }
        double *k = r->matrix + (size_t)i * m;
        for (int32_t j = 0; j <= i; ++j) {
            k[j] = total(sums, r->from[j], r->to[j]) + (p->extra ? in_slopes(r, i, j) : 0.0);
        }
        r->unit[i] = k[i] > 0.0 ? 1.0 / sqrt(k[i]) : 0.0;
        const double next = i + 1 < r->size && r->linked[i + 1] ? c->extra_rhs[r->member[i + 1]] : 0.0;
        r->rhs[i] = r->unit[i] * (total(c->rhs, r->from[i], r->to[i]) + c->extra_rhs[r->member[i]] - next);
    }
    for (size_t i = 0; i < m; ++i) {
        for (size_t j = 0; j <= i; ++j) {
            r->matrix[i * m + j] *= r->unit[i] * r->unit[j];
            r->matrix[j * m + i] = r->matrix[i * m + j];
        }
    }
}

/* S by the factor, then corrections from residuals until they no longer shrink. */
static void solve(refinement *r)
{
    double before = INFINITY;
    cholesky_back(&r->factor, r->factor.z, r->slope);
    for (int round = 0; round < ROUNDS; ++round) {
        double size = 0.0;
        for (int32_t i = 0; i < r->size; ++i) {
            const double *row = r->matrix + (size_t)i * (size_t)r->size;
            r->work[i] = r->rhs[i] - engine_kernels_in_use()->dot(r->size, row, r->slope);
        }
        cholesky_forward(&r->factor, r->work, r->work);
        cholesky_back(&r->factor, r->work, r->work);
        for (int32_t i = 0; i < r->size; ++i) {
            size = fmax(size, fabs(r->work[i]));
        }
        if (!(size < 0.5 * before)) {
            break;
        }
        before = size;
        engine_kernels_in_use()->subtract(r->size, -1.0, r->work, r->slope);
    }
}

/* Gradient in cells, rhs - sum_i S_i cells_i, then in u. */
static void differentiate(refinement *r, const double *x, double *gradient)
{
    const columns *c = r->columns;
    const engine_program *p = c->program;
    const size_t n = (size_t)p->unknowns;
    double *cells = c->cells;
    memcpy(cells, c->rhs, n * sizeof *cells);
    engine_kernels_in_use()->subtract_rows(p->unknowns, r->size, r->row, r->slope, cells);
    columns_transpose(c, cells, c->extra_rhs, 1.0, gradient);
    for (int32_t i = 0; p->extra && i < r->size; ++i) {
        const size_t j = (size_t)r->member[i];
        for (size_t k = 0; k < n; ++k) {
            gradient[k] -= c->scale[k] * x[j] * p->extra[j * n + k];
        }
    }
}

int32_t refine(refinement *r, const columns *c, const uint8_t *passive, double *x, double *gradient)
{
    int32_t size = 0;
    for (int32_t j = 0; j < c->program->unknowns; ++j) {
        size += passive[j] != 0;
        x[j] = 0.0;
    }
    refinement_free(r);
    if (make(r, size, c->program->unknowns)) {
        return -2;
    }
    r->columns = c;
    collect(r, passive);
    form(r);
    for (int32_t i = 0; i < size; ++i) {
        const double *k = r->matrix + (size_t)i * (size_t)size;
        if (engine_asked()) {
            return -2;
        }
        if (!(cholesky_append(&r->factor, k, k[i], r->rhs[i], vanishing) > vanishing)) {
            return r->member[i];
        }
    }
    solve(r);
    for (int32_t i = 0; i < size; ++i) {
        r->slope[i] *= r->unit[i];
        x[r->member[i]] = r->slope[i] - (r->linked[i] ? r->slope[i - 1] : 0.0);
    }
    differentiate(r, x, gradient);
    return -1;
}

double refinement_condition(refinement *r)
{
    const size_t m = (size_t)r->size;
    double ends[2] = {1.0, 1.0}; /* eigenvalues of the matrix and of its inverse, from below */
    for (int inverse = 0; inverse < 2 && m > 0; ++inverse) {
        double *v = r->work, *w = r->factor.z, norm = 1.0; /* z has served */
        for (size_t i = 0; i < m; ++i) {
            v[i] = (inverse && i % 2 ? -1.0 : 1.0) / (double)(1 + i % 7); /* unlike any eigenvector */
        }
        for (int round = 0; round < ROUNDS; ++round) {
            if (inverse) {
                cholesky_forward(&r->factor, v, w);
                cholesky_back(&r->factor, w, w);
            } else {
                for (size_t i = 0; i < m; ++i) {
                    w[i] = engine_kernels_in_use()->dot(r->size, r->matrix + i * m, v);
                }
            }
            norm = sqrt(engine_kernels_in_use()->dot(r->size, w, w));
            for (size_t i = 0; i < m; ++i) {
                v[i] = w[i] / norm;
            }
        }
        ends[inverse] = norm;
    }
    return fmax(1.0, sqrt(ends[0] * ends[1]));
}

double refinement_gain(refinement *r, int32_t i, double x)
{
    double *v = r->work;
    memset(v, 0, (size_t)r->size * sizeof *v);
    v[i] = r->unit[i];
    if (r->linked[i]) {
        v[i - 1] = -r->unit[i - 1];
    }
    cholesky_forward(&r->factor, v, v);
    const double scale = r->columns->scale[r->member[i]];
    return x * scale / engine_kernels_in_use()->dot(r->size, v, v);
}
