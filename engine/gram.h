/* Sums of products of cells without touching the cells: what the files of the Gram pass share.
 *
 * With delta_c = cell c / (r_{c+1} - r_c) the vector delta is piecewise constant: delta = s inside a segment of sign s, 0
 * below the stack, another value only in the cells at the boundaries of segments. So its differences
 *   g_p = delta_{p-1} - delta_p,   delta_c = sum_{p > c} g_p      (place p between cells p - 1 and p)
 * are zero except beside boundaries: a boundary in cell c with value v, sign s above it and s' below, contributes
 *   up = s - v  to g_c      and      down = v - s'  to g_{c+1}.
 * While nothing but the moving cell changes, sums of up and down over samples follow from sums of d = x - origin alone; they
 * are written to a log. A boundary that rested is paired, when it moves again, with the log written since it froze: all that
 * lies above it is newer, for segments are a stack. Now and then the log, summed, is paired with all boundaries and emptied.
 * This gives sum g g'; sums over its rows and columns give sum delta delta' (gram_finish.c). A sample costs one line of
 * arithmetic, an event as many operations as there are segments, and neither depends on n. The last cell is z_n itself, of
 * any size: it is kept out of the differences (delta = 0 there for g_{n-1}) and is what place n holds.
 */
#ifndef DEHYST_GRAM_H
#define DEHYST_GRAM_H

#include <stddef.h>
#include <stdint.h>

#include "lanes/kernels.h"
#include "stack.h"

/* Sums over samples of the two differences beside a boundary. */
typedef struct gram_pair {
    double up, down;
    int32_t cell;
} gram_pair;

/* A boundary that rests: its pair for one sample of weight 1, and when it froze. */
typedef struct gram_frozen {
    gram_pair beside;
    int32_t log;  /* entries of the log before */
    double since; /* weight of samples before */
} gram_frozen;

/* Sums over samples, of places 0 .. n; place 0 is nobody's: what lands there is not read. */
typedef struct gram_sums {
    double *cross;    /* g_p g_q of different boundaries, p from the deeper one: packed lower triangle */
    double *diagonal; /* (n + 1,) g_p^2 of the same boundary */
    double *next;     /* (n + 1,) g_p g_{p-1} of the same boundary */
    double *ones;     /* (n + 1,) g_p */
    double *with;     /* (n + 1, columns) g_p f_k */
    double weight;    /* of the samples, up to when the log was last emptied */
    double *total;    /* (columns,) f_k, likewise */
} gram_sums;

/* Events: the operators behind one play, driven by it. */
typedef struct gram_machine {
    int32_t n, columns;
    int only_columns; /* cells are not paired with cells */
    stack_grid grid;
    stack stack;
    double *scale;       /* (n,) 1 / (r_{c+1} - r_c), 1 for the last */
    gram_frozen *frozen; /* (n + 2,) bottom boundary of each segment below the top; 0: the last cell of the lowest segment */
    double *frozen_at;   /* (n + 2, columns) sums of the columns when it froze */
    int outermost;       /* boundary 0 rests: no segment has reached the last operator */
    gram_pair *log;
    int32_t logged, log_size;
    double *block;       /* (n + 1,) and up to a multiple of 8: the log summed by place */
    gram_sums sums;
    double weight;       /* of the samples since the log was emptied */
    double *total;       /* (columns,) their sums */
    /* the present run: samples with the same moving cell and sign */
    int32_t cell;
    double sign, below, origin, last;
    double run_weight, run_d, run_dd;
    double *run_f, *run_df; /* (columns,) */
} gram_machine;

/* gram_machine.c */
int gram_machine_start(gram_machine *m, int32_t n, const double *threshold, const double *state, int32_t columns);
void gram_machine_free(gram_machine *m);
double gram_machine_play(const gram_machine *m, int32_t i);
void gram_machine_clear(gram_machine *m);

/* gram_stack.c: a state as a stack of segments */
int gram_grid_start(stack_grid *grid, int32_t n, const double *threshold);
void gram_grid_free(stack_grid *grid);
void gram_stack_from_state(const stack_grid *grid, stack *k, double *rest, const double *state);

/* gram_events.c */
void gram_begin_run(gram_machine *m);
void gram_end_run(gram_machine *m);
void gram_event(gram_machine *m, double x);
void gram_empty_log(gram_machine *m, const engine_kernels *kernels);
void gram_freeze_all(gram_machine *m);

/* gram_run.c: samples of x with their columns f, already multiplied by the weights if there are any */
void gram_run(gram_machine *m, const engine_kernels *kernels, int64_t samples, const double *x, const double *weight,
              const double *const *f);
void gram_pass_by(gram_machine *m, const engine_kernels *kernels, int64_t samples, const double *x);

/* gram_finish.c: sums over cells, added to what is there */
void gram_finish_cells(const gram_machine *m, double *column, double *out, ptrdiff_t stride);
void gram_finish_column(const gram_machine *m, int32_t column, double *out);

/* Where row p of the packed triangle begins; columns 0 .. p, its length a multiple of 8. */
static inline size_t gram_row(int32_t p)
{
    const size_t group = (size_t)p / 8, within = (size_t)p % 8;
    return 32 * group * (group + 1) + 8 * within * (group + 1);
}

#endif
