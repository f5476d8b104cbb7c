#include "friction.h"
#include "patience.h"

#include <math.h>
#include <string.h>

#include "rising.h"

enum { MOST_STEPS = 200000 };
static const double fine = 0.2;     /* step times steepness of Runge-Kutta: errors below 1e-8 of the state */
static const double beyond = 1e9; /* steepness of a state that grows without limit */
static const double settled = 1e-5; /* dz/dx over its value at z = 0 near its limit: its square is left out */

static int phase_of(double dx, double z, double x)
{
    return (dx > 0.0 ? 4 : 0) + (z > 0.0 ? 2 : 0) + (x > 0.0 ? 1 : 0);
}

/* Power 1, one sign of z throughout except that it may end at zero: how far of dx was gone is left in *gone. */
static double exact(double slope, double psi, double z, double dx, double *gone)
{
    const double side = z > 0.0 ? 1.0 : (z < 0.0 ? -1.0 : (dx > 0.0 ? 1.0 : -1.0)), kappa = psi * side;
    const double grown = kappa == 0.0 ? dx : -expm1(-kappa * dx) / kappa;
    const double next = z + (slope - kappa * z) * grown;
    *gone = dx;
    if (z != 0.0 && next * side < 0.0) { /* it passes zero: there psi may change */
        const double reach = kappa == 0.0 ? -z / slope : log1p(-kappa * z / slope) / kappa;
        *gone = fabs(reach) < fabs(dx) ? reach : dx;
        return 0.0;
    }
    return next;
}

static double power_of(double r, double n)
{
    return n == 2.0 ? r * r : pow(r, n);
}

static double rate_of(double slope, double n, double psi, double z)
{
    return slope - psi * power_of(fabs(z), n);
}

/* Distance to z = 0: the integral of dz / (dz/dx), by five points of Gauss and Legendre. */
static double to_zero(double slope, double n, double psi, double z)
{
    static const double at[5] = {0.04691007703066802, 0.23076534494715845, 0.5, 0.7692346550528415, 0.9530899229693319};
    static const double weight[5] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                                     0.11846344252809454};
    double sum = 0.0;
    for (int k = 0; k < 5; ++k) {
        sum += weight[k] / rate_of(slope, n, psi, z * at[k]);
    }
    return -z * sum;
}

/* The first step away from z = 0, by its power series in q, to the third power of q. */
static double from_zero(double slope, double n, double psi, double h)
{
    const double q = psi * power_of(slope * fabs(h), n) / slope;
    const double a = 1.0 / (1.0 + n), b = n * a / (1.0 + 2.0 * n);
    const double c = (n * b + 0.5 * n * (n - 1.0) * a * a) / (1.0 + 3.0 * n);
    return slope * h * (1.0 - q * (a - q * (b - q * c)));
}

/* Mean of dz/dx over a step by the formula of fifth order of Dormand and Prince. */
static double mean_rate(double slope, double n, double psi, double z, double first, double h)
{
    const double k1 = first;
    const double k2 = rate_of(slope, n, psi, z + h * (k1 / 5.0));
    const double k3 = rate_of(slope, n, psi, z + h * (3.0 * k1 + 9.0 * k2) / 40.0);
    const double k4 = rate_of(slope, n, psi, z + h * (44.0 * k1 / 45.0 - 56.0 * k2 / 15.0 + 32.0 * k3 / 9.0));
    const double k5 = rate_of(slope, n, psi,
                              z + h * (19372.0 * k1 / 6561.0 - 25360.0 * k2 / 2187.0 + 64448.0 * k3 / 6561.0 -
                                       212.0 * k4 / 729.0));
    const double k6 = rate_of(slope, n, psi,
                              z + h * (9017.0 * k1 / 3168.0 - 355.0 * k2 / 33.0 + 46732.0 * k3 / 5247.0 +
                                       49.0 * k4 / 176.0 - 5103.0 * k5 / 18656.0));
    return 35.0 * k1 / 384.0 + 500.0 * k3 / 1113.0 + 125.0 * k4 / 192.0 - 2187.0 * k5 / 6784.0 + 11.0 * k6 / 84.0;
}

/* What every step from a state needs: |z|^n, of elements with n other than 1. */
typedef struct departure {
    double z, power;
} departure;

static departure from_state(const double *element, double z)
{
    const departure from = {z, element[1] == 1.0 ? fabs(z) : power_of(fabs(z), element[1])};
    return from;
}

/* Steepness of a phase at its limit, where dz/dx = 0; no state of the phase is steeper, but for where it stands. */
static double steepness_of(double slope, double n, double psi)
{
    return psi != 0.0 ? n * slope / pow(slope / fabs(psi), 1.0 / n) : 0.0;
}

