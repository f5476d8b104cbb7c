/* All sums in one matrix. */
#include "gram.h"

static double total_of(const gram_machine *m, int32_t column)
{
    return m->sums.total[column] + m->sums.total_lost[column];
}

/* Cells of the dense prefix with ones and each other, rows 1 .. prefix of out, and with the cells behind them. */
static void add_dense(const engine_gram *g, double *out, ptrdiff_t size)
{
    const gram_dense *d = &g->dense;
    const int32_t prefix = d->prefix, width = d->width, cells = prefix < g->n ? prefix : g->n;
    for (int32_t i = 0; i < cells && !g->only_targets; ++i) {
        double *row = out + (1 + i) * size;
        const double *products = d->products + (ptrdiff_t)i * width, *lost = products + (ptrdiff_t)width * width;
        row[0] += g->machine.n > 0 ? total_of(&g->machine, 1 + i) : d->ones[i] + d->ones[width + i];
        for (int32_t j = 0; j <= i; ++j) {
            row[1 + j] += products[j] + lost[j];
        }
        if (g->machine.n > 0) {
            gram_finish_column(&g->machine, GRAM_COLUMNS + 1 + i, out + (1 + prefix) * size + 1 + i, size);
        }
    }
}

/* What targets have to do with ones, cells and each other: the last rows. */
static void add_targets(const engine_gram *g, double *out, ptrdiff_t size)
{
    const int32_t prefix = g->dense.prefix, width = g->dense.width, cells = prefix < g->n ? prefix : g->n;
    for (int32_t t = 0; t < g->targets; ++t) {
        double *row = out + (1 + g->n + t) * size;
        row[0] += g->total[t] + g->total[g->targets + t];
        for (int32_t i = 0; i < cells; ++i) {
            const double *with = g->dense.with + t * (ptrdiff_t)width + i;
            row[1 + i] += with[0] + with[(ptrdiff_t)g->targets * width];
        }
        if (g->machine.n > 0) {
            const int32_t column = gram_column_of(&g->machine, t);
            row[0] += total_of(&g->machine, column);
            gram_finish_column(&g->machine, GRAM_COLUMNS + column, row + 1 + prefix, 1);
        }
        for (int32_t j = 0; j <= t; ++j) {
            const double *pair = g->pairs + t * (ptrdiff_t)g->targets + j;
            row[1 + g->n + j] += pair[0] + pair[(ptrdiff_t)g->targets * g->targets];
        }
    }
}

/* Sums of pairs that were put aside come back. */
static void settle(gram_machine *m)
{
    const double *kept = m->sums.cross_kept;
    const size_t size = gram_row(m->n + 1);
    for (size_t i = 0; i < size && kept != NULL; ++i) {
        m->sums.cross[i] = kept[i] + (kept[size + i] + m->sums.cross[i]);
    }
}

/* Adds the present sums to the lower triangle of out (size, size), size = 1 + n + targets. The log must be empty;
 * the sums must be cleared afterwards. */
void gram_sum_up(engine_gram *g, double *out)
{
    const ptrdiff_t size = 1 + (ptrdiff_t)g->n + g->targets, cells = 1 + (ptrdiff_t)g->dense.prefix;
    out[0] += g->weight + (g->machine.n > 0 ? g->machine.sums.weight : 0.0);
    add_dense(g, out, size);
    if (g->machine.n > 0 && !g->only_targets) {
        settle(&g->machine);
        gram_finish_column(&g->machine, GRAM_ONES, out + cells * size, size);
        gram_finish_cells(&g->machine, g->state, out + cells * size + cells, size);
    }
    add_targets(g, out, size);
}
