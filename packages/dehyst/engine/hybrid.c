/* Which operators are evaluated densely: exact switching between methods, and the choice from the events of a probe. */
#include "evaluator.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void evaluator_state(const engine_evaluator *e, double *z)
{
    if (e->method == ENGINE_EVENTS) {
        machine_state(&e->events, z);
        return;
    }
    const int32_t k = e->dense.operators;
    dense_state(e, z);
    if (k < e->n) {
        const double last = z[k - 1];
        machine_state(&e->rest, z + k - 1); /* its first operator is the prefix's last one */
        z[k - 1] = last;
    }
}

/* Tables of the operators after a prefix: thresholds above its last one, behind an operator of weight 0. */
static int make_rest(engine_evaluator *e, int32_t prefix)
{
    if (e->rest_after == prefix) {
        return 0;
    }
    const int32_t n = e->n - prefix + 1;
    double *r = malloc(2 * (size_t)n * sizeof *r);
    machine rest;
    if (r == NULL) {
        return -1;
    }
    double *const w = r + n;
    for (int32_t i = 0; i < n; ++i) {
        r[i] = e->r[prefix - 1 + i] - e->r[prefix - 1];
        w[i] = i == 0 ? 0.0 : e->w[prefix - 1 + i];
    }
    const int short_of_memory = machine_make(&rest, n, r, w, e->limit);
    free(r);
    if (short_of_memory) {
        return -1;
    }
    e->rest_events += e->rest.events;
    machine_free(&e->rest);
    e->rest = rest;
    e->rest_after = prefix;
    return 0;
}

int evaluator_switch(engine_evaluator *e, int32_t method)
{
    if (method == e->method) {
        return 0;
    }
    const int hybrid = method != ENGINE_EVENTS && method < e->n;
    if (method != ENGINE_EVENTS && e->dense.p == NULL && dense_make(e) != 0) {
        return -1;
    }
    evaluator_state(e, e->z);
    if (hybrid && make_rest(e, method) != 0) {
        return -1;
    }
    if (method == ENGINE_EVENTS) {
        machine_start(&e->events, e->z);
    } else {
        dense_start(e, hybrid ? method : e->n, e->z);
    }
    if (hybrid) {
        machine_start(&e->rest, e->z + method - 1);
    }
    e->method = method;
    return 0;
}

/* ---- Costs in ns, measured on one machine; only their ratios matter.
 * Events: four to five branches that nobody foresees, or none or one where the boundary moves on by an operator or a few. */
static const double LINE = 0.3, EVENT = 30.0, CRAWLED = 4.0;
static const double REST = 1.4; /* times that, of an event behind a prefix: it comes when nothing hints at it */
/* Dense: a sample, an operator, and what a prefix costs besides. By level. */
static const double DENSE_SAMPLE[ENGINE_LEVELS] = {0.7, 0.9, 1.0};
static const double DENSE_OPERATOR[ENGINE_LEVELS] = {0.25, 0.115, 0.07};
static const double PREFIX = 0.6;
/* sum |w| (r + reach) of dense operators may be so often the largest output: the error stays below 1e-14 of that. */
static const double HARMLESS = 8.0;

enum {
    PROBE = 256,                       /* samples */
    STRETCH = 4 * EVALUATOR_BLOCK,     /* between two looks at the events */
    SHORTEST_DWELL = 8 * STRETCH,     /* with a dense method before the next probe */
    LONGEST_DWELL = 64 * STRETCH,
    LONGEST_CALM = 16 * STRETCH,       /* between probes that found nothing better than events */
    LARGEST_PREFIX = 512
};

static double event_cost(const machine *m, const choice *c)
{
    const double events = (double)(m->events - c->events), crawled = (double)(m->crawled - c->crawled);
    return EVENT * (events - crawled) + CRAWLED * crawled;
}

static void look_again(engine_evaluator *e, int64_t samples)
{
    const machine *m = e->method == ENGINE_EVENTS ? &e->events : &e->rest;
    e->choice.left = samples;
    e->choice.span = samples;
    e->choice.events = m->events;
    e->choice.crawled = m->crawled;
}

static void probe(engine_evaluator *e)
{
    e->choice.probing = 1;
    machine_forget(&e->events);
    look_again(e, PROBE);
}

void choice_start(engine_evaluator *e, int automatic)
{
    choice *c = &e->choice;
    c->automatic = automatic;
    c->dwell = SHORTEST_DWELL;
    c->calm = STRETCH;
    c->probing = 0;
    if (automatic && e->method == ENGINE_EVENTS) {
        probe(e);
    } else {
        look_again(e, PROBE);
        c->stay = 0;
    }
}

/* The cheapest method for what the probe saw, and its cost in ns a sample. */
static int32_t cheapest(const engine_evaluator *e, double *cost)
{
    const machine *m = &e->events;
    const int64_t events = m->events - e->choice.events;
    const double each = events > 0 ? event_cost(m, &e->choice) / (double)events / (double)PROBE : 0.0;
    const int level = engine_level();
    int32_t best = ENGINE_EVENTS;
    *cost = LINE + each * (double)events;
    int64_t shallow = 0; /* events that a prefix removes */
    double harm = 0.0;
    for (int32_t k = 0; k < e->n && k < LARGEST_PREFIX;) {
        const int32_t end = k + 8 < e->n ? k + 8 : e->n;
        shallow += m->depth[k / 8];
        for (; k < end; ++k) {
            harm += fabs(e->w[k]) * (e->r[k] + m->reach);
        }
        if (harm > HARMLESS * m->size) {
            break;
        }
        const double padded = (double)((k + 7) / 8 * 8);
        double price = DENSE_SAMPLE[level] + DENSE_OPERATOR[level] * padded;
        if (k < e->n) {
            if ((k & (k - 1)) != 0) {
                continue;
            }
            price += PREFIX + REST * each * (double)(events - shallow);
        }
        if (price < *cost) {
            *cost = price;
            best = k < e->n ? k : ENGINE_DENSE;
        }
    }
    return best;
}

static void choose(engine_evaluator *e)
{
    choice *c = &e->choice;
    double cost;
    const int32_t best = cheapest(e, &cost);
    c->probing = 0;
    if (best == ENGINE_EVENTS || evaluator_switch(e, best) != 0) {
        c->dwell = SHORTEST_DWELL;
        look_again(e, c->calm);
        c->calm = 2 * c->calm < LONGEST_CALM ? 2 * c->calm : LONGEST_CALM;
        return;
    }
    c->calm = STRETCH;
    c->expected = cost;
    c->stay = c->dwell;
    c->dwell = 2 * c->dwell < LONGEST_DWELL ? 2 * c->dwell : LONGEST_DWELL;
    look_again(e, 4 * STRETCH);
}

void choice_decide(engine_evaluator *e)
{
    choice *c = &e->choice;
    if (e->method != ENGINE_EVENTS) {
        c->stay -= 4 * STRETCH;
        const double by_rest = REST * event_cost(&e->rest, c) / (4 * STRETCH);
        if (c->stay > 0 && by_rest <= 2 * c->expected) {
            look_again(e, 4 * STRETCH);
        } else if (evaluator_switch(e, ENGINE_EVENTS) == 0) {
            probe(e);
        }
    } else if (c->probing) {
        choose(e);
    } else if (event_cost(&e->events, c) >
               DENSE_SAMPLE[engine_level()] * (double)c->span) {
        probe(e);
    } else {
        c->calm = STRETCH;
        look_again(e, STRETCH);
    }
}
