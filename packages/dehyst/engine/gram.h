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

#include "engine.h"
#include "lanes/kernels.h"
#include "stack.h"

typedef double gram_two __attribute__((vector_size(16), aligned(8), may_alias));

/* Sums over samples of the two differences beside a boundary. */
typedef struct gram_pair {
    gram_two g; /* up, down */
    int32_t cell;
} gram_pair;

/* A boundary that rests: its pair for one sample of weight 1, and when it froze. */
typedef struct gram_frozen {
    gram_pair beside;
    int32_t log;  /* entries of the log before */
    double since; /* weight of samples before */
} gram_frozen;

/* Columns are the first target (zeros if there is none), the cells of a dense prefix, the other targets. */
enum { GRAM_SQUARE, GRAM_NEXT, GRAM_ONES, GRAM_COLUMNS };

/* Sums over samples at places 0 .. n; place 0 is nobody's: what lands there is not read. */
typedef struct gram_sums {
    double *cross; /* g_p g_q of different boundaries, p from the deeper one: packed lower triangle */
    double *cross_kept; /* (2, triangle) the same from earlier on, and its rounding; a null pointer while there is none */
    double *place; /* (n + 1, stride): g_p^2 and g_p g_{p-1} of the same boundary, g_p, and g_p f_k for each column f_k */
    double *kept, *lost; /* (n + 1, stride) the same from earlier on: a sum and its rounding */
    double weight;       /* of the samples, up to then */
    double *total, *total_lost; /* (columns,) f_k, likewise */
} gram_sums;

/* Events: operators behind one play, driven by it. */
typedef struct gram_machine {
    int32_t n, dense, targets, columns;
    ptrdiff_t stride;    /* GRAM_COLUMNS + columns */
    int only_targets;    /* cells are paired with targets alone */
    stack_grid grid;
    stack stack;
    double *scale;       /* (n,) 1 / (r_{c+1} - r_c), 1 for the last */
    gram_frozen *frozen; /* (n + 2,) bottom boundary of each segment below the top; 0: the last cell of the lowest segment */
    double *frozen_at;   /* (n + 2, columns) sums of the columns when it froze */
    int outermost;       /* boundary 0 rests: no segment has reached the last operator */
    gram_pair *log;
    int32_t logged, log_size;
    double *block;       /* (n + 1,) the log summed by place */
    gram_sums sums;
    double weight;       /* of the samples since the log was emptied */
    double *total;       /* (columns,) their sums */
    int64_t events, emptied;           /* so far; how often the log was emptied */
    int64_t places_kept, pairs_kept;   /* their sum when sums were last put aside */
    /* the present run: samples with the same moving cell and sign */
    int32_t cell;
    double sign, below, origin, last;
    double run_weight, run_d, run_dd;
    double *run_f, *run_df; /* (columns,) */
    double squares;         /* of the first target in the last call, if samples had no weights */
} gram_machine;

/* Column of target t. */
static inline int32_t gram_column_of(const gram_machine *m, int32_t t) { return t == 0 ? 0 : m->dense + t; }

/* Cells 0 .. prefix - 1, written out: z_0 .. z_prefix, of which the last drives the events. */
typedef struct gram_dense {
    int32_t prefix, width, targets; /* a multiple of 4, 0 for none; the same as a multiple of 8 */
    double *r, *z;           /* (width,) of operators 1 .. prefix; those that fill it up have r infinite and z = 0 */
    double *rows, *weighted; /* (SAMPLES, width) cells, and times weight */
    double *drive;           /* (SAMPLES,) z_prefix */
    /* sums, each followed by as many numbers that rounding took from it */
    double *products;        /* (2, width, width) cell_i cell_j, lower triangle of blocks of 8 */
    double *with;            /* (2, targets, width) */
    double *ones;            /* (2, width) */
} gram_dense;

enum { GRAM_SAMPLES = 1024, GRAM_DENSE_SAMPLES = 128, GRAM_PREFIX_LIMIT = 64, GRAM_EMPTY = 1 << 17 };

struct engine_gram {
    int32_t n, targets, method;
    int only_targets;
    double *r, *state;      /* (n,) thresholds; scratch for states */
    double input;           /* the last sample, z_0 */
    gram_dense dense;
    gram_machine machine;   /* operators prefix .. n - 1; n = 0 if there are none */
    double *pairs;          /* (2, targets, targets) lower triangle of sums, what rounding took from them */
    double weight, *total;  /* of samples that no machine has seen; sums of targets (2, targets) likewise */
    double *weighted;       /* (targets, GRAM_SAMPLES) targets times weight */
    double *square;         /* (targets,) sums of squares in a chunk */
    const double **column;  /* (targets,) those of a chunk, times weight if there is one */
    const double **here;    /* (targets,) within it */
    double *earlier;        /* (size, size) sums taken over from other prefixes, lower triangle; a null pointer if none */
    int64_t until_empty;    /* samples until logs are emptied, for accuracy */
    int empty;              /* nothing was added since the last take */
    int64_t until_choice, since_choice, events_then; /* samples until the prefix is considered again, and since */
    int64_t events_before;  /* of machines that are gone */
};

/* gram_machine.c */
int gram_machine_start(gram_machine *m, int32_t n, const double *threshold, const double *state, int32_t dense,
                       int32_t targets);
void gram_machine_free(gram_machine *m);
void gram_machine_state(const gram_machine *m, double *z);
void gram_machine_clear(gram_machine *m);
void gram_freeze_all(gram_machine *m);

/* gram_stack.c: a state as a stack of segments */
int gram_grid_start(stack_grid *grid, int32_t n, const double *threshold);
void gram_grid_free(stack_grid *grid);
void gram_stack_from_state(stack_grid *grid, stack *k, const double *state);

/* gram_dense.c */
int gram_dense_start(gram_dense *d, int32_t prefix, int32_t n, const double *threshold, const double *state,
                     int32_t targets);
void gram_dense_free(gram_dense *d);
void gram_dense_clear(gram_dense *d);

/* gram_finish.c: sums over cells, added to what is there */
void gram_finish_cells(const gram_machine *m, double *column, double *out, ptrdiff_t stride);
void gram_finish_column(const gram_machine *m, int32_t entry, double *out, ptrdiff_t step);

/* gram.c: the log emptied, so that all sums are complete */
void gram_finish_log(engine_gram *g);
int gram_change_prefix(engine_gram *g, int32_t prefix);

/* gram_take.c */
void gram_sum_up(engine_gram *g, double *out);

/* gram_choice.c */
int32_t gram_choose(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *x);

/* total += a; what rounding took away goes to lost. */
static inline void gram_add_exactly(double *total, double *lost, double a)
{
    const double sum = *total + a, back = sum - *total;
    *lost += (*total - (sum - back)) + (a - back);
    *total = sum;
}

/* Where row p of the packed triangle begins; columns 0 .. p, its length a multiple of 8. */
static inline size_t gram_row(int32_t p)
{
    const size_t group = (size_t)p / 8, within = (size_t)p % 8;
    return 32 * group * (group + 1) + 8 * within * (group + 1);
}

#endif
