/* What the page asks of the C code, compiled to WebAssembly: models as the robot runs them (core/), sums and programs of
 * a fit (engine/). Memory is the caller's, by page_alloc; arrays are those of JavaScript. */
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "engine.h"
#include "signal.h"

#define PAGE(name) __attribute__((export_name(#name), used))

PAGE(page_alloc) void *page_alloc(uint32_t bytes) { return malloc(bytes); }
PAGE(page_free) void page_free(void *memory) { free(memory); }

/* ---- y = after(offset + sum w_i play_{r_i}[before(x) - center]), one sample after the other, as exported code runs it */
typedef struct page_model {
    dehyst_model model;
    dehyst_state state;
    double *threshold, *weight, *slope, *loading, *start; /* (n,) each, in one block behind this one */
} page_model;

/* A map of `points` breakpoints u and values v, one behind the other in `from`, copied to `room`. */
static dehyst_map map_of(int32_t points, const double *from, double *room)
{
    const dehyst_map none = {0, NULL, NULL};
    if (points == 0) {
        return none;
    }
    memcpy(room, from, 2 * (size_t)points * sizeof(double));
    const dehyst_map map = {points, room, room + points};
    return map;
}

/* before: breakpoints, then values, of a map with `points_before` points; after: likewise. No points: no map. */
PAGE(page_model_new) page_model *page_model_new(int32_t n, const double *threshold, const double *weight, double center,
                                                double offset, const double *start, int32_t points_before,
                                                const double *before, int32_t points_after, const double *after)
{
    const size_t size = (size_t)n, points = (size_t)points_before + (size_t)points_after;
    page_model *m = calloc(1, sizeof *m + (6 * size + 2 * points) * sizeof(double));
    if (m == NULL) {
        return NULL;
    }
    double *room = (double *)(void *)(m + 1);
    m->threshold = room;
    m->weight = room + size;
    m->slope = room + 2 * size;
    m->loading = room + 3 * size;
    m->start = room + 4 * size;
    m->state.z = room + 5 * size;
    memcpy(m->threshold, threshold, size * sizeof(double));
    memcpy(m->weight, weight, size * sizeof(double));
    memcpy(m->start, start, size * sizeof(double));
    dehyst_pi_tables(n, m->threshold, m->weight, m->slope, m->loading);
    m->model.before = map_of(points_before, before, room + 6 * size);
    m->model.hysteresis = (dehyst_pi){n, m->threshold, m->slope, m->loading, center, offset};
    m->model.after = map_of(points_after, after, room + 6 * size + 2 * (size_t)points_before);
    dehyst_model_reset(&m->model, &m->state, m->start);
    return m;
}

/* Breakpoints and values of the inverse of a map, whose breakpoints rise. */
static void turned(const dehyst_map *map, double *out)
{
    const int32_t n = map->n;
    const int falls = n > 0 && map->v[0] > map->v[n - 1];
    for (int32_t k = 0; k < n; k++) {
        const int32_t from = falls ? n - 1 - k : k;
        out[k] = map->v[from];
        out[n + k] = map->u[from];
    }
}

/* The closed inverse of a model from the states that it starts with, or a null pointer if there is none. */
PAGE(page_model_inverse) page_model *page_model_inverse(const page_model *m)
{
    const dehyst_model *of = &m->model;
    const int32_t n = of->hysteresis.n;
    const size_t points = (size_t)of->before.n + (size_t)of->after.n;
    double *room = malloc((3 * (size_t)n + 2 * points) * sizeof(double));
    page_model *inverse = NULL;
    if (room != NULL && dehyst_pi_invert(n, m->threshold, m->weight, m->start, room, room + n, room + 2 * n) == 0) {
        double *before = room + 3 * n, *after = before + 2 * of->after.n;
        turned(&of->after, before);
        turned(&of->before, after);
        inverse = page_model_new(n, room, room + n, of->hysteresis.offset, of->hysteresis.center, room + 2 * n,
                                 of->after.n, before, of->before.n, after);
    }
    free(room);
    return inverse;
}

PAGE(page_model_reset) void page_model_reset(page_model *m) { dehyst_model_reset(&m->model, &m->state, m->start); }

/* y (samples,) of x (samples,), going on from the present state; y may be x. */
PAGE(page_model_run) void page_model_run(page_model *m, int32_t samples, const double *x, double *y)
{
    for (int32_t k = 0; k < samples; k++) {
        y[k] = dehyst_model_step(&m->model, &m->state, x[k]);
    }
}

PAGE(page_model_states) void page_model_states(const page_model *m, double *z)
{
    memcpy(z, m->state.z, (size_t)m->model.hysteresis.n * sizeof(double));
}

PAGE(page_map_values) void page_map_values(int32_t n, const double *u, const double *v, int32_t samples, const double *x,
                                           double *y)
{
    const dehyst_map map = {n, u, v};
    for (int32_t k = 0; k < samples; k++) {
        y[k] = dehyst_map_value(&map, x[k]);
    }
}

/* ---- Sums and programs of a fit */
PAGE(page_bin_sums) void page_bin_sums(int32_t samples, const double *x, const double *y, const double *weight,
                                       int32_t bins, double low, double high, double *sums)
{
    engine_bin_sums(samples, x, y, weight, bins, low, high, sums);
}

PAGE(page_gram_new) engine_gram *page_gram_new(int32_t n, const double *threshold, const double *state, int32_t targets)
{
    return engine_gram_new(n, threshold, state, targets);
}
PAGE(page_gram_free) void page_gram_free(engine_gram *g) { engine_gram_free(g); }
/* targets (m, samples), at most 64 of them; weight (samples,) or a null pointer. */
PAGE(page_gram_add) int32_t page_gram_add(engine_gram *g, int32_t samples, const double *x, int32_t m, const double *targets,
                                          const double *weight)
{
    const double *column[64] = {0};
    for (int32_t j = 0; j < m && j < 64; j++) {
        column[j] = targets + (size_t)j * (size_t)samples;
    }
    return (int32_t)engine_gram_add(g, samples, x, column, weight);
}
PAGE(page_gram_take) void page_gram_take(engine_gram *g, double *sums) { engine_gram_take(g, sums); }

/* answer: kkt, condition, status. */
PAGE(page_solve) int32_t page_solve(int32_t n, int32_t plays, int32_t basis, const double *gram, const double *rhs,
                                    const double *extra, const double *extra_rhs, const double *lower, double target_norm,
                                    double *u, double *answer)
{
    const engine_program program = {n, 1, plays, basis, gram, rhs, extra, extra_rhs, lower, target_norm};
    engine_solution solution = {0};
    uint8_t *passive = calloc((size_t)n, 1);
    const int failed = passive == NULL || engine_solve(&program, u, passive, &solution);
    answer[0] = solution.kkt;
    answer[1] = solution.condition;
    answer[2] = solution.status;
    free(passive);
    return failed;
}
