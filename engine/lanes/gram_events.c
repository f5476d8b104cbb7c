/* Samples between events and the events of the Gram pass; compiled once per level. */
#include "gram_boundaries.h"
#include "kernels.h"
#include "moments.h"

int64_t LANES_NAME(engine_gram_run)(gram_machine *m, int64_t samples, const double *x, const double *weight,
                                 const double *const *f, const double *rows);
void LANES_NAME(engine_gram_pass_by)(gram_machine *m, int64_t samples, const double *x);
void LANES_NAME(engine_gram_empty)(gram_machine *m);

static inline run_window window_of(const gram_machine *m, int begin)
{
    const stack_segment *top = &m->stack.segment[m->stack.top];
    const int monotone = top->b == 1 ? 0 : top->s > 0 ? 1 : -1;
    const run_window window = {m->stack.low, m->stack.high, m->last, m->origin, monotone, begin};
    return window;
}

/* Adds sum u and sum d u of `vectors` times eight cells u; `ways` samples at once, for a sum waits for itself. */
static inline __attribute__((always_inline)) void add_cells(const int vectors, const int ways, gram_machine *m, int32_t first,
                                                            int32_t stride, int64_t samples, const double *x,
                                                            const double *rows)
{
    const lanes origin = lanes_all(m->origin);
    lanes sum[4][4], sum_d[4][4];
    for (int w = 0; w < ways; ++w) {
        for (int j = 0; j < vectors; ++j) {
            sum[w][j] = sum_d[w][j] = lanes_all(0.0);
        }
    }
    const double *u = rows + first;
    int64_t k = 0;
    for (; k + ways <= samples; k += ways) {
        for (int w = 0; w < ways; ++w, u += stride) {
            const lanes d = lanes_sub(lanes_all(x[k + w]), origin);
            for (int j = 0; j < vectors; ++j) {
                const lanes a = lanes_load(u + 8 * j);
                sum[w][j] = lanes_add(sum[w][j], a);
                sum_d[w][j] = lanes_fma(d, a, sum_d[w][j]);
            }
        }
    }
    for (; k < samples; ++k, u += stride) {
        const lanes d = lanes_sub(lanes_all(x[k]), origin);
        for (int j = 0; j < vectors; ++j) {
            const lanes a = lanes_load(u + 8 * j);
            sum[0][j] = lanes_add(sum[0][j], a);
            sum_d[0][j] = lanes_fma(d, a, sum_d[0][j]);
        }
    }
    for (int j = 0; j < vectors; ++j) {
        double *f = m->run_f + 1 + first + 8 * j, *df = m->run_df + 1 + first + 8 * j;
        for (int w = 1; w < ways; ++w) {
            sum[0][j] = lanes_add(sum[0][j], sum[w][j]);
            sum_d[0][j] = lanes_add(sum_d[0][j], sum_d[w][j]);
        }
        lanes_store(f, lanes_add(lanes_load(f), sum[0][j]));
        lanes_store(df, lanes_add(lanes_load(df), sum_d[0][j]));
    }
}

/* The cells (samples, prefix) of a dense prefix. */
static inline void add_rows(gram_machine *m, int32_t prefix, int64_t samples, const double *x, const double *rows)
{
    int32_t first = 0;
    for (; first + 32 <= prefix; first += 32) {
        add_cells(4, 1, m, first, prefix, samples, x, rows);
    }
    if (first + 24 <= prefix) {
        add_cells(3, 2, m, first, prefix, samples, x, rows);
    } else if (first + 16 <= prefix) {
        add_cells(2, 2, m, first, prefix, samples, x, rows);
    } else if (first + 8 <= prefix) {
        add_cells(1, 4, m, first, prefix, samples, x, rows);
    }
}

/* Samples [k, ...) of one run; the first column of weight 1 is summed while its end is sought. */
static inline int64_t sum_one_run(gram_machine *m, int64_t samples, const double *x, const double *weight,
                                  const double *const *f, int64_t k, int begin)
{
    const run_window window = window_of(m, begin);
    double sums[4] = {0};
    int64_t count;
    int32_t t = 0;
    if (weight == NULL) { /* the first target at once; x in its place if there is none: nobody reads that */
        count = sum_run(samples - k, x + k, (m->targets > 0 ? f[0] : x) + k, &window, sums);
        m->run_weight += (double)count;
        m->run_d += sums[0];
        m->run_dd += sums[1];
        m->run_f[0] += sums[2];
        m->run_df[0] += sums[3];
        t = 1;
    } else {
        count = scan_run(samples - k, x + k, &window);
        add_moments(count, x + k, weight + k, m->origin, sums);
        m->run_weight += sums[0];
        m->run_d += sums[1];
        m->run_dd += sums[2];
    }
    for (; t < m->targets; ++t) {
        double moments[3] = {0};
        add_moments(count, x + k, f[t] + k, m->origin, moments);
        m->run_f[gram_column_of(m, t)] += moments[0];
        m->run_df[gram_column_of(m, t)] += moments[1];
    }
    return count;
}

/* x drives the machine; f are its targets and rows (samples, prefix) the cells before it, both times weight if there is one.
 * Returns the number of samples taken: all, or those before one that the core would reject. */
int64_t LANES_NAME(engine_gram_run)(gram_machine *m, int64_t samples, const double *x, const double *weight,
                                 const double *const *f, const double *rows)
{
    int begin = 0;
    for (int64_t k = 0; k < samples;) {
        const int64_t count = sum_one_run(m, samples, x, weight, f, k, begin);
        if (m->dense > 0 && !m->only_targets) {
            add_rows(m, m->dense, count, x + k, rows + k * m->dense);
        }
        k += count;
        m->last = k > 0 ? x[k - 1] : m->last;
        if (k == samples) {
            break;
        }
        if (!(__builtin_fabs(x[k]) <= m->grid.limit)) {
            return k;
        }
        if (m->logged >= m->log_size) {
            gram_empty_log(m);
        }
        gram_event(m, x[k]);
        ++m->events;
        begin = 1; /* an event takes its sample whatever rounding says, so that it ends */
    }
    return samples;
}

/* The state alone; nothing may be pending. Boundaries must be frozen anew afterwards. */
void LANES_NAME(engine_gram_pass_by)(gram_machine *m, int64_t samples, const double *x)
{
    int begin = 0;
    for (int64_t k = 0; k < samples;) {
        const run_window window = window_of(m, begin);
        k += scan_run(samples - k, x + k, &window);
        m->last = k > 0 ? x[k - 1] : m->last;
        m->stack.segment[m->stack.top].e = m->last;
        if (k == samples) {
            break;
        }
        stack_event(&m->grid, &m->stack, x[k]);
        ++m->events;
        begin = 1;
    }
}

void LANES_NAME(engine_gram_empty)(gram_machine *m) { gram_empty_log(m); }
