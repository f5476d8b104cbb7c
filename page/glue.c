/* What the page asks of the C code, compiled to WebAssembly: models as the robot runs them (core/). Memory is the
 * caller's own, by page_alloc; arrays are those of JavaScript, so no call keeps a pointer that it was given. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "engine.h"
#include "signal.h"
#include "text.h"

#define PAGE(name) __attribute__((export_name(#name), used))

PAGE(page_alloc) void *page_alloc(uint32_t bytes) { return malloc(bytes); }
PAGE(page_free) void page_free(void *memory) { free(memory); }

/* ---- y = offset + sum w_i play_{r_i}[x - center], one sample after the other, as exported code runs it */
typedef struct page_model {
    dehyst_model model;
    dehyst_state state;
    double *threshold, *weight, *slope, *loading, *start; /* (n,) each, in one block behind this one */
} page_model;

PAGE(page_model_new) page_model *page_model_new(int32_t n, const double *threshold, const double *weight, double center,
                                                double offset, const double *start)
{
    const size_t size = (size_t)n;
    page_model *m = calloc(1, sizeof *m + 6 * size * sizeof(double));
    if (m == NULL) {
        return NULL;
    }
    double *room = (double *)(void *)(m + 1);
    m->threshold = room;
    m->weight = room + size;
    m->slope = room + 2 * size;
    m->loading = room + 3 * size;
    m->start = room + 4 * size;
    m->state.z = room + 5 * size;
    memcpy(m->threshold, threshold, size * sizeof(double));
    memcpy(m->weight, weight, size * sizeof(double));
    memcpy(m->start, start, size * sizeof(double));
    dehyst_pi_tables(n, m->threshold, m->weight, m->slope, m->loading);
    m->model.hysteresis = (dehyst_pi){n, m->threshold, m->slope, m->loading, center, offset};
    dehyst_model_reset(&m->model, &m->state, m->start);
    return m;
}

/* The closed inverse of a model from the states that it starts with, or a null pointer if there is none. */
PAGE(page_model_inverse) page_model *page_model_inverse(const page_model *m)
{
    const int32_t n = m->model.hysteresis.n;
    double *room = malloc(3 * (size_t)n * sizeof(double));
    page_model *inverse = NULL;
    if (room != NULL && dehyst_pi_invert(n, m->threshold, m->weight, m->start, room, room + n, room + 2 * n) == 0) {
        inverse = page_model_new(n, room, room + n, m->model.hysteresis.offset, m->model.hysteresis.center, room + 2 * n);
    }
    free(room);
    return inverse;
}

PAGE(page_model_reset) void page_model_reset(page_model *m) { dehyst_model_reset(&m->model, &m->state, m->start); }

/* y (samples,) of x (samples,), going on from the present state; y may be x. */
PAGE(page_model_run) void page_model_run(page_model *m, int32_t samples, const double *x, double *y)
{
    for (int32_t k = 0; k < samples; k++) {
        y[k] = dehyst_model_step(&m->model, &m->state, x[k]);
    }
}

PAGE(page_model_states) void page_model_states(const page_model *m, double *z)
{
    memcpy(z, m->state.z, (size_t)m->model.hysteresis.n * sizeof(double));
}

/* ---- What the package asks of its extension, for the same Python carried over (house.py): arrays as they are, int64
 * indices as doubles. */
static int64_t *whole(int32_t n, const double *values)
{
    int64_t *made = malloc((size_t)(n > 0 ? n : 1) * sizeof *made);
    for (int32_t k = 0; made != NULL && k < n; k++) {
        made[k] = (int64_t)values[k];
    }
    return made;
}

static void doubles(int64_t n, const int64_t *values, double *out)
{
    for (int64_t k = 0; k < n; k++) {
        out[k] = (double)values[k];
    }
}

