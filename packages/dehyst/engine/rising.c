#include "rising.h"

#include <math.h>

enum { MOST_WIDENINGS = 60, MOST_STEPS = 200 };
static const double narrow = 2.3e-16; /* relative width of a bracket that holds no further number worth a look */

typedef struct bracket {
    double low, high, below, above;
} bracket;

/* 1 if the zero lies within the bracket, which is widened by doubling. */
static int widen(engine_rising f, const void *context, bracket *b, double reach, double farthest)
{
    for (int k = 0; k < MOST_WIDENINGS && b->below > 0.0 && b->low > -farthest; ++k, reach *= 2.0) {
        b->high = b->low;
        b->above = b->below;
        b->low = fmax(b->low - reach, -farthest);
        b->below = f(context, b->low);
    }
    for (int k = 0; k < MOST_WIDENINGS && b->above < 0.0 && b->high < farthest; ++k, reach *= 2.0) {
        b->low = b->high;
        b->below = b->above;
        b->high = fmin(b->high + reach, farthest);
        b->above = f(context, b->high);
    }
    return b->below <= 0.0 && b->above >= 0.0;
}

double engine_root(engine_rising f, const void *context, double guess, double farthest)
{
    const double first = f(context, guess);
    /* Slopes are of the order of 1. */
    const double reach = fmin(fmax(1.5 * fabs(first), 1e-9), 1.0);
    bracket b = {guess, guess, first, first};
    if (first == 0.0) {
        return guess;
    }
    if (!widen(f, context, &b, reach, farthest)) {
        return b.below > 0.0 ? b.low : b.high;
    }
    int side = 0;
    double wide = b.high - b.low;
    for (int k = 0; k < MOST_STEPS && b.high - b.low > narrow * fmax(fabs(b.low), fabs(b.high)); ++k) {
        double middle = (b.low * b.above - b.high * b.below) / (b.above - b.below);
        /* Every fourth step must have made the bracket smaller by half, else it is halved. */
        const int slow = k % 4 == 3 && b.high - b.low > 0.5 * wide;
        wide = k % 4 == 3 ? b.high - b.low : wide;
        if (slow || !(middle > b.low && middle < b.high)) {
            middle = 0.5 * (b.low + b.high);
        }
        if (!(middle > b.low && middle < b.high)) {
            break;
        }
        const double value = f(context, middle);
        if (value == 0.0) {
            return middle;
        }
        if (value < 0.0) {
            b.low = middle;
            b.below = value;
            b.above *= side < 0 ? 0.5 : 1.0;
            side = -1;
        } else {
            b.high = middle;
            b.above = value;
            b.below *= side > 0 ? 0.5 : 1.0;
            side = 1;
        }
    }
    return -b.below < b.above ? b.low : b.high;
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
