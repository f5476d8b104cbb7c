/* dehyst core: the only arithmetic that runs on the robot.
 *
 * Prandtl-Ishlinskii hysteresis, its closed inverse, and monotone maps around it. C11, re-entrant, no
 * allocation, no library call. Model and state are two structs and the caller owns both.
 *
 * Notation (Kuhnen, European Journal of Control 9(4), 2003):
 *   z_i[k] = max(x[k] - r_i, min(x[k] + r_i, z_i[k-1]))      play operator, threshold r_i >= 0
 *   H[x]   = sum_i w_i z_i                                    0 = r_1 < r_2 < ... < r_n
 */
#ifndef DEHYST_H
#define DEHYST_H

#include <stdint.h>

#include "dehyst_config.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifdef DEHYST_FLOAT
typedef float dehyst_real;
#define DEHYST_INPUT_LIMIT 1e15f
#define DEHYST_FAR 1e38f
#else
typedef double dehyst_real;
#define DEHYST_INPUT_LIMIT 1e100 /* beyond this no signal is physical, and sums could overflow */
#define DEHYST_FAR 1e300         /* beyond every input and output; finite, and so are sums with it */
#endif

enum {
    DEHYST_REJECTED = 1u,      /* the last sample was not finite or beyond DEHYST_INPUT_LIMIT */
    DEHYST_REJECTED_EVER = 2u, /* some sample since the last reset was rejected (sticky) */
    DEHYST_LIMITED = 4u,       /* of a block: the last sample met the limit of the input or of the output */
    DEHYST_LIMITED_EVER = 8u   /* some sample since the last reset did (sticky) */
};

/* Strictly monotone, piecewise linear map v(u), continued along its end segments. n = 0: identity. */
typedef struct dehyst_map {
    int32_t n;              /* number of breakpoints, 0 or >= 2 */
    const dehyst_real *u;   /* (n,) breakpoints, strictly increasing, [unit of the argument] */
    const dehyst_real *v;   /* (n,) values, strictly increasing or strictly decreasing, [unit of the result] */
} dehyst_map;

/* y = offset + sum_i w_i play_{r_i}[x - center], weights as running sums: those lose no digits in an inverse */
typedef struct dehyst_pi {
    int32_t n;                     /* number of play operators, >= 1 */
    const dehyst_real *threshold;  /* (n,) r, increasing, r_1 >= 0, [input] */
    const dehyst_real *slope;      /* (n,) S_i = w_1 + ... + w_i, [output/input] */
    const dehyst_real *loading;    /* (n,) phi_i = sum_{j<i} S_j (r_{j+1} - r_j), loading curve at r_i, [output] */
    dehyst_real center;            /* subtracted from the input, [input] */
    dehyst_real offset;            /* added to the output, [output] */
} dehyst_pi;

/* y = after(H[before(x)]): the modified Prandtl-Ishlinskii model, and by its closure its own inverse */
typedef struct dehyst_model {
    dehyst_map before;   /* memoryless map of the input, n = 0 if there is none */
    dehyst_pi hysteresis;
    dehyst_map after;    /* memoryless map of the output, n = 0 if there is none */
} dehyst_model;

/* Play states that an input can leave are admissible: |z_i - z_{i+1}| <= r_{i+1} - r_i. Only such may be set. */
typedef struct dehyst_state {
    dehyst_real *z;      /* (n,) play states of the centred input, [input of the hysteresis] */
    dehyst_real output;  /* last good output, held while samples are rejected, [output] */
    uint32_t flags;      /* DEHYST_REJECTED, DEHYST_REJECTED_EVER */
} dehyst_state;

/* 1 if x is finite and within the input limit, by bit pattern: -ffast-math cannot delete it. */
int dehyst_accept(dehyst_real x);

/* Advance n play states, admissible or not, by the input x (already centred) in place: the definition. */
void dehyst_play_step(int32_t n, const dehyst_real *threshold, dehyst_real x, dehyst_real *z);

/* Tables of an operator from its weights w (n,): slope (n,) and loading (n,). */
void dehyst_pi_tables(int32_t n, const dehyst_real *threshold, const dehyst_real *weight, dehyst_real *slope,
                      dehyst_real *loading);

/* offset + sum_i w_i z_i, summed by slopes in a fixed order: the same bits from every compiler. */
dehyst_real dehyst_pi_output(const dehyst_pi *pi, const dehyst_real *z);

enum { /* what a step did */
    DEHYST_MOVED = 1,    /* states moved, and the output is new */
    DEHYST_HELD_BACK = 2 /* the output met a limit: the input was not followed all the way */
};

/* One step of an operator with admissible states z (n,) by a centred input x: moves the states and writes H[x]; an x that
 * moves no operator leaves both alone. Where H would leave low .. high, outwards, x is held back at the point where it
 * meets the limit; not so for operators with r_1 > 0. Returns what it did. O(n), but for the states O(log n). */
int dehyst_pi_step(const dehyst_pi *pi, dehyst_real *z, dehyst_real x, dehyst_real low, dehyst_real high,
                   dehyst_real *output);

/* Value of a map at u. */
dehyst_real dehyst_map_value(const dehyst_map *map, dehyst_real u);

/* Output that belongs to the present states: what the model says before the first sample. */
dehyst_real dehyst_model_output(const dehyst_model *model, const dehyst_real *z);

/* Set the states to z0 (n,), the held output to the one that belongs to them, and clear the flags. */
void dehyst_model_reset(const dehyst_model *model, dehyst_state *state, const dehyst_real *z0);

/* One sample. A rejected sample holds the last good output, raises the flags and leaves z untouched. Also rejected are
 * samples of which the model's first map makes infinity. */
dehyst_real dehyst_model_step(const dehyst_model *model, dehyst_state *state, dehyst_real x);

/* Closed inverse (Kuhnen 2003):
 *   r'_i = sum_{j<=i} w_j (r_i - r_j),  w'_1 = 1/w_1,  w'_i = -w_i/(S_i S_{i-1}),  S_i = w_1 + ... + w_i
 *   z'_i = sum_{j<=i} w_j z_i + sum_{j>i} w_j z_j
 * Center and offset change places. All S_i must have one sign; if it is negative the thresholds are mirrored.
 * Returns 0, or the 1-based index of the first partial sum that is zero or of the wrong sign (-1: r_1 > 0). */
int32_t dehyst_pi_invert(int32_t n, const dehyst_real *threshold, const dehyst_real *weight,
                         const dehyst_real *z, dehyst_real *inverse_threshold,
                         dehyst_real *inverse_weight, dehyst_real *inverse_z);

/* Play weights of the stop form y = slope x + sum_i s_i (x - play_{r_i}[x]), r_1 = 0 (whose stop is zero):
 *   w_1 = slope + sum_{i>=2} s_i,   w_i = -s_i */
void dehyst_stop_to_play(int32_t n, dehyst_real slope, const dehyst_real *stop_weight,
                         dehyst_real *weight);

/* ---- A model or its inverse as a function block of a machine: bounded for every input, switched without a bump.
 *
 * A compensator asks for an input of the actuator. Where the actuator cannot follow, a plain inverse would go on as if
 * it had: its states would be wrong from there on. The block holds its own input back at the point where the output
 * meets its limit, so that its states stay those of the actuator. */

typedef struct dehyst_block {
    dehyst_model model;
    const dehyst_real *start;            /* (n,) play states after a reset, [input of the hysteresis] */
    dehyst_real input_low, input_high;   /* inputs beyond are taken as the limit, [input] */
    dehyst_real output_low, output_high; /* no output lies beyond, [output] */
    dehyst_real reach_low, reach_high;   /* the same in front of the last map: where the input is held back, [its argument] */
    dehyst_real line_slope, line_offset; /* answer while off: line_offset + line_slope x, [output/input], [output] */
    dehyst_real fade;                    /* share of a switching that one sample makes, 1e-12 (float: 1e-6) .. 1 */
    uint32_t fingerprint;                /* of the model: images of another one are refused */
} dehyst_block;

typedef struct dehyst_block_state {
    dehyst_state model;  /* its z (n,) must point to memory before the reset */
    dehyst_real share;   /* 0 off .. 1 on */
    dehyst_real output;  /* last good output, [output] */
    uint32_t flags;
    int32_t started;     /* 0 until the first good sample after the reset */
} dehyst_block_state;

