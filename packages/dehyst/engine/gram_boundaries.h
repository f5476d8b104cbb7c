/* Boundaries that freeze, move again, and the log between. See gram.h. Compiled once per instruction set. */
#ifndef DEHYST_GRAM_BOUNDARIES_H
#define DEHYST_GRAM_BOUNDARIES_H

#include <stdlib.h>
#include <string.h>

#include "gram.h"
#include "lanes/lanes.h"

static inline double gram_value(const gram_machine *m, int32_t cell, double z, double z_next)
{
    return (cell + 1 < m->n ? z - z_next : z) * m->scale[cell];
}

/* The pair of one sample at which the boundary has value v. The last cell stands apart: see gram.h. */
static inline gram_pair gram_beside(const gram_machine *m, int32_t cell, double above, double v, double below)
{
    const gram_pair pair = {{cell + 1 < m->n ? above - v : above, v - below}, cell};
    return pair;
}

/* The run that the top of the stack begins. */
static inline void gram_begin_run(gram_machine *m)
{
    const stack *k = &m->stack;
    const stack_segment *top = &k->segment[k->top];
    m->cell = top->b - 1;
    m->sign = top->s;
    m->below = top->b < m->n ? k->segment[k->top - 1].s : 0.0;
    m->origin = top->s * m->grid.r[m->cell] + stack_below(&m->grid, k);
}

/* Columns after the first: up += a f + b h and down += c f + d h, then f goes to the total and both are cleared. */
static inline void gram_move_columns(gram_machine *m, double *up, double a, double b, double c, double d)
{
    double *down = up + m->stride, *f = m->run_f, *h = m->run_df;
    const int32_t targets = m->dense + 1;
    const lanes a8 = lanes_all(a), b8 = lanes_all(b), c8 = lanes_all(c), d8 = lanes_all(d), none = lanes_all(0.0);
    for (int32_t j = 1; j < targets && !m->only_targets; j += 8) {
        const lanes fj = lanes_load(f + j), hj = lanes_load(h + j);
        lanes_store(up + j, lanes_fma(b8, hj, lanes_fma(a8, fj, lanes_load(up + j))));
        lanes_store(down + j, lanes_fma(d8, hj, lanes_fma(c8, fj, lanes_load(down + j))));
        lanes_store(m->total + j, lanes_add(lanes_load(m->total + j), fj));
        lanes_store(f + j, none);
        lanes_store(h + j, none);
    }
    for (int32_t j = targets; j < m->columns; ++j) {
        up[j] += a * f[j] + b * h[j];
        down[j] += c * f[j] + d * h[j];
        m->total[j] += f[j];
        f[j] = h[j] = 0.0;
    }
}

/* Sums of the run go to the log; the run may go on afterwards with new sums. */
static inline void gram_end_run(gram_machine *m)
{
    const int32_t c = m->cell;
    const double s = m->sign, below = m->below, weight = m->run_weight, scale = m->scale[c];
    const double kept = c + 1 < m->n ? 1.0 : 0.0; /* does v enter the difference above? */
    const double s1 = m->run_d * scale, s2 = m->run_dd * scale * scale, f = m->run_f[0], moving = m->run_df[0] * scale;
    const double up = s * weight - kept * s1, down = s1 - below * weight;
    double *above = m->sums.place + c * m->stride, *under = above + m->stride;
    above[GRAM_COLUMNS] += s * f - kept * moving;
    under[GRAM_COLUMNS] += moving - below * f;
    m->total[0] += f;
    m->run_f[0] = m->run_df[0] = 0.0;
    if (m->columns > 1) {
        gram_move_columns(m, above + GRAM_COLUMNS, s, -kept * scale, -below, scale);
    }
    m->weight += weight;
    m->run_weight = m->run_d = m->run_dd = 0.0;
    if (m->only_targets) {
        return;
    }
    above[GRAM_SQUARE] += s * s * weight + kept * (s2 - 2 * s * s1);
    above[GRAM_ONES] += up;
    under[GRAM_SQUARE] += s2 - below * (s1 + down);
    under[GRAM_NEXT] += s * down - kept * (s2 - below * s1);
    under[GRAM_ONES] += down;
    m->log[m->logged++] = (gram_pair){{up, down}, c};
}

