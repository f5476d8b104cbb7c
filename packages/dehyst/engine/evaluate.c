/* y = offset + sum_i w_i play_{r_i}[x - center] of long signals: the interface, and blocks for signals in place. */
#include "engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "evaluator.h"
#include "patience.h"

/* Copies of thresholds, weights and states with an operator of threshold 0 and weight 0 in front if there is none. */
static int copy_operators(engine_evaluator *e, int32_t n, const double *r, const double *w, const double *z)
{
    e->front = r[0] > 0 ? 1 : 0;
    e->n = n + e->front;
    const size_t size = (size_t)e->n;
    e->r = malloc(3 * size * sizeof *e->r);
    if (e->r == NULL) {
        return -1;
    }
    e->w = e->r + size;
    e->z = e->w + size;
    e->r[0] = 0.0;
    e->w[0] = 0.0;
    e->z[0] = z[0];
    memcpy(e->r + e->front, r, (size_t)n * sizeof *r);
    memcpy(e->w + e->front, w, (size_t)n * sizeof *w);
    memcpy(e->z + e->front, z, (size_t)n * sizeof *z);
    return 0;
}

engine_evaluator *engine_evaluator_new(int32_t n, const double *threshold, const double *weight, double center,
                                       double offset, const double *state)
{
    engine_evaluator *e = calloc(1, sizeof *e);
    if (e == NULL) {
        return NULL;
    }
    e->center = center;
    e->offset = offset;
    /* |x - center| below it means that the core accepts x. */
    e->limit = fmax(DEHYST_INPUT_LIMIT * (1 - 0x1p-40) - fabs(center), 0.0);
    if (copy_operators(e, n, threshold, weight, state) != 0 || machine_make(&e->events, e->n, e->r, e->w, e->limit) != 0) {
        engine_evaluator_free(e);
        return NULL;
    }
    e->events.offset = offset;
    machine_start(&e->events, e->z);
    choice_start(e, 1);
    return e;
}

void engine_evaluator_free(engine_evaluator *e)
{
    if (e != NULL) {
        machine_free(&e->events);
        machine_free(&e->rest);
        dense_free(e);
        free(e->r);
        free(e);
    }
}

int engine_evaluator_method(engine_evaluator *e, int32_t method)
{
    if (method == ENGINE_AUTO) {
        choice_start(e, 1);
        return 0;
    }
    const int prefix = method > 0 && method % 8 == 0 && method < e->n;
    if ((method != ENGINE_EVENTS && method != ENGINE_DENSE && !prefix) || evaluator_switch(e, method) != 0) {
        return -1;
    }
    choice_start(e, 0);
    return 0;
}

/* By the method in use. */
static int64_t run_method(engine_evaluator *e, int64_t samples, const double *x, double *y, int stream)
{
    return e->method == ENGINE_EVENTS ? engine_kernels_in_use()->events(&e->events, samples, x, y, e->center, stream)
                                      : dense_run(e, samples, x, y);
}

enum { PART = 64 * EVALUATOR_BLOCK }; /* samples between two questions whether to go on */

/* Outputs of samples in memory that y does not overlap. Decisions fall on the same samples however a signal is cut. */
static int64_t run_apart(engine_evaluator *e, int64_t samples, const double *x, double *y)
{
    const int stream = samples >= ENGINE_STREAM_SAMPLES;
    int64_t rejected = 0;
    for (int64_t k = 0; k < samples && !(k > 0 && engine_asked());) {
        const int64_t rest = samples - k < PART ? samples - k : PART;
        const int64_t part = e->choice.automatic && e->choice.left < rest ? e->choice.left : rest;
        rejected += run_method(e, part, x + k, y + k, stream);
        k += part;
        if (e->choice.automatic) {
            e->choice.left -= part;
            if (e->choice.left == 0) {
                choice_decide(e);
            }
        }
    }
    if (stream) {
        engine_kernels_in_use()->fence();
    }
    return rejected;
}

int64_t engine_evaluator_run(engine_evaluator *e, int64_t samples, const double *x, double *y)
{
    const uintptr_t from = (uintptr_t)x, to = (uintptr_t)y, bytes = (uintptr_t)samples * sizeof *x;
    const int apart = from + bytes <= to || to + bytes <= from;
    if (apart) {
        return run_apart(e, samples, x, y);
    }
    int64_t rejected = 0;
    for (int64_t k = 0; k < samples && !(k % PART == 0 && k > 0 && engine_asked()); k += EVALUATOR_BLOCK) {
        double block[EVALUATOR_BLOCK];
        const int64_t part = samples - k < EVALUATOR_BLOCK ? samples - k : EVALUATOR_BLOCK;
        memcpy(block, x + k, (size_t)part * sizeof *x);
        rejected += run_apart(e, part, block, y + k);
    }
    return rejected;
}

void engine_evaluator_state(const engine_evaluator *e, double *z)
{
    evaluator_state(e, e->z);
    memcpy(z, e->z + e->front, (size_t)(e->n - e->front) * sizeof *z);
}

int64_t engine_evaluator_events(const engine_evaluator *e)
{
    return e->events.events + e->rest_events + e->rest.events;
}
