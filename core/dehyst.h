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

#ifdef __cplusplus
extern "C" {
#endif

#ifdef DEHYST_FLOAT
typedef float dehyst_real;
#define DEHYST_INPUT_LIMIT 1e15f
#else
typedef double dehyst_real;
#define DEHYST_INPUT_LIMIT 1e100 /* beyond this no signal is physical, and sums could overflow */
#endif

enum {
    DEHYST_REJECTED = 1u,      /* the last sample was not finite or beyond DEHYST_INPUT_LIMIT */
    DEHYST_REJECTED_EVER = 2u  /* some sample since the last reset was rejected (sticky) */
};

/* Strictly monotone, piecewise linear map v(u), continued along its end segments. n = 0: identity. */
typedef struct dehyst_map {
    int32_t n;              /* number of breakpoints, 0 or >= 2 */
    const dehyst_real *u;   /* (n,) breakpoints, strictly increasing, [unit of the argument] */
    const dehyst_real *v;   /* (n,) values, strictly increasing or strictly decreasing, [unit of the result] */
} dehyst_map;

/* y = offset + sum_i w_i play_{r_i}[x - center] */
typedef struct dehyst_pi {
    int32_t n;                     /* number of play operators, >= 1 */
    const dehyst_real *threshold;  /* (n,) r, increasing, r_1 >= 0, [input] */
    const dehyst_real *weight;     /* (n,) w, [output/input] */
    dehyst_real center;            /* subtracted from the input, [input] */
    dehyst_real offset;            /* added to the output, [output] */
} dehyst_pi;

/* y = after(H[before(x)]): the modified Prandtl-Ishlinskii model, and by its closure its own inverse */
typedef struct dehyst_model {
    dehyst_map before;   /* memoryless map of the input, n = 0 if there is none */
    dehyst_pi hysteresis;
    dehyst_map after;    /* memoryless map of the output, n = 0 if there is none */
} dehyst_model;

typedef struct dehyst_state {
    dehyst_real *z;      /* (n,) play states of the centred input, [input of the hysteresis] */
    dehyst_real output;  /* last good output, held while samples are rejected, [output] */
    uint32_t flags;      /* DEHYST_REJECTED, DEHYST_REJECTED_EVER */
} dehyst_state;

/* 1 if x is finite and within the input limit, by bit pattern: -ffast-math cannot delete it. */
int dehyst_accept(dehyst_real x);

/* Advance n play states by the input x (already centred) in place. */
void dehyst_play_step(int32_t n, const dehyst_real *threshold, dehyst_real x, dehyst_real *z);

/* offset + sum_i w_i z_i, summed by slopes in a fixed order: the same bits from every compiler. */
dehyst_real dehyst_pi_output(const dehyst_pi *pi, const dehyst_real *z);

/* Value of a map at u. */
dehyst_real dehyst_map_value(const dehyst_map *map, dehyst_real u);

/* Output that belongs to the present states: what the model says before the first sample. */
dehyst_real dehyst_model_output(const dehyst_model *model, const dehyst_real *z);

/* Set the states to z0 (n,), the held output to the one that belongs to them, and clear the flags. */
void dehyst_model_reset(const dehyst_model *model, dehyst_state *state, const dehyst_real *z0);

/* One sample. A rejected sample holds the last good output, raises the flags and leaves z untouched. */
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

#ifdef __cplusplus
}
#endif

#endif
