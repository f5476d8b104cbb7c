/* Samples between events. */
#include "gram.h"

static engine_window window_of(const gram_machine *m, int begin)
{
    const stack_segment *top = &m->stack.segment[m->stack.top];
    const int monotone = top->b == 1 ? 0 : top->s > 0 ? 1 : -1;
    const engine_window window = {m->stack.low, m->stack.high, m->last, m->origin, monotone, begin};
    return window;
}

/* Sums over a run of weight 1; returns its length. */
static int64_t sum_run(gram_machine *m, const engine_kernels *kernels, int64_t samples, int64_t from, const double *x,
                       const double *const *f, int begin)
{
    const engine_window window = window_of(m, begin);
    double sums[4] = {0};
    const int64_t count = kernels->run(samples - from, x + from, m->columns > 0 ? f[0] + from : x + from, &window, sums);
    m->run_weight += (double)count;
    m->run_d += sums[0];
    m->run_dd += sums[1];
    if (m->columns > 0) {
        m->run_f[0] += sums[2];
        m->run_df[0] += sums[3];
    }
    for (int32_t j = 1; j < m->columns; ++j) {
        double moment[3] = {0};
        kernels->moments(count, x + from, f[j] + from, m->origin, moment);
        m->run_f[j] += moment[0];
        m->run_df[j] += moment[1];
    }
    return count;
}

static int64_t sum_weighted_run(gram_machine *m, const engine_kernels *kernels, int64_t samples, int64_t from,
                                const double *x, const double *weight, const double *const *f, int begin)
{
    const engine_window window = window_of(m, begin);
    const int64_t count = kernels->scan(samples - from, x + from, &window);
    double moment[3] = {0};
    kernels->moments(count, x + from, weight + from, m->origin, moment);
    m->run_weight += moment[0];
    m->run_d += moment[1];
    m->run_dd += moment[2];
    for (int32_t j = 0; j < m->columns; ++j) {
        double sums[3] = {0};
        kernels->moments(count, x + from, f[j] + from, m->origin, sums);
        m->run_f[j] += sums[0];
        m->run_df[j] += sums[1];
    }
    return count;
}

void gram_run(gram_machine *m, const engine_kernels *kernels, int64_t samples, const double *x, const double *weight,
              const double *const *f)
{
    int begin = 0;
    for (int64_t k = 0; k < samples;) {
        k += weight == 0 ? sum_run(m, kernels, samples, k, x, f, begin)
                         : sum_weighted_run(m, kernels, samples, k, x, weight, f, begin);
        m->last = k > 0 ? x[k - 1] : m->last;
        if (k == samples) {
            break;
        }
        if (m->logged >= m->log_size) {
            gram_empty_log(m, kernels);
        }
        gram_event(m, x[k]);
        begin = 1; /* an event takes its sample whatever rounding says, so that it ends */
    }
}

/* The state alone; nothing may be pending, and all boundaries rest anew afterwards. */
void gram_pass_by(gram_machine *m, const engine_kernels *kernels, int64_t samples, const double *x)
{
    int begin = 0;
    for (int64_t k = 0; k < samples;) {
        const engine_window window = window_of(m, begin);
        k += kernels->scan(samples - k, x + k, &window);
        m->last = k > 0 ? x[k - 1] : m->last;
        m->stack.segment[m->stack.top].e = m->last;
        if (k == samples) {
            break;
        }
        stack_event(&m->grid, &m->stack, x[k]);
        begin = 1;
    }
    gram_freeze_all(m);
}