/* Start states, flags cleared, the output that belongs to them. */
void dehyst_block_reset(const dehyst_block *block, dehyst_block_state *state);

/* One sample; `on` may change at any time: the output fades between the model's and the line's over 1/fade samples,
 * but for the first sample after a reset, which begins where it is told to. The states follow in either case. A rejected
 * sample holds all of it: switching goes on with the next good one, so a machine whose reference died is to be stopped
 * elsewhere.
 * output_low <= output <= output_high for every x, whatever its bits. While it is on and nothing is limited the output
 * is that of dehyst_model_step, to the bit. */
dehyst_real dehyst_block_step(const dehyst_block *block, dehyst_block_state *state, dehyst_real x, int on);

/* x within low..high, low if it is not a number; a share one part nearer to its target. */
dehyst_real dehyst_within(dehyst_real x, dehyst_real low, dehyst_real high);
dehyst_real dehyst_faded(dehyst_real share, dehyst_real target, dehyst_real part);

/* ---- Images: states and parameters as 32-bit words that can be stored, sent and checked. The first word tells kind and
 * format, the last one is a CRC-32; numbers are IEEE patterns, low word first, whatever the machine. Nothing is changed
 * unless all of an image is good. */

enum { /* answers */
    DEHYST_IMAGE_GOOD = 0,
    DEHYST_IMAGE_SIZE = 1,    /* of another length, or the memory given is too small */
    DEHYST_IMAGE_KIND = 2,    /* not of this kind, format or precision */
    DEHYST_IMAGE_DAMAGED = 3, /* checksum */
    DEHYST_IMAGE_FOREIGN = 4, /* of another model */
    DEHYST_IMAGE_INVALID = 5  /* parameters of no model, or states that no input leaves */
};

/* Words of an image of n operators: the state of a block; the parameters of one with maps of `before` and `after`
 * points; the state of a joint controller with n operators, 0 without compensator, and a direct inverse with `memory`
 * reals, -1 without one. */
#define DEHYST_REAL_WORDS ((int32_t)(sizeof(dehyst_real) / sizeof(uint32_t)))
#define DEHYST_STATE_WORDS(n) (6 + DEHYST_REAL_WORDS * ((n) + 3))
#define DEHYST_BLOCK_WORDS(n, before, after) (6 + DEHYST_REAL_WORDS * (4 * (n) + 2 * ((before) + (after)) + 11))
#define DEHYST_JOINT_WORDS(n, memory)                                                                                 \
    (16 + DEHYST_REAL_WORDS * ((n) + 40 + DEHYST_FIT_REALS + ((memory) < 0 ? 0 : 21 + 10 * DEHYST_GROUPS + 2 * (memory))))

/* Reals of memory that the parameters of an image need. */
#define DEHYST_BLOCK_REALS(n, before, after) (4 * (n) + 2 * ((before) + (after)))

/* Save the state into `image` of that many words, and go on from it; returns one of the answers above. */
int32_t dehyst_block_save(const dehyst_block *block, const dehyst_block_state *state, uint32_t *image, int32_t words);
int32_t dehyst_block_restore(const dehyst_block *block, dehyst_block_state *state, const uint32_t *image,
                             int32_t words);

/* Write the parameters of a block, and make a block of them that lives in `memory` of `reals` numbers (memory is
 * written even if the image is refused: not that of a block in use). */
int32_t dehyst_block_dump(const dehyst_block *block, uint32_t *image, int32_t words);
int32_t dehyst_block_load(const uint32_t *image, int32_t words, dehyst_real *memory, int32_t reals,
                          dehyst_block *block);

/* DEHYST_IMAGE_GOOD if parameters are those of a block, whatever their source, else DEHYST_IMAGE_INVALID. */
int32_t dehyst_block_check(const dehyst_block *block);

/* 1 if an input can leave play states z: |z_i - z_{i+1}| <= r_{i+1} - r_i, to rounding. */
int dehyst_admissible(int32_t n, const dehyst_real *threshold, const dehyst_real *z);

/* CRC-32 (IEEE 802.3) of words, low byte first; write n reals, read n reals. The last two return where to go on;
 * reading returns a null pointer if some number is not one that dehyst_accept takes. */
uint32_t dehyst_image_sum(const uint32_t *words, int32_t count);
uint32_t *dehyst_image_put(uint32_t *at, const dehyst_real *values, int32_t n);
const uint32_t *dehyst_image_get(const uint32_t *at, dehyst_real *values, int32_t n);

/* sum + low += term, with all digits. */
void dehyst_accumulate(dehyst_real *sum, dehyst_real *low, dehyst_real term);

/* ---- The same step in O(log n), for many operators.
 *
 * The states of all plays are a stack of segments z_i = e - s r_i: operators that the input dragged up (s = +1) or down
 * (s = -1) to a turning point e and that nothing moved since. The lowest one, the floor, is what they held at first.
 * With cells z_i - z_{i+1} and slopes S_i = w_1 + ... + w_i
 *   y = offset + sum_{i<n} S_i (z_i - z_{i+1}) + S_n z_n.
 * Inside a segment a cell is s (r_{i+1} - r_i), so its part of the sum is a difference of loading curves; and while x
 * stays in a window only the cell at the edge of the top segment moves. A sample outside the window costs a bisection of
 * the stack and one of the thresholds. Nothing is summed over operators in a step, and nothing over time.
 * Start states must be admissible: |z_i - z_{i+1}| <= r_{i+1} - r_i. Also rejected are samples of which the model's
 * first map makes infinity. */

/* What does not change. A model without an operator of threshold 0 gets one of weight 0 in front. */
typedef struct dehyst_stack_model {
    dehyst_map before;            /* as in dehyst_model */
    dehyst_map after;             /* as in dehyst_model */
    int32_t n;                    /* number of operators, the added one included, >= 1 */
    int32_t added;                /* 1 if one was added, else 0 */
    int32_t half;                 /* largest power of two that is not above n: where bisections begin */
    const dehyst_real *threshold; /* (n + 1,) r, 0 = r_1, increasing; one more, beyond any input, [input] */
    const dehyst_real *slope;     /* (n,) S_i = w_1 + ... + w_i, [output/input] */
    const dehyst_real *loading;   /* (n,) phi_i = sum_{j<i} S_j (r_{j+1} - r_j), loading curve at r_i, [output] */
    dehyst_real center;           /* subtracted from the input, [input] */
    dehyst_real offset;           /* added to the output, [output] */
} dehyst_stack_model;

/* A segment below the top one: the operators from the end of the segment above it to its own. */
typedef struct dehyst_stack_segment {
    dehyst_real turn;    /* e, [input] */
    dehyst_real rest;    /* sum of S_i cell_i from its last cell, which reaches into the segment below, on, [output] */
    dehyst_real loading; /* s phi of its last operator, [output] */
    dehyst_real side;    /* s, +1 or -1; 0 for the floor */
    int32_t end;         /* one past its last operator */
} dehyst_stack_segment;

/* The caller owns it and the memory that the first five point to; n is that of dehyst_stack_model. */
typedef struct dehyst_stack_state {
    dehyst_stack_segment *segment; /* (n,) segments below the top one from 1 on; 0 stands for the floor */
    dehyst_real *bound[2];         /* (n,) each: segment k is gone once -x > bound[0][k] or x > bound[1][k], [input] */
    dehyst_real *start;            /* (n + 1,) play states of the floor, 0 beyond the last, [input] */
    dehyst_real *start_sum;        /* (n + 1,) sum of S_j cell_j over j >= i in the floor, [output] */
    int32_t depth;                 /* number of segments below the top one with the floor, 1 .. n */
    int32_t end;                   /* one past the last operator of the top segment, 1 .. n */
    int32_t rising;                /* 1: s = +1 in the top segment, 0: s = -1 */
    dehyst_real input;             /* e of the top segment: the last good input, centred, [input] */
    dehyst_real reach[2];          /* window: -x <= reach[0] and x <= reach[1], [input] */
    dehyst_real pivot, shift;      /* edge cell = (x - pivot) - shift, [input] */
    dehyst_real slope;             /* S of the edge cell, [output/input] */
    dehyst_real loading;           /* s phi of the last operator of the top segment, [output] */
    dehyst_real rest;              /* sum of S_i cell_i beyond the edge cell, [output] */
    dehyst_real output;            /* last good output, held while samples are rejected, [output] */
    uint32_t flags;                /* DEHYST_REJECTED, DEHYST_REJECTED_EVER */
} dehyst_stack_state;

