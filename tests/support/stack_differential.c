/* The core's step in O(log n) against its dense step, on random models and short signals.
 *
 *   stack_differential MODELS SAMPLES SEED
 *
 * n from 1 to 64; thresholds on a grid of integers, evenly spaced or random, from 0 or above; states at the start zero,
 * dragged or anywhere admissible; weights of both signs, many of them 0; inputs white, walking, shrinking or repeated,
 * on the grid where thresholds are. Prints the largest error of an output over the largest sum of |w_i z_i| (a small
 * input in front of old states leaves outputs that cancel), and that of a play state over the largest of them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"

enum { MOST = 64 };

static uint64_t seed;

static double uniform(void) /* 0..1 */
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (double)(seed >> 11) / 9007199254740992.0;
}

static int pick(int choices) { return (int)(uniform() * choices); }

static double size(double x) { return x < 0 ? -x : x; }

typedef struct trial {
    int n, grid;
    dehyst_real r[MOST], w[MOST], start[MOST];
} trial;

static void draw(trial *t)
{
    t->n = 1 + pick(MOST);
    t->grid = pick(3) == 0;
    const int even = pick(2);
    double at = pick(3) == 0 ? (t->grid ? 1.0 : 0.1) : 0.0;
    for (int i = 0; i < t->n; ++i) {
        t->r[i] = (dehyst_real)at;
        at += t->grid ? 1 + pick(2) : (even ? 1.0 : 0.05 + uniform()) / t->n;
        t->w[i] = (dehyst_real)(pick(4) == 0 ? 0.0 : uniform() - (t->grid ? 0.1 : 0.3 * uniform()));
    }
    const int kind = pick(3), last = t->n - 1;
    t->start[last] = (dehyst_real)(kind == 0 ? 0.0 : t->grid ? pick(9) - 4 : 4.0 * uniform() - 2.0);
    for (int i = last - 1; i >= 0; --i) {
        const double share = kind == 0 ? 0.0 : t->grid || pick(3) == 0 ? pick(3) - 1 : 2.0 * uniform() - 1.0;
        t->start[i] = (dehyst_real)(t->start[i + 1] + share * (double)(t->r[i + 1] - t->r[i]));
    }
}

static double next_input(const trial *t, int signal, int k, double last)
{
    const double range = t->grid ? 1.5 * t->n : 1.5;
    double x = last;
    if (pick(6) != 0) { /* otherwise repeated */
        x = signal == 0   ? range * (2.0 * uniform() - 1.0)
            : signal == 1 ? last + 0.3 * range * (uniform() - 0.5)
            : signal == 2 ? (k % 2 ? 1.0 : -1.0) * range * (1.0 - (double)(k % 40) / 40.0)
                          : 0.05 * range * (2.0 * uniform() - 1.0);
    }
    return t->grid ? (double)(int)x : x;
}

static double terms(const trial *t, const dehyst_real *z)
{
    double sum = 0;
    for (int i = 0; i < t->n; ++i) sum += size((double)(t->w[i] * z[i]));
    return sum;
}

static double larger(double a, double b) { return a >= b ? a : b; } /* b if one is not a number */

int main(int count, char **word)
{
    if (count != 4) return 1;
    seed = (uint64_t)atoi(word[3]) * UINT64_C(0x9e3779b97f4a7c15) + 1;
    double worst = 0, worst_play = 0;
    for (int m = atoi(word[1]); m > 0; --m) {
        trial t;
        draw(&t);
        dehyst_real z[MOST], other[MOST], threshold[MOST + 2], slope[MOST + 1], loading[MOST + 1];
        dehyst_real bound[2][MOST + 1], start[MOST + 2], start_sum[MOST + 2];
        dehyst_stack_segment segment[MOST + 1];
        dehyst_model model;
        memset(&model, 0, sizeof model);
        model.hysteresis.n = t.n;
        model.hysteresis.threshold = t.r;
        dehyst_real sums[MOST], curve[MOST];
        dehyst_pi_tables(t.n, t.r, t.w, sums, curve);
        model.hysteresis.slope = sums;
        model.hysteresis.loading = curve;
        dehyst_state dense = {z, 0, 0};
        dehyst_stack_model tables;
        dehyst_stack_state stack;
        memset(&stack, 0, sizeof stack);
        stack.segment = segment;
        stack.bound[0] = bound[0];
        stack.bound[1] = bound[1];
        stack.start = start;
        stack.start_sum = start_sum;
        dehyst_model_reset(&model, &dense, t.start);
        dehyst_stack_prepare(&model, threshold, slope, loading, &tables);
        dehyst_stack_reset(&tables, &stack, t.start);
        double error = size((double)(stack.output - dense.output)), most = terms(&t, t.start), x = 0;
        double play_error = 0, play_most = 0;
        const int signal = pick(4), samples = atoi(word[2]);
        for (int k = 0; k < samples; ++k) {
            x = next_input(&t, signal, k, x);
            const dehyst_real y = dehyst_model_step(&model, &dense, (dehyst_real)x);
            error = larger(error, size((double)(dehyst_stack_step(&tables, &stack, (dehyst_real)x) - y)));
            most = larger(most, terms(&t, z));
            if (stack.depth < 1 || stack.depth > tables.n || stack.end < 1 || stack.end > tables.n) return 2;
        }
        dehyst_stack_play(&tables, &stack, other);
        for (int i = 0; i < t.n; ++i) {
            play_error = larger(play_error, size((double)(z[i] - other[i])));
            play_most = larger(play_most, size((double)z[i]));
        }
        worst = larger(worst, most > 0 ? error / most : error);
        worst_play = larger(worst_play, play_most > 0 ? play_error / play_most : play_error);
    }
    printf("%.3e %.3e\n", worst, worst_play);
    return 0;
}
