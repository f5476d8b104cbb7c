/* One step of the core at a time: latency of single calls, throughput, or plain steps for an instruction counter.
 *
 *   step latency|steps dense|logarithmic N SIGNAL SAMPLES RUNS
 *
 * latency prints nanoseconds: median, maximum (each sample's minimum over the runs counts), back to back. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dehyst.h"

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#if defined(__x86_64__) || defined(__i386__)
#include <x86intrin.h>
static uint64_t ticks(void)
{
    _mm_lfence(); /* what came before has ended; what follows has not begun */
    const uint64_t now = __rdtsc();
    _mm_lfence();
    return now;
}
#else
static uint64_t ticks(void) { return (uint64_t)(1e9 * seconds()); }
#endif

static double ticks_per_nanosecond(void)
{
    const double begin = seconds();
    const uint64_t first = ticks();
    while (seconds() - begin < 0.05) {
    }
    const uint64_t last = ticks();
    return (double)(last - first) / ((seconds() - begin) * 1e9);
}

/* ---- The model, thresholds (i - 1)/n and weights that make the output of order one, and both ways to step it. */
typedef struct bench {
    dehyst_model model;
    dehyst_state dense;
    dehyst_stack_model tables;
    dehyst_stack_state stack;
    int logarithmic;
    double *zero;
} bench;

static void *block(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory) exit(2);
    return memory;
}

static double *reals(int n) { return block((size_t)n + 2, sizeof(double)); }

static void build(bench *b, int n, int logarithmic)
{
    memset(b, 0, sizeof *b);
    double *r = reals(n), *w = reals(n);
    for (int i = 0; i < n; ++i) {
        r[i] = (double)i / n;
        w[i] = (1.0 + (i % 7)) / (3.0 * n);
    }
    b->model.hysteresis.n = n;
    b->model.hysteresis.threshold = r;
    double *slope = reals(n), *loading = reals(n);
    dehyst_pi_tables(n, r, w, slope, loading);
    b->model.hysteresis.slope = slope;
    b->model.hysteresis.loading = loading;
    b->dense.z = reals(n);
    b->zero = reals(n);
    dehyst_stack_prepare(&b->model, reals(n), reals(n), reals(n), &b->tables);
    b->stack.segment = block((size_t)n + 1, sizeof *b->stack.segment);
    b->stack.bound[0] = reals(n);
    b->stack.bound[1] = reals(n);
    b->stack.start = reals(n);
    b->stack.start_sum = reals(n);
    b->logarithmic = logarithmic;
}

static void reset(bench *b)
{
    dehyst_model_reset(&b->model, &b->dense, b->zero);
    dehyst_stack_reset(&b->tables, &b->stack, b->zero);
}

static double step(bench *b, double x)
{
    return b->logarithmic ? dehyst_stack_step(&b->tables, &b->stack, x) : dehyst_model_step(&b->model, &b->dense, x);
}

/* ---- Signals within +-1: a sine of 20 s at 2 kHz, the same with noise of 1 % of its range, white noise, and two that
 * shrink by one threshold a half swing, so that every operator is a segment of its own: `wiped` then wipes all at once,
 * `torn` tears down to a random depth. */
static double uniform(void)
{
    static uint64_t seed = UINT64_C(0x9e3779b97f4a7c15);
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (double)(seed >> 11) / 4503599627370496.0 - 1.0;
}

static void fill(double *x, int samples, const char *signal, int n)
{
    int left = 0;
    for (int k = 0; k < samples; ++k) {
        const double sine = sin(2.0 * 3.14159265358979 * k / 40000.0);
        if (strcmp(signal, "sine") == 0) {
            x[k] = sine;
        } else if (strcmp(signal, "noisy") == 0) {
            x[k] = sine + 0.02 * uniform();
        } else if (strcmp(signal, "white") == 0) {
            x[k] = uniform();
        } else if (strcmp(signal, "wiped") == 0 || strcmp(signal, "torn") == 0) {
            const double size = (double)left / n;
            if (left == 0) {
                x[k] = signal[0] == 'w' ? 1.0 : uniform();
                left = n;
            } else {
                x[k] = left % 2 ? size : -size;
                --left;
            }
        } else {
            exit(3);
        }
    }
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void latency(bench *b, const double *x, int samples, int runs)
{
    const double scale = 1.0 / ticks_per_nanosecond();
    double *best = reals(samples), empty = 1e9, back = 1e9, sink = 0.0;
    for (int k = 0; k < samples; ++k) best[k] = 1e9;
    for (int k = 0; k < 1000; ++k) {
        const uint64_t begin = ticks();
        const double spent = (double)(ticks() - begin);
        empty = spent < empty ? spent : empty;
    }
    for (int run = 0; run < runs; ++run) {
        reset(b);
        for (int k = 0; k < samples; ++k) {
            const uint64_t begin = ticks();
            sink += step(b, x[k]);
            const double spent = (double)(ticks() - begin) - empty;
            best[k] = spent < best[k] ? spent : best[k];
        }
        reset(b);
        const double begin = seconds();
        for (int k = 0; k < samples; ++k) sink += step(b, x[k]);
        const double spent = (seconds() - begin) / samples * 1e9;
        back = spent < back ? spent : back;
    }
    int where = 0;
    for (int k = 0; k < samples; ++k)
        if (best[k] > best[where]) where = k;
    const double worst = best[where];
    qsort(best, (size_t)samples, sizeof *best, by_size);
    printf("%.1f %.1f %.1f %d %g\n", best[samples / 2] * scale, worst * scale, back, where, sink);
}

int main(int count, char **word)
{
    if (count != 7) return 1;
    const int n = atoi(word[3]), samples = atoi(word[5]);
    bench b;
    build(&b, n, strcmp(word[2], "logarithmic") == 0);
    double *x = reals(samples);
    fill(x, samples, word[4], n);
    if (strcmp(word[1], "latency") == 0) {
        latency(&b, x, samples, atoi(word[6]));
        return 0;
    }
    double sum = 0.0;
    reset(&b);
    for (int k = 0; k < samples; ++k) sum += step(&b, x[k]);
    return sum == 12345.678;
}