static inline void gram_freeze(gram_machine *m, int32_t q, gram_pair pair)
{
    m->frozen[q] = (gram_frozen){pair, m->logged, m->weight};
    double *at = m->frozen_at + (ptrdiff_t)q * m->columns;
    int32_t j = 1;
    at[0] = m->total[0];
    for (; j < 1 + m->dense; j += 8) {
        lanes_store(at + j, lanes_load(m->total + j));
    }
    for (; j < m->columns; ++j) {
        at[j] = m->total[j];
    }
}

static inline void gram_rested_columns(gram_machine *m, double *above, const double *then, double up, double down)
{
    double *under = above + m->stride;
    const int32_t targets = m->dense + 1;
    const lanes up8 = lanes_all(up), down8 = lanes_all(down);
    for (int32_t j = 1; j < targets && !m->only_targets; j += 8) {
        const lanes since = lanes_sub(lanes_load(m->total + j), lanes_load(then + j));
        lanes_store(above + j, lanes_fma(up8, since, lanes_load(above + j)));
        lanes_store(under + j, lanes_fma(down8, since, lanes_load(under + j)));
    }
    for (int32_t j = targets; j < m->columns; ++j) {
        const double since = m->total[j] - then[j];
        above[j] += up * since;
        under[j] += down * since;
    }
}

/* What a boundary at rest contributes with itself, with ones and with columns since it froze; returns its pair so far. */
static inline gram_pair gram_rested(gram_machine *m, int32_t q)
{
    const gram_frozen *frozen = &m->frozen[q];
    const int32_t c = frozen->beside.cell;
    const double up = frozen->beside.g[0], down = frozen->beside.g[1], weight = m->weight - frozen->since;
    const double up_so_far = up * weight, down_so_far = down * weight;
    double *above = m->sums.place + c * m->stride, *under = above + m->stride;
    const double *then = m->frozen_at + (ptrdiff_t)q * m->columns, since = m->total[0] - then[0];
    above[GRAM_COLUMNS] += up * since;
    under[GRAM_COLUMNS] += down * since;
    if (m->columns > 1) {
        gram_rested_columns(m, above + GRAM_COLUMNS, then, up, down);
    }
    if (!m->only_targets) {
        above[GRAM_SQUARE] += up * up_so_far;
        above[GRAM_ONES] += up_so_far;
        under[GRAM_SQUARE] += down * down_so_far;
        under[GRAM_NEXT] += up * down_so_far;
        under[GRAM_ONES] += down_so_far;
    }
    const gram_pair pair = {{up_so_far, down_so_far}, c};
    return pair;
}

/* A boundary moves again, or is swallowed: pair it with all that was logged meanwhile, then log it. */
static inline void gram_thaw(gram_machine *m, int32_t q)
{
    const gram_frozen frozen = m->frozen[q];
    const gram_pair rest = gram_rested(m, q);
    if (m->only_targets) {
        return;
    }
    const gram_two up = {frozen.beside.g[0], frozen.beside.g[0]}, down = {frozen.beside.g[1], frozen.beside.g[1]};
    double *above = m->sums.cross + gram_row(rest.cell), *under = m->sums.cross + gram_row(rest.cell + 1);
    for (const gram_pair *l = m->log + frozen.log, *end = m->log + m->logged; l < end; ++l) {
        gram_two *a = (gram_two *)(above + l->cell), *b = (gram_two *)(under + l->cell);
        *a += up * l->g;
        *b += down * l->g;
    }
    m->log[m->logged++] = rest;
}

