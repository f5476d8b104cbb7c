#include "active_set.h"
#include "patience.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lanes/kernels.h"

enum { MOST = 16 };

static const double rounding = 0x1p-52;
static const double half_digits = 1e-6; /* less than that share of |y| a difference of squares cannot tell */
static const double nothing_left = 1e-13; /* squared length of a column of length one that the free ones explain */
static const double alike = 1e-14;        /* squared pivot below which a column is a sum of the passive ones */

int active_set_make(active_set *a, const engine_program *program, uint8_t *passive)
{
    const size_t n = (size_t)program->unknowns;
    memset(a, 0, sizeof *a);
    a->passive = passive;
    a->limit = 100 + 10 * program->unknowns;
    a->x = calloc(7 * n + 7 * 8, sizeof(double));
    a->row = calloc(2 * n + 1, sizeof(double *));
    a->index = malloc((sizeof(int32_t) + 1) * n + 1);
    if (!a->x || !a->row || !a->index || columns_make(&a->columns, program) || cholesky_make(&a->factor, 64)) {
        return -1;
    }
    a->next = a->x + n + 8;
    a->coefficient = a->next + n + 8;
    a->gather = a->coefficient + n + 8;
    a->gradient = a->gather + n + 8;
    a->length = a->gradient + n + 8;
    a->chosen = (const double **)(a->row + n);
    a->closed = (uint8_t *)(a->index + n);
    memset(a->closed, OPEN, n);
    return 0;
}

void active_set_free(active_set *a)
{
    for (int32_t j = 0; a->row && a->columns.program && j < a->columns.program->unknowns; ++j) {
        free(a->row[j]);
    }
    free(a->x);
    free(a->row);
    free(a->index);
    columns_free(&a->columns);
    cholesky_free(&a->factor);
}

static const double *row_of(active_set *a, int32_t j)
{
    if (!a->row[j]) {
        a->row[j] = malloc((size_t)a->columns.program->unknowns * sizeof(double));
        if (a->row[j]) {
            columns_row(&a->columns, j, a->row[j]);
        }
    }
    return a->row[j];
}

/* Append unknown j: 0, 1 if its pivot vanishes, -1 if memory is short. */
static int append(active_set *a, int32_t j)
{
    const double *row = row_of(a, j);
    if (!row) {
        return -1;
    }
    const int32_t m = a->factor.size;
    for (int32_t k = 0; k < m; ++k) {
        a->gather[k] = row[a->index[k]];
    }
    const double square = cholesky_append(&a->factor, a->gather, row[j], a->columns.target[j], alike);
    if (!(square > alike)) {
        return square < -1e299 ? -1 : 1;
    }
    a->index[m] = j;
    a->chosen[m] = row;
    a->passive[j] = 1;
    return 0;
}

static void remove_at(active_set *a, int32_t position)
{
    const size_t after = (size_t)(a->factor.size - position - 1);
    a->passive[a->index[position]] = 0;
    a->x[a->index[position]] = 0.0;
    cholesky_remove(&a->factor, position);
    memmove(a->index + position, a->index + position + 1, after * sizeof *a->index);
    memmove(a->chosen + position, a->chosen + position + 1, after * sizeof *a->chosen);
}

void active_set_drop(active_set *a, int32_t j, uint8_t closed)
{
    for (int32_t k = a->factor.size - 1; k >= 0; --k) {
        if (a->index[k] == j) {
            remove_at(a, k);
        }
    }
    a->closed[j] = closed;
}

void active_set_reopen(active_set *a, uint8_t most)
{
    for (int32_t j = 0; j < a->columns.program->unknowns; ++j) {
        if (a->closed[j] <= most) {
            a->closed[j] = OPEN;
        }
    }
}

int active_set_start(active_set *a)
{
    const engine_program *p = a->columns.program;
    const int32_t free_ones = p->free;
    double largest = 0.0, explained = 0.0;
    memset(a->passive, 0, (size_t)p->unknowns);
    for (int32_t j = 0; j < free_ones; ++j) {
        const int failed = append(a, j);
        if (failed) {
            return failed;
        }
        a->gather[j] = p->rhs[j] + (p->extra_rhs ? p->extra_rhs[j] : 0.0);
        a->gather[j] *= a->columns.scale[j];
    }
    cholesky_forward(&a->factor, a->gather, a->next);
    for (int32_t f = 0; f < free_ones; ++f) {
        explained += a->next[f] * a->next[f];
    }
    for (int32_t j = 0; j < p->unknowns; ++j) {
        double square = a->columns.scale[j] > 0.0 ? 1.0 : 0.0;
        largest = fmax(largest, fabs(a->columns.target[j]));
        for (int32_t f = 0; f < free_ones; ++f) {
            a->gather[f] = a->row[f][j];
        }
        cholesky_forward(&a->factor, a->gather, a->next);
        for (int32_t f = 0; f < free_ones; ++f) {
            square -= a->next[f] * a->next[f];
        }
        a->length[j] = j >= free_ones && square > nothing_left ? sqrt(square) : 0.0;
    }
    a->reference = fmax(largest, p->target_norm);
    a->tolerance = 8.0 * rounding * a->reference;
    a->target = a->reference;
    if (p->target_norm > 0.0) {
        a->target = sqrt(fmax(p->target_norm * p->target_norm - explained, 0.0));
        a->target = fmax(a->target, half_digits * a->reference);
    }
    return 0;
}