/* Any power: Runge-Kutta along dx, ended where z passes zero. */
static double stepped(double slope, double n, double psi, double limit, const departure *from, double z, double dx,
                      double *gone)
{
    double left = dx;
    for (int k = 0; k < MOST_STEPS && left != 0.0; ++k) {
        const double first = z == from->z ? slope - psi * from->power : rate_of(slope, n, psi, z);
        const double steep = fmax(limit, z != 0.0 ? n * fabs(slope - first) / fabs(z) : 0.0);
        if (!(steep < beyond) || isinf(z)) { /* it hardens: the state has gone to infinity within this move */
            z = copysign(HUGE_VAL, z);
            break;
        }
        const double h = fabs(left) * steep <= fine ? left : copysign(fine / steep, left);
        if (fabs(first) <= settled * slope) { /* so near its limit that the way there is an exponential */
            z += first * -expm1(-limit * fabs(left)) / copysign(limit, left);
            break;
        }
        const double next = z == 0.0 ? from_zero(slope, n, psi, h) : z + h * mean_rate(slope, n, psi, z, first, h);
        if (z != 0.0 && next * z <= 0.0) {
            const double reach = to_zero(slope, n, psi, z);
            *gone = dx - left + (fabs(reach) < fabs(left) ? reach : left);
            return 0.0;
        }
        z = next;
        left = h == left ? 0.0 : left - h;
    }
    *gone = dx;
    return z;
}

/* From x0 to x1, between which x does not change its sign. */
static double one_side(const double *element, const double *limit, const departure *from, double x0, double z,
                       double x1)
{
    const double x = 0.5 * (x0 + x1), whole = x1 - x0, n = element[1];
    double left = whole;
    for (int part = 0; part < 4 && left != 0.0; ++part) {
        const int phase = phase_of(whole, z == 0.0 ? whole : z, x); /* from zero it moves along with x */
        const double psi = element[2 + phase];
        double gone = left;
        z = n == 1.0 ? exact(element[0], psi, z, left, &gone)
                     : stepped(element[0], n, psi, limit[phase], from, z, left, &gone);
        left = gone == left ? 0.0 : left - gone;
    }
    return z;
}

/* The state of an element at x1, for z at x0. */
static double moved(const double *element, const double *limit, const departure *from, double x0, double x1)
{
    double z = from->z;
    if (x0 == x1) {
        return z;
    }
    if ((x0 < 0.0 && x1 > 0.0) || (x0 > 0.0 && x1 < 0.0)) {
        z = one_side(element, limit, from, x0, z, 0.0);
        x0 = 0.0;
    }
    return one_side(element, limit, from, x0, z, x1);
}

void engine_friction_limits(int32_t elements, const double *element, double *limit)
{
    for (int32_t i = 0; i < elements; ++i, element += ENGINE_FRICTION) {
        for (int phase = 0; phase < ENGINE_PHASES; ++phase) {
            *limit++ = steepness_of(element[0], element[1], element[2 + phase]);
        }
    }
}

void engine_bank_run(const engine_bank *bank, int64_t samples, const double *x, double *memory, double *y, double *z)
{
    double before = memory[0];
    for (int64_t t = 0, left = ENGINE_BETWEEN; t < samples && !engine_stops(&left, 20 + 100 * bank->elements); ++t) {
        double sum = engine_curve(bank->coefficients, bank->curve, x[t]);
        for (int32_t i = 0; i < bank->elements; ++i) {
            const double *element = bank->element + ENGINE_FRICTION * i;
            double *state = &memory[1 + i];
            if (x[t] != before) {
                const departure from = from_state(element, *state);
                *state = moved(element, bank->limit + ENGINE_PHASES * i, &from, before, x[t]);
            }
            sum += bank->weight[i] * *state;
        }
        if (z) {
            memcpy(z + t * bank->elements, memory + 1, (size_t)bank->elements * sizeof(double));
        }
        y[t] = sum;
        before = x[t];
    }
    memory[0] = before;
}

typedef struct wish {
    const engine_bank *bank;
    const double *memory, *power; /* x and z before; |z|^n */
    double y;
} wish;

static double state_at(const wish *w, int32_t i, double x)
{
    const departure from = {w->memory[1 + i], w->power[i]};
    return moved(w->bank->element + ENGINE_FRICTION * i, w->bank->limit + ENGINE_PHASES * i, &from, w->memory[0], x);
}

static double miss(const void *context, double x)
{
    const wish *w = (const wish *)context;
    double sum = engine_curve(w->bank->coefficients, w->bank->curve, x);
    for (int32_t i = 0; i < w->bank->elements; ++i) {
        sum += w->bank->weight[i] * state_at(w, i, x);
    }
    return sum - w->y;
}

void engine_bank_invert(const engine_bank *bank, int64_t samples, const double *y, double farthest, double *memory,
                        double *power, double *x)
{
    for (int64_t t = 0, left = ENGINE_BETWEEN; t < samples && !engine_stops(&left, 500 + 2000 * bank->elements); ++t) {
        const wish w = {bank, memory, power, y[t]};
        for (int32_t i = 0; i < bank->elements; ++i) {
            power[i] = from_state(bank->element + ENGINE_FRICTION * i, memory[1 + i]).power;
        }
        const double found = engine_root(miss, &w, memory[0], farthest);
        for (int32_t i = 0; i < bank->elements; ++i) {
            memory[1 + i] = state_at(&w, i, found);
        }
        memory[0] = x[t] = found;
    }
}
