/* What the events of the Gram pass need, allocated; the sums set to zero. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "gram_boundaries.h"

static double *zeros(size_t count) { return calloc(count + 8, sizeof(double)); } /* pages of zeros cost nothing unread */

static int allocate(gram_machine *m)
{
    const size_t n = (size_t)m->n, columns = (size_t)m->columns;
    m->log_size = m->n < 256 ? 512 : 2 * m->n;
    m->scale = malloc(n * sizeof *m->scale);
    m->stack.segment = malloc((n + 2) * sizeof *m->stack.segment);
    m->frozen = calloc(n + 2, sizeof *m->frozen);
    m->log = malloc(((size_t)m->log_size + n + 4) * sizeof *m->log);
    m->frozen_at = zeros((n + 2) * columns);
    m->block = zeros(n + 8);
    m->sums.cross = zeros(gram_row(m->n + 1));
    m->sums.place = zeros((n + 1) * (size_t)m->stride);
    m->sums.kept = zeros((n + 1) * (size_t)m->stride);
    m->sums.lost = zeros((n + 1) * (size_t)m->stride);
    m->sums.total = zeros(columns);
    m->sums.total_lost = zeros(columns);
    m->total = zeros(columns);
    m->run_f = zeros(columns);
    m->run_df = zeros(columns);
    return m->scale == NULL || m->stack.segment == NULL || m->frozen == NULL || m->log == NULL ||
                   m->frozen_at == NULL || m->block == NULL || m->sums.cross == NULL || m->sums.place == NULL ||
                   m->sums.kept == NULL || m->sums.lost == NULL || m->sums.total == NULL ||
                   m->sums.total_lost == NULL || m->total == NULL || m->run_f == NULL || m->run_df == NULL
               ? -1
               : 0;
}

int gram_machine_start(gram_machine *m, int32_t n, const double *threshold, const double *state, int32_t dense,
                       int32_t targets)
{
    memset(m, 0, sizeof *m);
    m->n = n;
    m->dense = dense;
    m->targets = targets;
    m->columns = 1 + dense + (targets > 1 ? targets - 1 : 0);
    m->stride = GRAM_COLUMNS + m->columns;
    if (allocate(m) != 0 || gram_grid_start(&m->grid, n, threshold) != 0) {
        return -1;
    }
    const double *r = m->grid.r;
    for (int32_t i = 0; i < n; ++i) { /* a cell below rounding has no direction: 0 is as good as any */
        const double gap = i + 1 < n ? r[i + 1] - r[i] : 1.0;
        m->scale[i] = gap > 8 * DBL_EPSILON * r[n - 1] ? 1 / gap : 0.0;
    }
    m->scale[n - 1] = 1.0;
    gram_stack_from_state(&m->grid, &m->stack, state);
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
    free(m->sums.cross_kept);
    free(m->sums.place);
    free(m->sums.kept);
    free(m->sums.lost);
    free(m->sums.total);
    free(m->sums.total_lost);
    free(m->total);
    free(m->run_f);
    free(m->run_df);
    memset(m, 0, sizeof *m);
}

void gram_machine_clear(gram_machine *m)
{
    const size_t places = ((size_t)m->n + 1) * (size_t)m->stride * sizeof(double), columns = (size_t)m->columns * sizeof(double);
    memset(m->sums.cross, 0, gram_row(m->n + 1) * sizeof(double));
    free(m->sums.cross_kept);
    m->sums.cross_kept = NULL;
    memset(m->sums.place, 0, places);
    memset(m->sums.kept, 0, places);
    memset(m->sums.lost, 0, places);
    memset(m->sums.total, 0, columns);
    memset(m->sums.total_lost, 0, columns);
    m->sums.weight = 0.0;
}

/* All boundaries of the stack as it is, resting from now; nothing is pending. */
void gram_freeze_all(gram_machine *m)
{
    const stack *k = &m->stack;
    const int32_t n = m->n;
    m->outermost = k->segment[1].b < n;
    if (m->outermost) {
        gram_freeze(m, 0, gram_beside(m, n - 1, 0.0, gram_value(m, n - 1, m->grid.rest[n - 1], 0.0), 0.0));
    }
    for (int32_t q = 1; q < k->top; ++q) {
        const int32_t c = k->segment[q].b - 1;
        const double z = stack_play(&m->grid, k, q, c);
        const double v = gram_value(m, c, z, c + 1 < n ? stack_play(&m->grid, k, q - 1, c + 1) : 0.0);
        gram_freeze(m, q, gram_beside(m, c, k->segment[q].s, v, c + 1 < n ? k->segment[q - 1].s : 0.0));
    }
    m->last = k->segment[k->top].e;
    gram_begin_run(m);
}

/* Present states (n,). */
void gram_machine_state(const gram_machine *m, double *z)
{
    const stack *k = &m->stack;
    for (int32_t q = k->top, i = 0; q >= 0; --q) {
        const stack_segment *segment = &k->segment[q];
        const double e = q == k->top ? m->last : segment->e;
        for (; i < segment->b; ++i) {
            z[i] = q == 0 ? m->grid.rest[i] : e - segment->s * m->grid.r[i];
        }
    }
}
