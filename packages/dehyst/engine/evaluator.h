/* Inside the evaluator: all that it owns. Private to engine/. */
#ifndef DEHYST_EVALUATOR_H
#define DEHYST_EVALUATOR_H

#include "engine.h"
#include "lanes/kernels.h"
#include "machine.h"

#ifndef ENGINE_STREAM_SAMPLES
#define ENGINE_STREAM_SAMPLES (1 << 22) /* so many outputs no cache keeps anyway: they are stored past them */
#endif

enum { EVALUATOR_BLOCK = 1024 }; /* samples that stay in the fastest cache */

/* The first `operators` ones evaluated densely; lane order of lanes/dense.c. */
typedef struct dense {
    void *memory;               /* what all arrays lie in */
    double *p, *width, *weight; /* (8 * vectors of all,), in whole cache lines */
    double *room;               /* blocks of samples: centred inputs, outputs, the last operator's p, outputs of the rest */
    int32_t operators;          /* 0: not in use */
    double base;                /* offset - sum w r */
} dense;

/* What ENGINE_AUTO has seen and decided (hybrid.c). */
typedef struct choice {
    int automatic;
    int probing;       /* events are counted to choose a method */
    int64_t left;      /* samples until the next decision, ... */
    int64_t span;      /* ... of so many */
    int64_t dwell;     /* samples from a decision for a dense method to the next probe */
    int64_t stay;      /* of them still to come */
    int64_t calm;      /* samples after which events are looked at again */
    int64_t events;    /* counted before the present stretch */
    int64_t crawled;
    double expected;   /* ns a sample that the present method should need */
} choice;

struct engine_evaluator {
    int32_t n, front; /* operators, with the one of weight 0 in front if there is one */
    double *r, *w;    /* (n,) */
    double *z;        /* (n,) room for states */
    double center, offset, limit;
    int32_t method;   /* in use: ENGINE_EVENTS, a prefix, ENGINE_DENSE */
    machine events;   /* all operators by events */
    machine rest;     /* those after the dense prefix, on the output of its last one */
    int32_t rest_after; /* prefix that `rest` has tables for, 0: none */
    int64_t rest_events; /* of earlier rests */
    dense dense;
    choice choice;
};

/* dense.c */
int dense_make(engine_evaluator *e);
void dense_free(engine_evaluator *e);
void dense_start(engine_evaluator *e, int32_t operators, const double *z);
void dense_state(const engine_evaluator *e, double *z);
int64_t dense_run(engine_evaluator *e, int64_t samples, const double *x, double *y);

/* hybrid.c */
int evaluator_switch(engine_evaluator *e, int32_t method); /* exact; -1 if memory is short: the old method goes on */
void evaluator_state(const engine_evaluator *e, double *z); /* (n,) with the operator in front */
void choice_start(engine_evaluator *e, int automatic);
void choice_decide(engine_evaluator *e); /* after choice.left samples */

#endif
