/* Proportional valve: spool of second order, flow by ISO 6358. */
#include "parts.h"

double plant_valve_flow(const plant_valve *valve, const plant_air *air, double s, double p)
{
    const double b = valve->ratio, slope = 1.0 / (1.0 - b);
    const double in = plant_opening(valve, s) * plant_flow_between(air->supply, p, b, slope);
    const double out = plant_opening(valve, -s) * plant_flow_between(p, air->ambient, b, slope);
    return valve->conductance * air->reference_density * (in - out);
}

/* Matrix exponential of s'' = w^2 (u - s) - 2 D w s' over h, for (s - u, s'). */
void plant_spool_prepare(const plant_valve *valve, plant_cache *cache, double h)
{
    const double w = valve->frequency, d = valve->damping * w;
    const double square = (w - d) * (w + d), rate = sqrt(fabs(square));
    double c = 1.0, s = h; /* cos(rate h) and sin(rate h)/rate, or cosh and sinh */
    if (rate * h > 1e-6) {
        c = square > 0 ? cos(rate * h) : cosh(rate * h);
        s = (square > 0 ? sin(rate * h) : sinh(rate * h)) / rate;
    }
    const double e = exp(-d * h);
    cache->spool[0] = e * (c + d * s);
    cache->spool[1] = e * s;
    cache->spool[2] = -e * w * w * s;
    cache->spool[3] = e * (c - d * s);
}
