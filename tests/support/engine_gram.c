/* The streaming normal equations against sums over cells written out, on random short signals.
 *
 * usage: engine_gram LEVEL SEED SIGNALS   ends with 1 and the first case that differs, with 2 if the level cannot run. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"

enum { MOST_N = 64, MOST_T = 400, MOST_M = 3, MOST = 1 + MOST_N + MOST_M };

static uint64_t random_state;

static double uniform(double low, double high)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    uint64_t a = random_state ^ (random_state >> 29);
    a *= UINT64_C(0xbf58476d1ce4e5b9);
    return low + (high - low) * (double)((a ^ (a >> 32)) >> 11) * 0x1p-53;
}

static int32_t below(int32_t n) { return (int32_t)uniform(0.0, (double)n); }

typedef struct problem {
    int32_t n, m;
    int64_t samples;
    int exact; /* integers, widths of cells 1 or 2: no operation rounds */
    double r[MOST_N], z[MOST_N];
    double x[MOST_T], f[MOST_M][MOST_T], weight[MOST_T];
    int weighted;
} problem;

static void step(int32_t n, const double *r, double x, double *z)
{
    for (int32_t i = 0; i < n; ++i) {
        z[i] = fmax(x - r[i], fmin(x + r[i], z[i]));
    }
}

static void make(problem *p, int32_t n)
{
    p->n = n;
    p->m = below(MOST_M + 1);
    p->samples = 1 + below(below(8) == 0 ? MOST_T : 60);
    p->exact = below(4) == 0;
    p->weighted = below(3) == 0;
    const int even = below(2);
    for (int32_t i = 0; i < n; ++i) {
        p->r[i] = i == 0 ? 0.0 : p->r[i - 1] + (p->exact ? 1 + below(2) : even ? 0.25 : uniform(0.01, 1.0));
        p->z[i] = 0.0;
    }
    const double range = (p->r[n - 1] + 1) * uniform(0.3, 1.5), rate = uniform(0.01, 1.0), noise = uniform(0.0, 0.2);
    const int kind = below(4), history = below(3) == 0 ? below(9) : 0;
    for (int k = 0; k < history; ++k) {
        step(n, p->r, p->exact ? floor(uniform(-range, range)) : uniform(-range, range), p->z);
    }
    double a = p->z[0];
    for (int64_t k = 0; k < p->samples; ++k) {
        a = kind == 0   ? uniform(-range, range)
            : kind == 1 ? a + range * uniform(-0.1, 0.1)
            : kind == 2 ? p->r[below(n)] * (below(2) ? 1 : -1)
                        : range * (sin(rate * (double)k) + uniform(-noise, noise));
        p->x[k] = p->exact ? floor(a) : k > 0 && below(12) == 0 ? p->x[k - 1] : a;
        p->weight[k] = p->exact ? (double)below(3) : uniform(0.0, 2.0);
        for (int32_t t = 0; t < p->m; ++t) {
            p->f[t][k] = p->exact ? (double)below(9) - 4 : uniform(-1, 1) + 0.1 * p->x[k];
        }
    }
}

/* By the definition, in long double. */
static void define(problem *p, int64_t from, int64_t to, double *z, long double *sums)
{
    const int32_t n = p->n, size = 1 + n + p->m;
    long double c[MOST];
    for (int64_t k = from; k < to; ++k) {
        step(n, p->r, p->x[k], z);
        c[0] = 1;
        for (int32_t i = 0; i < n; ++i) {
            c[1 + i] = i + 1 < n ? (long double)z[i] - z[i + 1] : z[i];
        }
        for (int32_t t = 0; t < p->m; ++t) {
            c[1 + n + t] = p->f[t][k];
        }
        const long double w = p->weighted ? p->weight[k] : 1;
        for (int32_t i = 0; i < size; ++i) {
            for (int32_t j = 0; j < size; ++j) {
                sums[i * size + j] += w * c[i] * c[j];
            }
        }
    }
}

