#include "duhem.h"
#include "patience.h"

#include <math.h>

#include "rising.h"

static double polynomial(int32_t size, const double *c, double x)
{
    double value = 0.0;
    for (int32_t j = size; j-- > 0;) {
        value = value * x + c[j];
    }
    return value;
}

void engine_duhem_make(engine_duhem *p, int32_t coefficients, const double *curve, double alpha, int32_t losses,
                       const double *loss)
{
    p->coefficients = coefficients;
    p->curve = curve;
    p->losses = losses;
    p->alpha = alpha;
    p->low = polynomial(losses, loss, -1.0);
    p->high = polynomial(losses, loss, 1.0);
    for (int up = 0; up < 2; ++up) { /* P' + alpha sgn P = h, from the highest power down */
        const double rate = up ? alpha : -alpha;
        double above = 0.0;
        for (int32_t j = losses; j-- > 0;) {
            above = (loss[j] - (j + 1) * above) / rate;
            p->particular[up][j] = above;
        }
    }
}

/* From x0 to x1, both at or below -1, within [-1, 1], or at or above 1. */
static double within(const engine_duhem *p, double x0, double w, double x1)
{
    const int up = x1 > x0;
    const double shrunk = expm1(-p->alpha * fabs(x1 - x0)); /* e^(-alpha |dx|) - 1 */
    const double middle = 0.5 * (x0 + x1);
    if (middle < -1.0 || middle > 1.0) {
        const double limit = (middle < 0.0 ? p->low : p->high) / (up ? p->alpha : -p->alpha);
        return w + (w - limit) * shrunk;
    }
    const double from = polynomial(p->losses, p->particular[up], x0), to = polynomial(p->losses, p->particular[up], x1);
    return w + (w - from) * shrunk + (to - from);
}

static double step(const engine_duhem *p, double x0, double w, double x1)
{
    if (x0 == x1) {
        return w;
    }
    const double first = x1 > x0 ? -1.0 : 1.0;
    for (int k = 0; k < 2; ++k) { /* stop at the ends of the polynomial */
        const double end = k == 0 ? first : -first;
        if ((x0 < end && end < x1) || (x1 < end && end < x0)) {
            w = within(p, x0, w, end);
            x0 = end;
        }
    }
    return within(p, x0, w, x1);
}

void engine_duhem_run(const engine_duhem *p, int64_t samples, const double *x, double *memory, double *y)
{
    for (int64_t t = 0, left = ENGINE_BETWEEN; t < samples && !engine_stops(&left, 100); ++t) {
        memory[1] = step(p, memory[0], memory[1], x[t]);
        memory[0] = x[t];
        y[t] = engine_curve(p->coefficients, p->curve, x[t]) - memory[1];
    }
}

typedef struct wish {
    const engine_duhem *p;
    const double *memory;
    double y;
} wish;

static double miss(const void *context, double x)
{
    const wish *w = (const wish *)context;
    return engine_curve(w->p->coefficients, w->p->curve, x) - step(w->p, w->memory[0], w->memory[1], x) - w->y;
}

void engine_duhem_invert(const engine_duhem *p, int64_t samples, const double *y, double farthest, double *memory,
                         double *x)
{
    for (int64_t t = 0, left = ENGINE_BETWEEN; t < samples && !engine_stops(&left, 2000); ++t) {
        const wish w = {p, memory, y[t]};
        const double found = engine_root(miss, &w, memory[0], farthest);
        memory[1] = step(p, memory[0], memory[1], found);
        memory[0] = x[t] = found;
    }
}