/* Tables of a model, into memory of the caller: threshold (n + 2,), slope (n + 1,), loading (n + 1,), n the model's
 * number of operators. `stack` then points to them and to the model's maps. O(n). */
void dehyst_stack_prepare(const dehyst_model *model, dehyst_real *threshold, dehyst_real *slope, dehyst_real *loading,
                          dehyst_stack_model *stack);

/* Set the states to z0, one an operator of the model (none for an added one), and clear the flags. O(n). */
void dehyst_stack_reset(const dehyst_stack_model *model, dehyst_stack_state *state, const dehyst_real *z0);

/* One sample: dehyst_model_step to rounding. O(log n). */
dehyst_real dehyst_stack_step(const dehyst_stack_model *model, dehyst_stack_state *state, dehyst_real x);

/* Output that belongs to the present states. */
dehyst_real dehyst_stack_output(const dehyst_stack_model *model, const dehyst_stack_state *state);

/* Write the present play states z, one an operator of the model (none for an added one). O(n). */
void dehyst_stack_play(const dehyst_stack_model *model, const dehyst_stack_state *state, dehyst_real *z);

/* Build a state again, to the bit: begin with its play states, then push its segments, the lowest first, the top one
 * last, onto below = 0, 1, 2, ... with falling ends, n >= end >= 1. Flags stay. */
void dehyst_stack_begin(const dehyst_stack_model *model, dehyst_stack_state *state, const dehyst_real *z);
void dehyst_stack_push(const dehyst_stack_model *model, dehyst_stack_state *state, int32_t below, int32_t end,
                       int32_t rising, dehyst_real turn);

/* ---- Direct inverse: the input that an actuator needs, identified as a function of its output. Not rate independent.
 *
 *   u = sum_c h_c [ P_c(y - center) + sum_i s_ci E_i + sum_k p_ck R_k + sum_j k_cj (y - L_j) + d_c v ]
 *
 *   E   stop operator of radius r: E = y - z, z the play of threshold r
 *   R   lag along the path of length x (element of Dahl, 1968): dR = dy - R |dy|/x
 *   L   lag of time constant tau (creep): L += (1 - exp(-T/tau)) (y - L)
 *   v   rate of y
 *   h   without schedule one set of weights, h = 1. Schedule number v adds two: xi = (sigma_v - low_v)/(high_v - low_v)
 *       within 0 .. 1, set 2v is taken times 1 - xi and set 2v + 1 times xi, all of them summed.
 * With weights >= 0 every term but P opposes motion. Terms of one group have a common scale that may be learned.
 *
 * Unknown memory: a stop keeps the lowest and the highest play state that some past can have left; it answers in the
 * middle, which is 0 as long as nothing is known, so that a compensator comes in with what it knows. Lags of unknown
 * past start from y at rest. `doubt` of the state bounds what all that can be wrong. */

#define DEHYST_DEGREE 8    /* most coefficients of a polynomial, lowest power first */
#define DEHYST_SCHEDULES 3 /* most schedules */
#define DEHYST_GROUPS 8    /* most groups of terms */
#define DEHYST_GIVEN 3     /* scheduling variables that come from outside */

enum { /* what a schedule follows */
    DEHYST_BY_OUTPUT = -1 /* y itself; 0, 1 or 2: the variable from outside of that number */
};

enum { /* past of a direct inverse at a reset; creep is at rest but for the first one */
    DEHYST_PAST_UNKNOWN = 0, /* anything */
    DEHYST_PAST_REST = 1,    /* nothing, as after a homing */
    DEHYST_PAST_RISING = 2,  /* strokes to input_high, to input_low, and up to y */
    DEHYST_PAST_FALLING = 3  /* strokes to input_low, to input_high, and down to y */
};

typedef struct dehyst_direct {
    int32_t coefficients;             /* of P_c, 1 .. DEHYST_DEGREE */
    int32_t stops, paths, creeps;     /* number of E, R and L */
    int32_t schedules;                /* 0 .. DEHYST_SCHEDULES */
    int32_t groups;                   /* 1 .. DEHYST_GROUPS */
    int32_t past;                     /* DEHYST_PAST_...: what the actuator did before the y of a reset */
    const dehyst_real *radius;        /* (stops,) r > 0, [y] */
    const dehyst_real *length;        /* (paths,) x > 0, [y] */
    const dehyst_real *gain;          /* (creeps,) 1 - exp(-T/tau) */
    const dehyst_real *weight;        /* (sets, terms): P, E, R, L, v in this order, [u], [u/y] */
    const int32_t *group;             /* (terms - coefficients,) group of each term, 0 .. groups - 1 */
    int32_t source[DEHYST_SCHEDULES]; /* what the schedule follows */
    dehyst_real low[DEHYST_SCHEDULES], high[DEHYST_SCHEDULES]; /* its range, [sigma] */
    dehyst_real center;                  /* [y] */
    dehyst_real input_low, input_high;   /* identified range: beyond it P and schedules of y are held, [y] */
    dehyst_real output_low, output_high; /* no u lies beyond, [u] */
} dehyst_direct;

/* Terms of a set; reals of memory that a state needs. */
#define DEHYST_DIRECT_TERMS(coefficients, stops, paths, creeps) ((coefficients) + (stops) + (paths) + (creeps) + 1)
#define DEHYST_DIRECT_REALS(stops, paths, creeps) (2 * ((stops) + (paths) + (creeps)))

typedef struct dehyst_direct_state {
    dehyst_real *memory;             /* lowest plays, highest plays (stops,), R, doubt (paths,), L, doubt (creeps,) */
    dehyst_real last;                /* last y, [y] */
    dehyst_real curve;               /* sum of the P_c, [u] */
    dehyst_real part[DEHYST_GROUPS]; /* what each group adds, [u] */
    dehyst_real doubt[DEHYST_GROUPS]; /* what each group can be wrong by for the unknown start, [u] */
    uint32_t flags;                  /* DEHYST_REJECTED, _EVER, DEHYST_LIMITED, _EVER */
} dehyst_direct_state;

/* 1 if dehyst_accept takes all scheduling variables. */
int dehyst_accept_given(const dehyst_real given[DEHYST_GIVEN]);

/* Begin at y, which must be acceptable, as `past` says. */
void dehyst_direct_reset(const dehyst_direct *direct, dehyst_direct_state *state, dehyst_real y);

/* Take over all that another state of the same parameters remembers; each keeps memory of its own. */
void dehyst_direct_follow(const dehyst_direct *direct, dehyst_direct_state *state, const dehyst_direct_state *other);

/* One sample: moves memory and writes curve, part and doubt. A sample with a number that is not finite or beyond
 * DEHYST_INPUT_LIMIT changes nothing but flags. */
void dehyst_direct_step(const dehyst_direct *direct, dehyst_direct_state *state, dehyst_real y, dehyst_real rate,
                        const dehyst_real given[DEHYST_GIVEN]);

/* curve + sum of scale (groups,) times part within the limits of the output; a null pointer: scales of 1. */
dehyst_real dehyst_direct_output(const dehyst_direct *direct, const dehyst_direct_state *state,
                                 const dehyst_real *scale);

/* Sum of the doubts times scales: the guaranteed half width of u. */
dehyst_real dehyst_direct_doubt(const dehyst_direct *direct, const dehyst_direct_state *state,
                                const dehyst_real *scale);

/* exp(-x) for x >= 0 without a library: within 1e-7 up to x = 0.5, 2e-3 of its value up to 4, in 0 .. 1 for any. */
dehyst_real dehyst_decay(dehyst_real x);

/* ---- A direct inverse as a function block of a machine: bounded for every input, switched without a bump. */

typedef struct dehyst_direct_block {
    dehyst_direct direct;                /* output_low .. output_high: what the actuator can be given */
    dehyst_real line_slope, line_offset; /* answer while off: line_offset + line_slope y, [u/y], [u] */
    dehyst_real fade;                    /* share of a switching that one sample makes, 1e-12 (float: 1e-6) .. 1 */
} dehyst_direct_block;

typedef struct dehyst_direct_block_state {
    dehyst_direct_state direct; /* its memory must point to numbers of its own before the reset */
    dehyst_real share;          /* 0 off .. 1 on */
    dehyst_real output;         /* last good output, [u] */
    uint32_t flags;             /* DEHYST_REJECTED, _EVER, DEHYST_LIMITED, _EVER */
    int32_t started;            /* 0 until the first good sample after the reset */
} dehyst_direct_block_state;