/* Pair a boundary at rest with everything in the block, and add its own pair to it. */
static inline void gram_pair_with_block(gram_machine *m, gram_pair each, gram_pair rest)
{
    const int32_t c = each.cell;
    double *block = m->block, *above = m->sums.cross + gram_row(c), *under = m->sums.cross + gram_row(c + 1);
    const lanes up = lanes_all(each.g[0]), down = lanes_all(each.g[1]);
    for (int32_t p = 0; p <= c; p += 8) { /* rows are that long, and the block is 0 there */
        const lanes b = lanes_load(block + p);
        lanes_store(above + p, lanes_fma(up, b, lanes_load(above + p)));
        lanes_store(under + p, lanes_fma(down, b, lanes_load(under + p)));
    }
    *(gram_two *)(block + c) += rest.g;
}

/* Sums so far are put aside now and then, so that sums of very many samples round as little as those of few. What that costs
 * is a part of what the events since the last time did. */
static inline void gram_put_aside(gram_machine *m)
{
    gram_sums *s = &m->sums;
    const int64_t places = (m->n + 1) * m->stride, pairs = (int64_t)m->n * m->n, now = m->events + ++m->emptied;
    if (8 * (now - m->places_kept) >= places) {
        m->places_kept = now;
        for (int64_t i = 0; i < places; i += 8) {
            lanes_add_exactly(s->kept + i, s->lost + i, lanes_load(s->place + i));
            lanes_store(s->place + i, lanes_all(0.0));
        }
    }
    if (m->only_targets || 4 * (now - m->pairs_kept) < pairs) {
        return;
    }
    m->pairs_kept = now;
    const size_t size = gram_row(m->n + 1);
    if (s->cross_kept == NULL && (s->cross_kept = calloc(2 * size, sizeof *s->cross_kept)) == NULL) {
        return; /* then they round a little more */
    }
    for (size_t i = 0; i < size; i += 8) {
        lanes_add_exactly(s->cross_kept + i, s->cross_kept + size + i, lanes_load(s->cross + i));
        lanes_store(s->cross + i, lanes_all(0.0));
    }
}

/* Pair every boundary at rest with the log written since it froze, all at once; it rests on from now. */
static inline void gram_empty_log(gram_machine *m)
{
    gram_end_run(m);
    memset(m->block, 0, ((size_t)m->n + 1) * sizeof *m->block);
    const int32_t last = m->outermost ? 0 : 1;
    for (int32_t q = m->stack.top - 1, to = m->logged; q >= last; --q) {
        const gram_pair rest = gram_rested(m, q);
        if (m->only_targets) {
            continue;
        }
        for (; to > m->frozen[q].log; --to) {
            *(gram_two *)(m->block + m->log[to - 1].cell) += m->log[to - 1].g;
        }
        gram_pair_with_block(m, m->frozen[q].beside, rest);
    }
    gram_put_aside(m);
    m->logged = 0;
    m->sums.weight += m->weight;
    m->weight = 0.0;
    for (int32_t j = 0; j < m->columns; ++j) {
        gram_add_exactly(m->sums.total + j, m->sums.total_lost + j, m->total[j]);
        m->total[j] = 0.0;
    }
    for (int32_t q = last; q < m->stack.top; ++q) {
        gram_freeze(m, q, m->frozen[q].beside);
    }
}

/* A sample that ends the run: the stack takes it, boundaries freeze and thaw, and the next run begins with it. */
static inline void gram_event(gram_machine *m, double x)
{
    stack *k = &m->stack;
    const int32_t before = k->top;
    const gram_pair old = gram_beside(m, m->cell, m->sign, (m->last - m->origin) * m->scale[m->cell], m->below);
    gram_end_run(m);
    k->segment[before].e = m->last;
    stack_event(&m->grid, k, x);
    if (k->top > before) { /* turned */
        gram_freeze(m, before, old);
    }
    for (int32_t q = before - 1; q >= k->top; --q) {
        gram_thaw(m, q);
    }
    if (m->outermost && k->segment[1].b == m->n) {
        gram_thaw(m, 0);
        m->outermost = 0;
    }
    gram_begin_run(m);
}

#endif
