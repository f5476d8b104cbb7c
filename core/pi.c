#include "dehyst.h"

/* sum_i w_i z_i = sum_{i<n} S_i (z_i - z_{i+1}) + S_n z_n,  S_i = w_1 + ... + w_i (Abel).
 * An inverse has weights far larger than its slopes S: the left side loses the digits that the right side keeps.
 *
 * Thresholds increase and states are admissible, so z_i + r_i and r_i - z_i increase with i: x drags along a first part
 * of the operators, found by bisection, and moves no other. Of these z_i = x - s r_i and z_i - z_{i+1} = s (r_{i+1} - r_i),
 * s = 1 upwards and -1 downwards, so that their part of the sum is s phi, read from a table. */

/* Knuth's two-sum: tables of 10 000 rows are as exact as those of 10. */
void dehyst_accumulate(dehyst_real *sum, dehyst_real *low, dehyst_real term)
{
    const dehyst_real total = *sum + term;
    const dehyst_real part = total - *sum;
    *low += (*sum - (total - part)) + (term - part);
    *sum = total;
}

void dehyst_pi_tables(int32_t n, const dehyst_real *threshold, const dehyst_real *weight, dehyst_real *slope,
                      dehyst_real *loading)
{
    dehyst_real total = 0;
    dehyst_real phi = 0;
    dehyst_real low = 0;
    for (int32_t i = 0; i < n; ++i) {
        if (i > 0) {
            dehyst_accumulate(&phi, &low, total * (threshold[i] - threshold[i - 1]));
        }
        total += weight[i];
        slope[i] = total;
        loading[i] = phi + low;
    }
}

/* Sum over the cells z_i - z_{i+1} from i = held on; what follows the last state is 0. */
static inline dehyst_real sum_beyond(const dehyst_pi *pi, const dehyst_real *z, int32_t held)
{
    const int32_t last = pi->n - 1;
    dehyst_real sum = 0;
    if (held > last) {
        return 0;
    }
    dehyst_real at = z[held];
    for (int32_t i = held; i < last; ++i) {
        const dehyst_real next = z[i + 1];
        sum += pi->slope[i] * (at - next);
        at = next;
    }
    return sum + pi->slope[last] * at;
}

/* H with the operators 0 .. held - 1 dragged so far that the last of them is at `edge`, held >= 1. */
static inline dehyst_real sum_dragged(const dehyst_pi *pi, const dehyst_real *z, int32_t held, dehyst_real s,
                                      dehyst_real edge, dehyst_real beyond)
{
    const dehyst_real next = held < pi->n ? z[held] : (dehyst_real)0;
    return pi->offset + ((s * pi->loading[held - 1] + pi->slope[held - 1] * (edge - next)) + beyond);
}

dehyst_real dehyst_pi_output(const dehyst_pi *pi, const dehyst_real *z)
{
    const dehyst_real *r = pi->threshold;
    if (pi->n < 2 || r[0] > 0) {
        return pi->offset + sum_beyond(pi, z, 0);
    }
    const dehyst_real s = z[1] < z[0] ? (dehyst_real)1 : (dehyst_real)-1; /* z_1 is the input */
    int32_t held = 1;
    while (held < pi->n && z[held] == z[0] - s * r[held]) {
        ++held;
    }
    return sum_dragged(pi, z, held, s, z[held - 1], sum_beyond(pi, z, held));
}

/* Number of operators that x drags along upwards, s = 1, or downwards, s = -1, if it is known to drag the first. */
static inline int32_t dragged(const dehyst_pi *pi, const dehyst_real *z, dehyst_real s, dehyst_real x)
{
    const dehyst_real *r = pi->threshold;
    int32_t held = 1;
    int32_t end = pi->n; /* the answer lies in held .. end */
    while (held < end) {
        const int32_t middle = held + (end - held) / 2;
        if (s > 0 ? x - r[middle] >= z[middle] : x + r[middle] <= z[middle]) {
            held = middle + 1;
        } else {
            end = middle;
        }
    }
    return held;
}

static inline void move(const dehyst_real *threshold, int32_t held, dehyst_real s, dehyst_real x, dehyst_real *z)
{
    if (s > 0) {
        for (int32_t i = 0; i < held; ++i) {
            z[i] = x - threshold[i];
        }
    } else {
        for (int32_t i = 0; i < held; ++i) {
            z[i] = x + threshold[i];
        }
    }
}

/* H[x] = wanted lies above `limit`, or below: go back, an operator less at a time, to the point where H meets the limit.
 * Where operator i begins to move, H = offset + s phi_i + beyond_i. */
static int hold_back(const dehyst_pi *pi, dehyst_real *z, int32_t held, dehyst_real s, dehyst_real x, int above,
                     dehyst_real limit, dehyst_real beyond, dehyst_real *output)
{
    const dehyst_real wanted = sum_dragged(pi, z, held, s, x - s * pi->threshold[held - 1], beyond);
    dehyst_real next = held < pi->n ? z[held] : (dehyst_real)0;
    dehyst_real there = wanted;
    dehyst_real end = x;
    for (int32_t i = held - 1; i >= 0; --i) {
        beyond += pi->slope[i] * (z[i] - next);
        there = pi->offset + (s * pi->loading[i] + beyond);
        const dehyst_real begin = z[i] + s * pi->threshold[i];
        if (above ? there <= limit : there >= limit) {
            const dehyst_real meets = begin + (limit - there) / pi->slope[i];
            const dehyst_real back = s > 0 ? dehyst_within(meets, begin, end) : dehyst_within(meets, end, begin);
            move(pi->threshold, i + 1, s, back, z);
            *output = limit;
            return DEHYST_MOVED | DEHYST_HELD_BACK;
        }
        next = z[i];
        end = begin; /* going back further moves no operator from i on */
    }
    if (above ? wanted < there : wanted > there) { /* it was beyond before, and x leads back */
        move(pi->threshold, held, s, x, z);
        *output = wanted;
        return DEHYST_MOVED | DEHYST_HELD_BACK;
    }
    return DEHYST_HELD_BACK;
}

int dehyst_pi_step(const dehyst_pi *pi, dehyst_real *z, dehyst_real x, dehyst_real low, dehyst_real high,
                   dehyst_real *output)
{
    const dehyst_real *r = pi->threshold;
    dehyst_real s = 1;
    if (x + r[0] < z[0]) {
        s = -1;
    } else if (!(x - r[0] > z[0])) {
        return 0;
    }
    const int32_t held = dragged(pi, z, s, x);
    const dehyst_real beyond = sum_beyond(pi, z, held);
    const dehyst_real wanted = sum_dragged(pi, z, held, s, x - s * r[held - 1], beyond);
    if (wanted > high && !(r[0] > 0)) {
        return hold_back(pi, z, held, s, x, 1, high, beyond, output);
    }
    if (wanted < low && !(r[0] > 0)) {
        return hold_back(pi, z, held, s, x, 0, low, beyond, output);
    }
    move(r, held, s, x, z);
    *output = wanted;
    return DEHYST_MOVED;
}
