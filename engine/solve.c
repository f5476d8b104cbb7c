/* Bounded least squares on normal equations: the active set in the unknowns, its solution in the cells. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "active_set.h"
#include "refine.h"

enum { ROUNDS = 30 };
static const double small = 1e-6; /* |column| x relative to |y|: only such weights are asked whether they are rounding */
static const double proven = 1e-10; /* KKT residual beyond which the columns are too alike for normal equations */

/* Move x to the refined solution as far as it is feasible; unknowns that are at their bound or rounding leave. 1 if so. */
static int settle(active_set *a, refinement *r, const double *refined)
{
    const engine_program *p = a->columns.program;
    const double unit = fmax(a->target, 1e-300);
    double share = 1.0;
    int left = 0;
    for (int32_t i = 0; i < r->size; ++i) {
        const int32_t j = r->member[i];
        const double next = refined[j] / a->columns.scale[j];
        if (j >= p->free && next < 0.0) {
            share = fmin(share, a->x[j] / (a->x[j] - next));
        }
    }
    for (int32_t i = 0; i < r->size; ++i) {
        const int32_t j = r->member[i];
        const double next = refined[j] / a->columns.scale[j];
        a->x[j] += share * (next - a->x[j]);
        if (j < p->free || a->x[j] > small * unit) {
            continue;
        }
        if (!(a->x[j] > 0.0) || (next < 0.0 && a->x[j] <= share * 1e-12 * unit) ||
            refinement_gain(r, i, refined[j]) <= a->tolerance) {
            active_set_drop(a, j, BARRED);
            left = 1;
        }
    }
    return left;
}

/* Refine, check, continue, until the gradient formed in the cells agrees. */
static int finish(active_set *a, refinement *r, double *refined, int warm)
{
    int status = warm ? 0 : active_set_run(a);
    for (int round = 0; round < ROUNDS && status == 0; ++round) {
        const int32_t vanished = refine(r, &a->columns, a->passive, refined, a->gradient);
        if (vanished == -2) {
            return -1;
        }
        if (vanished >= 0) {
            if (vanished < a->columns.program->free) {
                return 2;
            }
            active_set_drop(a, vanished, BARRED);
            continue;
        }
        if (settle(a, r, refined)) {
            continue;
        }
        active_set_reopen(a, BARRED);
        int failed = 1;
        for (int32_t j = active_set_steepest(a); j >= 0 && failed > 0; j = active_set_steepest(a)) {
            failed = active_set_enter(a, j);
        }
        if (failed > 0) {
            return 0;
        }
        status = failed < 0 ? -1 : active_set_run(a);
    }
    return status ? status : 1;
}

static double violation(const active_set *a)
{
    double worst = 0.0;
    for (int32_t j = 0; j < a->columns.program->unknowns; ++j) {
        const double length = j < a->columns.program->free ? 1.0 : a->length[j];
        const double gradient = a->passive[j] ? fabs(a->gradient[j]) : a->gradient[j];
        if (length > 0.0 && a->target > 0.0) {
            worst = fmax(worst, gradient / (length * a->target));
        }
    }
    return worst;
}

static int solve(active_set *a, refinement *r, const uint8_t *marked, double *u, engine_solution *solution)
{
    const engine_program *p = a->columns.program;
    int status = active_set_start(a), warm = 0;
    for (int32_t j = p->free; j < p->unknowns; ++j) {
        warm |= marked[j];
    }
    if (status == 0 && warm && active_set_warm(a, marked)) {
        return -1;
    }
    memset(u, 0, (size_t)p->unknowns * sizeof *u);
    status = status == 0 ? finish(a, r, u, warm) : status == 1 ? 2 : -1;
    solution->status = status;
    solution->iterations = a->iterations;
    solution->kkt = status == 2 ? INFINITY : violation(a);
    solution->condition = status == 2 ? INFINITY : refinement_condition(r);
    if (status == 0 && !(solution->kkt <= proven)) {
        solution->status = 2;
    }
    for (int32_t j = 0; j < p->unknowns; ++j) {
        u[j] = a->columns.lower[j] + (a->passive[j] ? u[j] : 0.0);
    }
    return status < 0 ? -1 : 0;
}

int engine_solve(const engine_program *program, double *u, uint8_t *passive, engine_solution *solution)
{
    active_set a;
    refinement r;
    uint8_t *marked = malloc((size_t)program->unknowns + 1);
    int failed = -1;
    memset(&r, 0, sizeof r);
    if (marked) {
        memcpy(marked, passive, (size_t)program->unknowns);
        failed = active_set_make(&a, program, passive) || solve(&a, &r, marked, u, solution) ? -1 : 0;
        active_set_free(&a);
        refinement_free(&r);
    }
    free(marked);
    return failed;
}
