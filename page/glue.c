/* What the page asks of the C code, compiled to WebAssembly: models as the robot runs them (core/). Memory is the
 * caller's own, by page_alloc; arrays are those of JavaScript, so no call keeps a pointer that it was given. */
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"

#define PAGE(name) __attribute__((export_name(#name), used))

PAGE(page_alloc) void *page_alloc(uint32_t bytes) { return malloc(bytes); }
PAGE(page_free) void page_free(void *memory) { free(memory); }

/* ---- y = offset + sum w_i play_{r_i}[x - center], one sample after the other, as exported code runs it */
typedef struct page_model {
    dehyst_model model;
    dehyst_state state;
    double *threshold, *weight, *slope, *loading, *start; /* (n,) each, in one block behind this one */
} page_model;

PAGE(page_model_new) page_model *page_model_new(int32_t n, const double *threshold, const double *weight, double center,
                                                double offset, const double *start)
{
    const size_t size = (size_t)n;
    page_model *m = calloc(1, sizeof *m + 6 * size * sizeof(double));
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
    m->model.hysteresis = (dehyst_pi){n, m->threshold, m->slope, m->loading, center, offset};
    dehyst_model_reset(&m->model, &m->state, m->start);
    return m;
}

/* The closed inverse of a model from the states that it starts with, or a null pointer if there is none. */
PAGE(page_model_inverse) page_model *page_model_inverse(const page_model *m)
{
    const int32_t n = m->model.hysteresis.n;
    double *room = malloc(3 * (size_t)n * sizeof(double));
    page_model *inverse = NULL;
    if (room != NULL && dehyst_pi_invert(n, m->threshold, m->weight, m->start, room, room + n, room + 2 * n) == 0) {
        inverse = page_model_new(n, room, room + n, m->model.hysteresis.offset, m->model.hysteresis.center, room + 2 * n);
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
