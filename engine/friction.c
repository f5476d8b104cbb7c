#include "friction.h"

#include <math.h>
#include <string.h>

#include "rising.h"

enum { MOST_STEPS = 200000 };
static const double fine = 0.02; /* step times steepness of Runge-Kutta: errors below 1e-10 of the state */

static double psi_of(const double *element, double dx, double z, double x)
{
    return element[2 + (dx > 0.0 ? 4 : 0) + (z > 0.0 ? 2 : 0) + (x > 0.0 ? 1 : 0)];
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

/* Any power: Runge-Kutta along dx, ended where z passes zero. */
static double stepped(double slope, double n, double psi, double z, double dx, double *gone)
{
    double left = dx;
    for (int k = 0; k < MOST_STEPS && left != 0.0; ++k) {
        const double steep = n * fabs(psi) * power_of(fmax(fabs(z), 1e-300), n - 1.0) +
                             n * fabs(psi) * power_of(slope * fabs(left) < fabs(z) ? slope * fabs(left) : fabs(z), n - 1.0);
        const double first = rate_of(slope, n, psi, z);
        /* The state may grow within the step: its change is limited too. */
        const double most = fmin(fine / fmax(steep, 1e-12), fine * fmax(fabs(z), 1.0) / fmax(fabs(first), 1e-12));
        const double h = fabs(left) <= most ? left : copysign(most, left);
        const double second = rate_of(slope, n, psi, z + 0.5 * h * first);
        const double third = rate_of(slope, n, psi, z + 0.5 * h * second);
        const double fourth = rate_of(slope, n, psi, z + h * third);
        const double next = z + h * (first + 2.0 * second + 2.0 * third + fourth) / 6.0;
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
static double one_side(const double *element, double x0, double z, double x1)
{
    const double x = 0.5 * (x0 + x1), whole = x1 - x0, n = element[1];
    double left = whole;
    for (int part = 0; part < 4 && left != 0.0; ++part) {
        const double psi = psi_of(element, whole, z == 0.0 ? whole : z, x); /* from zero it moves along with x */
        double gone = left;
        z = n == 1.0 ? exact(element[0], psi, z, left, &gone) : stepped(element[0], n, psi, z, left, &gone);
        left = gone == left ? 0.0 : left - gone;
    }
    return z;
}

double engine_friction_step(const double *element, double x0, double z, double x1)
{
    if (x0 == x1) {
        return z;
    }
    if ((x0 < 0.0 && x1 > 0.0) || (x0 > 0.0 && x1 < 0.0)) {
        z = one_side(element, x0, z, 0.0);
        x0 = 0.0;
    }
    return one_side(element, x0, z, x1);
}

void engine_bank_run(const engine_bank *bank, int64_t samples, const double *x, double *memory, double *y, double *z)
{
    double before = memory[0];
    for (int64_t t = 0; t < samples; ++t) {
        double sum = engine_curve(bank->coefficients, bank->curve, x[t]);
        for (int32_t i = 0; i < bank->elements; ++i) {
            double *state = &memory[1 + i];
            *state = engine_friction_step(bank->element + ENGINE_FRICTION * i, before, *state, x[t]);
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
    const double *memory;
    double y;
} wish;

static double miss(const void *context, double x)
{
    const wish *w = (const wish *)context;
    double sum = engine_curve(w->bank->coefficients, w->bank->curve, x);
    for (int32_t i = 0; i < w->bank->elements; ++i) {
        sum += w->bank->weight[i] *
               engine_friction_step(w->bank->element + ENGINE_FRICTION * i, w->memory[0], w->memory[1 + i], x);
    }
    return sum - w->y;
}

void engine_bank_invert(const engine_bank *bank, int64_t samples, const double *y, double farthest, double *memory,
                        double *x)
{
    double reach = 0.1;
    for (int64_t t = 0; t < samples; ++t) {
        const wish w = {bank, memory, y[t]};
        const double found = engine_root(miss, &w, memory[0], reach, farthest);
        for (int32_t i = 0; i < bank->elements; ++i) {
            memory[1 + i] =
                engine_friction_step(bank->element + ENGINE_FRICTION * i, memory[0], memory[1 + i], found);
        }
        reach = fmin(fmax(fabs(found - memory[0]), 1e-9), 1.0);
        memory[0] = x[t] = found;
    }
}
