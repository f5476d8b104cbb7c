/* Play outputs at chosen samples: a sample costs a comparison, a row its length. */
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "engine.h"
#include "machine.h"
#include "patience.h"

/* A machine without weights for operators with one of threshold 0 in front if there is none; returns 1 for that one, 0, or
 * -1 if memory is short. */
static int make(machine *m, int32_t n, const double *r, const double *z)
{
    const int32_t front = r[0] > 0 ? 1 : 0;
    const size_t size = (size_t)(n + front);
    double *const room = calloc(3 * size, sizeof *room);
    if (room == NULL) {
        return -1;
    }
    double *const all_r = room + size, *const all_z = all_r + size;
    memcpy(all_r + front, r, (size_t)n * sizeof *r);
    memcpy(all_z + front, z, (size_t)n * sizeof *z);
    all_z[0] = z[0];
    const int short_of_memory = machine_make(m, n + front, all_r, room, DEHYST_INPUT_LIMIT);
    if (!short_of_memory) {
        machine_start(m, all_z);
    }
    free(room);
    return short_of_memory ? -1 : front;
}

/* States of the operators but `front`. */
static void write_row(const machine *m, int32_t front, double *z)
{
    int32_t i = front;
    for (int32_t q = m->stack.top; q >= 0; --q) {
        const stack_segment *segment = &m->stack.segment[q];
        const double *r = q == 0 ? m->grid.rest : m->grid.r, e = q == 0 ? 0.0 : segment->e, s = q == 0 ? -1.0 : segment->s;
        for (; i < segment->b; ++i) {
            z[i - front] = e - s * r[i];
        }
    }
}

typedef struct task {
    machine m;
    double last;
    int32_t n, front;
    int64_t next, rows; /* number of the next row, and of all */
    const int64_t *row;
    double *out;
} task;

/* Samples from .. end: a loop of its own, so that who asks whether to go on costs it no register. */
static void follow(task *t, const double *x, int64_t from, int64_t end)
{
    stack *const k = &t->m.stack;
    double last = t->last;
    int64_t wanted = t->next < t->rows ? t->row[t->next] : -1;
    for (int64_t j = from; j < end; ++j) {
        const stack_segment *top = &k->segment[k->top];
        const double low = top->b > 1 && top->s > 0 ? last : k->low, high = top->b > 1 && top->s < 0 ? last : k->high;
        if (low <= x[j] && x[j] <= high) {
            last = x[j];
        } else if (dehyst_accept(x[j])) {
            k->segment[k->top].e = last;
            stack_event(&t->m.grid, k, x[j]);
            last = x[j];
        }
        if (wanted == j) {
            k->segment[k->top].e = last;
            write_row(&t->m, t->front, t->out + t->next * t->n);
            ++t->next;
            wanted = t->next < t->rows ? t->row[t->next] : -1;
        }
    }
    t->last = last;
}

int engine_plays(int32_t n, const double *threshold, double *state, int64_t samples, const double *x, int64_t rows,
                 const int64_t *row, double *out)
{
    task t = {.last = state[0], .n = n, .rows = rows, .row = row, .out = out};
    t.front = make(&t.m, n, threshold, state);
    if (t.front < 0) {
        return -1;
    }
    for (int64_t j = 0, end; (end = engine_until(j, samples, 20 + n)) > j; j = end) {
        follow(&t, x, j, end);
    }
    t.m.stack.segment[t.m.stack.top].e = t.last;
    write_row(&t.m, t.front, state);
    machine_free(&t.m);
    return 0;
}
