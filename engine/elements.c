/* Plays, stops, springs, dampers, creep and rates in parallel: forward sample by sample, backward by Newton's method on the
 * piecewise linear equation of one sample. */
#include "elements.h"
#include "patience.h"

#include <math.h>
#include <stddef.h>

enum { PATIENCE = 12 };
static const double ROUNDING = 2e-16;

static double clip(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

static double radius_of(const engine_elements *p, int32_t i, double rate) { return p->radius[i] + p->extra[i] * fabs(rate); }

/* Creep states move under the input that was held since the sample before. */
static void creep(const engine_elements *p, double h, double *memory)
{
    const double held = memory[0];
    if (!(h > 0)) {
        return;
    }
    for (int32_t i = 0; i < p->n; ++i) {
        if (p->kind[i] == ENGINE_CREEP) {
            double *z = &memory[ENGINE_ELEMENT_MEMORY + i];
            const double target = clip(*z, held - p->radius[i], held + p->radius[i]);
            *z = target + (*z - target) * exp(-h / p->extra[i]);
        }
    }
}

/* Output of an element at the input x; its state follows. */
static double element(const engine_elements *p, int32_t i, double x, double h, double *memory)
{
    const double rate = memory[1], r = p->radius[i];
    double *z = &memory[ENGINE_ELEMENT_MEMORY + i];
    switch (p->kind[i]) {
    case ENGINE_PLAY: {
        const double now = radius_of(p, i, rate);
        *z = clip(*z, x - now, x + now);
        return *z;
    }
    case ENGINE_STOP: {
        const double now = radius_of(p, i, rate), e = clip(x - *z, -now, now);
        *z = clip(*z, x - now, x + now);
        return e;
    }
    case ENGINE_PIECE:
        return clip(x - p->extra[i], -r, r);
    case ENGINE_DAMPER:
        return h > 0 ? clip((x - memory[0]) / h, -r, r) : 0.0;
    case ENGINE_CREEP:
        return *z;
    default:
        return rate;
    }
}

/* The rate that later samples see. */
static void moved(const engine_elements *p, double x, double h, double *memory)
{
    if (h > 0) {
        memory[1] += (1.0 - exp(-h / p->lag)) * ((x - memory[0]) / h - memory[1]);
    }
    memory[0] = x;
}

void engine_elements_run(const engine_elements *p, int64_t samples, const double *x, const double *dt, double *memory,
                         double *y, double *bank)
{
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 10 + 4 * p->n); ++k) {
        const double h = dt != NULL ? dt[k] : 0.0;
        creep(p, h, memory);
        double sum = p->slope * x[k];
        for (int32_t i = 0; i < p->n; ++i) {
            const double e = element(p, i, x[k], h, memory);
            sum += p->weight[i] * e;
            if (bank != NULL) {
                bank[k * p->n + i] = e;
            }
        }
        moved(p, x[k], h, memory);
        y[k] = sum;
    }
}

/* The sum at one input as constant + slope x, true on the piece around it. */
typedef struct line {
    double constant, slope;
} line;

static void add_clip(line *sum, double weight, double x, double origin, double r)
{
    if (x - origin > r) {
        sum->constant += weight * r;
    } else if (x - origin < -r) {
        sum->constant -= weight * r;
    } else {
        sum->constant -= weight * origin;
        sum->slope += weight;
    }
}

static line sum_at(const engine_elements *p, double x, double h, const double *memory)
{
    line sum = {0.0, p->slope};
    for (int32_t i = 0; i < p->n; ++i) {
        const double w = p->weight[i], r = p->radius[i], z = memory[ENGINE_ELEMENT_MEMORY + i], rate = memory[1];
        switch (p->kind[i]) {
        case ENGINE_PLAY: {
            const double now = radius_of(p, i, rate), along = clip(z, x - now, x + now);
            if (along == z) {
                sum.constant += w * z;
            } else {
                sum.constant += along > z ? -w * now : w * now;
                sum.slope += w;
            }
            break;
        }
        case ENGINE_STOP:
            add_clip(&sum, w, x, z, radius_of(p, i, rate));
            break;
        case ENGINE_PIECE:
            add_clip(&sum, w, x, p->extra[i], r);
            break;
        case ENGINE_DAMPER:
            if (h > 0) {
                add_clip(&sum, w / h, x, memory[0], r * h);
            }
            break;
        case ENGINE_CREEP:
            sum.constant += w * z;
            break;
        default:
            sum.constant += w * rate;
        }
    }
    return sum;
}

/* Zero of the rising piecewise linear sum less y. A Newton step that does not leave its piece is exact. One that leaves the
 * bracket gives way to its middle, and so does every third after the first PATIENCE: whatever the weights, it ends. */
static double solve(const engine_elements *p, double y, double h, double farthest, const double *memory)
{
    double low = -farthest, high = farthest, x = clip(memory[0], low, high);
    for (int turn = 1; turn < 400; ++turn) {
        const line at = sum_at(p, x, h, memory);
        const double miss = at.constant + at.slope * x - y;
        if (miss == 0.0) {
            break;
        }
        if (miss < 0.0) {
            low = x;
        } else {
            high = x;
        }
        const double newton = at.slope > 0.0 ? (y - at.constant) / at.slope : 2.0 * farthest;
        double next = newton;
        if (fabs(newton - x) <= ROUNDING * (1.0 + fabs(x))) {
            return newton;
        }
        if (!(newton >= low && newton <= high) || (turn > PATIENCE && turn % 3 == 0)) {
            next = 0.5 * (low + high);
        } else {
            const line there = sum_at(p, newton, h, memory);
            if (there.slope == at.slope && there.constant == at.constant) {
                return newton;
            }
        }
        if (next == x || !(low < high)) {
            break;
        }
        x = next;
    }
    return x;
}

void engine_elements_invert(const engine_elements *p, int64_t samples, const double *y, const double *dt, double farthest,
                            double *memory, double *x)
{
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 50 + 50 * p->n); ++k) {
        const double h = dt != NULL ? dt[k] : 0.0;
        creep(p, h, memory);
        x[k] = solve(p, y[k], h, farthest, memory);
        for (int32_t i = 0; i < p->n; ++i) {
            (void)element(p, i, x[k], h, memory);
        }
        moved(p, x[k], h, memory);
    }
}