/* Step from x towards the solution `next` on the passive set; unknowns that reach their bound on the way leave it. */
static void step(active_set *a)
{
    for (;;) {
        const int32_t m = a->factor.size;
        double share = 1.0;
        for (int32_t k = 0; k < m; ++k) {
            const int32_t j = a->index[k];
            if (j >= a->columns.program->free && a->next[k] <= 0.0) {
                share = fmin(share, a->x[j] / (a->x[j] - a->next[k]));
            }
        }
        for (int32_t k = 0; k < m; ++k) {
            a->x[a->index[k]] += share * (a->next[k] - a->x[a->index[k]]);
        }
        if (!(share < 1.0)) {
            break;
        }
        for (int32_t k = m - 1; k >= 0; --k) {
            const int32_t j = a->index[k];
            if (j >= a->columns.program->free && a->next[k] <= 0.0 && a->x[j] <= rounding * a->tolerance) {
                remove_at(a, k);
            }
        }
        ++a->iterations;
        cholesky_back(&a->factor, a->factor.z, a->next);
    }
    for (int32_t k = 0; k < a->factor.size; ++k) {
        a->x[a->index[k]] = a->next[k];
    }
}

int active_set_enter(active_set *a, int32_t j)
{
    const int failed = append(a, j);
    if (failed) {
        a->closed[j] = ALIKE;
        return failed;
    }
    cholesky_back(&a->factor, a->factor.z, a->next);
    if (!(a->next[a->factor.size - 1] > 0.0)) { /* rounding: its gradient was positive */
        active_set_drop(a, j, TRIED);
        return 1;
    }
    ++a->iterations;
    step(a);
    active_set_reopen(a, ALIKE);
    return 0;
}

static void differentiate(active_set *a)
{
    const int32_t n = a->columns.program->unknowns;
    for (int32_t k = 0; k < a->factor.size; ++k) {
        a->coefficient[k] = a->x[a->index[k]];
    }
    memcpy(a->gradient, a->columns.target, (size_t)n * sizeof *a->gradient);
    engine_kernels_in_use()->subtract_rows(n, a->factor.size, a->chosen, a->coefficient, a->gradient);
}

int32_t active_set_steepest(const active_set *a)
{
    int32_t best = -1;
    double most = 0.0;
    for (int32_t j = a->columns.program->free; j < a->columns.program->unknowns; ++j) {
        if (a->gradient[j] > a->tolerance && !a->passive[j] && a->closed[j] == OPEN &&
            a->gradient[j] > most * a->length[j] && a->length[j] > 0.0) {
            most = a->gradient[j] / a->length[j];
            best = j;
        }
    }
    return best;
}

/* Besides the steepest unknown, up to MOST peaks of the gradient that are half as steep: where many unknowns wait, one
 * gradient of all of them serves several. */
static int32_t peaks(const active_set *a, int32_t steepest, int32_t *peak)
{
    const int32_t first = a->columns.program->free, last = a->columns.program->unknowns - 1;
    const double least = 0.5 * a->gradient[steepest] / a->length[steepest];
    int32_t count = 0;
    for (int32_t j = first + 1; j < last && count < MOST; ++j) {
        const double g = a->gradient[j];
        if (g > a->tolerance && g >= a->gradient[j - 1] && g > a->gradient[j + 1] && g > least * a->length[j] &&
            !a->passive[j] && a->closed[j] == OPEN && a->length[j] > 0.0 && j != steepest) {
            peak[count++] = j;
        }
    }
    return count;
}

static double gradient_of(const active_set *a, int32_t j)
{
    double sum = a->columns.target[j];
    for (int32_t k = 0; k < a->factor.size; ++k) {
        sum -= a->x[a->index[k]] * a->chosen[k][j];
    }
    return sum;
}

int active_set_run(active_set *a)
{
    for (;;) {
        int32_t peak[MOST], count = 0;
        if (engine_asked()) {
            return -1;
        }
        differentiate(a);
        for (int failed = 1; failed > 0;) {
            const int32_t j = active_set_steepest(a);
            if (j < 0) {
                return 0;
            }
            if (a->iterations >= a->limit) {
                return 1;
            }
            count = peaks(a, j, peak);
            failed = active_set_enter(a, j);
            if (failed < 0) {
                return -1;
            }
        }
        for (int32_t k = 0; k < count; ++k) {
            const int32_t j = peak[k];
            if (!a->passive[j] && gradient_of(a, j) > fmax(a->tolerance, 0.5 * a->gradient[j]) &&
                active_set_enter(a, j) < 0) {
                return -1;
            }
        }
    }
}

int active_set_warm(active_set *a, const uint8_t *marked)
{
    for (int32_t j = a->columns.program->free; j < a->columns.program->unknowns; ++j) {
        if (marked[j] && a->length[j] > 0.0 && (engine_asked() || append(a, j) < 0)) {
            return -1;
        }
    }
    cholesky_back(&a->factor, a->factor.z, a->next);
    step(a); /* from x = 0: whatever is negative leaves at once */
    return 0;
}
