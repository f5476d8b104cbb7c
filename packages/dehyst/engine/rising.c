#include "rising.h"

#include <math.h>

enum { MOST_WIDENINGS = 60, MOST_STEPS = 200 };
static const double narrow = 2.3e-16; /* relative width of a bracket that holds no further number worth a look */

/* An input, and the function there. */
typedef struct point {
    double x, f;
} point;

/* Steps from `near` away from the guess, further each time, until the function changes its sign between `far` and `near`,
 * or the end is reached. The first step is as long as a slope of 2/3 asks for, the second one as the first one tells. */
static int widen(engine_rising f, const void *context, point *near, point *far, double farthest)
{
    const double side = near->f < 0.0 ? 1.0 : -1.0;
    double reach = fmin(fmax(1.5 * fabs(near->f), 1e-9), 1.0);
    for (int k = 0; k < MOST_WIDENINGS && side * near->x < farthest; ++k) {
        const double x = side * fmin(side * near->x + reach, farthest);
        *far = (point){x, f(context, x)};
        if (side * far->f >= 0.0) {
            return 1;
        }
        const double rise = far->f - near->f, rest = -1.25 * far->f * ((far->x - near->x) / rise) * side;
        reach = k == 0 && rest > 0.25 * reach && rest < 2.0 * reach ? rest : 2.0 * reach;
        *near = *far;
    }
    return 0;
}

/* Inverse quadratic interpolation where that is sure to come closer, bisection elsewhere (T. R. Chandrupatla, Advances in
 * Engineering Software 28, 1997). */
static double share_of(point a, point b, point c)
{
    const double xi = (a.x - b.x) / (c.x - b.x), phi = (a.f - b.f) / (c.f - b.f);
    if (!(phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi)) {
        return 0.5;
    }
    return a.f / (b.f - a.f) * (c.f / (b.f - c.f)) +
           (c.x - a.x) / (b.x - a.x) * (a.f / (c.f - a.f)) * (b.f / (c.f - b.f));
}

double engine_root(engine_rising f, const void *context, double guess, double farthest)
{
    point a = {guess, f(context, guess)}, b = a;
    if (a.f == 0.0) {
        return guess;
    }
    if (!widen(f, context, &a, &b, farthest)) {
        return a.x;
    }
    double share = a.f / (a.f - b.f); /* the first step is a false position */
    for (int k = 0; k < MOST_STEPS; ++k) {
        const double least = narrow * fmax(fabs(a.x), fabs(b.x)) / fabs(b.x - a.x);
        if (!(least < 1.0)) {
            break;
        }
        const double inside = fmin(fmax(share, least), 1.0 - least);
        point x = {a.x + inside * (b.x - a.x), 0.0};
        if (!((x.x - a.x) * (x.x - b.x) < 0.0)) {
            x.x = 0.5 * (a.x + b.x);
            if (x.x == a.x || x.x == b.x) {
                break;
            }
        }
        x.f = f(context, x.x);
        if (x.f == 0.0) {
            return x.x;
        }
        point c = b;
        if ((x.f > 0.0) == (a.f > 0.0)) {
            c = a;
        } else {
            b = a;
        }
        a = x;
        share = share_of(a, b, c);
    }
    return fabs(a.f) < fabs(b.f) ? a.x : b.x;
}

double engine_curve(int32_t size, const double *c, double x)
{
    const double held = x < -1.0 ? -1.0 : (x > 1.0 ? 1.0 : x);
    double value = 0.0, slope = 0.0;
    for (int32_t j = size; j-- > 0;) {
        slope = slope * held + value;
        value = value * held + c[j];
    }
    return value + slope * (x - held);
}