PAGE(page_turning_points) int32_t page_turning_points(int32_t samples, const double *x, double swing, double *point)
{
    int64_t *found = malloc((size_t)(samples + 2) * sizeof *found);
    if (found == NULL) {
        return -1;
    }
    const int64_t count = engine_turning_points(samples, x, swing, found);
    doubles(count, found, point);
    free(found);
    return (int32_t)count;
}

/* kept has room for the last row + 1; place for all rows. */
PAGE(page_essential) int32_t page_essential(const double *x, int32_t rows, const double *row, double *kept, double *place)
{
    int64_t *wanted = whole(rows, row);
    const size_t room = rows > 0 ? (size_t)row[rows - 1] + 1 : 1;
    int64_t *found = malloc(room * sizeof *found), *places = malloc((size_t)(rows + 1) * sizeof *places);
    int64_t count = -1;
    if (wanted != NULL && found != NULL && places != NULL) {
        count = engine_essential(x, rows, wanted, found, places);
        doubles(count, found, kept);
        doubles(rows, places, place);
    }
    free(wanted);
    free(found);
    free(places);
    return (int32_t)count;
}

PAGE(page_bin_sums) void page_bin_sums(int32_t samples, const double *x, const double *y, const double *weight, int32_t bins,
                                       double low, double high, double *sums)
{
    engine_bin_sums(samples, x, y, weight, bins, low, high, sums);
}

PAGE(page_plays) int32_t page_plays(int32_t n, const double *threshold, double *state, int32_t samples, const double *x,
                                    int32_t rows, const double *row, double *out)
{
    int64_t *wanted = whole(rows, row);
    const int failed = wanted == NULL || engine_plays(n, threshold, state, samples, x, rows, wanted, out);
    free(wanted);
    return failed;
}

PAGE(page_evaluator_new) engine_evaluator *page_evaluator_new(int32_t n, const double *threshold, const double *weight,
                                                              double center, double offset, const double *state)
{
    return engine_evaluator_new(n, threshold, weight, center, offset, state);
}
PAGE(page_evaluator_free) void page_evaluator_free(engine_evaluator *e) { engine_evaluator_free(e); }
PAGE(page_evaluator_run) int32_t page_evaluator_run(engine_evaluator *e, int32_t samples, const double *x, double *y)
{
    return (int32_t)engine_evaluator_run(e, samples, x, y);
}

PAGE(page_gram_new) engine_gram *page_gram_new(int32_t n, const double *threshold, const double *state, int32_t targets)
{
    return engine_gram_new(n, threshold, state, targets);
}
PAGE(page_gram_free) void page_gram_free(engine_gram *g) { engine_gram_free(g); }
/* targets (m, samples), at most 64 of them; weight may be a null pointer. */
PAGE(page_gram_add) int32_t page_gram_add(engine_gram *g, int32_t samples, const double *x, int32_t m, const double *targets,
                                          const double *weight)
{
    const double *column[65] = {0};
    for (int32_t j = 0; j < m && j < 64; j++) {
        column[j] = targets + (size_t)j * (size_t)samples;
    }
    return (int32_t)engine_gram_add(g, samples, x, column, weight);
}
PAGE(page_gram_skip) int32_t page_gram_skip(engine_gram *g, int32_t samples, const double *x)
{
    return (int32_t)engine_gram_skip(g, samples, x);
}
PAGE(page_gram_take) void page_gram_take(engine_gram *g, double *sums) { engine_gram_take(g, sums); }
PAGE(page_gram_only_targets) void page_gram_only_targets(engine_gram *g, int32_t only) { engine_gram_only_targets(g, only); }

