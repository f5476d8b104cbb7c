/* The streaming normal equations: samples, in chunks that stay in the first cache. */
#include "dehyst.h"
#include "gram.h"
#include "patience.h"

/* Targets of a chunk and their squares; returns how many samples have usable ones. A square that is too large or not a
 * number says where to look, so that good data are read once. Without a prefix the first target is left to the runs. */
static int64_t plain_targets(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *const *targets,
                             int64_t from)
{
    const double limit = DEHYST_INPUT_LIMIT;
    int64_t good = samples;
    for (int32_t t = 0; t < g->targets; ++t) {
        const double *f = targets[t] + from;
        g->column[t] = f;
        if (t == 0 && g->dense.prefix == 0) {
            continue;
        }
        g->square[t] = kernels->dot(samples, f, f);
        if (!(g->square[t] <= limit * limit)) {
            good = kernels->between(good, f, -limit, limit);
        }
    }
    return good;
}

/* Targets of a chunk times their weights; returns how many samples have usable ones. */
static int64_t weighted_targets(engine_gram *g, const engine_kernels *kernels, int64_t samples,
                                const double *const *targets, const double *weight, int64_t from)
{
    int64_t good = kernels->between(samples, weight + from, 0.0, DEHYST_INPUT_LIMIT);
    for (int32_t t = 0; t < g->targets; ++t) {
        const double *f = targets[t] + from;
        good = kernels->between(good, f, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT);
        double *product = g->weighted + (ptrdiff_t)t * GRAM_SAMPLES;
        for (int64_t k = 0; k < good; ++k) {
            product[k] = weight[from + k] * f[k];
        }
        g->column[t] = product;
    }
    return good;
}

/* Products of targets with each other. The squares of the first one and of the others may be known. */
static void add_pairs(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *const *targets,
                      int64_t from, int first, int squares)
{
    for (int32_t i = 0; i < g->targets; ++i) {
        double *row = g->pairs + (ptrdiff_t)i * g->targets;
        for (int32_t j = 0; j <= i; ++j) {
            const int known = i == j && (i == 0 ? first : squares);
            gram_add_exactly(row + j, row + j + (ptrdiff_t)g->targets * g->targets,
                             known ? g->square[i] : kernels->dot(samples, g->column[i], targets[j] + from));
        }
    }
}

/* What only machines sum otherwise. */
static void add_totals(engine_gram *g, int64_t samples, const double *weight, const double *const *f)
{
    double sum = weight == NULL ? (double)samples : 0.0;
    for (int64_t k = 0; k < samples && weight != NULL; ++k) {
        sum += weight[k];
    }
    g->weight += sum;
    for (int32_t t = 0; t < g->targets; ++t) {
        sum = 0.0;
        for (int64_t k = 0; k < samples; ++k) {
            sum += f[t][k];
        }
        gram_add_exactly(g->total + t, g->total + g->targets + t, sum);
    }
}

/* A prefix written out, and events behind it. f are the targets, times weight if there is one. */
static void add_dense(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *x, const double *weight,
                      const double *const *f)
{
    gram_dense *d = &g->dense;
    const int32_t prefix = d->prefix, width = d->width;
    const double *rows = d->rows;
    kernels->cells(samples, prefix, d->r, d->z, x, d->rows, d->drive);
    if (weight != NULL) {
        for (int64_t k = 0; k < samples * width; ++k) {
            d->weighted[k] = weight[k / width] * d->rows[k];
        }
        rows = d->weighted;
    }
    const ptrdiff_t offset = (ptrdiff_t)g->targets * width; /* to what rounding took away */
    int32_t t = 0;
    if (!g->only_targets) {
        kernels->products(samples, prefix, rows, d->rows, g->targets > 0 ? f[t++] : NULL, d->products, d->with, offset);
    }
    for (; t < g->targets; ++t) {
        kernels->row_sums(samples, width, d->rows, f[t], d->with + (ptrdiff_t)t * width, offset);
    }
    if (g->machine.n > 0) {
        kernels->gram_run(&g->machine, samples, d->drive, weight, f, rows);
    } else {
        kernels->row_sums(samples, width, rows, NULL, d->ones, width);
        add_totals(g, samples, weight, f);
    }
}

/* Samples of a chunk whose targets are usable; returns how many were taken. */
static int64_t add_chunk(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *x,
                         const double *weight)
{
    if (g->dense.prefix == 0) {
        const int64_t taken = kernels->gram_run(&g->machine, samples, x, weight, g->column, NULL);
        g->square[0] = g->machine.squares;
        return taken;
    }
    const double limit = DEHYST_INPUT_LIMIT;
    const int64_t good = kernels->dot(samples, x, x) <= limit * limit ? samples : kernels->between(samples, x, -limit, limit);
    for (int64_t from = 0; from < good; from += GRAM_DENSE_SAMPLES) {
        const int64_t count = good - from < GRAM_DENSE_SAMPLES ? good - from : GRAM_DENSE_SAMPLES;
        for (int32_t t = 0; t < g->targets; ++t) {
            g->here[t] = g->column[t] + from;
        }
        add_dense(g, kernels, count, x + from, weight == NULL ? NULL : weight + from, g->here);
    }
    return good;
}

int64_t engine_gram_add(engine_gram *g, int64_t samples, const double *x, const double *const *targets,
                        const double *weight)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    for (int64_t from = 0; from < samples;) {
        if (from > 0 && engine_asked()) {
            return from;
        }
        const int64_t count = samples - from < GRAM_SAMPLES ? samples - from : GRAM_SAMPLES;
        gram_change_prefix(g, gram_choose(g, kernels, samples - from, x + from));
        const int64_t good = weight == NULL ? plain_targets(g, kernels, count, targets, from)
                                            : weighted_targets(g, kernels, count, targets, weight, from);
        const int64_t taken = add_chunk(g, kernels, good, x + from, weight == NULL ? NULL : weight + from);
        const int known = weight == NULL && taken == count;
        add_pairs(g, kernels, taken, targets, from, known || (weight == NULL && g->dense.prefix == 0), known);
        g->empty = g->empty && taken == 0;
        if ((g->until_empty -= taken) <= 0) {
            gram_finish_log(g);
            g->until_empty = GRAM_EMPTY;
        }
        from += taken;
        g->until_choice -= taken;
        g->since_choice += taken;
        g->input = from > 0 ? x[from - 1] : g->input;
        if (taken < count) {
            return from;
        }
    }
    return samples;
}

int64_t engine_gram_skip(engine_gram *g, int64_t samples, const double *x)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    const int64_t good = kernels->between(samples, x, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT);
    gram_dense *d = &g->dense;
    gram_finish_log(g);
    int64_t left = ENGINE_BETWEEN;
    for (int64_t from = 0; from < good && !engine_stops(&left, d->prefix == 0 ? ENGINE_BETWEEN : 1 << 16);) {
        const int64_t most = d->prefix == 0 ? GRAM_EMPTY : GRAM_DENSE_SAMPLES, count = good - from < most ? good - from : most;
        const double *drive = x + from;
        if (d->prefix > 0) {
            kernels->cells(count, d->prefix, d->r, d->z, x + from, d->rows, d->drive);
            drive = d->drive;
        }
        if (g->machine.n > 0) {
            kernels->gram_pass_by(&g->machine, count, drive);
        }
        from += count;
        g->input = x[from - 1];
    }
    if (g->machine.n > 0) {
        gram_freeze_all(&g->machine);
    }
    return good;
}
