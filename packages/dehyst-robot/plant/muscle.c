/* Static force and volume of a pneumatic muscle. */
#include "parts.h"

/* The cell of `n` points that x, in steps from the first one, lies in; the first or last one where it is outside. */
static int32_t cell(double x, int32_t n)
{
    if (!(x > 0.0)) return 0;
    return x < n - 2 ? (int32_t)x : n - 2;
}

/* Linear between two neighbours in a row, and beyond them; no muscle pulls more where it is shorter than the table. */
static double along(const double *pair, double way)
{
    const double rise = pair[1] - pair[0];
    return pair[0] + (way > 1.0 && rise > 0.0 ? 1.0 : way) * rise;
}

static double looked_up(const plant_muscle *muscle, double p, double kappa)
{
    const double *a = muscle->coefficient;
    const double x = (p - a[2]) / a[3], y = (a[1] * kappa - a[4]) / a[5];
    const int32_t row = cell(x, muscle->rows), column = cell(y, muscle->columns);
    const double *low = muscle->table + (int64_t)row * muscle->columns + column;
    const double below = along(low, y - column), above = along(low + muscle->columns, y - column);
    return a[0] * (below + (x - row) * (above - below));
}

double plant_muscle_force(const plant_muscle *muscle, double p, double kappa)
{
    const double *a = muscle->coefficient;
    if (muscle->map == PLANT_MAP_TOOL) { /* Fm a0 a1 a3 km p_ref */
        const double k = kappa / a[4];
        return a[0] * (a[1] * (exp(-a[2] * k) - 1.0) + p / a[5] * exp(-a[3] * k * k));
    }
    if (muscle->map == PLANT_MAP_EXPONENTIAL) /* a1 a2 a3 a4 a5 a6 */
        return (a[0] * p + a[1]) * exp(a[2] * kappa) + a[3] * kappa * p + a[4] * p + a[5];
    if (muscle->map == PLANT_MAP_SPRING) return a[0] - a[1] * kappa; /* F0 K */
    if (muscle->map == PLANT_MAP_TABLE) return looked_up(muscle, p, kappa);
    const double stretch = 1.0 - a[4] * kappa; /* mu A0 a b ke c1 c2 c3 */
    return a[0] * a[1] * p * (a[2] * stretch * stretch - a[3]) + a[5] * kappa + a[6] * (1.0 - exp(-a[7] * kappa));
}

double plant_muscle_volume(const plant_muscle *muscle, double kappa, double *slope)
{
    const double *v = muscle->volume;
    if (slope) *slope = muscle->length * (v[1] + kappa * (2.0 * v[2] + kappa * 3.0 * v[3]));
    return muscle->length * (v[0] + kappa * (v[1] + kappa * (v[2] + kappa * v[3]))) + muscle->dead_volume;
}
