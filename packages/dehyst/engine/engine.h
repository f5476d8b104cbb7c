/* dehyst engine: the same Prandtl-Ishlinskii operator for long signals on a host.
 *
 * The core pays for every operator at every sample; here a sample costs one line of arithmetic between events and an
 * event does not depend on the number of operators. Host only: it allocates, uses SIMD chosen at run time, and agrees
 * with the core to rounding, not to the bit.
 *
 * Cells. With the slopes S_i = w_1 + ... + w_i the output is
 *   y = offset + sum_{i<n} S_i (z_i - z_{i+1}) + S_n z_n,
 * and z_i - z_{i+1} =: cell i (i < n), z_n =: cell n. A stack of segments (e, s, b) holds the state: z_i = e - s r_i for the
 * operators of a segment, so every cell inside one is s (r_{i+1} - r_i) and only the cell at the boundary of the top
 * segment moves (Kuhnen 2003 for the operator; the bookkeeping is stack.h).
 */
#ifndef DEHYST_ENGINE_H
#define DEHYST_ENGINE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Instruction sets: one binary, the best kernels the processor has, the others selectable for tests. */
enum { ENGINE_PORTABLE = 0, ENGINE_AVX2 = 1, ENGINE_AVX512 = 2, ENGINE_LEVELS = 3 };
int engine_best_level(void);       /* highest level this build and processor can run */
int engine_level(void);            /* level in use */
int engine_use_level(int level);   /* 0, or -1 if it cannot run here; for tests and benchmarks, not thread safe */

/* ---- Evaluation: y = offset + sum_i w_i play_{r_i}[x - center] */
enum { ENGINE_AUTO = -1, ENGINE_EVENTS = 0, ENGINE_DENSE = INT32_MAX }; /* or a prefix: a multiple of 8 below n */

typedef struct engine_evaluator engine_evaluator;

/* Tables and state of one operator, or a null pointer if memory is short. threshold (n,) increasing, r_1 >= 0; any
 * weights; state (n,) admissible: |z_i - z_{i+1}| <= r_{i+1} - r_i. Everything is copied. */
engine_evaluator *engine_evaluator_new(int32_t n, const double *threshold, const double *weight, double center,
                                       double offset, const double *state);
void engine_evaluator_free(engine_evaluator *evaluator);
/* Force a method (ENGINE_EVENTS, ENGINE_DENSE, a prefix) or leave the choice to the signal (ENGINE_AUTO, the default).
 * Forced dense methods do not ask whether their error, eps sum |w| (r + |x|), is small beside y; the choice does.
 * Returns 0, or -1 if there is no such method for so many operators, or memory is short. */
int engine_evaluator_method(engine_evaluator *evaluator, int32_t method);
/* Outputs y (samples,) of x (samples,), continuing from the present state; returns the number of rejected samples (not
 * finite, or beyond the core's DEHYST_INPUT_LIMIT): the last good output is held for them, as the core does. x may be y. */
int64_t engine_evaluator_run(engine_evaluator *evaluator, int64_t samples, const double *x, double *y);
void engine_evaluator_state(const engine_evaluator *evaluator, double *z); /* (n,) */
int64_t engine_evaluator_events(const engine_evaluator *evaluator);        /* so far; what a sample costs follows them */

/* Outputs out (rows, n), row-major, of n play operators at the increasing samples row (rows,) of a signal x (samples,) from
 * admissible states (n,), which it advances. Samples that the core rejects move nothing. Returns 0, or -1 if memory is short. */
int engine_plays(int32_t n, const double *threshold, double *state, int64_t samples, const double *x, int64_t rows,
                 const int64_t *row, double *out);

/* ---- Normal equations of the cells, streamed: memory does not depend on the number of samples.
 * Columns c = [1 | cell_1 .. cell_n | f_1 .. f_m], sums over samples k of weight_k c_i c_j. */
typedef struct engine_gram engine_gram;

engine_gram *engine_gram_new(int32_t n, const double *threshold, const double *state, int32_t targets);
void engine_gram_free(engine_gram *gram);
/* Method as for the evaluator: events only, a dense prefix (a multiple of 4, at most 64), or the choice of the signal.
 * ENGINE_DENSE: up to 64 operators. Sums and states go on. Returns 0, or -1 if it does not apply. */
int engine_gram_method(engine_gram *gram, int32_t method);
/* Add samples. x (samples,) centred; targets: m pointers to (samples,) columns, the output y among them; weight
 * (samples,) >= 0 or a null pointer for ones. All must be finite: returns samples, or the index of the first sample of
 * which the core would reject x, a target or the weight, where it stopped: those before it are in the sums. */
int64_t engine_gram_add(engine_gram *gram, int64_t samples, const double *x, const double *const *targets,
                        const double *weight);
/* Advance the state by x without adding anything; returns as engine_gram_add. */
int64_t engine_gram_skip(engine_gram *gram, int64_t samples, const double *x);
/* Write the sums since the last take as a full symmetric matrix (1 + n + m)^2, row-major, and start new ones; the state
 * goes on. sums may be a null pointer: forget. */
