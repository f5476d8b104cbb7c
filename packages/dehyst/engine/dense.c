/* Dense evaluation in blocks of samples, alone or as a prefix whose last output drives the rest by events: with admissible
 * states play_{a+b} = play_a o play_b, so noise below the prefix's last threshold never reaches the rest. */
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "evaluator.h"

enum { ROOM = EVALUATOR_BLOCK + 8, LINE = 64 /* of the cache [byte] */ };

static int32_t lane_of(int32_t i) { return (i & ~7) | (7 - (i & 7)); }

int dense_make(engine_evaluator *e)
{
    dense *d = &e->dense;
    const size_t padded = ((size_t)e->n + 7) / 8 * 8;
    d->memory = malloc((3 * padded + 4 * ROOM) * sizeof *d->p + LINE); /* Windows has no aligned_alloc */
    if (d->memory == NULL) {
        return -1;
    }
    d->p = (double *)(((uintptr_t)d->memory + LINE - 1) / LINE * LINE);
    memset(d->p, 0, 3 * padded * sizeof *d->p);
    d->width = d->p + padded;
    d->weight = d->width + padded;
    d->room = d->weight + padded;
    for (int32_t i = 0; i < e->n; ++i) {
        d->width[lane_of(i)] = 2 * e->r[i];
        d->weight[lane_of(i)] = e->w[i];
    }
    return 0;
}

void dense_free(engine_evaluator *e) { free(e->dense.memory); }

void dense_start(engine_evaluator *e, int32_t operators, const double *z)
{
    dense *d = &e->dense;
    double moment = 0.0;
    for (int32_t i = 0; i < operators; ++i) {
        d->p[lane_of(i)] = z[i] + e->r[i];
        moment += e->w[i] * e->r[i];
    }
    d->operators = operators;
    d->base = e->offset - moment;
}

void dense_state(const engine_evaluator *e, double *z)
{
    for (int32_t i = 0; i < e->dense.operators; ++i) {
        z[i] = e->dense.p[lane_of(i)] - e->r[i];
    }
}

/* Centred samples; those that the core would reject repeat the one before, which moves no play. */
static int64_t centre(engine_evaluator *e, int64_t samples, const double *x, double *u)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    int64_t rejected = 0;
    double last = e->dense.p[lane_of(0)]; /* threshold 0: the sample before */
    for (int64_t k = 0; k < samples;) {
        const int64_t good = kernels->centre(samples - k, x + k, e->center, DEHYST_INPUT_LIMIT, u + k);
        last = good > 0 ? u[k + good - 1] : last;
        k += good;
        if (k < samples) {
            u[k++] = last;
            ++rejected;
        }
    }
    return rejected;
}

/* At most a block. */
static int64_t run_block(engine_evaluator *e, int64_t samples, const double *x, double *y)
{
    const engine_kernels *kernels = engine_kernels_in_use();
    const dense *d = &e->dense;
    double *const u = d->room, *const out = u + ROOM, *const moved = out + ROOM, *const rest = moved + ROOM;
    const int64_t rejected = centre(e, samples, x, u), eights = (samples + 7) / 8 * 8;
    for (int64_t k = samples; k < eights; ++k) {
        u[k] = u[samples - 1];
    }
    const engine_ahead ahead = {x + samples, y};
    const int hybrid = d->operators < e->n;
    double *const to = hybrid || eights > samples ? out : y;
    kernels->dense((d->operators + 7) / 8, d->p, d->width, d->weight, eights, u, to, d->base, hybrid ? moved : NULL, &ahead);
    if (!hybrid) {
        if (to != y) {
            memcpy(y, out, (size_t)samples * sizeof *y);
        }
        return rejected;
    }
    kernels->events(&e->rest, samples, moved, rest, e->r[d->operators - 1], 0);
    kernels->sum(samples, out, rest, y);
    return rejected;
}

int64_t dense_run(engine_evaluator *e, int64_t samples, const double *x, double *y)
{
    int64_t rejected = 0;
    for (int64_t k = 0; k < samples; k += EVALUATOR_BLOCK) {
        const int64_t part = samples - k < EVALUATOR_BLOCK ? samples - k : EVALUATOR_BLOCK;
        rejected += run_block(e, part, x + k, y + k);
    }
    return rejected;
}