/* Nothing is remembered and flags are cleared; the first good sample begins at its y as `past` says. */
void dehyst_direct_block_reset(const dehyst_direct_block *block, dehyst_direct_block_state *state);

/* One sample; `on` may change at any time: the output fades between that of the inverse and the line's over 1/fade
 * samples, but for the first one after a reset. The memory follows y in either case. A sample with a number that is not
 * finite or beyond DEHYST_INPUT_LIMIT holds all of it. DEHYST_LIMITED: y beyond the identified range, or u at a limit.
 * output_low <= output <= output_high for every input, whatever its bits. While it is on and not fading the output is
 * that of dehyst_direct_output, to the bit. */
dehyst_real dehyst_direct_block_step(const dehyst_direct_block *block, dehyst_direct_block_state *state, dehyst_real y,
                                     dehyst_real rate, const dehyst_real given[DEHYST_GIVEN], int on);

/* ---- Elements: one machine for sums of memories, forward and, sample by sample, inverse.
 *
 *   after^-1(y) = offset + sum_k h_k w_k f_k(e_k),   x = before(u),   x' and z: those of the sample before
 *
 *   INPUT   e = x
 *   PLAY    e = z <- max(x - r, min(x + r, z))                             play operator
 *   STOP    e = x - z, z the play                                          stop operator
 *   CREEP   e = z <- z + g (t - z), t = max(x - r, min(x + r, z))          lag of a play in time: g = 1 - exp(-T/tau)
 *   RELAX   e = x - z of the sample before, then z as CREEP                what relaxes; with g = 1 and r = 0 the rate
 *   PAST    e = z of the sample before, then z as CREEP                    lag that knows past samples only
 *   PATH    e = z <- s r + exp(-|x - x'|/r) (z - s r), s the sign of x - x'   lag along the path (Dahl, 1968)
 *   WIDE    e = z <- play of radius r + g |x - x'|, 0 <= g < 1             play that widens with the rate
 *   PRODUCT e = z z+ of the sample before, each within -r .. r, then z as PAST without r; z+: of the next element, which
 *           is a PAST or a PRODUCT                                         Volterra's second order: creep of creep
 *
 * f is a piecewise linear map of any slopes, continued along its ends, or none; h is 1, or a schedule's share as in
 * dehyst_direct, where DEHYST_BY_OUTPUT is x'. Given the memory every e rises with x or stands still, so whoever makes the
 * tables can make sure that the sum rises with x whatever the memory is. Then each value has one solution x in
 * low .. high, and it is found exactly, to rounding, in a bounded number of rounds. */

enum { /* kinds */
    DEHYST_INPUT,
    DEHYST_PLAY,
    DEHYST_STOP,
    DEHYST_CREEP,
    DEHYST_RELAX,
    DEHYST_PAST,
    DEHYST_PATH,
    DEHYST_WIDE,
    DEHYST_PRODUCT,
    DEHYST_KINDS
};

typedef struct dehyst_element {
    int32_t kind;
    int32_t schedule;   /* whose share is h: 0: h = 1; 2v + 1: 1 - xi of schedule v, 2v + 2: xi */
    dehyst_real radius; /* r >= 0, that of PATH > 0, [x] */
    dehyst_real gain;   /* g, 0 .. 1 and below 1 for WIDE; for the period of the samples */
    dehyst_real weight; /* w */
    dehyst_map map;     /* f: u increasing, v any; n = 0: f(e) = e */
} dehyst_element;

#define DEHYST_SHARES (2 * DEHYST_SCHEDULES + 1) /* h: 1, then two of each schedule */

typedef struct dehyst_elements {
    int32_t n;                     /* >= 1 */
    const dehyst_element *element; /* (n,) */
    dehyst_map before, after;      /* increasing, n = 0 if there is none */
    dehyst_real offset;
    dehyst_real low, high;         /* of the x that solves */
    int32_t schedules;             /* 0 .. DEHYST_SCHEDULES */
    int32_t source[DEHYST_SCHEDULES]; /* what the schedule follows: DEHYST_BY_OUTPUT, or the given variable 0, 1 or 2 */
    dehyst_real schedule_low[DEHYST_SCHEDULES], schedule_high[DEHYST_SCHEDULES]; /* xi is 0 and 1 there */
} dehyst_elements;

typedef struct dehyst_elements_state {
    dehyst_real *z;     /* (n,), memory of the caller */
    dehyst_real last;   /* x of the sample before */
    dehyst_real output; /* last good answer of a step */
    dehyst_real step;   /* from the one before that: where a solution is looked for first */
    int32_t rounds;     /* that the last solution took, at most DEHYST_ROUNDS */
    uint32_t flags;     /* DEHYST_REJECTED, _EVER, DEHYST_LIMITED, _EVER: a solution at low or high */
} dehyst_elements_state;

/* Halvings that come down from any range to its rounding, relative. Rounds of a solution: 12 of Newton's method, and two for each
 * of them; see element_inverse.c. */
#ifdef DEHYST_FLOAT
#define DEHYST_HALVINGS 25
#define DEHYST_ROUNDING 1.2e-7f
#else
#define DEHYST_HALVINGS 54
#define DEHYST_ROUNDING 2.2e-16
#endif
#define DEHYST_ROUNDS (12 + 2 * DEHYST_HALVINGS)

/* At rest at x: all that follows it is there, and nothing relaxes. Flags are cleared; `output` is held until the first
 * good sample. */
void dehyst_elements_reset(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real x,
                           dehyst_real output);

/* One sample forward, u -> y, and backward, y -> u; `given` are the scheduling variables, null if none is used. A
 * sample with a number that is not finite or beyond DEHYST_INPUT_LIMIT, also behind a map, changes nothing but flags.
 * Where no u in range answers y, the nearest end is taken, and the memory follows it, as the actuator does. */
dehyst_real dehyst_elements_step(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real u,
                                 const dehyst_real *given);
dehyst_real dehyst_elements_solve_step(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real y,
                                       const dehyst_real *given);

/* Their parts. Shares h for the next sample; the sum at x, and its slope with x that rises from there or falls; the sum,
 * or each e, or nothing, with the memory moved to x; the x that gives a value. */
void dehyst_elements_shares(const dehyst_elements *sum, const dehyst_elements_state *state, const dehyst_real *given,
                            dehyst_real share[DEHYST_SHARES]);
dehyst_real dehyst_elements_value(const dehyst_elements *sum, const dehyst_elements_state *state,
                                  const dehyst_real *share, dehyst_real x, int rising, dehyst_real *slope);
dehyst_real dehyst_elements_follow(const dehyst_elements *sum, dehyst_elements_state *state, const dehyst_real *share,
                                   dehyst_real x);
void dehyst_elements_columns(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real x,
                             dehyst_real *column);
void dehyst_elements_advance(const dehyst_elements *sum, dehyst_elements_state *state, dehyst_real x);
dehyst_real dehyst_elements_solve(const dehyst_elements *sum, dehyst_elements_state *state, const dehyst_real *share,
                                  dehyst_real value);

/* DEHYST_IMAGE_GOOD if parameters, and a memory z (n,) with its last x, are those of elements, whatever their source,
 * else DEHYST_IMAGE_INVALID. That the sum rises is not checked. */
int32_t dehyst_elements_check(const dehyst_elements *sum);
int32_t dehyst_elements_memory_check(const dehyst_elements *sum, const dehyst_real *z, dehyst_real last);

/* ---- Two inputs that act on two outputs, such as the axes of a stage or the muscles of a joint.
 *
 *   output_j = level_j + amplitude_j (path_j0 at x_0 + path_j1 at x_1),   x_i = (input_i - center_i)/half_range_i
 *
 * Every path is a sum of elements without maps and schedules of its own. The paths [0][0] and [1][1] rise; the other
 * two rise or fall. Where the determinant of the four slopes stays above 0, two outputs have one pair of inputs, and it
 * is found to rounding in a bounded number of rounds: at most 12 + DEHYST_HALVINGS solutions of path [1][1]. */

