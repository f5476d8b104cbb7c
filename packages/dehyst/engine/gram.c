/* The streaming normal equations: interface. See engine.h for what, gram.h for how. */
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "gram.h"

/* The prefix and the events behind it, at these states; what is there already goes. 0, or -1 and nothing has changed. */
static int build(engine_gram *g, int32_t prefix, const double *state)
{
    const int32_t n = g->n;
    gram_dense dense;
    gram_machine machine;
    memset(&machine, 0, sizeof machine);
    if (gram_dense_start(&dense, prefix, n, g->r, state, g->targets) != 0 ||
        (prefix < n &&
         gram_machine_start(&machine, n - prefix, g->r + prefix, state + prefix, dense.width, g->targets) != 0)) {
        gram_dense_free(&dense);
        gram_machine_free(&machine);
        return -1;
    }
    g->events_before += g->machine.events;
    gram_dense_free(&g->dense);
    gram_machine_free(&g->machine);
    g->dense = dense;
    g->machine = machine;
    g->machine.only_targets = g->only_targets;
    g->events_then = 0;
    return 0;
}

engine_gram *engine_gram_new(int32_t n, const double *threshold, const double *state, int32_t targets)
{
    engine_gram *g = calloc(1, sizeof *g);
    if (g == NULL) {
        return NULL;
    }
    const size_t m = (size_t)targets, bytes = (size_t)n * sizeof(double);
    g->n = n;
    g->targets = targets;
    g->method = ENGINE_AUTO;
    g->empty = 1;
    g->r = malloc(bytes);
    g->state = malloc(bytes);
    g->pairs = calloc(2 * m * m + 1, sizeof *g->pairs);
    g->total = calloc(2 * m + 1, sizeof *g->total);
    g->weighted = malloc((m * GRAM_SAMPLES + 1) * sizeof *g->weighted);
    g->square = malloc((m + 1) * sizeof *g->square);
    g->column = malloc((m + 1) * sizeof *g->column);
    g->here = malloc((m + 1) * sizeof *g->here);
    if (g->r == NULL || g->state == NULL || g->pairs == NULL || g->total == NULL || g->weighted == NULL ||
        g->square == NULL || g->column == NULL || g->here == NULL) {
        engine_gram_free(g);
        return NULL;
    }
    memcpy(g->r, threshold, bytes);
    g->input = state[0];
    if (build(g, 0, state) != 0) {
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
    gram_dense_free(&g->dense);
    free(g->r);
    free(g->state);
    free(g->pairs);
    free(g->total);
    free(g->weighted);
    free(g->square);
    free((void *)(uintptr_t)g->column);
    free((void *)(uintptr_t)g->here);
    free(g->earlier);
    free(g);
}

static void clear(engine_gram *g)
{
    if (g->machine.n > 0) {
        gram_machine_clear(&g->machine);
    }
    gram_dense_clear(&g->dense);
    memset(g->pairs, 0, 2 * (size_t)g->targets * (size_t)g->targets * sizeof *g->pairs);
    memset(g->total, 0, 2 * (size_t)g->targets * sizeof *g->total);
    g->weight = 0.0;
}

void gram_finish_log(engine_gram *g)
{
    if (g->machine.n > 0) {
        engine_kernels_in_use()->gram_empty(&g->machine);
    }
}

/* Another prefix: sums so far are put aside, the states go on. */
int gram_change_prefix(engine_gram *g, int32_t prefix)
{
    const size_t size = 1 + (size_t)g->n + (size_t)g->targets;
    if (prefix == g->dense.prefix) {
        return 0;
    }
    gram_finish_log(g);
    if (!g->empty) {
        if (g->earlier == NULL && (g->earlier = calloc(size * size, sizeof *g->earlier)) == NULL) {
            return -1;
        }
        gram_sum_up(g, g->earlier);
        clear(g);
    }
    engine_gram_state(g, g->state);
    return build(g, prefix, g->state);
}

/* A prefix of a multiple of 4 operators, all of them if there are few. */
int engine_gram_method(engine_gram *g, int32_t method)
{
    if (method == ENGINE_DENSE) {
        method = (g->n + 3) / 4 * 4;
    }
    if (method > 0 && (method % 4 != 0 || method > GRAM_PREFIX_LIMIT || method >= g->n + 8)) {
        return -1;
    }
    if (method < ENGINE_AUTO) {
        return -1;
    }
    g->method = method;
    return method == ENGINE_AUTO ? 0 : gram_change_prefix(g, method);
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
    const size_t size = 1 + (size_t)g->n + (size_t)g->targets;
    gram_finish_log(g);
    if (out != NULL) {
        for (size_t i = 0; i < size; ++i) {
            if (g->earlier != NULL) {
                memcpy(out + i * size, g->earlier + i * size, (i + 1) * sizeof *out);
            } else {
                memset(out + i * size, 0, (i + 1) * sizeof *out);
            }
        }
        gram_sum_up(g, out);
        mirror(out, (ptrdiff_t)size);
    }
    free(g->earlier);
    g->earlier = NULL;
    g->empty = 1;
    clear(g);
}

/* What was added so far must keep its meaning: it is put aside, if there is something. */
void engine_gram_only_targets(engine_gram *g, int only)
{
    gram_finish_log(g);
    g->only_targets = only != 0;
    g->machine.only_targets = g->only_targets;
}

void engine_gram_state(const engine_gram *g, double *z)
{
    const int32_t prefix = g->dense.prefix;
    if (g->machine.n > 0) {
        gram_machine_state(&g->machine, z + prefix);
    }
    for (int32_t i = 1; i <= prefix && i < g->n; ++i) {
        z[i] = g->dense.z[i - 1];
    }
    z[0] = g->input;
}

int64_t engine_gram_events(const engine_gram *g) { return g->events_before + g->machine.events; }

int32_t engine_gram_prefix(const engine_gram *g) { return g->dense.prefix; }
