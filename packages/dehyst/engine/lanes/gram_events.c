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

/* The samples of one run, the first target at once; x is in its place if there is none: nobody reads that. Squares of a
 * target of weight 1 are summed as well, for one that is too large or not a number spoils them: then the samples before it
 * are summed again and `refused` is set. */
static inline __attribute__((always_inline)) int64_t sum_run(const int what, gram_machine *m, run_samples r,
                                                             const run_window *window, int *refused)
{
    const lanes none = lanes_all(0.0);
    const double limit = m->grid.limit;
    sums_of_run s = {none, none, none, none, none, none};
    double sums[4] = {0};
    int64_t count = follow_run(what, r, window, &s);
    double squares = what == PLAIN ? lanes_sum(s.ff) : 0.0;
    if (!(squares <= limit * limit)) {
        int64_t good = 0;
        while (good < count && __builtin_fabs(r.f[good]) <= limit) {
            ++good;
        }
        *refused = good < count;
        r.count = count = good;
        s = (sums_of_run){none, none, none, none, none, none};
        if (good > 0) {
            follow_run(what, r, window, &s);
        }
        squares = lanes_sum(s.ff);
    }
    lanes_add_sums(s.d, s.dd, s.f, s.df, sums);
    m->squares += squares;
    m->run_weight += what == WEIGHTED ? lanes_sum(s.w) : (double)count;
    m->run_d += sums[0];
    m->run_dd += sums[1];
    m->run_f[0] += sums[2];
    m->run_df[0] += sums[3];
    return count;
}

/* Samples [k, ...) of one run with all columns. */
static inline int64_t sum_columns(gram_machine *m, int64_t samples, const double *x, const double *weight,
                                  const double *const *f, const double *rows, int64_t k, int begin, int *refused)
{
    const run_window window = window_of(m, begin);
    const run_samples r = {samples - k, x + k, (m->targets > 0 ? f[0] : x) + k, weight + (weight == NULL ? 0 : k)};
    const int64_t count = weight == NULL ? sum_run(PLAIN, m, r, &window, refused) : sum_run(WEIGHTED, m, r, &window, refused);
    for (int32_t t = 1; t < m->targets; ++t) {
        double moments[2] = {0};
        add_moments(count, x + k, f[t] + k, m->origin, moments);
        m->run_f[gram_column_of(m, t)] += moments[0];
        m->run_df[gram_column_of(m, t)] += moments[1];
    }
    if (m->dense > 0 && !m->only_targets) {
        add_rows(m, m->dense, count, x + k, rows + k * m->dense);
    }
    return count;
}

/* x drives the machine; f are its targets and rows (samples, prefix) the cells before it, both times weight if there is one.
 * Returns the number of samples taken: all, or those before an x or, without weights, a first target that the core would
 * reject. The squares of that target are left in the machine. */
int64_t LANES_NAME(engine_gram_run)(gram_machine *m, int64_t samples, const double *x, const double *weight,
                                 const double *const *f, const double *rows)
{
    const double limit = m->grid.limit, *target = weight == NULL && m->targets > 0 ? f[0] : x;
    int begin = 0, refused = 0;
    m->squares = 0.0;
    for (int64_t k = 0; k < samples;) {
        k += sum_columns(m, samples, x, weight, f, rows, k, begin, &refused);
        m->last = k > 0 ? x[k - 1] : m->last;
        if (k == samples || refused) {
            return k;
        }
        if (!(__builtin_fabs(x[k]) <= limit && __builtin_fabs(target[k]) <= limit)) {
            return k; /* before the state knows of it */
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
        const run_samples r = {samples - k, x + k, x, x};
        k += follow_run(SCAN, r, &window, 0);
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