typedef struct dehyst_pair {
    dehyst_elements path[2][2];             /* [output][input]; low .. high of [i][i] are the limits of x_i */
    dehyst_real center[2], half_range[2];   /* half_range is not 0, [input] */
    dehyst_real level[2], amplitude[2];     /* amplitude is not 0, [output] */
    dehyst_real rest[2];                    /* x at which everything rests after a reset */
    int32_t solves;                         /* 0: inputs in, outputs out; 1: the other way round */
} dehyst_pair;

typedef struct dehyst_pair_state {
    dehyst_elements_state path[2][2]; /* each z (n,) must point to memory of its own before the reset */
    dehyst_real answer[2];            /* last good one */
    int32_t rounds;                   /* that the last solution took */
    uint32_t flags;                   /* DEHYST_REJECTED, _EVER; DEHYST_LIMITED, _EVER: an input at low or high */
} dehyst_pair_state;

/* At rest, flags cleared. */
void dehyst_pair_reset(const dehyst_pair *pair, dehyst_pair_state *state);

/* One sample of both. Where one of them is not finite or beyond DEHYST_INPUT_LIMIT, nothing changes but flags. */
void dehyst_pair_step(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real sample[2],
                      dehyst_real answer[2]);

/* Its part: the x that give the values of both sums; memory stands. */
void dehyst_pair_solve(const dehyst_pair *pair, dehyst_pair_state *state, const dehyst_real value[2], dehyst_real x[2]);

/* DEHYST_IMAGE_GOOD if parameters are those of a pair, else DEHYST_IMAGE_INVALID; slopes are not checked. */
int32_t dehyst_pair_check(const dehyst_pair *pair);

/* Dead time of n samples; `ring` (n,) is memory of the caller, what comes out first at `at`. Returns x of n samples ago. */
typedef struct dehyst_delay {
    int32_t n;         /* 0: none */
    int32_t at;        /* 0 .. n - 1 */
    dehyst_real *ring; /* (n,) */
} dehyst_delay;

dehyst_real dehyst_delay_step(dehyst_delay *delay, dehyst_real x);

/* ---- A sum of elements, or what solves it, as a function block of a machine: bounded for every input, switched without
 * a bump, saved and restored.
 *
 *   v = before((input - center)/half_range), late by the dead time
 *   output = level + amplitude after(w),   w: the sum at v, or the x in low .. high at which the sum is v
 *
 * Where the answer meets its limit, memory follows what was answered: it stays that of an actuator that got it. */

typedef struct dehyst_element_block {
    dehyst_elements sum;                 /* maps before and after as they are run through here; low .. high of all x */
    int32_t solves;                      /* 0: the sum is evaluated, 1: it is solved */
    int32_t delay;                       /* of the input, samples */
    const dehyst_real *start;            /* (n,) memory at x = origin, from where one stroke leads to the first sample;
                                          * null: at rest at the first sample */
    dehyst_real echo;                    /* share of the delayed input in what the sum is given, 0 .. 1: 1 is a dead
                                          * time, less a zero-vibration shaper, whose two parts cancel a resonance */
    dehyst_real origin;
    dehyst_real center, half_range;      /* half_range is not 0, [input] */
    dehyst_real level, amplitude;        /* [output] */
    dehyst_real input_low, input_high;   /* inputs beyond are taken as the limit, [input] */
    dehyst_real output_low, output_high; /* no output lies beyond, [output] */
    dehyst_real reach_low, reach_high;   /* of the sum, where it is evaluated: there x is held back; DEHYST_FAR: nowhere */
    dehyst_real line_slope, line_offset; /* answer while off: line_offset + line_slope input, [output/input], [output] */
    dehyst_real fade;                    /* share of a switching that one sample makes, 1e-12 (float: 1e-6) .. 1 */
    uint32_t fingerprint;                /* of the model: images of another one are refused */
} dehyst_element_block;

typedef struct dehyst_element_block_state {
    dehyst_elements_state sum; /* its z (n,) and the ring (delay,) must point to memory before the reset */
    dehyst_delay delay;
    dehyst_real share;         /* 0 off .. 1 on */
    dehyst_real output;        /* last good output, [output] */
    dehyst_real least;         /* x that the actuator had for certain: a play of a radius of half */
    dehyst_real most;          /* their distance or less is known */
    uint32_t flags;            /* DEHYST_REJECTED, _EVER, DEHYST_LIMITED, _EVER */
    int32_t started;           /* 0 until the first good sample after the reset */
} dehyst_element_block_state;

/* Nothing is remembered and flags are cleared; the first good sample begins as the model says. */
void dehyst_element_block_reset(const dehyst_element_block *block, dehyst_element_block_state *state);

/* One sample, as dehyst_block_step; `given`: scheduling variables, any good numbers where there are none. The first good
 * sample after a reset of a block that solves takes four to ten evaluations more, at most 22 + DEHYST_HALVINGS. */
dehyst_real dehyst_element_block_step(const dehyst_element_block *block, dehyst_element_block_state *state,
                                      dehyst_real x, const dehyst_real given[DEHYST_GIVEN], int on);

/* One sample while something else drives the actuator: in place of a step, with what a step would have been given and
 * what it would have answered. For an inverse block these are the actuator's measured output and the input that it got.
 * Memory follows the input of the sum; what the sum should be tells of the plays that are not known yet:
 *
 *   most - r <= z <= least + r,   least, most: of x since the start;   a play is known when these meet
 *   z <- z + 1/4 c b miss / sum of c^2 b within these bounds,   c = d sum/dz, b their distance
 *
 * so that the sum comes a quarter nearer to what was seen each time. Of a number that dehyst_accept refuses nothing is
 * learnt, and the other one is followed alone; beyond its limits it is taken as the limit. The next step with `on` goes on
 * from there without a ramp. */
void dehyst_element_block_observe(const dehyst_element_block *block, dehyst_element_block_state *state,
                                  dehyst_real input, dehyst_real output, const dehyst_real given[DEHYST_GIVEN]);

/* Parameters, and images of the state, as those of a block. */
#define DEHYST_ELEMENT_WORDS(n, delay) (6 + DEHYST_REAL_WORDS * ((n) + (delay) + 6))
int32_t dehyst_element_block_check(const dehyst_element_block *block);
int32_t dehyst_element_block_save(const dehyst_element_block *block, const dehyst_element_block_state *state,
                                  uint32_t *image, int32_t words);
int32_t dehyst_element_block_restore(const dehyst_element_block *block, dehyst_element_block_state *state,
                                     const uint32_t *image, int32_t words);

/* ---- An offset that follows the last cycle: for an actuator whose loop keeps its shape and wanders as a whole.
 *
 *   d = measured - said,   said: what a forward block answered, or what an inverse one was asked for
 *   target = mean of d over the last cycle, two strokes of x between turning points, within +-limit
 *   applied goes towards the target by at most part |x - x'|, x' the sample before
 *
 * Added to what a forward block answers, taken from what an inverse one is asked for. It moves with the way of x only:
 * where x rests, the offset rests; what is given on is continuous in x, and with part < 1 it turns where x turns. A step
 * uses measurements of samples before it alone. A stroke of which more than an eighth was off, limited or without a
 * measurement teaches nothing. */

typedef struct dehyst_offset {
    dehyst_real limit;    /* >= 0, [output of the actuator] */
    dehyst_real turn;     /* way back of x that makes a turning point, > 0, [x] */
    dehyst_real part;     /* of the offset that comes in along a way of 1, >= 0, [output/x] */
    uint32_t fingerprint; /* images of another one are refused */
} dehyst_offset;

typedef struct dehyst_offset_state {
    dehyst_real target;  /* of the last cycle, within +-limit, [output] */
    dehyst_real applied; /* in use, within +-limit, [output] */
    dehyst_real last;    /* x of the sample before, [x] */
    dehyst_real extreme; /* farthest x of this stroke, [x] */
    dehyst_real mean[2]; /* of d in this stroke and in the one before, [output] */
    int32_t good[2];     /* samples in them; 0: the one before does not count */
    int32_t bad;         /* samples of this stroke that do not count */
    int32_t phase;       /* 0 nothing seen, 1 never turned, 2 falling, 3 rising */
} dehyst_offset_state;

void dehyst_offset_reset(dehyst_offset_state *state);

/* Offset for a sample x, from before its measurement; where `on` is 0 it is held. */
dehyst_real dehyst_offset_next(const dehyst_offset *offset, const dehyst_offset_state *state, dehyst_real x, int on);