static int add(engine_gram *g, const problem *p, int64_t from, int64_t to)
{
    const double *f[MOST_M] = {p->f[0] + from, p->f[1] + from, p->f[2] + from};
    return engine_gram_add(g, to - from, p->x + from, f, p->weighted ? p->weight + from : NULL) != to - from;
}

static int32_t any_method(int32_t n)
{
    const int32_t prefixes = (n + 3) / 4, choice = below(4);
    return choice == 0 ? ENGINE_AUTO : choice == 1 ? ENGINE_EVENTS : choice == 2 ? ENGINE_DENSE : 4 * (1 + below(prefixes));
}

/* In pieces: some added, some skipped, some taken at once; methods change on the way. */
static int differs(problem *p, double *worst)
{
    static double found[MOST * MOST], part[MOST * MOST];
    static long double exact[MOST * MOST];
    const int32_t n = p->n, size = 1 + n + p->m, all = size * size;
    memset(found, 0, sizeof found);
    memset(exact, 0, sizeof exact);
    double z[MOST_N], state[MOST_N], most = 0, range = p->r[n - 1];
    memcpy(z, p->z, sizeof z);
    engine_gram *g = engine_gram_new(n, p->r, p->z, p->m);
    for (int64_t k = 0; k < p->samples;) {
        int64_t to = k + 1 + below(below(2) ? 10 : MOST_T);
        to = to < p->samples ? to : p->samples;
        if (below(2) == 0 && engine_gram_method(g, any_method(n)) != 0) {
            printf("no such method, ");
            return 1;
        }
        if (below(8) == 0) {
            engine_gram_skip(g, to - k, p->x + k);
            for (; k < to; ++k) {
                step(n, p->r, p->x[k], z);
            }
            continue;
        }
        if (add(g, p, k, to) != 0) {
            printf("a good sample was refused, ");
            return 1;
        }
        define(p, k, to, z, exact);
        k = to;
        if (below(4) == 0 || k == p->samples) {
            engine_gram_take(g, part);
            for (int32_t i = 0; i < all; ++i) {
                found[i] += part[i];
            }
        }
    }
    engine_gram_take(g, part);
    engine_gram_state(g, state);
    engine_gram_free(g);
    for (int32_t i = 0; i < all; ++i) {
        found[i] += part[i];
        most = fmax(most, (double)fabsl(exact[i]));
    }
    for (int32_t i = 0; i < all; ++i) {
        const double error = (double)fabsl(found[i] - exact[i]);
        if (!(error <= (p->exact ? 0.0 : 1e-14) * most)) {
            printf("sum (%d, %d) off by %g of %g, ", i / size, i % size, error, most);
            return 1;
        }
        *worst = fmax(*worst, most > 0 ? error / most : 0.0);
    }
    for (int64_t k = 0; k < p->samples; ++k) {
        range = fmax(range, fabs(p->x[k]));
    }
    for (int32_t i = 0; i < n; ++i) {
        if (!(fabs(state[i] - z[i]) <= (p->exact ? 0.0 : 8 * 0x1p-52 * range))) {
            printf("z[%d] off by %g, ", i, state[i] - z[i]);
            return 1;
        }
    }
    return 0;
}

int main(int count, char **argument)
{
    static problem p;
    if (count < 4 || engine_use_level(atoi(argument[1])) != 0) {
        return 2;
    }
    const uint64_t seed = strtoull(argument[2], NULL, 10);
    double worst = 0.0;
    for (long number = 0; number < atol(argument[3]); ++number) {
        random_state = seed * UINT64_C(1000003) + (uint64_t)number;
        make(&p, 1 + (int32_t)(number % MOST_N));
        if (differs(&p, &worst)) {
            printf("signal %ld of seed %s at level %s: n = %d, m = %d, %lld samples%s%s\n", number, argument[2], argument[1],
                   (int)p.n, (int)p.m, (long long)p.samples, p.exact ? ", integers" : "", p.weighted ? ", weighted" : "");
            return 1;
        }
    }
    printf("largest error %.2g of the largest sum\n", worst);
    return 0;
}
