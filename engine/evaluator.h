/* Inside the evaluator: all that it owns. Private to engine/. */
#ifndef DEHYST_EVALUATOR_H
#define DEHYST_EVALUATOR_H

#include "lanes/kernels.h"
#include "machine.h"

enum { EVALUATOR_BLOCK = 1024 }; /* samples that stay in the fastest cache */

struct engine_evaluator {
    int32_t n, front;   /* operators, with the one of weight 0 in front if there is one */
    double *r, *w;      /* (n,) */
    double *z;          /* (n,) room for states */
    double center, offset, limit;
    machine events;
};

#endif