/* The same, and then what was measured is taken in. `share` and `flags` are those of the block after this sample: where
 * it was rejected nothing is done, and limited or not wholly on it does not count. Nor does a measurement that
 * dehyst_accept refuses. */
dehyst_real dehyst_offset_step(const dehyst_offset *offset, dehyst_offset_state *state, dehyst_real x,
                               dehyst_real said, dehyst_real measured, dehyst_real share, uint32_t flags,
                               int on);

/* Image of the state in DEHYST_OFFSET_WORDS words. */
#define DEHYST_OFFSET_WORDS (7 + 6 * DEHYST_REAL_WORDS)
void dehyst_offset_save(const dehyst_offset *offset, const dehyst_offset_state *state, uint32_t *image);
int32_t dehyst_offset_restore(const dehyst_offset *offset, dehyst_offset_state *state, const uint32_t *image);

/* ---- Learning while running: scales of the groups and an offset, from what the actuator needed at its measured output.
 *
 *   e = measured - (curve + offset + sum_g scale_g part_g)
 *   scale_g += mu e part_g/(noise^2 + unit^2 + sum part^2),  offset likewise with `unit` for its part,  mu = rate T <= 1
 * and back into lowest .. highest and +-offset_limit: scales stay >= 0, so that whatever is learned opposes motion as the
 * model does and is invertible with it. An error beyond most_error and beyond contact_ratio times the usual one is contact:
 * learning rests until it is over. If errors were usual for `settling` before, with terms as large, it is held for as long
 * as it lasts: hysteresis does not change at once. Else, if it stays, the usual error grows by what was cut, and after a while it is learned as
 * the actuator's own: usual += T/patience (limit^2 - usual), at most exp((contact_ratio^2 - 1) t/patience). What was learned is used while its squared error, remembered over `memory`, is
 * below that of scales 1 and offset 0; else these are. Normalised and projected: nothing that is measured can make it
 * leave its bounds. */

typedef struct dehyst_adaptation {
    dehyst_real rate;            /* share of the error that a second of full excitation takes away, [1/s]; 0: never */
    dehyst_real memory;          /* over which errors are compared, and learned values faded in, [s] */
    dehyst_real noise;           /* size of a signal that teaches nothing, > 0, [u] */
    dehyst_real dead_zone;       /* errors below teach nothing, [u] */
    dehyst_real most_error;      /* errors beyond are something else, contact: nothing is learned from them, [u], */
    dehyst_real contact_ratio;   /* unless they are below so many times the usual error; 0: never */
    dehyst_real first_error;     /* usual error at first, [u] */
    dehyst_real patience;        /* over which larger errors that stay become the usual ones, [s] */
    dehyst_real rest;            /* without learning after a large error, [s] */
    dehyst_real settling;        /* of usual errors, after which a large one is never learned, [s]; 0: there is none */
    dehyst_real lowest, highest; /* of a scale, 0 <= lowest <= 1 <= highest */
    dehyst_real offset_limit;    /* [u]; 0: no offset */
    dehyst_real unit;            /* size that the offset has as a signal, [u] */
} dehyst_adaptation;

typedef struct dehyst_learning {
    dehyst_real scale[DEHYST_GROUPS];   /* learned */
    dehyst_real offset;
    dehyst_real applied[DEHYST_GROUPS]; /* in use */
    dehyst_real curve;                  /* scale of the curve, in use: 1, or that of all if the model does not fit */
    dehyst_real applied_offset;
    dehyst_real error;                  /* mean square error of what was learned, [u^2] */
    dehyst_real error_before;           /* of the model as it was identified */
    dehyst_real usual;                  /* mean square error of what was learned, large ones cut, [u^2] */
    dehyst_real resting;                /* time without learning that is left, [s] */
    dehyst_real settled;                /* time of usual errors, at most twice `settling`, [s] */
    dehyst_real large;                  /* time of large errors in a row, after usual ones, [s] */
    dehyst_real held;                   /* > 0: contact began after usual errors; time until it counts as over, [s] */
    dehyst_real tried[DEHYST_GROUPS];   /* largest size of each term while errors were usual, [u] */
} dehyst_learning;

/* As identified. */
void dehyst_learning_reset(const dehyst_adaptation *adaptation, dehyst_learning *learning);

/* Learn anew: what is in use fades to the model as it was identified. */
void dehyst_learning_forget(const dehyst_adaptation *adaptation, dehyst_learning *learning);

/* Nothing is known of usual errors: contact is not held, until they are again. */
void dehyst_learning_unsettle(dehyst_learning *learning);

/* One sample at a period [s]: what the actuator needed, `measured`, beside the model's answer at the measured output. While
 * `frozen` nothing is learned, and what is in use still goes towards what was. Returns 1 if something was. */
int dehyst_learning_step(const dehyst_adaptation *adaptation, dehyst_learning *learning, int32_t groups,
                         dehyst_real period, dehyst_real curve, const dehyst_real *part, dehyst_real measured,
                         dehyst_real fitting, int frozen);

/* ---- One joint of two antagonistic muscles: position controller, static characteristic, compensator, pressure loops.
 *
 *   Q_d = M (qdd_d + 3 L (qd_d - qd) + 3 L^2 (q_d - q)) + I + Q_load    poles of the error at -L, I' = M L^3 (q_d - q)
 *   dp_d = (Q_d + direct(q_d) - A(q) p_m - C(q))/B(q) + compensator(q_d)    inverse of Q = A p_m + B dp + C
 *   p_1,2 = p_m +- dp/2
 *   mdot_d = V/(n R T) (dp_d/dt + k_p (p_d - p)) + p Vdot/(R T)         flatness-based pressure loop, one a muscle
 * A second memory of the direct inverse follows the measured angle: what the observer sees beyond direct(q) is contact.
 * SI units. Nothing here allocates, calls a library or loops without a bound. */

/* Nominal valve and air as the controller believes them (ISO 6358); the true ones differ. */
typedef struct dehyst_pneumatics {
    dehyst_real supply;            /* absolute, [Pa] */
    dehyst_real ambient;           /* absolute, [Pa] */
    dehyst_real gas_temperature;   /* R T, [J/kg] */
    dehyst_real polytropic;        /* n */
    dehyst_real reference_density; /* rho_0, [kg/m^3] */
    dehyst_real conductance;       /* C of the fully open valve, [m^3/(s Pa)] */
    dehyst_real ratio;             /* critical pressure ratio b */
    dehyst_real dead_band;         /* half width of the valve's dead band, share of the stroke; compensated */
} dehyst_pneumatics;

typedef struct dehyst_joint {
    dehyst_real period;                   /* of the control, T, [s] */
    dehyst_real inertia;                  /* nominal M, [kg m^2] */
    dehyst_real pole;                     /* L (lambda): error poles of the position loop, [1/s] */
    dehyst_real observer_pole;            /* of the observer of q, qd and load, [1/s] */
    dehyst_real pressure_gain;            /* k_p, [1/s] */
    dehyst_real windup_gain;              /* back-calculation while pressures or valves saturate, [1/s] */
    dehyst_real a[DEHYST_DEGREE];         /* A(q) = sum a_j q^j, [Nm/Pa] */
    dehyst_real b[DEHYST_DEGREE];         /* B(q), > 0 over the joint's range, [Nm/Pa] */
    dehyst_real c[DEHYST_DEGREE];         /* C(q), [Nm] */
    dehyst_real volume[2][4];             /* V_i(q) = sum v_j q^j of both chambers, [m^3] */
    dehyst_real angle_low, angle_high;    /* range of the calibration: A, B, C, V are held beyond it, [rad] */
    dehyst_real pressure_low;             /* smallest commanded gauge pressure of a muscle, [Pa] */
    dehyst_real pressure_high;            /* largest, [Pa] */
    dehyst_real ramp;                     /* time over which a switched term fades in and out, [s] */
    dehyst_real shear;                    /* k of the sheared loop x = dp - dp_nom + k q, [Pa/rad] */
    dehyst_real compensator_unit;         /* [Pa] of one unit of the compensator's output */
    const dehyst_model *compensator;      /* H^-1: q_d -> x, or a null pointer: no compensator, no shear term */
    const dehyst_direct *direct;          /* q_d -> torque, [Nm]; given: p_m [Pa], Q_load [Nm]; or a null pointer */
    dehyst_adaptation adaptation;         /* of `direct`, [Nm] */
    dehyst_real most_acceleration;        /* of the reference; beyond, inertia would be learned as hysteresis, [rad/s^2] */
    dehyst_real least_speed;              /* of the reference; below, a drift would be learned as hysteresis, [rad/s] */
    dehyst_real disturbance_pole;         /* of the feedback of the contact torque, [1/s] */
    dehyst_pneumatics pneumatics;
    dehyst_real angle_jump;               /* largest credible distance of the angle from its prediction, [rad]; 0: any */
    dehyst_real pressure_jump;            /* largest credible change of a pressure in a period, [Pa]; 0: any */
    dehyst_real angle_step;               /* resolution of the encoder, [rad] */
    int32_t frozen_samples;               /* equal samples of a sensor in a row that mean it is frozen; 0: never */
    int32_t hold_samples;                 /* faulty samples bridged by prediction; beyond it the joint fails safe */
} dehyst_joint;