/* answer: kkt, condition, iterations, status. passive (n,) in and out. */
PAGE(page_solve) int32_t page_solve(int32_t n, int32_t free_unknowns, int32_t plays, int32_t basis, const double *gram,
                                    const double *rhs, const double *extra, const double *extra_rhs, const double *lower,
                                    double target_norm, double *u, uint8_t *passive, double *answer)
{
    const engine_program program = {n, free_unknowns, plays, basis, gram, rhs, extra, extra_rhs, lower, target_norm};
    engine_solution solution = {0};
    const int failed = engine_solve(&program, u, passive, &solution);
    answer[0] = solution.kkt;
    answer[1] = solution.condition;
    answer[2] = solution.iterations;
    answer[3] = solution.status;
    return failed;
}

PAGE(page_map_values) void page_map_values(int32_t n, const double *u, const double *v, int32_t samples, const double *x,
                                           double *y)
{
    const dehyst_map map = {n, u, v};
    for (int32_t k = 0; k < samples; k++) {
        y[k] = dehyst_map_value(&map, x[k]);
    }
}

PAGE(page_pi_invert) int32_t page_pi_invert(int32_t n, const double *r, const double *w, const double *z, double *ri,
                                            double *wi, double *zi)
{
    return dehyst_pi_invert(n, r, w, z, ri, wi, zi);
}

PAGE(page_decay) double page_decay(double x) { return dehyst_decay(x); }

/* ---- Tables in text */
static double nearest(const char *number, size_t length, void *context)
{
    char text[512];
    const size_t kept = length < sizeof text - 1 ? length : sizeof text - 1;
    for (size_t k = 0; k < kept; k++) {
        text[k] = number[k] == *(const char *)context ? '.' : number[k];
    }
    text[kept] = '\0';
    return strtod(text, NULL);
}

PAGE(page_text_lines) double page_text_lines(const char *text, uint32_t size) { return (double)text_lines(text, size); }
PAGE(page_text_offset) double page_text_offset(const char *text, uint32_t size, double lines)
{
    return (double)text_offset(text, size, (int64_t)lines);
}
PAGE(page_text_whole_lines) double page_text_whole_lines(const char *text, uint32_t size)
{
    return (double)text_whole_lines(text, size);
}
/* answer: rows, lines, bytes, column, empty, odd. */
PAGE(page_text_read) void page_text_read(const char *text, uint32_t size, int32_t delimiter, int32_t decimal, int32_t missing,
                                         int32_t width, const int32_t *letters, double line, double capacity, int64_t *row,
                                         void *const *columns, double *answer)
{
    char sign = (char)decimal;
    const text_format format = {(char)delimiter, sign, missing, 0, width, letters, nearest, &sign};
    text_stop stop = {0};
    stop.column = -1;
    answer[0] = (double)text_read(&format, text, size, (int64_t)line, (int64_t)capacity, row, columns, &stop);
    answer[1] = (double)stop.lines;
    answer[2] = (double)stop.bytes;
    answer[3] = stop.column;
    answer[4] = stop.empty;
    answer[5] = stop.odd;
}

/* ---- Triangular factor of rows (n, m), added to the one in r (m, m): Householder on [R; rows], a cacheful at a time.
 * Four reflections are applied to the columns behind them in one pass. */
enum { TRIANGLE_ROWS = 256, AT_ONCE = 4 };
typedef double two __attribute__((vector_size(16)));

static double sum_of(two s) { return s[0] + s[1]; }

/* Products of four columns, one behind the other, with w. */
static void dots(const double *v, const double *w, double *d)
{
    const two *a = (const two *)(const void *)v, *b = (const two *)(const void *)w;
    enum { N = TRIANGLE_ROWS / 2 };
    two s = {0.0, 0.0}, t = s, u = s, q = s;
    for (int32_t i = 0; i < N; i++) {
        s += a[i] * b[i];
        t += a[i + N] * b[i];
        u += a[i + 2 * N] * b[i];
        q += a[i + 3 * N] * b[i];
    }
    d[0] = sum_of(s);
    d[1] = sum_of(t);
    d[2] = sum_of(u);
    d[3] = sum_of(q);
}

