/* Boundaries that freeze, move again, and the log between. See gram.h. */
#include <string.h>

#include "gram.h"

static double boundary(const gram_machine *m, int32_t cell, double z, double z_next)
{
    return (cell + 1 < m->n ? z - z_next : z) * m->scale[cell];
}

/* The pair of one sample at which the boundary has value v. The last cell stands apart: see gram.h. */
static gram_pair beside(const gram_machine *m, int32_t cell, double above, double v, double below)
{
    const gram_pair pair = {cell + 1 < m->n ? above - v : above, v - below, cell};
    return pair;
}

static void write_log(gram_machine *m, gram_pair pair)
{
    m->log[m->logged++] = pair;
    m->sums.ones[pair.cell] += pair.up;
    m->sums.ones[pair.cell + 1] += pair.down;
}

/* The run that the top of the stack begins. */
void gram_begin_run(gram_machine *m)
{
    const stack *k = &m->stack;
    const stack_segment *top = &k->segment[k->top];
    m->cell = top->b - 1;
    m->sign = top->s;
    m->below = top->b < m->n ? k->segment[k->top - 1].s : 0.0;
    m->origin = top->s * m->grid.r[m->cell] + stack_below(&m->grid, k);
}

/* Sums of the run go to the log; the run may go on afterwards with new sums. */
void gram_end_run(gram_machine *m)
{
    if (m->run_weight == 0.0) {
        return;
    }
    const int32_t c = m->cell, columns = m->columns;
    const double s = m->sign, below = m->below, weight = m->run_weight;
    const double s1 = m->run_d * m->scale[c], s2 = m->run_dd * m->scale[c] * m->scale[c];
    const double kept = c + 1 < m->n ? 1.0 : 0.0; /* does v enter the difference above? */
    double *up = m->sums.with + (size_t)c * (size_t)columns;
    for (int32_t j = 0; j < columns; ++j) {
        const double moving = m->run_df[j] * m->scale[c];
        up[j] += s * m->run_f[j] - kept * moving;
        up[columns + j] += moving - below * m->run_f[j];
        m->total[j] += m->run_f[j];
        m->run_f[j] = m->run_df[j] = 0.0;
    }
    m->weight += weight;
    m->run_weight = m->run_d = m->run_dd = 0.0;
    if (m->only_columns) {
        return;
    }
    const gram_pair pair = {s * weight - kept * s1, s1 - below * weight, c};
    write_log(m, pair);
    m->sums.diagonal[c] += s * s * weight + kept * (s2 - 2 * s * s1);
    m->sums.next[c + 1] += s * (s1 - below * weight) - kept * (s2 - below * s1);
    m->sums.diagonal[c + 1] += s2 - below * (2 * s1 - below * weight);
}

static void freeze(gram_machine *m, int32_t q, gram_pair pair)
{
    m->frozen[q] = (gram_frozen){pair, m->logged, m->weight};
    if (m->columns > 0) {
        const size_t columns = (size_t)m->columns;
        memcpy(m->frozen_at + (size_t)q * columns, m->total, columns * sizeof *m->total);
    }
}

/* What a boundary at rest contributes with itself, with ones and with columns since it froze; returns its pair so far. */
static gram_pair rested(gram_machine *m, int32_t q)
{
    const gram_frozen *f = &m->frozen[q];
    const int32_t c = f->beside.cell, columns = m->columns;
    const double up = f->beside.up, down = f->beside.down, weight = m->weight - f->since;
    double *with = m->sums.with + (size_t)c * (size_t)columns;
    const double *then = m->frozen_at + (size_t)q * (size_t)columns;
    for (int32_t j = 0; j < columns; ++j) {
        const double since = m->total[j] - then[j];
        with[j] += up * since;
        with[columns + j] += down * since;
    }
    if (!m->only_columns) {
        m->sums.diagonal[c] += up * up * weight;
        m->sums.next[c + 1] += up * down * weight;
        m->sums.diagonal[c + 1] += down * down * weight;
    }
    const gram_pair pair = {up * weight, down * weight, c};
    return pair;
}

