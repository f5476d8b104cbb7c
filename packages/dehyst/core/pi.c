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

/* Sum over the cells z_i - z_{i+1} from i = held on, held < n; what follows the last state is 0. */
static inline dehyst_real sum_beyond(const dehyst_pi *pi, const dehyst_real *z, int32_t held)
{
    const int32_t last = pi->n - 1;
    dehyst_real sum = 0;
    dehyst_real at = z[held];
    for (int32_t i = held; i < last; ++i) {
        const dehyst_real next = z[i + 1];
        sum += pi->slope[i] * (at - next);
        at = next;
    }
    return sum + pi->slope[last] * at;
}

/* H with the operators 0 .. front dragged so far that the last of them is at `edge`, and the one behind it at `next`. */
static inline dehyst_real sum_dragged(const dehyst_pi *pi, int32_t front, dehyst_real s, dehyst_real edge,
                                      dehyst_real next, dehyst_real beyond)
{
    return pi->offset + ((s * pi->loading[front] + pi->slope[front] * (edge - next)) + beyond);
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
    const int any = held < pi->n;
    return sum_dragged(pi, held - 1, s, z[held - 1], any ? z[held] : (dehyst_real)0,
                       any ? sum_beyond(pi, z, held) : (dehyst_real)0);
}

/* Number of operators that x drags along upwards, if it is known to drag the first. */
static inline int32_t dragged_up(int32_t n, const dehyst_real *r, const dehyst_real *z, dehyst_real x)
{
    int32_t held = 1;
    int32_t last = n - 1; /* the answer lies in held .. last + 1; loops of its own for each direction are shorter */
    while (held <= last) {
        const int32_t middle = (held + last) >> 1;
        if (x - r[middle] >= z[middle]) {
            held = middle + 1;
        } else {
            last = middle - 1;
        }
    }
    return held;
}

static inline int32_t dragged_down(int32_t n, const dehyst_real *r, const dehyst_real *z, dehyst_real x)
{
    int32_t held = 1;
    int32_t last = n - 1;
    while (held <= last) {
        const int32_t middle = (held + last) >> 1;
        if (x + r[middle] <= z[middle]) {
            held = middle + 1;
        } else {
            last = middle - 1;
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

/* A step that cannot be made all the way. */
typedef struct excess {
    int32_t held;          /* operators that it would drag */
    dehyst_real s;         /* 1 upwards, -1 downwards */
    dehyst_real wanted;    /* H[x], beyond the limit */
    dehyst_real next;      /* state of the first operator that stays, 0 if there is none */
    dehyst_real beyond;    /* sum from there on */
} excess;

/* Go back, an operator less at a time, to the point where H meets the limit. Where operator i begins to move,
 * H = offset + s phi_i + beyond_i. */
static int hold_back(const dehyst_pi *pi, dehyst_real *z, dehyst_real x, const excess *step, int above,
                     dehyst_real limit, dehyst_real *output)
{
    const dehyst_real s = step->s;
    dehyst_real next = step->next;
    dehyst_real beyond = step->beyond;
    dehyst_real there = step->wanted;
    dehyst_real end = x;
    for (int32_t i = step->held - 1; i >= 0; --i) {
        beyond += pi->slope[i] * (z[i] - next);
        there = pi->offset + (s * pi->loading[i] + beyond);
        const dehyst_real begin = z[i] + s * pi->threshold[i];
        if (above ? there <= limit : there >= limit) {
            const dehyst_real missing = limit - there; /* 0 only without a division: the slope may be 0 as well */
            const dehyst_real meets = missing < 0 || missing > 0 ? begin + missing / pi->slope[i] : begin;
            const dehyst_real back = s > 0 ? dehyst_within(meets, begin, end) : dehyst_within(meets, end, begin);
            move(pi->threshold, i + 1, s, back, z);
            *output = limit;
            return DEHYST_MOVED | DEHYST_HELD_BACK;
        }
        next = z[i];
        end = begin; /* going back further moves no operator from i on */
    }
    if (above ? step->wanted < there : step->wanted > there) { /* it was beyond before, and x leads back */
        move(pi->threshold, step->held, s, x, z);
        *output = step->wanted;
        return DEHYST_MOVED | DEHYST_HELD_BACK;
    }
    return DEHYST_HELD_BACK;
}

int dehyst_pi_step(const dehyst_pi *pi, dehyst_real *z, dehyst_real x, dehyst_real low, dehyst_real high,
                   dehyst_real *output)
{
    const dehyst_real *r = pi->threshold;
    const int32_t n = pi->n;
    excess step = {0, 1, 0, 0, 0};
    dehyst_real edge = x;
    if (x + r[0] < z[0]) {
        step.s = -1;
        step.held = dragged_down(n, r, z, x);
        edge += r[step.held - 1];
    } else if (x - r[0] > z[0]) {
        step.held = dragged_up(n, r, z, x);
        edge -= r[step.held - 1];
    } else {
        return 0;
    }
    if (step.held < n) {
        step.next = z[step.held];
        step.beyond = sum_beyond(pi, z, step.held);
    }
    step.wanted = sum_dragged(pi, step.held - 1, step.s, edge, step.next, step.beyond);
    const int above = step.wanted > high;
    if ((above || step.wanted < low) && !(r[0] > 0)) {
        return hold_back(pi, z, x, &step, above, above ? high : low, output);
    }
    move(r, step.held, step.s, x, z);
    *output = step.wanted;
    return DEHYST_MOVED;
}