static void take(const double *v, const double *t, double *w)
{
    const two *a = (const two *)(const void *)v;
    two *b = (two *)(void *)w;
    enum { N = TRIANGLE_ROWS / 2 };
    const two t0 = {t[0], t[0]}, t1 = {t[1], t[1]}, t2 = {t[2], t[2]}, t3 = {t[3], t[3]};
    for (int32_t i = 0; i < N; i++) {
        b[i] -= (t0 * a[i] + t1 * a[i + N]) + (t2 * a[i + 2 * N] + t3 * a[i + 3 * N]);
    }
}

PAGE(page_triangle) int32_t page_triangle(int32_t n, int32_t m, const double *rows, double *r)
{
    const int32_t wide = m + AT_ONCE; /* by columns, padded with zeros */
    double *c = aligned_alloc(16, (size_t)wide * TRIANGLE_ROWS * sizeof *c);
    if (c == NULL) {
        return -1;
    }
    for (int32_t from = 0; from < n; from += TRIANGLE_ROWS) {
        const int32_t count = n - from < TRIANGLE_ROWS ? n - from : TRIANGLE_ROWS;
        memset(c, 0, (size_t)wide * TRIANGLE_ROWS * sizeof *c);
        for (int32_t j = 0; j < m; j++) {
            for (int32_t i = 0; i < count; i++) {
                c[(size_t)j * TRIANGLE_ROWS + (size_t)i] = rows[(size_t)(from + i) * (size_t)m + (size_t)j];
            }
        }
        for (int32_t first = 0; first < m; first += AT_ONCE) {
            double *v = c + (size_t)first * TRIANGLE_ROWS, *top = r + (size_t)first * (size_t)m;
            double tau[AT_ONCE] = {0.0}, cross[AT_ONCE][AT_ONCE], d[AT_ONCE], t[AT_ONCE];
            const int32_t last = m - first < AT_ONCE ? m - first : AT_ONCE;
            for (int32_t q = first; q < m; q++) {
                const int32_t mine = q - first; /* below four: a column of these reflections themselves */
                double *w = c + (size_t)q * TRIANGLE_ROWS;
                dots(v, w, d);
                memset(t, 0, sizeof t);
                for (int32_t k = 0; k < last && k < mine; k++) {
                    double *at = top + (size_t)k * (size_t)m + q, sum = *at + d[k];
                    for (int32_t l = 0; l < k; l++) {
                        sum -= t[l] * cross[k][l];
                    }
                    t[k] = tau[k] * sum;
                    *at -= t[k];
                }
                take(v, t, w);
                if (mine >= last) {
                    continue;
                }
                dots(v, w, cross[mine]);
                double *diagonal = top + (size_t)mine * (size_t)m + q;
                const double alpha = *diagonal, square = cross[mine][mine];
                if (square == 0.0) {
                    continue;
                }
                const double length = sqrt(alpha * alpha + square), beta = alpha >= 0.0 ? -length : length;
                const double scale = 1.0 / (alpha - beta);
                tau[mine] = (beta - alpha) / beta;
                for (int32_t i = 0; i < TRIANGLE_ROWS; i++) {
                    w[i] *= scale;
                }
                for (int32_t l = 0; l < mine; l++) {
                    cross[mine][l] *= scale;
                }
                *diagonal = beta;
            }
        }
    }
    free(c);
    return 0;
}

/* ---- Rows of the test for rate and creep, as evidence_rows.py has them: the next `wanted` that count, (wanted, m).
 * sizes: degree, stops, lags, creep terms, loads; scale: their radii, lengths and time constants. state: low and high of the
 * stops, lags, creep, then the number of samples so far. signal (5 + loads, samples): which count, time, drive, its rate,
 * what is explained, loads. */
static double *scaled(double *to, double by, const double *from, int32_t n)
{
    for (int32_t k = 0; k < n; k++) {
        to[k] = by * from[k];
    }
    return to + n;
}

