/* Tables and state of an operator that is evaluated by events. */
#include "machine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BUCKETS_PER_OPERATOR = 2 };

/* guide[g] = number of thresholds below g / per_unit */
static void fill_guide(stack_grid *g, int32_t *guide)
{
    const double top = g->r[g->n - 1];
    g->buckets = BUCKETS_PER_OPERATOR * g->n;
    g->per_unit = top > 0 ? g->buckets / top : 0.0;
    int32_t i = 0;
    for (int32_t bucket = 0; bucket <= g->buckets; ++bucket) {
        while (i < g->n && g->r[i] * g->per_unit < bucket) {
            ++i;
        }
        guide[bucket] = i;
    }
    g->guide = guide;
}

int machine_make(machine *m, int32_t n, const double *r, const double *w, double limit)
{
    memset(m, 0, sizeof *m);
    const size_t size = (size_t)n;
    m->memory = malloc((6 * size + 3) * sizeof *m->memory);
    m->stack.segment = calloc(size + 2, sizeof *m->stack.segment);
    m->depth = calloc(size / 8 + 1, sizeof *m->depth);
    int32_t *guide = malloc((BUCKETS_PER_OPERATOR * size + 1) * sizeof *guide);
    m->grid.guide = guide;
    if (m->memory == NULL || m->stack.segment == NULL || m->depth == NULL || guide == NULL) {
        machine_free(m);
        return -1;
    }
    m->r = m->memory;
    m->rest = m->r + n;
    m->slope = m->rest + n;
    m->phi = m->slope + n;
    m->rest_sum = m->phi + n;
    m->frozen = m->rest_sum + n + 1;
    memcpy(m->r, r, size * sizeof *r);
    double slope = 0, phi = 0;
    for (int32_t i = 0; i < n; ++i) {
        phi += i > 0 ? slope * (r[i] - r[i - 1]) : 0.0;
        slope += w[i];
        m->phi[i] = phi;
        m->slope[i] = slope;
    }
    m->grid.n = n;
    m->grid.r = m->r;
    m->grid.rest = m->rest;
    m->grid.limit = limit;
    fill_guide(&m->grid, guide);
    return 0;
}

void machine_free(machine *m)
{
    free(m->memory);
    free(m->stack.segment);
    free(m->depth);
    free((void *)(uintptr_t)m->grid.guide);
    memset(m, 0, sizeof *m);
}

/* z_i - z_{i+1}. Plays that were dragged together lie exactly r_{i+1} - r_i apart; their stored states know it only to the
 * rounding of the input, which slopes of 1000 and more would show. */
static double cell(const machine *m, const double *z, int32_t i)
{
    const double width = m->r[i + 1] - m->r[i], gap = z[i] - z[i + 1];
    const double rounding = 0x1p-52 * (fabs(z[i]) + fabs(z[i + 1]) + m->r[i + 1]);
    return fabs(fabs(gap) - width) <= rounding ? copysign(width, gap) : gap;
}

void machine_start(machine *m, const double *z)
{
    const int32_t n = m->grid.n;
    memmove(m->rest, z, (size_t)n * sizeof *z);
    m->grid.rest_is_flat = 1;
    m->rest_sum[n] = 0.0;
    m->rest_sum[n - 1] = m->slope[n - 1] * z[n - 1];
    for (int32_t i = n - 2; i >= 0; --i) {
        m->rest_sum[i] = m->rest_sum[i + 1] + m->slope[i] * cell(m, m->rest, i);
        m->grid.rest_is_flat &= z[i] == z[0];
    }
    m->grid.rest_is_flat &= z[n - 1] == z[0];
    m->stack.top = 1;
    /* Equal rest states are one more segment: e - 0 r_i. */
    m->stack.segment[0] = (stack_segment){z[0], 0.0, n};
    m->frozen[0] = m->rest_sum[n - 1];
    m->stack.segment[1] = (stack_segment){z[0], 1.0, 1};
    stack_window(&m->grid, &m->stack);
    machine_line(m);
}

void machine_state(const machine *m, double *z)
{
    int32_t i = 0;
    for (int32_t q = m->stack.top; q >= 0; --q) {
        for (const int32_t end = m->stack.segment[q].b; i < end; ++i) {
            z[i] = stack_play(&m->grid, &m->stack, q, i);
        }
    }
}

void machine_forget(machine *m) { memset(m->depth, 0, ((size_t)m->grid.n / 8 + 1) * sizeof *m->depth); }
