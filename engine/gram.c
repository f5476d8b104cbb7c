/* The streaming normal equations: interface. See engine.h for what, gram.h for how. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "engine.h"
#include "gram.h"

enum { CHUNK = 1024 }; /* samples at once: with a few columns they stay in the first cache */

struct engine_gram {
    int32_t n, targets;
    int only_targets;
    gram_machine machine;
    double *scratch;       /* (n,) */
    double *pairs;         /* (targets, targets) sums of target products, lower triangle */
    double *weighted;      /* (targets, CHUNK) */
    const double **column; /* (targets,) */
};

engine_gram *engine_gram_new(int32_t n, const double *threshold, const double *state, int32_t targets)
{
    engine_gram *g = calloc(1, sizeof *g);
    if (g == NULL) {
        return NULL;
    }
    const size_t m = (size_t)targets;
    g->n = n;
    g->targets = targets;
    g->scratch = malloc((size_t)n * sizeof *g->scratch);
    g->pairs = calloc(m * m + 1, sizeof *g->pairs);
    g->weighted = malloc((m * CHUNK + 1) * sizeof *g->weighted);
    g->column = malloc((m + 1) * sizeof *g->column);
    if (gram_machine_start(&g->machine, n, threshold, state, targets) != 0 || g->scratch == NULL || g->pairs == NULL ||
        g->weighted == NULL || g->column == NULL) {
        engine_gram_free(g);
        return NULL;
    }
    return g;
}

void engine_gram_free(engine_gram *g)
{
    if (g == NULL) {
        return;
    }
    gram_machine_free(&g->machine);
    free(g->scratch);
    free(g->pairs);
    free(g->weighted);
    free((void *)(uintptr_t)g->column);
    free(g);
}

int engine_gram_method(engine_gram *g, int32_t method)
{
    (void)g;
    return method == ENGINE_AUTO || method == ENGINE_EVENTS ? 0 : -1;
}

/* How many samples of a chunk can be used. */
static int64_t usable(const engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *x,
                      const double *const *targets, const double *weight, int64_t from)
{
    int64_t good = kernels->between(samples, x + from, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT);
    for (int32_t j = 0; j < g->targets; ++j) {
        good = kernels->between(good, targets[j] + from, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT);
    }
    return weight == NULL ? good : kernels->between(good, weight + from, 0.0, DEHYST_INPUT_LIMIT);
}

/* Columns of a chunk, multiplied by the weights, and their sums and products. */
static void prepare(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *const *targets,
                    const double *weight, int64_t from)
{
    for (int32_t i = 0; i < g->targets; ++i) {
        const double *f = targets[i] + from;
        g->column[i] = f;
        if (weight != NULL) {
            double *product = g->weighted + (ptrdiff_t)i * CHUNK;
            for (int64_t k = 0; k < samples; ++k) {
                product[k] = weight[from + k] * f[k];
            }
            g->column[i] = product;
        }
        for (int32_t j = 0; j <= i; ++j) {
            g->pairs[i * g->targets + j] += kernels->dot(samples, g->column[i], targets[j] + from);
        }
    }
}

int64_t engine_gram_add(engine_gram *g, int64_t samples, const double *x, const double *const *targets,
                        const double *weight)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    for (int64_t from = 0; from < samples;) {
        const int64_t count = samples - from < CHUNK ? samples - from : CHUNK;
        const int64_t good = usable(g, kernels, count, x, targets, weight, from);
        prepare(g, kernels, good, targets, weight, from);
        gram_run(&g->machine, kernels, good, x + from, weight == NULL ? NULL : weight + from, g->column);
        from += good;
        if (good < count) {
            return from;
        }
    }
    return samples;
}

int64_t engine_gram_skip(engine_gram *g, int64_t samples, const double *x)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    const int64_t good = kernels->between(samples, x, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT);
    gram_empty_log(&g->machine, kernels);
    gram_pass_by(&g->machine, kernels, good, x);
    return good;
}

/* What targets have to do with ones, cells and each other: the last rows of the lower triangle. */
static void write_targets(const engine_gram *g, double *out, ptrdiff_t stride)
{
    for (int32_t i = 0; i < g->targets; ++i) {
        double *row = out + (1 + g->n + i) * stride;
        row[0] = g->machine.sums.total[i];
        gram_finish_column(&g->machine, i, row + 1);
        memcpy(row + 1 + g->n, g->pairs + (ptrdiff_t)i * g->targets, (size_t)(i + 1) * sizeof *row);
    }
}

static void mirror(double *out, ptrdiff_t size)
{
    enum { TILE = 32 };
    for (ptrdiff_t top = 0; top < size; top += TILE) {
        for (ptrdiff_t left = 0; left <= top; left += TILE) {
            for (ptrdiff_t i = top; i < top + TILE && i < size; ++i) {
                for (ptrdiff_t j = left; j < left + TILE && j < i; ++j) {
                    out[j * size + i] = out[i * size + j];
                }
            }
        }
    }
}

void engine_gram_take(engine_gram *g, double *out)
{
    const ptrdiff_t size = 1 + (ptrdiff_t)g->n + g->targets;
    gram_empty_log(&g->machine, engine_kernels_in_use());
    if (out != NULL) {
        memset(out, 0, (size_t)(size * size) * sizeof *out);
        out[0] = g->machine.sums.weight;
        if (!g->machine.only_columns) {
            gram_finish_column(&g->machine, -1, out + 1);
            for (int32_t c = 0; c < g->n; ++c) {
                out[(1 + c) * size] = out[1 + c];
            }
            gram_finish_cells(&g->machine, g->scratch, out + size + 1, size);
        }
        write_targets(g, out, size);
        mirror(out, size);
    }
    gram_machine_clear(&g->machine);
    memset(g->pairs, 0, (size_t)g->targets * (size_t)g->targets * sizeof *g->pairs);
}

void engine_gram_only_targets(engine_gram *g, int only)
{
    gram_empty_log(&g->machine, engine_kernels_in_use());
    g->machine.only_columns = only != 0;
}

void engine_gram_state(const engine_gram *g, double *z)
{
    for (int32_t i = 0; i < g->n; ++i) {
        z[i] = gram_machine_play(&g->machine, i);
    }
}