PAGE(page_evidence_rows) void page_evidence_rows(const int32_t *sizes, const double *scale, double *state, int32_t samples,
                                                 const double *signal, int32_t wanted, double *row)
{
    const int32_t degree = sizes[0], s = sizes[1], p = sizes[2], c = sizes[3], loads = sizes[4];
    const double *time = signal + samples, *q = time + samples, *rate = q + samples, *y = rate + samples, *load = y + samples;
    double *low = state, *high = low + s, *lag = high + s, *creep = lag + p, *next = creep + c;
    double memory[64], crept[64], power[64];
    int32_t k = (int32_t)*next;
    for (; wanted > 0 && k < samples; k++) {
        const double x = q[k], way = k > 0 ? x - q[k - 1] : 0.0, passed = k > 0 ? time[k] - time[k - 1] : 0.0;
        for (int32_t i = 0; i < s; i++) {
            const double down = x - scale[i], up = x + scale[i];
            const double a = k > 0 ? low[i] : down, b = k > 0 ? high[i] : up;
            low[i] = a > up ? up : a < down ? down : a;
            high[i] = b > up ? up : b < down ? down : b;
            memory[i] = x - (low[i] + 0.5 * (high[i] - low[i]));
        }
        for (int32_t i = 0; i < p; i++) {
            const double length = scale[s + i], end = way < 0.0 ? -length : length;
            lag[i] = end + dehyst_decay(fabs(way) / length) * (lag[i] - end);
            memory[s + i] = lag[i];
        }
        for (int32_t i = 0; i < c; i++) {
            creep[i] = k > 0 ? creep[i] - expm1(-passed / scale[s + p + i]) * (x - creep[i]) : x;
            crept[i] = x - creep[i];
        }
        if (signal[k] == 0.0) {
            continue;
        }
        wanted--;
        const double inside = x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x;
        power[0] = 1.0;
        power[1] = inside;
        for (int32_t i = 2; i <= degree; i++) {
            power[i] = power[i - 1] * (2.0 * inside) - power[i - 2];
        }
        row = scaled(row, 1.0, power + 1, degree);
        for (int32_t i = 0; i < loads; i++) {
            row = scaled(row, load[i * samples + k], power, degree + 1);
        }
        row = scaled(row, 0.5 * (1.0 + inside), memory, s + p);
        row = scaled(row, 0.5 * (1.0 - inside), memory, s + p);
        for (int32_t i = 0; i < 2 * loads; i++) {
            row = scaled(row, i % 2 ? 1.0 - load[i / 2 * samples + k] : load[i / 2 * samples + k], memory, s + p);
        }
        for (int32_t i = 0; i < (loads > 0 ? 2 * loads : 1); i++) {
            row = scaled(row, loads == 0 ? 1.0 : i % 2 ? 1.0 - load[i / 2 * samples + k] : load[i / 2 * samples + k], crept, c);
        }
        for (int32_t i = 0; i < (loads > 0 ? 2 * loads : 1); i++) {
            *row++ = rate[k] * (loads == 0 ? 1.0 : i % 2 ? 1.0 - load[i / 2 * samples + k] : load[i / 2 * samples + k]);
        }
        *row++ = y[k];
    }
    *next = k;
}

/* Rows (n, m) less their mean, which row[n] .. has room for. */
PAGE(page_centre) void page_centre(int32_t n, int32_t m, double *rows)
{
    double *mean = rows + (size_t)n * (size_t)m;
    memset(mean, 0, (size_t)m * sizeof *mean);
    for (int32_t k = 0; k < 2 * n; k++) {
        double *row = rows + (size_t)(k % n) * (size_t)m;
        for (int32_t j = 0; j < m; j++) {
            if (k < n) {
                mean[j] += row[j];
            } else {
                row[j] -= mean[j] / n;
            }
        }
    }
}

/* ---- A block as it is exported: its parameters in one image, and its answers to the bit. */
typedef struct page_block {
    dehyst_block block;
    dehyst_block_state state;
    double *z, *memory;
} page_block;