#define DEHYST_TORQUE_LIMIT ((dehyst_real)1e6) /* that no joint has, [Nm]: nothing that `direct` adds is larger */

enum { /* what is switched on */
    DEHYST_POSITION = 1u,    /* position control; otherwise the reference's pressure difference is applied */
    DEHYST_INTEGRATOR = 2u,  /* integrator of the position loop */
    DEHYST_COMPENSATOR = 4u, /* hysteresis compensator and the reference's `extra`; its state follows q_d in either case */
    DEHYST_ADAPT = 8u,       /* the scales of `direct` are learned */
    DEHYST_DISTURBANCE = 16u /* the contact torque is fed back: what `direct` gives already is not in it */
};

enum { /* flags of the output */
    DEHYST_ANGLE_FAULT = 1u,       /* NaN, jump or frozen: the prediction is used */
    DEHYST_PRESSURE_FAULT_1 = 2u,
    DEHYST_PRESSURE_FAULT_2 = 4u,
    DEHYST_FAILED = 8u,            /* a fault outlasted hold_samples: valves closed until a reset (sticky) */
    DEHYST_PRESSURE_LIMIT = 16u,   /* desired pressures were limited */
    DEHYST_VALVE_LIMIT = 32u,      /* a valve was limited */
    DEHYST_REFERENCE_FAULT = 64u,  /* reference not finite: the last good one is held */
    DEHYST_FAULT_EVER = 128u,      /* some sensor or reference fault since the reset (sticky) */
    DEHYST_LEARNED = 256u,         /* this period taught the adaptation something */
    DEHYST_STALE = 512u,           /* the compensator's model does not fit: it is scaled down to what there is */
    DEHYST_SHIFTED = 1024u,        /* an offset of the torque, the same both ways: a pressure sensor or a weight */
    DEHYST_TOUCHED = 2048u         /* a torque that came at once and is none of the joint's: a hand, a wall, a load */
};

typedef struct dehyst_joint_reference {
    dehyst_real angle;               /* q_d, [rad] */
    dehyst_real velocity;            /* [rad/s] */
    dehyst_real acceleration;        /* [rad/s^2] */
    dehyst_real load;                /* Q_load: torque of gravity and coupling at the reference, [Nm] */
    dehyst_real mean_pressure;       /* p_m, gauge, [Pa] */
    dehyst_real pressure_difference; /* dp to apply without DEHYST_POSITION, [Pa] */
    dehyst_real extra;               /* compensator term from outside, added to the built-in one, [Pa] */
} dehyst_joint_reference;

typedef struct dehyst_joint_sensors {
    dehyst_real angle;       /* [rad] */
    dehyst_real pressure[2]; /* gauge, [Pa] */
} dehyst_joint_sensors;

typedef struct dehyst_joint_output {
    dehyst_real valve[2];            /* command, -1..1, > 0 fills */
    dehyst_real desired[2];          /* p_d of both muscles after limits, gauge, [Pa] */
    dehyst_real pressure_difference; /* dp_d before limits, at most 4 (pressure_high - pressure_low), [Pa] */
    dehyst_real torque;              /* Q_d of the position law; without DEHYST_POSITION A p_m + B dp_d + C, [Nm] */
    dehyst_real integrator;          /* I, [Nm] */
    dehyst_real compensation;        /* compensators' part of dp_d, [Pa] */
    dehyst_real angle, velocity;     /* observed q, qd */
    dehyst_real load;                /* observed torque beyond Q_load (same sign), not used by the controller, [Nm] */
    dehyst_real contact;             /* what of it `direct` does not explain either, [Nm]; 0 without `direct` */
    dehyst_real doubt;               /* what the torque of `direct` can be wrong by for an unknown past, [Nm] */
    uint32_t flags;
} dehyst_joint_output;

/* ---- State of a joint controller. */

typedef struct dehyst_fade {
    dehyst_real value; /* what is left of a term that was switched */
    dehyst_real step;  /* taken from it every period */
} dehyst_fade;

typedef struct dehyst_observer {
    dehyst_real angle;    /* q, [rad] */
    dehyst_real velocity; /* qd, [rad/s] */
    dehyst_real load;     /* torque that the model does not know, M qdd = Q - Q_load - load, [Nm] */
} dehyst_observer;

typedef struct dehyst_sensor {
    dehyst_real last; /* last good reading */
    int32_t equal;    /* readings in a row that equal it */
    int32_t faulty;   /* bridged samples: + 1 for a faulty one, - 1 for a good one, >= 0 */
} dehyst_sensor;

/* How well the compensator's torque h and the observed one l agree: see dehyst_fit_step. */
#define DEHYST_FIT_SUMS 6
#define DEHYST_FIT_REALS (23 + 2 * DEHYST_FIT_SUMS) /* of the structure: nothing else is in it */
typedef struct dehyst_fit {
    dehyst_real torque[4];               /* lags of h, the last one as the position loop answers, [Nm] */
    dehyst_real load[4];                 /* of l, [Nm] */
    dehyst_real angle[4];                /* of q, [rad] */
    dehyst_real stroke[DEHYST_FIT_SUMS]; /* integrals of hh, hl, ll, hq, lq, qq since the last turning point */
    dehyst_real sum[DEHYST_FIT_SUMS];    /* of the strokes before, forgotten */
    dehyst_real strokes;                 /* number of these, forgotten alike */
    dehyst_real way;                     /* -1, 0, 1 of the joint */
    dehyst_real rest, time;              /* since the last turning point: integral of l - h under position control, [Nm s], and time, [s] */
    dehyst_real mean;                    /* of l - h over the stroke before, [Nm] */
    dehyst_real offset;                  /* of l - h, the same both ways, [Nm] */
    dehyst_real shifted;                 /* 1: it is large: of a pressure sensor, or a weight that is not known */
    dehyst_real found;                   /* hysteresis that there is over that of the model */
    dehyst_real scale;                   /* of the compensator, in use: 1 while the model fits */
    dehyst_real stale;                   /* 1: the model does not fit */
    dehyst_real spoiled;                 /* 1: something touched the joint in this stroke, which says nothing of it then */
} dehyst_fit;

typedef struct dehyst_compared {
    dehyst_real torque, load;    /* h and l, [Nm] */
    dehyst_real angle, velocity; /* [rad], [rad/s] */
    dehyst_real largest;         /* torque of the joint, [Nm] */
    int position;                /* under position control */
    int touched;                 /* by a hand or a wall */
} dehyst_compared;

typedef struct dehyst_characteristic {
    dehyst_real a, b, c; /* A [Nm/Pa], B [Nm/Pa], C [Nm] at one angle */
} dehyst_characteristic;

/* Curve and groups of `direct` at the measured angle, as late as the observer sees their sum: three lags in a row. */
typedef struct dehyst_delayed {
    dehyst_real curve[3];
    dehyst_real part[DEHYST_GROUPS][3];
} dehyst_delayed;

/* The caller owns it, and `compensator.z` (n,), `wanted.memory` and `seen.memory`, which must point to memory before the
 * reset where there is a compensator or a `direct`. */
