/* Bounded least squares on normal equations: the active set in the unknowns, its solution in the cells. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "active_set.h"
#include "refine.h"

enum { ROUNDS = 30, PATIENCE = 4 };
static const double small = 1e-6;   /* |column| x relative to |y|: only such weights are asked whether they are rounding */
static const double proven = 1e-10; /* violation relative to |y| beyond which normal equations have not done */

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
        if (!(a->x[j] > 0.0) || (next < 0.0 && a->x[j] <= 1e-12 * unit) ||
            refinement_gain(r, i, refined[j]) <= a->tolerance) {
            active_set_drop(a, j, BARRED);
            left = 1;
        }
    }
    return left;
}

/* Enter the steepest unknown that can: 1 if there was none. */
static int enter_one(active_set *a)
{
    for (int32_t j = active_set_steepest(a); j >= 0; j = active_set_steepest(a)) {
        const int failed = active_set_enter(a, j);
        if (failed <= 0) {
            return failed;
        }
    }
    return 1;
}

/* Refine, check, continue, until the gradient formed in the cells agrees. Rounding in G may keep a few unknowns coming and
 * going: then what counts as rounding is raised. */
static int finish(active_set *a, refinement *r, double *refined, int warm)
{
    int status = warm ? 0 : active_set_run(a);
    for (int round = 0; round < ROUNDS && status >= 0; ++round) {
        a->tolerance *= round < PATIENCE ? 1.0 : 2.0;
        const int32_t vanished = refine(r, &a->columns, a->passive, refined, a->gradient);
        if (vanished == -2) {
            return -1;
        }
        if (vanished >= 0 && vanished < a->columns.program->free) {
            return 2;
        }
        if (vanished >= 0) {
            active_set_drop(a, vanished, GONE);
            continue;
        }
        if (settle(a, r, refined)) {
            continue;
        }
        active_set_reopen(a, BARRED);
        if (status == 1) {
            return active_set_steepest(a) < 0 ? 0 : 1;
        }
        const int entered = enter_one(a);
        if (entered > 0) {
            return 0;
        }
        status = entered < 0 ? -1 : active_set_run(a);
    }
    return status < 0 ? -1 : 1;
}

/* Largest violation of the optimality conditions, relative to the columns. */
static double violation(const active_set *a)
{
    double worst = 0.0;
    for (int32_t j = 0; j < a->columns.program->unknowns; ++j) {
        const double length = j < a->columns.program->free ? 1.0 : a->length[j];
        const double gradient = a->passive[j] ? fabs(a->gradient[j]) : a->gradient[j];
        if (!isfinite(gradient)) {
            return INFINITY;
        }
        worst = length > 0.0 ? fmax(worst, gradient / length) : worst;
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
    solution->kkt = solution->condition = INFINITY;
    if (status == 0 || status == 1) {
        const double worst = violation(a);
        solution->kkt = a->target > 0.0 ? worst / a->target : worst;
        solution->condition = refinement_condition(r);
        solution->status = status == 0 && !(worst <= proven * a->reference) ? 2 : status;
    }
    for (int32_t j = 0; j < p->unknowns; ++j) {
        const double x = status == 0 ? u[j] : a->x[j] * a->columns.scale[j]; /* out of rounds: the last feasible one */
        u[j] = a->columns.lower[j] + (a->passive[j] ? x : 0.0);
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
