#include "oscillator.h"
#include "patience.h"

#include <math.h>

enum { EVENTS = 6, HALVINGS = 60 }; /* corners within a step; more means chatter at rest and is stepped over */

typedef struct motion { double y, v, z; } motion;

/* A step of the fine grid: the force is the parabola through its values at both ends and the middle. */
typedef struct stretch { double h, start, curve_a, curve_b; } stretch;

/* Signs of y' and z between two corners. */
typedef struct branch { double s, sigma; } branch;

static double force_at(const stretch *f, double t) { return f->start + t * (f->curve_a + t * f->curve_b); }

static double clip(double x, double r) { return x > r ? r : x < -r ? -r : x; }

static double stop_force(const engine_oscillator *o, const double *stop, double moved, double y)
{
    double sum = 0.0;
    for (int32_t i = 0; i < o->stops; ++i)
        sum += (o->weight[i] + o->square[i] * y * y) * clip(stop[i] + moved, o->threshold[i]);
    return sum;
}

static double table(const engine_oscillator *o, double x)
{
    const double place = (x - o->first) / o->spacing;
    int32_t j = 0;
    if (place > 0.0) j = place < (double)(o->knots - 2) ? (int32_t)place : o->knots - 2;
    return o->slope[j] + (place - (double)j) * (o->slope[j + 1] - o->slope[j]);
}

/* dz/dy on a branch; |z| = sigma z continues smoothly beyond the corner, so that a trial step may look over it. */
static double slope(const engine_oscillator *o, double z, branch b)
{
    if (o->law == ENGINE_NO_LAW) return 0.0;
    if (o->law == ENGINE_SLOPES) return table(o, b.s * z);
    const double size = b.sigma * z;
    const double power = o->nu == 1.0 ? size : size > 0.0 ? pow(size, o->nu) : 0.0;
    return o->alpha - o->beta * (o->gamma * b.s * b.sigma + o->delta) * power;
}

typedef struct problem {
    const engine_oscillator *o;
    const double *stop; /* at y0 */
    double y0;
    branch b;
    stretch f;
} problem;

static double acceleration(const problem *p, motion x, double t)
{
    const engine_oscillator *o = p->o;
    const double spring = x.y * (o->stiffness + o->cubic * x.y * x.y);
    const double held = x.z + stop_force(o, p->stop, x.y - p->y0, x.y);
    return (force_at(&p->f, t) - o->damping * x.v - spring - held) / o->mass;
}

static motion rate(const problem *p, motion x, double t)
{
    const motion r = {x.v, acceleration(p, x, t), x.v * slope(p->o, x.z, p->b)};
    return r;
}

static motion ahead(motion x, double h, motion r)
{
    const motion next = {x.y + h * r.y, x.v + h * r.v, x.z + h * r.z};
    return next;
}

/* Classical Runge-Kutta from t over a part of the stretch (both in units of its length h). */
static motion advance(const problem *p, motion x, double t, double part)
{
    const double h = part * p->f.h;
    const motion a = rate(p, x, t);
    const motion b = rate(p, ahead(x, 0.5 * h, a), t + 0.5 * part);
    const motion c = rate(p, ahead(x, 0.5 * h, b), t + 0.5 * part);
    const motion d = rate(p, ahead(x, h, c), t + part);
    const motion sum = {a.y + 2.0 * (b.y + c.y) + d.y, a.v + 2.0 * (b.v + c.v) + d.v, a.z + 2.0 * (b.z + c.z) + d.z};
    return ahead(x, h / 6.0, sum);
}

static double sign_or(double x, double otherwise)
{
    if (x != 0.0) return x > 0.0 ? 1.0 : -1.0;
    return otherwise < 0.0 ? -1.0 : 1.0;
}

/* The branch that the motion is on, or moves to from a corner. */
static branch branch_of(const problem *p, motion x, double t)
{
    branch b = {1.0, 1.0};
    b.s = sign_or(x.v, x.v == 0.0 ? acceleration(p, x, t) : 0.0);
    b.sigma = sign_or(x.z, b.s * p->o->alpha);
    return b;
}

