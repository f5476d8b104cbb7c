#include "lugre.h"
#include "patience.h"

#include <math.h>

#include "rising.h"

/* From x0, z to x1 within dt: the new z; *rate and *speed are z' and v at the end, 0 where dt is 0. */
static double step(const engine_lugre *p, double x0, double z, double x1, double dt, double *rate, double *speed)
{
    const double move = x1 - x0, v = dt > 0.0 ? move / dt : 0.0, relative = v / p->stribeck;
    const double length = p->length * (1.0 + (p->ratio - 1.0) * exp(-relative * relative));
    const double end = move > 0.0 ? length : -length;
    const double next = move != 0.0 ? z - (z - end) * -expm1(-fabs(move) / length) : z;
    *speed = v;
    *rate = v - fabs(v) * next / length;
    return next;
}

static double sum_of(const engine_lugre *p, double x, double z, double rate, double speed)
{
    return engine_curve(p->coefficients, p->curve, x) + p->sigma[0] * z + p->sigma[1] * rate + p->sigma[2] * speed;
}

void engine_lugre_run(const engine_lugre *p, int64_t samples, const double *x, const double *dt, double *memory,
                      double *y, double *columns)
{
    double before = memory[0], z = memory[1];
    for (int64_t t = 0, end; (end = engine_until(t, samples, 50)) > t;) {
        for (; t < end; ++t) {
            double rate = 0.0, speed = 0.0;
            z = step(p, before, z, x[t], dt[t], &rate, &speed);
            y[t] = sum_of(p, x[t], z, rate, speed);
            if (columns) {
                columns[3 * t] = z;
                columns[3 * t + 1] = rate;
                columns[3 * t + 2] = speed;
            }
            before = x[t];
        }
    }
    memory[0] = before;
    memory[1] = z;
}

typedef struct wish {
    const engine_lugre *p;
    const double *memory;
    double y, dt;
} wish;

static double miss(const void *context, double x)
{
    const wish *w = (const wish *)context;
    double rate = 0.0, speed = 0.0;
    const double z = step(w->p, w->memory[0], w->memory[1], x, w->dt, &rate, &speed);
    return sum_of(w->p, x, z, rate, speed) - w->y;
}

void engine_lugre_invert(const engine_lugre *p, int64_t samples, const double *y, const double *dt, double farthest,
                         double *memory, double *x)
{
    for (int64_t t = 0, left = ENGINE_BETWEEN; t < samples && !engine_stops(&left, 1000); ++t) {
        const wish w = {p, memory, y[t], dt[t]};
        double rate = 0.0, speed = 0.0;
        const double found = engine_root(miss, &w, memory[0], farthest);
        memory[1] = step(p, memory[0], memory[1], found, dt[t], &rate, &speed);
        memory[0] = x[t] = found;
    }
}