/* Image of a block of plays without maps; limits: input, output and reach low and high, slope and offset of the line, fade.
 * Returns its words, or -1. */
PAGE(page_block_image) int32_t page_block_image(int32_t n, const double *r, const double *w, double center, double offset,
                                                const double *start, const double *limits, uint32_t fingerprint,
                                                uint32_t *image)
{
    double *slope = malloc(2 * (size_t)n * sizeof *slope);
    if (slope == NULL) {
        return -1;
    }
    dehyst_pi_tables(n, r, w, slope, slope + n);
    const dehyst_block block = {
        {{0, NULL, NULL}, {n, r, slope, slope + n, center, offset}, {0, NULL, NULL}}, start, limits[0], limits[1],
        limits[2], limits[3], limits[4], limits[5], limits[6], limits[7], limits[8], fingerprint};
    const int32_t words = DEHYST_BLOCK_WORDS(n, 0, 0);
    (void)dehyst_block_dump(&block, image, words);
    free(slope);
    return words;
}
PAGE(page_block_words) int32_t page_block_words(int32_t n) { return DEHYST_BLOCK_WORDS(n, 0, 0); }
PAGE(page_state_words) int32_t page_state_words(int32_t n) { return DEHYST_STATE_WORDS(n); }

PAGE(page_block_new) page_block *page_block_new(const uint32_t *image, int32_t words)
{
    page_block *b = calloc(1, sizeof *b);
    double *memory = malloc((size_t)words * sizeof *memory);
    if (b == NULL || memory == NULL || dehyst_block_load(image, words, memory, words, &b->block) != DEHYST_IMAGE_GOOD) {
        free(memory);
        free(b);
        return NULL;
    }
    b->memory = memory;
    b->z = malloc((size_t)b->block.model.hysteresis.n * sizeof *b->z);
    b->state.model.z = b->z;
    dehyst_block_reset(&b->block, &b->state);
    return b;
}
PAGE(page_block_reset) void page_block_reset(page_block *b) { dehyst_block_reset(&b->block, &b->state); }
PAGE(page_block_run) void page_block_run(page_block *b, int32_t samples, const double *x, const uint8_t *on, double *y,
                                         double *flags)
{
    for (int32_t k = 0; k < samples; k++) {
        y[k] = dehyst_block_step(&b->block, &b->state, x[k], on[k]);
        flags[k] = b->state.flags;
    }
}
PAGE(page_block_save) void page_block_save(const page_block *b, uint32_t *image)
{
    (void)dehyst_block_save(&b->block, &b->state, image, DEHYST_STATE_WORDS(b->block.model.hysteresis.n));
}
PAGE(page_block_output) double page_block_output(const page_block *b) { return b->state.output; }
/* n, then threshold, slope, loading and start (n,) each, then center, offset, limits, line, fade, fingerprint (12). */
PAGE(page_block_parameters) int32_t page_block_parameters(const page_block *b, double *out)
{
    const dehyst_pi *pi = &b->block.model.hysteresis;
    const size_t n = (size_t)pi->n;
    if (out != NULL) {
        memcpy(out, pi->threshold, n * sizeof *out);
        memcpy(out + n, pi->slope, n * sizeof *out);
        memcpy(out + 2 * n, pi->loading, n * sizeof *out);
        memcpy(out + 3 * n, b->block.start, n * sizeof *out);
        const dehyst_block *k = &b->block;
        const double rest[12] = {pi->center,     pi->offset,     k->input_low,   k->input_high, k->output_low, k->output_high,
                                 k->reach_low,   k->reach_high,  k->line_slope,  k->line_offset, k->fade,      (double)k->fingerprint};
        memcpy(out + 4 * n, rest, sizeof rest);
    }
    return pi->n;
}
PAGE(page_model_output) double page_model_output(const page_model *m) { return m->state.output; }