/* Distance to the corner that is looked at, positive on the present branch. */
static double distance(const problem *p, motion x, int of_z) { return of_z ? p->b.sigma * x.z : p->b.s * x.v; }

/* Part of the step at which a distance, positive before and negative after it, vanishes: false position, with the
 * weight of an end that stays halved (Illinois). */
static double corner(const problem *p, motion x, double t, double part, motion end, int of_z)
{
    double low = 0.0, high = part, at_low = distance(p, x, of_z), at_high = distance(p, end, of_z);
    const double small = 1e-13 * (at_low - at_high);
    for (int k = 0; k < HALVINGS && high - low > 1e-14; ++k) {
        const double middle = low + (high - low) * (at_low / (at_low - at_high));
        const double value = distance(p, advance(p, x, t, middle), of_z);
        if (fabs(value) <= small) return middle;
        if (value > 0.0) {
            low = middle;
            at_low = value;
            at_high *= 0.5;
        } else {
            high = middle;
            at_high = value;
            at_low *= 0.5;
        }
    }
    return high;
}

static int crosses(const problem *p, motion x, motion end, int of_z)
{
    return distance(p, x, of_z) > 0.0 && distance(p, end, of_z) < 0.0;
}

static void keep_stops(const engine_oscillator *o, double *stop, double moved)
{
    for (int32_t i = 0; i < o->stops; ++i) stop[i] = clip(stop[i] + moved, o->threshold[i]);
}

/* One stretch, piece by piece from corner to corner. */
static motion cross(problem *p, double *stop, motion x)
{
    double t = 0.0;
    for (int events = 0; t < 1.0; ++events) {
        double part = 1.0 - t;
        p->y0 = x.y;
        p->b = branch_of(p, x, t);
        motion end = advance(p, x, t, part);
        if (p->o->law != ENGINE_NO_LAW || p->o->stops > 0) {
            for (int of_z = 0; of_z <= (p->o->law == ENGINE_BOUC_WEN) && events < EVENTS; ++of_z) {
                if (!crosses(p, x, end, of_z)) continue;
                part = corner(p, x, t, part, end, of_z);
                end = advance(p, x, t, part);
                if (of_z) end.z = 0.0;
                else end.v = 0.0;
            }
        }
        keep_stops(p->o, stop, end.y - x.y);
        x = end;
        t = part >= 1.0 - t ? 1.0 : t + part;
    }
    return x;
}

static void put(const engine_oscillator *o, motion x, const double *stop, double *row)
{
    row[0] = x.y;
    row[1] = x.v;
    row[2] = x.z + stop_force(o, stop, 0.0, x.y);
}

int64_t engine_oscillate(const engine_oscillator *o, int64_t samples, int32_t steps, double dt, const double *force,
                         double *state, double *rows)
{
    motion x = {state[0], state[1], state[2]};
    double *stop = state + 3;
    problem p = {o, stop, x.y, {1.0, 1.0}, {dt / (double)steps, 0.0, 0.0, 0.0}};
    for (int64_t k = 0, left = ENGINE_BETWEEN; k < samples && !engine_stops(&left, 200 * (1 + (int64_t)o->stops) * steps); ++k) {
        if (!(isfinite(x.y) && isfinite(x.v) && isfinite(x.z))) return k;
        put(o, x, stop, rows + 3 * k);
        if (k + 1 == samples) break;
        for (int32_t j = 0; j < steps; ++j) {
            const double *u = force + 2 * (k * (int64_t)steps + j);
            p.f.start = u[0];
            p.f.curve_a = -3.0 * u[0] + 4.0 * u[1] - u[2];
            p.f.curve_b = 2.0 * u[0] - 4.0 * u[1] + 2.0 * u[2];
            x = cross(&p, stop, x);
        }
    }
    state[0] = x.y;
    state[1] = x.v;
    state[2] = x.z;
    return samples;
}