void engine_gram_take(engine_gram *gram, double *sums);
/* Only sums of targets with the columns and each other; a pass of refinement needs no more. After
 * engine_gram_only_targets(gram, 1) sums of cells with cells and with ones are not accumulated and engine_gram_take leaves
 * them zero. Meant for the time between two takes as a whole. */
void engine_gram_only_targets(engine_gram *gram, int only);
void engine_gram_state(const engine_gram *gram, double *z); /* (n,) */
int64_t engine_gram_events(const engine_gram *gram);         /* so far, behind the dense prefix of the time */
int32_t engine_gram_prefix(const engine_gram *gram);         /* operators taken one by one at present */

/* ---- Bounded least squares on normal equations: minimise 1/2 v'G v - g'v over v = T u, u_i >= 0 where bounded.
 * The first `free` unknowns have no bound and T leaves them alone; the next `plays` ones are related to cells by
 *   ENGINE_SLOPES   v_i = u_i                          u are slopes S          (family pi-cumulative)
 *   ENGINE_WEIGHTS  v_i = u_1 + ... + u_i              u are play weights w    (pi, modified-pi)
 *   ENGINE_STOPS    v_i = u_1 + sum_{j>i} u_j, j>=2    u_1 slope k, u_j stop weights s_j    (stop)
 * and the rest again have v = u. A second, small quadratic term 1/2 u'E u - h'u (ridge, smoothing) may be given in u. */
enum { ENGINE_SLOPES = 0, ENGINE_WEIGHTS = 1, ENGINE_STOPS = 2 };

typedef struct engine_program {
    int32_t unknowns;      /* N */
    int32_t free;          /* leading unknowns without a bound */
    int32_t plays;         /* unknowns that follow and are transformed by T */
    int32_t basis;         /* ENGINE_SLOPES, ENGINE_WEIGHTS, ENGINE_STOPS */
    const double *gram;    /* (N, N) G in v, row-major, symmetric */
    const double *rhs;     /* (N,) g in v */
    const double *extra;   /* (N, N) E in u, or a null pointer */
    const double *extra_rhs; /* (N,) h in u, or a null pointer */
    const double *lower;   /* (N,) lower bounds of u; ignored for the free ones */
    double target_norm;    /* |y| of all the rows behind G, g and E, h, or 0 if unknown: what tolerances refer to */
} engine_program;

typedef struct engine_solution {
    double kkt;            /* largest violation of the optimality conditions, relative to |column| |y|, both as the free
                              unknowns leave them; where |y| is unknown, to the largest T'g / |column| instead */
    double condition;      /* of the least-squares matrix behind G for the passive unknowns, in cells joined between passive
                              operators and scaled to length one: an estimate from below, mostly within a few per cent.
                              Slopes carry a relative error of about condition^2 2^-52; infinite with status 2 */
    int32_t iterations;    /* changes of the passive set */
    int32_t status;        /* 0 optimal; 1 out of iterations: feasible, kkt tells how far; 2 a pivot vanished: the columns
                              are too alike for normal equations, use orthogonal factors */
} engine_solution;

/* Active set method with exact zeros: u (N,) out; passive (N,) in and out, 1 where u is off its bound (in: warm start, or
 * all 0). The passive set found in u is solved again in the cells, whose condition number is the square root of that of w,
 * and its gradient formed there decides. An unknown enters where that exceeds 8 2^-52 |column| |y|; one whose absence would
 * leave less is set to its bound. Returns 0, or -1 if memory is short. */
int engine_solve(const engine_program *program, double *u, uint8_t *passive, engine_solution *solution);

/* The lower triangle of a matrix (n, n), row by row, into out (n (n + 1) / 2,). */
void engine_triangle(int32_t n, const double *matrix, double *out);

/* out (sums, n, n): sum s is that of factors[s, m] of matrix m, at the rows and columns `chosen`, which increase. The
 * matrices are symmetric; their lower triangles are stored row by row, `size` numbers each. -1 if memory is short. */
int engine_sums_of_triangles(int32_t matrices, int64_t size, const double *triangles, int32_t sums, const double *factors,
                             int32_t n, const int64_t *chosen, double *out);

/* ---- Columns of sums of elements, of samples of cells e (samples, cells), the first of which is the input x:
 *   out_j = gain_j ramp(e_cell_j; low_j, high_j) + ramp(x; x_low_j, x_high_j),  ramp(v; a, b) = clip(v, a, b) - clip(0, a, b) */
typedef struct engine_ramp_table {
    int64_t columns;
    const int64_t *cell; /* (columns,), each below the number of cells */
    const double *gain, *low, *high, *x_low, *x_high;
} engine_ramp_table;

void engine_ramps(int64_t samples, int64_t cells, const double *e, const engine_ramp_table *table, double *out);

#ifdef __cplusplus
}
#endif

#endif
