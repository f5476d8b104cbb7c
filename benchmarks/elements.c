/* A block of 10 or 40 elements of all kinds, a third of them mapped: time and instructions of a step.
 *
 *   elements forward|inverse 10|40 SIGNAL SAMPLES RUNS
 *
 * prints nanoseconds back to back (the least of the runs), the mean and the largest number of rounds of a solution. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dehyst.h"

enum { N = 40, POINTS = 6 };

static dehyst_element element[N];
static double u[N][POINTS], v[N][POINTS], memory[N];
static dehyst_element_block block = {.sum.element = element, .sum.low = -2, .sum.high = 2,
                                     .half_range = 1, .amplitude = 1,
                                     .input_low = -10, .input_high = 10, .output_low = -10, .output_high = 10,
                                     .reach_low = -DEHYST_FAR, .reach_high = DEHYST_FAR, .fade = 1};
static dehyst_element_block_state state = {.sum.z = memory};
static const double given[DEHYST_GIVEN];

static void add(int count, int32_t kind, double first, double gain, double weight, int mapped)
{
    for (int i = 0; i < count; ++i) {
        const int32_t k = block.sum.n++;
        const double radius = first * (double)(i + 1) / count;
        element[k] = (dehyst_element){kind, 0, radius, gain / (i + 1), weight / count, {0, 0, 0}};
        if (i < mapped) {
            for (int j = 0; j < POINTS; ++j) {
                u[k][j] = 2.0 * j / (POINTS - 1) - 1.0;
                v[k][j] = u[k][j] + 0.3 * sin(3.0 * u[k][j]);
            }
            element[k].map = (dehyst_map){POINTS, u[k], v[k]};
        }
    }
}

static void build(int many)
{
    add(1, DEHYST_INPUT, 0.0, 0.0, 0.5, 1);
    add(many ? 16 : 3, DEHYST_PLAY, 0.8, 0.0, 0.5, many ? 6 : 1);
    add(many ? 8 : 1, DEHYST_STOP, 0.4, 0.0, 0.2, many ? 2 : 0);
    add(many ? 5 : 1, DEHYST_CREEP, 0.1, 0.02, 0.2, many ? 2 : 1);
    add(many ? 4 : 1, DEHYST_RELAX, 0.1, 0.02, 0.1, many ? 2 : 0);
    add(many ? 2 : 1, DEHYST_PAST, 0.1, 0.02, 0.1, 0);
    add(many ? 2 : 1, DEHYST_PATH, 0.3, 0.0, 0.1, 0);
    add(many ? 2 : 1, DEHYST_WIDE, 0.3, 0.5, 0.1, 0);
}

static double uniform(void)
{
    static uint64_t seed = UINT64_C(0x9e3779b97f4a7c15);
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (double)(seed >> 11) / 4503599627370496.0 - 1.0;
}

/* A sine of 2000 samples, the same with noise of 1 % of its range, white noise, steps from end to end. */
static void fill(double *x, int samples, const char *signal)
{
    for (int k = 0; k < samples; ++k) {
        const double sine = sin(3.14159265358979 * k / 1000.0);
        x[k] = strcmp(signal, "sine") == 0    ? sine
               : strcmp(signal, "noisy") == 0 ? sine + 0.02 * uniform()
               : strcmp(signal, "white") == 0 ? uniform()
                                              : (k / 7 % 2 ? 1.0 : -1.0);
    }
}

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double step(double x) { return dehyst_element_block_step(&block, &state, x, given, 1); }

int main(int count, char **word)
{
    if (count != 6) return 1;
    const int inverse = strcmp(word[1], "inverse") == 0, samples = atoi(word[4]), runs = atoi(word[5]);
    double *x = calloc((size_t)samples, sizeof *x), *y = calloc((size_t)samples, sizeof *y), best = 1e9, worst = 0.0;
    long rounds = 0, most = 0;
    if (!x || !y) return 2;
    build(strcmp(word[2], "40") == 0);
    fill(x, samples, word[3]);
    dehyst_element_block_reset(&block, &state);
    for (int k = 0; k < samples; ++k) y[k] = step(x[k]);
    block.solves = inverse;
    const double *in = inverse ? y : x, *out = inverse ? x : y;
    for (int run = 0; run < runs; ++run) {
        dehyst_element_block_reset(&block, &state);
        const double begin = seconds();
        for (int k = 0; k < samples; ++k) {
            const double miss = fabs(step(in[k]) - out[k]);
            worst = miss > worst ? miss : worst;
            rounds += state.sum.rounds;
            most = state.sum.rounds > most ? state.sum.rounds : most;
        }
        const double spent = (seconds() - begin) / samples * 1e9;
        best = spent < best ? spent : best;
    }
    printf("%.1f %.2f %ld %g\n", best, (double)rounds / runs / samples, most, worst);
    return worst > 1e-12;
}