/* A boundary moves again, or is swallowed: pair it with all that was logged meanwhile, then log it. */
static void thaw(gram_machine *m, int32_t q)
{
    const gram_pair rest = rested(m, q), each = m->frozen[q].beside;
    if (m->only_columns) {
        return;
    }
    double *up = m->sums.cross + gram_row(each.cell), *down = m->sums.cross + gram_row(each.cell + 1);
    for (const gram_pair *l = m->log + m->frozen[q].log, *end = m->log + m->logged; l < end; ++l) {
        const int32_t c = l->cell;
        up[c] += each.up * l->up;
        up[c + 1] += each.up * l->down;
        down[c] += each.down * l->up;
        down[c + 1] += each.down * l->down;
    }
    write_log(m, rest);
}

/* Pair a boundary at rest with everything in the block, and add its own pair to it. */
static void pair_with_block(gram_machine *m, const engine_kernels *kernels, gram_pair each, gram_pair rest)
{
    const int32_t c = each.cell;
    double *block = m->block, *rows = m->sums.cross;
    kernels->add_to_rows(c + 1, block, each.up, rows + gram_row(c), each.down, rows + gram_row(c + 1));
    block[c] += rest.up;
    block[c + 1] += rest.down;
    m->sums.ones[c] += rest.up;
    m->sums.ones[c + 1] += rest.down;
}

/* Pair every boundary at rest with the log written since it froze, all at once; it rests on from now. */
void gram_empty_log(gram_machine *m, const engine_kernels *kernels)
{
    gram_end_run(m);
    memset(m->block, 0, ((size_t)m->n + 1) * sizeof *m->block);
    const int32_t last = m->outermost ? 0 : 1;
    for (int32_t q = m->stack.top - 1, to = m->logged; q >= last; --q) {
        const gram_pair rest = rested(m, q);
        if (m->only_columns) {
            continue;
        }
        for (; to > m->frozen[q].log; --to) {
            const gram_pair *l = &m->log[to - 1];
            m->block[l->cell] += l->up;
            m->block[l->cell + 1] += l->down;
        }
        pair_with_block(m, kernels, m->frozen[q].beside, rest);
    }
    m->logged = 0;
    m->sums.weight += m->weight;
    m->weight = 0.0;
    for (int32_t j = 0; j < m->columns; ++j) {
        m->sums.total[j] += m->total[j];
        m->total[j] = 0.0;
    }
    for (int32_t q = last; q < m->stack.top; ++q) {
        freeze(m, q, m->frozen[q].beside);
    }
}

/* All boundaries of the stack as it is, resting from now; nothing is pending. */
void gram_freeze_all(gram_machine *m)
{
    const stack *k = &m->stack;
    const int32_t n = m->n;
    m->outermost = k->segment[1].b < n;
    if (m->outermost) {
        freeze(m, 0, beside(m, n - 1, 0.0, boundary(m, n - 1, m->grid.rest[n - 1], 0.0), 0.0));
    }
    for (int32_t q = 1; q < k->top; ++q) {
        const int32_t c = k->segment[q].b - 1;
        const double z = stack_play(&m->grid, k, q, c);
        const double v = boundary(m, c, z, c + 1 < n ? stack_play(&m->grid, k, q - 1, c + 1) : 0.0);
        freeze(m, q, beside(m, c, k->segment[q].s, v, c + 1 < n ? k->segment[q - 1].s : 0.0));
    }
    m->last = k->segment[k->top].e;
    gram_begin_run(m);
}

/* A sample that ends the run: the stack takes it, boundaries freeze and thaw, and the next run begins with it. */
void gram_event(gram_machine *m, double x)
{
    stack *k = &m->stack;
    const int32_t before = k->top;
    gram_end_run(m);
    const gram_pair old = beside(m, m->cell, m->sign, (m->last - m->origin) * m->scale[m->cell], m->below);
    k->segment[before].e = m->last;
    stack_event(&m->grid, k, x);
    if (k->top > before) { /* turned */
        freeze(m, before, old);
    }
    for (int32_t q = before - 1; q >= k->top; --q) {
        thaw(m, q);
    }
    if (m->outermost && k->segment[1].b == m->n) {
        thaw(m, 0);
        m->outermost = 0;
    }
    gram_begin_run(m);
}
