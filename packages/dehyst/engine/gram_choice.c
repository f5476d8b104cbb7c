/* How many operators in front are cheaper one by one than by events: noise moves them at every sample. */
#include <stdlib.h>
#include <string.h>

#include "dehyst.h"
#include "gram.h"

enum { TRIAL = 512, FEWEST = 128, SOONEST = 1 << 14, LATEST = 1 << 18, LONGEST = 32 };

/* What a sample costs with a prefix of 0, 4, ... 32 operators, and what an event adds: ns, measured at each level. Only
 * their ratios matter. */
static const double prefix_cost[ENGINE_LEVELS][LONGEST / 4 + 1] = {
    {1.1, 12.0, 15.7, 28.8, 37.0, 50.4, 61.5, 81.0, 95.6},
    {0.6, 5.5, 6.7, 11.9, 15.7, 20.4, 24.0, 31.5, 36.6},
    {0.5, 4.4, 5.0, 8.7, 10.9, 13.6, 15.7, 21.7, 24.6}};
static const double event_cost[ENGINE_LEVELS] = {80.0, 65.0, 65.0};
static const double column_cost = 1.0; /* of a cell of the prefix, per event */
static const double few = 0.03;        /* events a sample that leave nothing to gain */

/* Events a sample behind a prefix, counted; z are the states now. Negative if memory is short. */
static double trial(const engine_gram *g, const engine_kernels *kernels, int32_t prefix, const double *z, int64_t samples,
                    const double *x)
{
    gram_machine m;
    gram_dense d;
    const int32_t n = g->n - prefix;
    double events = -1.0;
    memset(&m, 0, sizeof m);
    memset(&d, 0, sizeof d);
    m.stack.segment = malloc(((size_t)n + 2) * sizeof *m.stack.segment);
    if (m.stack.segment != NULL && gram_grid_start(&m.grid, n, g->r + prefix) == 0 &&
        gram_dense_start(&d, prefix, g->n, g->r, z, 0) == 0) {
        gram_stack_from_state(&m.grid, &m.stack, z + prefix);
        m.last = m.stack.segment[m.stack.top].e;
        for (int64_t from = 0, count; from < samples; from += count) {
            count = samples - from < GRAM_DENSE_SAMPLES ? samples - from : GRAM_DENSE_SAMPLES;
            const double *drive = x + from;
            if (prefix > 0) {
                kernels->cells(count, prefix, d.r, d.z, drive, d.rows, d.drive);
                drive = d.drive;
            }
            kernels->gram_pass_by(&m, count, drive);
        }
        events = (double)m.events / (double)samples;
    }
    gram_grid_free(&m.grid);
    gram_dense_free(&d);
    free(m.stack.segment);
    return events;
}

static double cost(int level, int32_t prefix, double events)
{
    return prefix_cost[level][prefix / 4] + events * (event_cost[level] + column_cost * prefix);
}

/* The cheapest prefix for samples like these. */
static int32_t cheapest(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *x, double *now,
                        double *best)
{
    const int level = engine_level();
    int32_t chosen = g->dense.prefix;
    *now = *best = 1e300;
    engine_gram_state(g, g->state);
    for (int32_t prefix = 0; prefix <= LONGEST && prefix < g->n + 3; prefix += 4) {
        if (cost(level, prefix, 0.0) >= *best && prefix > g->dense.prefix) { /* without any event too dear */
            break;
        }
        const double events = prefix < g->n ? trial(g, kernels, prefix, g->state, samples, x) : 0.0;
        const double one = cost(level, prefix, events);
        if (events < 0.0) {
            break;
        }
        *now = prefix == g->dense.prefix ? one : *now;
        if (one < *best) {
            *best = one;
            chosen = prefix;
        }
        if (events < few) { /* a longer prefix only adds work */
            break;
        }
    }
    return chosen;
}

/* The prefix to go on with. Called before samples are added; looks at some of them when it is time to. */
int32_t gram_choose(engine_gram *g, const engine_kernels *kernels, int64_t samples, const double *x)
{
    const int64_t count = samples < TRIAL ? samples : TRIAL;
    if (g->method != ENGINE_AUTO || g->until_choice > 0 || count < FEWEST) {
        return g->dense.prefix;
    }
    const int64_t seen = g->since_choice;
    const double events = (double)(g->machine.events - g->events_then) / (double)(seen > 0 ? seen : 1);
    g->until_choice = 4 * seen < SOONEST ? SOONEST : 4 * seen > LATEST ? LATEST : 4 * seen;
    g->since_choice = 0;
    g->events_then = g->machine.events;
    if (seen > 0 && g->dense.prefix == 0 && events < few) {
        return 0;
    }
    if (kernels->between(count, x, -DEHYST_INPUT_LIMIT, DEHYST_INPUT_LIMIT) < count) {
        return g->dense.prefix;
    }
    double now, best;
    const int32_t chosen = cheapest(g, kernels, count, x, &now, &best);
    const double change = g->empty ? 0.0 : 4.0 * (double)g->n * (double)g->n; /* sums so far are put aside */
    return (now - best) * (double)g->until_choice > change ? chosen : g->dense.prefix;
}
