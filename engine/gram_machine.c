/* What the events of the Gram pass need, allocated; the sums set to zero. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "gram.h"

static double *zeros(size_t count) { return calloc(count + 1, sizeof(double)); } /* pages of zeros cost nothing unread */

static int allocate(gram_machine *m)
{
    const size_t n = (size_t)m->n, columns = (size_t)m->columns;
    m->log_size = m->n < 256 ? 512 : 2 * m->n;
    m->scale = malloc(n * sizeof *m->scale);
    m->stack.segment = malloc((n + 2) * sizeof *m->stack.segment);
    m->frozen = calloc(n + 2, sizeof *m->frozen);
    m->log = malloc(((size_t)m->log_size + n + 4) * sizeof *m->log);
    m->frozen_at = zeros((n + 2) * columns);
    m->block = zeros(n + 16);
    m->sums.cross = zeros(gram_row(m->n + 1));
    m->sums.diagonal = zeros(n + 1);
    m->sums.next = zeros(n + 1);
    m->sums.ones = zeros(n + 1);
    m->sums.with = zeros((n + 1) * columns);
    m->sums.total = zeros(columns);
    m->total = zeros(columns);
    m->run_f = zeros(columns);
    m->run_df = zeros(columns);
    return m->scale == NULL || m->stack.segment == NULL || m->frozen == NULL || m->log == NULL ||
                   m->frozen_at == NULL || m->block == NULL || m->sums.cross == NULL || m->sums.diagonal == NULL ||
                   m->sums.next == NULL || m->sums.ones == NULL || m->sums.with == NULL || m->sums.total == NULL || m->total == NULL ||
                   m->run_f == NULL || m->run_df == NULL
               ? -1
               : 0;
}

int gram_machine_start(gram_machine *m, int32_t n, const double *threshold, const double *state, int32_t columns)
{
    memset(m, 0, sizeof *m);
    m->n = n;
    m->columns = columns;
    if (allocate(m) != 0 || gram_grid_start(&m->grid, n, threshold) != 0) {
        return -1;
    }
    const double *r = m->grid.r;
    for (int32_t i = 0; i < n; ++i) { /* a cell below rounding has no direction: 0 is as good as any */
        const double gap = i + 1 < n ? r[i + 1] - r[i] : 1.0;
        m->scale[i] = gap > 8 * DBL_EPSILON * r[n - 1] ? 1 / gap : 0.0;
    }
    m->scale[n - 1] = 1.0;
    gram_stack_from_state(&m->grid, &m->stack, (double *)(uintptr_t)m->grid.rest, state);
    gram_freeze_all(m);
    return 0;
}

void gram_machine_free(gram_machine *m)
{
    gram_grid_free(&m->grid);
    free(m->scale);
    free(m->stack.segment);
    free(m->frozen);
    free(m->frozen_at);
    free(m->log);
    free(m->block);
    free(m->sums.cross);
    free(m->sums.diagonal);
    free(m->sums.next);
    free(m->sums.ones);
    free(m->sums.with);
    free(m->sums.total);
    free(m->total);
    free(m->run_f);
    free(m->run_df);
    memset(m, 0, sizeof *m);
}

void gram_machine_clear(gram_machine *m)
{
    const size_t n = (size_t)m->n + 1;
    memset(m->sums.cross, 0, gram_row(m->n + 1) * sizeof(double));
    memset(m->sums.diagonal, 0, n * sizeof(double));
    memset(m->sums.next, 0, n * sizeof(double));
    memset(m->sums.ones, 0, n * sizeof(double));
    memset(m->sums.with, 0, n * (size_t)m->columns * sizeof(double));
    memset(m->sums.total, 0, (size_t)m->columns * sizeof(double));
    m->sums.weight = 0.0;
}

double gram_machine_play(const gram_machine *m, int32_t i)
{
    int32_t q = m->stack.top;
    if (i == 0) {
        return m->last;
    }
    while (q > 0 && m->stack.segment[q].b <= i) {
        --q;
    }
    return q == m->stack.top ? m->last - m->stack.segment[q].s * m->grid.r[i] : stack_play(&m->grid, &m->stack, q, i);
}
