/* The engine against the definition on random short signals: engine_differential LEVEL SEED COUNT [-v]
 *
 * Every n from 1 to 64 in turn; thresholds even, random or integer; weights of any sign; states that a history leaves,
 * random admissible ones, or zero; samples smooth, random, integer with ties, repeated, constant, not a number; in one call
 * or in pieces, apart or in place. Exits with 1 and a line that reproduces the case when a bound is passed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "engine.h"

enum { MOST_N = 64, MOST_T = 2000 };

static uint64_t random_state;

static uint64_t bits(void)
{
    random_state += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = random_state;
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static double uniform(double low, double high) { return low + (high - low) * ((double)(bits() >> 11) * 0x1p-53); }
static int32_t below(int32_t n) { return (int32_t)(bits() % (uint64_t)n); }

typedef struct operator_ {
    int32_t n;
    double r[MOST_N], w[MOST_N], z[MOST_N], center, offset;
    int exact; /* all integer: no rounding anywhere */
} operator_;

static void make_operator(operator_ *o, int32_t n, int exact)
{
    o->n = n;
    o->exact = exact;
    o->r[0] = below(3) == 0 ? (exact ? 1 + below(5) : uniform(0.01, 0.3)) : 0.0;
    const int even = below(2), crowded = below(8) == 0; /* most thresholds within a small part of their range */
    for (int32_t i = 1; i < n; ++i) {
        const double tiny = crowded && i + 2 < n ? uniform(1e-6, 1e-3) : below(8) == 0 ? 1e-9 : 0.0; /* or nearly equal ones */
        o->r[i] = o->r[i - 1] + (exact ? 1 + below(4) : tiny > 0 ? tiny : even ? 1.0 / n : uniform(0.001, 2.0 / n));
    }
    const int any_sign = below(2);
    for (int32_t i = 0; i < n; ++i) {
        o->w[i] = exact ? below(17) - 8 * any_sign : uniform(any_sign ? -1.0 : 0.0, 1.0);
        o->w[i] = below(6) == 0 ? 0.0 : o->w[i];
    }
    o->center = exact ? below(7) - 3 : below(2) ? uniform(-0.5, 0.5) : 0.0;
    o->offset = exact ? below(7) - 3 : below(2) ? uniform(-1.0, 1.0) : 0.0;
    const int start = below(3);
    double z = exact ? below(9) - 4 : uniform(-0.5, 0.5);
    for (int32_t i = 0; i < n; ++i) { /* zero, flat, or any that is admissible */
        const double gap = i > 0 ? o->r[i] - o->r[i - 1] : 0.0;
        const double step = exact ? gap * (below(3) - 1) : gap * (below(3) == 0 ? below(3) - 1 : uniform(-1.0, 1.0));
        z += start == 2 && i > 0 ? step : 0.0;
        o->z[i] = start == 0 ? 0.0 : z;
    }
}

static void make_signal(const operator_ *o, int64_t samples, double *x)
{
    const double range = 1.2 * o->r[o->n - 1] + 0.1;
    const int kind = o->exact ? 1 : below(6);
    double a = 0.0, rate = below(2) ? uniform(0.002, 0.03) : uniform(0.03, 0.8), noise = below(2) ? uniform(0.0, 0.3) : 0.0, shrink = uniform(0.98, 1.0);
    double size = range;
    for (int64_t k = 0; k < samples; ++k) {
        switch (kind) {
        case 0: a = uniform(-range, range); break;
        case 1: a = below(2 * (int32_t)range + 3) - (int32_t)range - 1; break;
        case 2: a += range * uniform(-0.2, 0.2); a = fabs(a) > range ? 0.0 : a; break;
        case 3: a = size * (k % 2 ? 1 : -1); size *= shrink; break;
        case 4: a = o->r[below(o->n)] * (below(2) ? 1 : -1); break; /* meets thresholds to the bit */
        default: a = range * sin(rate * (double)k) + noise * uniform(-range, range); break;
        }
        x[k] = o->center + a;
        const int repeats = below(60) == 0 ? below(100) : below(12) == 0 ? 1 + below(2) : 0;
        for (int again = 0; again < repeats && k + 1 < samples; ++again) {
            ++k;
            x[k] = x[k - 1];
        }
        if (below(200) == 0) {
            x[k] = below(2) ? (double)NAN : below(2) ? -(double)INFINITY : 1e101;
            a = 0.0;
        }
    }
}