typedef struct dehyst_joint_state {
    dehyst_state compensator;
    dehyst_direct_state wanted;       /* memory of `direct` along q_d; along the measured q without position control */
    dehyst_direct_state seen;         /* along the measured q */
    dehyst_delayed delayed;
    dehyst_learning learning;
    dehyst_fit fit;
    dehyst_real torque_direct;        /* of `direct` at q_d, [Nm] */
    dehyst_real contact;              /* [Nm] */
    dehyst_real disturbance;          /* what of it is fed back, [Nm] */
    dehyst_real disturbance_share;    /* 0 off .. 1 on */
    dehyst_observer observer;
    dehyst_sensor angle;
    dehyst_sensor muscle[2];
    dehyst_real travel;               /* way that the observer sees while the encoder stands still, forgotten, [rad] */
    dehyst_real travel_most;          /* its largest size since the encoder last moved, [rad] */
    dehyst_real pressure[2];          /* last used, measured or bridged, gauge, [Pa] */
    dehyst_real desired[2];           /* last desired, gauge, [Pa] */
    dehyst_real feedforward[2];       /* part of them that is known from references alone, [Pa] */
    dehyst_real rate[2];              /* its smoothed derivative, [Pa/s] */
    dehyst_real expected[2];          /* how pressures should change under the last commands, [Pa/s] */
    dehyst_characteristic at;         /* at the observed angle */
    dehyst_real torque;               /* Q - Q_load of the last sample, [Nm] */
    dehyst_real pressure_difference;  /* last dp_d, [Pa] */
    dehyst_real compensator_share;    /* 0 off .. 1 on */
    dehyst_fade integrator;           /* I; it runs out while the integrator is off, [Nm] */
    dehyst_fade difference;           /* makes dp_d continuous when position control is switched, [Pa] */
    dehyst_fade mean;                 /* makes p_m continuous at the start, [Pa] */
    dehyst_fade exchanged;            /* makes the compensator continuous when it is exchanged, [Pa] */
    dehyst_joint_reference reference; /* last good one */
    uint32_t switches;                /* of the last period */
    uint32_t flags;                   /* sticky ones */
    int32_t started;                  /* 0 until the first period after the reset */
} dehyst_joint_state;

/* Start at the sensed angle with the last commanded pressures equal to the sensed ones; the compensator's states z0 (n,)
 * are those of the homing (a null pointer without compensator). From there p_m and dp_d run to those of the reference
 * over `ramp`. A sensor that is not finite here means DEHYST_FAILED. */
void dehyst_joint_reset(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors,
                        const dehyst_real *z0);

/* One period. `switches` may change at any time without a bump: a term that is switched fades over `ramp`. */
void dehyst_joint_step(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors,
                       const dehyst_joint_reference *reference, uint32_t switches, dehyst_joint_output *output);

/* Exchange the compensator (a null pointer: none) with its unit and shear while running; its term fades from the old
 * one to the new one over `ramp`. z (n,) is memory for its states, z0 (n,) their start. */
void dehyst_joint_exchange(dehyst_joint *joint, dehyst_joint_state *state, const dehyst_model *compensator,
                           dehyst_real unit, dehyst_real shear, dehyst_real *z, const dehyst_real *z0);

/* Save the state of a joint controller and go on from it, as for blocks; `fingerprint` is that of its parameters.
 * `state->compensator.z` must point to memory if there is a compensator. */
int32_t dehyst_joint_save(const dehyst_joint *joint, const dehyst_joint_state *state, uint32_t fingerprint,
                          uint32_t *image, int32_t words);
int32_t dehyst_joint_restore(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t fingerprint,
                             const uint32_t *image, int32_t words);

/* ---- Parts of it. */

/* x within +-limit; whatever is not a number becomes some value within. */
dehyst_real dehyst_bounded(dehyst_real x, dehyst_real limit);

/* Range of the pressures [Pa], the largest dp; share of a fading term that is lost in a period, 0..1. */
dehyst_real dehyst_pressure_range(const dehyst_joint *joint);
dehyst_real dehyst_fade_part(const dehyst_joint *joint);

/* Let a term fade from `value`, losing the share `part` (0..1) of it every period. */
void dehyst_fade_start(dehyst_fade *fade, dehyst_real value, dehyst_real part);
void dehyst_fade_step(dehyst_fade *fade);

/* A, B and C at an angle; B is kept away from zero. */
void dehyst_characteristic_at(const dehyst_joint *joint, dehyst_real angle, dehyst_characteristic *at);

/* Q = A p_m + B dp + C and its inverse dp = (Q - A p_m - C)/B. */
dehyst_real dehyst_characteristic_torque(const dehyst_characteristic *at, dehyst_real mean, dehyst_real difference);
dehyst_real dehyst_characteristic_difference(const dehyst_characteristic *at, dehyst_real mean, dehyst_real torque);

/* p_1,2 = p_m +- dp/2 within the limits: dp is kept by shifting the mean as long as it fits at all.
 * Returns 1 if anything was changed. */
int dehyst_pressures(const dehyst_joint *joint, dehyst_real mean, dehyst_real difference, dehyst_real *pressure);

/* One period of the observer: prediction with the mean known torque Q - Q_load of the period, then correction. */
void dehyst_observer_predict(const dehyst_joint *joint, dehyst_observer *observer, dehyst_real torque);
void dehyst_observer_correct(const dehyst_joint *joint, dehyst_observer *observer, dehyst_real angle);

/* 1 if a reading is not finite or further than `jump` from what was expected; counts equal readings. */
int dehyst_sensor_fault(dehyst_sensor *sensor, dehyst_real reading, dehyst_real expected, dehyst_real jump);

/* Guard the sensors, bridge faulty ones and advance the observer. Returns flags of the output. */
uint32_t dehyst_joint_sense(const dehyst_joint *joint, dehyst_joint_state *state, const dehyst_joint_sensors *sensors);

/* scale (unit H^-1[q_d] - shear q_d) of the last reference, 0 without compensator, [Pa] */
dehyst_real dehyst_compensator_term(const dehyst_joint *joint, const dehyst_joint_state *state, dehyst_real scale);

/* Move the memory of `direct` along the measured angle, learn from it if that is switched on, and write the contact torque.
 * Returns flags of the output. */
uint32_t dehyst_joint_estimate(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches, uint32_t flags);

/* Move the memory of `direct` along q_d, or along the measured angle without position control, and write its torque. */
void dehyst_joint_direct(const dehyst_joint *joint, dehyst_joint_state *state, uint32_t switches);

/* Compare the torques of compensator and observer of a period; `good`: they can be compared. */
void dehyst_fit_reset(dehyst_fit *fit);
void dehyst_fit_step(const dehyst_joint *joint, dehyst_fit *fit, const dehyst_compared *seen, int good);

/* `share` a `part` nearer to 0 or 1. */
dehyst_real dehyst_share_step(dehyst_real share, int on, dehyst_real part);

/* Count a sample that was good or faulty; 1 if the faulty ones can be bridged no longer. */
int dehyst_sensor_failed(dehyst_sensor *sensor, int faulty, int32_t hold_samples);

/* Square root of x >= 0 by Newton's method, within a few units in the last place; 0 for x <= 0. */
dehyst_real dehyst_root(dehyst_real x);

/* psi of ISO 6358: 1 up to the critical ratio b, sqrt(1 - ((ratio - b)/(1 - b))^2), straight to 0 above 0.999. */
dehyst_real dehyst_flow_function(dehyst_real ratio, dehyst_real critical);

/* Opening, -1..1 if the valve can do it, that makes the mass flow [kg/s] into a chamber at an absolute pressure [Pa]. */
dehyst_real dehyst_valve_opening(const dehyst_pneumatics *air, dehyst_real flow, dehyst_real pressure);

/* Command that opens a valve with the nominal dead band so far. */
dehyst_real dehyst_valve_command(const dehyst_pneumatics *air, dehyst_real opening);

/* V(q) [m^3] of a chamber and V'(q) [m^3/rad]. */
void dehyst_volume_at(const dehyst_joint *joint, int32_t muscle, dehyst_real angle, dehyst_real *volume,
                      dehyst_real *slope);

/* Mass flow [kg/s] that changes the absolute pressure p of a chamber at `rate` [Pa/s] while its volume changes, and
 * the rate that a mass flow makes. */
dehyst_real dehyst_chamber_flow(const dehyst_pneumatics *air, dehyst_real volume, dehyst_real volume_rate,
                                dehyst_real pressure, dehyst_real rate);
dehyst_real dehyst_chamber_rate(const dehyst_pneumatics *air, dehyst_real volume, dehyst_real volume_rate,
                                dehyst_real pressure, dehyst_real flow);

#ifdef __cplusplus
}
#endif

#endif
