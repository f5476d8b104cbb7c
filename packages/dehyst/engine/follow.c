#include "follow.h"
#include "patience.h"

#include <math.h>
#include <stdlib.h>

#include "dehyst.h"

enum { MOST_STEPS = 100 };

typedef struct follower {
    const engine_direct *d;
    const double *given; /* (sets,) factors of this sample, or NULL */
    double *lowest, *highest, *lag, *path, *gain;
    double last, step;
} follower;

static double share_of(const follower *f, int32_t set, double y)
{
    const engine_direct *d = f->d;
    if (d->factor[set] == ENGINE_FACTOR_GIVEN) {
        return f->given ? f->given[set] : 1.0;
    }
    const double xi = dehyst_within((y - d->low[set]) / (d->high[set] - d->low[set]), 0.0, 1.0);
    return d->factor[set] == ENGINE_FACTOR_RISING ? xi : 1.0 - xi;
}

static double play_of(double y, double radius, double state)
{
    return dehyst_within(state, y - radius, y + radius);
}

static double path_of(const follower *f, int32_t k, double y)
{
    const double move = y - f->last, length = f->d->length[k], end = move < 0.0 ? -length : length;
    return end + dehyst_decay(fabs(move) / length) * (f->path[k] - end);
}

/* D[y] if y were the next output. */
static double input_of(const follower *f, double y)
{
    const engine_direct *d = f->d;
    double share[ENGINE_SETS], sum = 0.0;
    const double held = dehyst_within(y, d->held_low, d->held_high);
    for (int32_t c = 0; c < d->sets; ++c) {
        share[c] = share_of(f, c, held);
        double power = 0.0, slope = 0.0;
        for (int32_t j = d->powers; j-- > 0;) {
            slope = slope * (held - d->center) + power;
            power = power * (held - d->center) + d->polynomial[c * d->powers + j];
        }
        power += slope * (y - held);
        const double speed = f->step > 0.0 ? (y - f->last) / f->step : 0.0;
        sum += share[c] * (power + d->viscous[c] * speed);
    }
    for (int32_t i = 0; i < d->stops; ++i) {
        const double r = d->radius[i];
        const double middle = 0.5 * (play_of(y, r, f->lowest[i]) + play_of(y, r, f->highest[i]));
        for (int32_t c = 0; c < d->sets; ++c) {
            sum += share[c] * d->stop_weight[c * d->stops + i] * (y - middle);
        }
    }
    for (int32_t k = 0; k < d->paths; ++k) {
        const double memory = path_of(f, k, y);
        for (int32_t c = 0; c < d->sets; ++c) {
            sum += share[c] * d->path_weight[c * d->paths + k] * memory;
        }
    }
    for (int32_t j = 0; j < d->lags; ++j) {
        const double above = (1.0 - f->gain[j]) * (y - f->lag[j]);
        for (int32_t c = 0; c < d->sets; ++c) {
            sum += share[c] * d->creep_weight[c * d->lags + j] * above;
        }
    }
    return sum;
}

static void go_to(follower *f, double y)
{
    const engine_direct *d = f->d;
    for (int32_t i = 0; i < d->stops; ++i) {
        f->lowest[i] = play_of(y, d->radius[i], f->lowest[i]);
        f->highest[i] = play_of(y, d->radius[i], f->highest[i]);
    }
    for (int32_t k = 0; k < d->paths; ++k) {
        f->path[k] = path_of(f, k, y);
    }
    for (int32_t j = 0; j < d->lags; ++j) {
        f->lag[j] += f->gain[j] * (y - f->lag[j]);
    }
    f->last = y;
}

/* A crossing of u from below between a and b, where D[y] - u is fa and fb: inverse quadratic interpolation where that
 * is sure to come closer, bisection elsewhere (T. R. Chandrupatla, Advances in Engineering Software 28, 1997). */
static double crossing(const follower *f, double u, double a, double fa, double b, double fb, double tolerance)
{
    double c = a, fc = fa, share = fa / (fa - fb); /* the first step is a false position */
    for (int step = 0; step < MOST_STEPS; ++step) {
        const double least = tolerance / fabs(b - a);
        if (!(least < 0.5)) {
            break;
        }
        const double x = a + dehyst_within(share, least, 1.0 - least) * (b - a), fx = input_of(f, x) - u;
        if (fx == 0.0) {
            return x;
        }
        if ((fx > 0.0) == (fa > 0.0)) {
            c = a;
            fc = fa;
        } else {
            c = b;
            fc = fb;
            b = a;
            fb = fa;
        }
        a = x;
        fa = fx;
        const double xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
        share = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi
                    ? fa / (fb - fa) * (fc / (fb - fc)) + (c - a) / (b - a) * (fa / (fc - fa)) * (fb / (fc - fb))
                    : 0.5;
    }
    return fabs(fa) < fabs(fb) ? a : b;
}

/* The output that follows; *found is 0 if the input is not reached within the bounds. It is looked for from the last
 * output on, first as far as that has moved. */
static double next(const follower *f, double u, double moved, int *found)
{
    const engine_direct *d = f->d;
    const double span = d->y_high - d->y_low;
    double a = dehyst_within(f->last, d->y_low, d->y_high), fa = input_of(f, a) - u;
    const double direction = fa < 0.0 ? 1.0 : -1.0;
    *found = 1;
    if (fa == 0.0) {
        return a;
    }
    for (double reach = 2.0 * moved + 1e-6 * span;; reach *= 4.0) {
        const double b = dehyst_within(a + direction * reach, d->y_low, d->y_high), fb = input_of(f, b) - u;
        if (direction * fb >= 0.0) {
            return crossing(f, u, a, fa, b, fb, 1e-14 * span);
        }
        if (b == d->y_low || b == d->y_high) {
            *found = 0;
            return b;
        }
        a = b;
        fa = fb;
    }
}

int64_t engine_follow(const engine_direct *d, int64_t samples, const double *u, const double *time,
                      const double *given, double *lowest, double *highest, double *path, double *y)
{
    double *memory = (double *)calloc(2 * (size_t)d->lags + 1, sizeof(double));
    if (!memory) {
        return -1;
    }
    follower f = {d, given, lowest, highest, memory, path, memory + d->lags, samples > 0 ? y[0] : 0.0, 0.0};
    for (int32_t j = 0; j < d->lags; ++j) {
        f.lag[j] = f.last;
    }
    int64_t lost = 0;
    for (int64_t k = 1, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 500 + 200 * (d->stops + d->paths + d->lags) * d->sets); ++k) {
        int found = 1;
        f.step = time ? time[k] - time[k - 1] : 0.0;
        f.given = given ? given + k * d->sets : NULL;
        for (int32_t j = 0; j < d->lags; ++j) {
            f.gain[j] = -expm1(-f.step / d->time_constant[j]);
        }
        y[k] = next(&f, u[k], k > 1 ? fabs(y[k - 1] - y[k - 2]) : 0.0, &found);
        lost += !found;
        go_to(&f, y[k]);
    }
    free(memory);
    return lost;
}