/* The definition: returns the largest |y - offset| bound by scale, writes y and the states. */
static int64_t define(operator_ *o, int64_t samples, const double *x, double *y, double *events_scale, double *dense_scale)
{
    dehyst_real slopes[MOST_N], loading[MOST_N];
    dehyst_pi_tables(o->n, o->r, o->w, slopes, loading);
    const dehyst_pi pi = {o->n, o->r, slopes, loading, o->center, o->offset};
    double most = fabs(o->z[0]) + o->r[o->n - 1], slope = 0, steepest = 0, weights = 0;
    double held = dehyst_pi_output(&pi, o->z);
    int64_t rejected = 0;
    for (int64_t k = 0; k < samples; ++k) {
        if (dehyst_accept(x[k])) {
            const double u = x[k] - o->center;
            most = fmax(most, fabs(u) + o->r[o->n - 1]);
            for (int32_t i = 0; i < o->n; ++i) {
                const double low = u - o->r[i], high = u + o->r[i], capped = o->z[i] < high ? o->z[i] : high;
                o->z[i] = capped > low ? capped : low;
            }
            held = dehyst_pi_output(&pi, o->z);
        } else {
            ++rejected;
        }
        y[k] = held;
    }
    for (int32_t i = 0; i < o->n; ++i) {
        slope += o->w[i];
        steepest = fmax(steepest, fabs(slope));
        weights += fabs(o->w[i]);
    }
    *events_scale = most * (steepest + 0x1p-4 * weights) + fabs(o->offset); /* slopes themselves are rounded sums */
    *dense_scale = most * weights + fabs(o->offset);
    return rejected;
}

static int64_t run(engine_evaluator *e, int64_t samples, const double *x, double *y, int pieces, int in_place)
{
    int64_t rejected = 0;
    if (in_place) {
        memcpy(y, x, (size_t)samples * sizeof *y);
    }
    for (int64_t k = 0; k < samples;) {
        int64_t part = pieces ? 1 + below(below(2) ? 20 : 2000) : samples;
        part = part < samples - k ? part : samples - k;
        rejected += engine_evaluator_run(e, part, in_place ? y + k : x + k, y + k);
        k += part;
    }
    return rejected;
}

static int32_t any_method(int32_t n)
{
    const int32_t choice = below(4);
    const int32_t prefixes = (n - 1) / 8;
    return choice == 0 ? ENGINE_AUTO : choice == 1 ? ENGINE_EVENTS : choice == 2 ? ENGINE_DENSE
           : prefixes > 0 ? 8 * (1 + below(prefixes)) : ENGINE_EVENTS;
}

static int differs(const operator_ *o, int64_t samples, const double *x, double *y, int32_t method, double *worst)
{
    static double want[MOST_T];
    double z[MOST_N], events_scale, dense_scale;
    operator_ after = *o;
    const int64_t bad = define(&after, samples, x, want, &events_scale, &dense_scale);
    engine_evaluator *e = engine_evaluator_new(o->n, o->r, o->w, o->center, o->offset, o->z);
    if (e == NULL || engine_evaluator_method(e, method) != 0) {
        printf("cannot be made, ");
        return 1;
    }
    const int64_t rejected = run(e, samples, x, y, below(2), below(3) == 0);
    engine_evaluator_state(e, z);
    engine_evaluator_free(e);
    const int events = method == ENGINE_EVENTS;
    const double scale = events ? events_scale : dense_scale, bound = o->exact ? 0.0 : 16 * 0x1p-53 * scale;
    for (int64_t k = 0; k < samples; ++k) {
        const double error = fabs(y[k] - want[k]);
        if (!(error <= bound)) {
            printf("y[%lld] off by %g of %g, ", (long long)k, error, bound);
            return 1;
        }
        *worst = fmax(*worst, error / (0x1p-53 * scale + 1e-300));
    }
    for (int32_t i = 0; i < o->n; ++i) {
        if (!(fabs(z[i] - after.z[i]) <= (o->exact ? 0.0 : 4 * 0x1p-52 * (fabs(after.z[i]) + 2 * o->r[i])))) {
            printf("z[%d] off by %g, ", i, z[i] - after.z[i]);
            return 1;
        }
    }
    if (rejected != bad) {
        printf("%lld rejected of %lld, ", (long long)rejected, (long long)bad);
        return 1;
    }
    return 0;
}

int main(int count, char **argument)
{
    if (count < 4 || engine_use_level(atoi(argument[1])) != 0) {
        return 2;
    }
    const uint64_t seed = strtoull(argument[2], NULL, 10);
    const long signals = atol(argument[3]);
    double worst = 0.0;
    for (long number = 0; number < signals; ++number) {
        random_state = seed * UINT64_C(1000003) + (uint64_t)number;
        operator_ o;
        make_operator(&o, 1 + (int32_t)(number % MOST_N), below(4) == 0);
        const int64_t samples = number % 256 == 255 ? MOST_T : 1 + below(below(8) == 0 ? 120 : 30);
        const int32_t method = any_method(o.n), shift = below(8);
        /* y after x, at any alignment; what follows x goes on as x did, and memory ends with the last output */
        double *const room = malloc((size_t)(2 * samples + shift + 8) * sizeof *room), *const x = room + shift;
        if (room == NULL) {
            return 2;
        }
        make_signal(&o, samples, x);
        for (int beyond = 0; beyond < 8; ++beyond) {
            x[samples + beyond] = x[samples - 1];
        }
        const int different = differs(&o, samples, x, x + samples + 8, method, &worst);
        free(room);
        if (different) {
            printf("signal %ld of seed %s at level %s: n = %d, method %d, %lld samples%s\n", number, argument[2], argument[1],
                   (int)o.n, (int)method, (long long)samples, o.exact ? ", integers" : "");
            return 1;
        }
    }
    printf("%ld signals, worst error %.2f roundings\n", signals, worst);
    return 0;
}
