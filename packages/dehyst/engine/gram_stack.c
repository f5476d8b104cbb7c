/* A state as a stack of segments, and the table that finds thresholds by value. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "dehyst.h"
#include "gram.h"

int gram_grid_start(stack_grid *grid, int32_t n, const double *threshold)
{
    const double span = threshold[n - 1] - threshold[0];
    double *r = malloc((size_t)n * sizeof *r);
    double *rest = malloc((size_t)n * sizeof *rest);
    int32_t *guide = malloc((2 * (size_t)n + 1) * sizeof *guide);
    grid->r = r;
    grid->rest = rest;
    grid->guide = guide;
    if (r == NULL || rest == NULL || guide == NULL) {
        return -1;
    }
    for (int32_t i = 0; i < n; ++i) {
        r[i] = threshold[i] - threshold[0];
    }
    grid->n = n;
    grid->buckets = 2 * n;
    grid->per_unit = span > 0 ? 2 * n / span : 0.0;
    grid->rest_is_flat = 1;
    grid->limit = DEHYST_INPUT_LIMIT;
    if (!(grid->per_unit <= DBL_MAX)) { /* thresholds at the edge of the numbers: search without a guide */
        grid->per_unit = 0.0;
    }
    for (int32_t bucket = 0, i = 0; bucket <= grid->buckets; ++bucket) {
        while (i < n && r[i] * grid->per_unit < bucket) {
            ++i;
        }
        guide[bucket] = bucket == 0 || grid->per_unit == 0.0 ? 0 : i;
    }
    return 0;
}

void gram_grid_free(stack_grid *grid)
{
    free((void *)(uintptr_t)grid->r);
    free((void *)(uintptr_t)grid->rest);
    free((void *)(uintptr_t)grid->guide);
}

/* One past the operators from `from` on that lie on one line z_i = e - s r_i, and that line. */
static int32_t line_from(const stack_grid *g, const double *z, int32_t from, int32_t to, stack_segment *segment)
{
    const double s = from + 1 < g->n && z[from] < z[from + 1] ? -1.0 : 1.0;
    const double e = z[from] + s * g->r[from];
    int32_t i = from + 1;
    while (i < to && fabs(z[i] - (e - s * g->r[i])) <= 4 * DBL_EPSILON * (fabs(z[i]) + g->r[i] + fabs(e))) {
        ++i;
    }
    segment->e = e;
    segment->s = s;
    segment->b = i;
    return i;
}

/* Operators at the end with one common value rest in the lowest segment; all others get segments of their own, as long as
 * lines reach, at worst one each. Either sign describes a single operator: both bounds of its play are the same. */
void gram_stack_from_state(stack_grid *grid, stack *k, const double *state)
{
    const int32_t n = grid->n;
    double *rest = (double *)(uintptr_t)grid->rest;
    int32_t moved = n;
    while (moved > 0 && state[moved - 1] == state[n - 1]) {
        --moved;
    }
    for (int32_t i = 0; i < n; ++i) {
        rest[i] = state[n - 1];
    }
    k->segment[0] = (stack_segment){0.0, 0.0, n};
    k->segment[1] = (stack_segment){state[0], 1.0, 1};
    k->top = 1;
    int32_t count = 0;
    for (int32_t i = 0; i < moved;) {
        i = line_from(grid, state, i, moved, &k->segment[++count]);
    }
    for (int32_t low = 1, high = count; low < high; ++low, --high) {
        const stack_segment swap = k->segment[low];
        k->segment[low] = k->segment[high];
        k->segment[high] = swap;
    }
    k->top = count > 0 ? count : 1;
    stack_window(grid, k);
}
