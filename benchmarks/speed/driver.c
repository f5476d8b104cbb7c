/* One run of the engine, to be counted by callgrind: driver evaluate|gram|plays|lugre LEVEL N SIGNAL SAMPLES.
 *
 * Signals as in signals.py, with a generator of its own for the noise. Built by benchmarks/instructions.py. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "lugre.h"

static uint64_t random_state = 1;

static double uniform(void) /* -1 .. 1 */
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (double)(random_state >> 11) * 0x1p-52 - 1.0;
}

static void fill(const char *signal, int64_t samples, double *x)
{
    const double turn = 6.283185307179586 / 40000.0;
    for (int64_t k = 0; k < samples; ++k) {
        const double sine = sin(turn * (double)k);
        x[k] = strcmp(signal, "white") == 0 ? uniform() : strcmp(signal, "noisy") == 0 ? sine + 0.02 * uniform() : sine;
    }
}

int main(int count, char **arguments)
{
    if (count != 6) {
        return 2;
    }
    const int32_t n = (int32_t)atoi(arguments[3]);
    const int64_t samples = atoll(arguments[5]);
    double *x = malloc(2 * (size_t)samples * sizeof(double)), *y = x + samples;
    double *r = calloc(3 * (size_t)n, sizeof(double)), *w = r + n, *z = w + n;
    if (x == NULL || r == NULL || engine_use_level(atoi(arguments[2])) != 0) {
        return 3;
    }
    for (int32_t i = 0; i < n; ++i) {
        r[i] = (double)i / (double)n;
        w[i] = (1.0 + 0.5 * uniform()) / (double)n;
    }
    fill(arguments[4], samples, x);
    memcpy(y, x, (size_t)samples * sizeof(double));
    if (strcmp(arguments[1], "evaluate") == 0) {
        engine_evaluator *evaluator = engine_evaluator_new(n, r, w, 0.0, 0.0, z);
        if (evaluator == NULL) {
            return 3;
        }
        (void)engine_evaluator_run(evaluator, samples, x, y);
        engine_evaluator_free(evaluator);
    } else if (strcmp(arguments[1], "plays") == 0) { /* every hundredth row */
        const int64_t rows = samples / 100;
        int64_t *row = calloc((size_t)rows, sizeof *row);
        double *out = calloc((size_t)rows * (size_t)n, sizeof *out);
        for (int64_t k = 0; k < rows && row != NULL; ++k) row[k] = 100 * k;
        if (row == NULL || out == NULL || engine_plays(n, r, z, samples, x, rows, row, out) != 0) {
            return 3;
        }
        free(row);
        free(out);
    } else if (strcmp(arguments[1], "lugre") == 0) {
        const engine_lugre model = {n, w, {1.0, 0.01, 0.1}, 0.1, 0.5, 2.0};
        double *dt = malloc((size_t)samples * sizeof *dt);
        for (int64_t k = 0; k < samples && dt != NULL; ++k) dt[k] = 1e-3;
        if (dt == NULL) {
            return 3;
        }
        engine_lugre_run(&model, samples, x, dt, z, y, NULL);
        free(dt);
    } else {
        engine_gram *gram = engine_gram_new(n, r, z, 1);
        const double *targets[1] = {y};
        if (gram == NULL) {
            return 3;
        }
        (void)engine_gram_add(gram, samples, x, targets, NULL);
        engine_gram_free(gram);
    }
    free(x);
    free(r);
    return 0;
}
