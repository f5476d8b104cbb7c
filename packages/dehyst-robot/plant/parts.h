/* What the files of the plant share among themselves. */
#ifndef PLANT_PARTS_H
#define PLANT_PARTS_H

#include <math.h>

#include "plant.h"

/* 1 - exp(-z), z >= 0, without the cancellation and the cost of exp where z is small. */
static inline double plant_settled(double z)
{
    if (z > 0.02) return 1.0 - exp(-z);
    return z * (1.0 - z * (1.0 / 2) * (1.0 - z * (1.0 / 3) * (1.0 - z * (1.0 / 4) * (1.0 - z * (1.0 / 5) *
           (1.0 - z * (1.0 / 6) * (1.0 - z * (1.0 / 7)))))));
}

static inline double plant_clip(double x, double low, double high) { return x < low ? low : (x > high ? high : x); }

/* splitmix64, Steele, Lea, Flood, OOPSLA 2014. */
static inline uint64_t plant_draw(uint64_t *random)
{
    uint64_t z = (*random += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Sum of twelve uniform 16-bit numbers, which has variance 2^32 - 1: normal to 2 % of the density within 3 sigma. */
static inline double plant_normal(uint64_t *random)
{
    int64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
        const uint64_t bits = plant_draw(random);
        sum += (int64_t)((bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48));
    }
    return (double)(2 * sum - 12 * 65535) * (0.5 / 65536.0);
}

static inline void plant_ring_fill(plant_ring *ring, double value)
{
    for (int i = 0; i < PLANT_RING; ++i) ring->value[i] = value;
}

/* Puts a value in and returns the one of `age` periods ago, linear in between. */
static inline double plant_delayed(plant_ring *ring, double value, double age)
{
    const double reached = age > 0.0 ? plant_clip(age, 0.0, PLANT_RING - 2) : 0.0; /* NaN: none */
    const uint32_t whole = (uint32_t)reached, at = ++ring->at;
    ring->value[at % PLANT_RING] = value;
    const double young = ring->value[(at - whole) % PLANT_RING], old = ring->value[(at - whole - 1) % PLANT_RING];
    return young + (reached - whole) * (old - young);
}

/* Age of a value with a delay and a drawn share of a jitter, [periods]; nothing is ever older than what came before. */
static inline double plant_age(double delay, double jitter, uint64_t *random, double last, double period)
{
    const double drawn = jitter > 0.0 ? jitter * (double)(plant_draw(random) >> 11) * 0x1p-53 : 0.0;
    const double age = (delay + drawn) / period;
    return age < last + 1.0 ? age : last + 1.0;
}

/* Forces of the mechanisms; `up`, `down`: force at which everything slips in contraction and elongation, [N]. */
double plant_maxwell_slip(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up,
                          double down);
double plant_dahl(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up, double down);
double plant_braid(const plant_hysteresis *hysteresis, plant_muscle_state *state, double input, double up, double down);
double plant_lugre(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up, double down,
                   double period);
double plant_pinched(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up,
                     double down);
double plant_ageing(const plant_hysteresis *hysteresis, plant_muscle_state *state, double change, double up, double down,
                    double period);
/* Normalised output -1..1 after moving to an input. */
double plant_preisach(const plant_hysteresis *hysteresis, plant_muscle_state *state, double input);

/* Creep force opposing contraction after kappa and p moved linearly by these changes, [N]. */
void plant_creep_prepare(const plant_muscle *muscle, plant_cache *cache, double period);
double plant_creep_step(const plant_muscle *muscle, plant_muscle_state *state, double kappa_change, double p_change);

/* Sensors that have been at rest, and their noise from `seed`. */
void plant_sensors_reset(const plant_joint *joint, plant_joint_state *state, double q, const double p[2], uint64_t seed);

/* Exact step of the spool over time h. */
void plant_spool_prepare(const plant_valve *valve, plant_cache *cache, double h);

/* A chamber over a period with the contraction moving linearly to kappa; and both of a joint, to the same bits. */
void plant_chamber_step(const plant_unit *unit, plant_muscle_state *state, double kappa, double command, double period);
void plant_chambers_step(const plant_unit unit[2], plant_muscle_state state[2], const double kappa[2],
                         const double command[2], double period);

/* Share of full opening of the way to the supply; the way to ambient opens with -s. Monotone in s. */
static inline double plant_opening(const plant_valve *valve, double s)
{
    const double closed = 1.0 / (1.0 - valve->dead_band);
    if (s > valve->dead_band) return valve->leak + (1.0 - valve->leak) * (s - valve->dead_band) * closed;
    if (s < -valve->dead_band) return valve->leak * (1.0 + (s + valve->dead_band) * closed);
    return valve->leak;
}

#define PLANT_LAMINAR 0.999 /* above this pressure ratio the flow is linear in it: ISO 6358 has an infinite slope at 1 */

/* Flow function psi of ISO 6358 for the ratio of downstream to upstream pressure; `slope` is 1/(1 - b). */
static inline double plant_flow_function(double ratio, double b, double slope)
{
    if (ratio <= b) return 1.0;
    const double inner = ratio < PLANT_LAMINAR ? ratio : PLANT_LAMINAR;
    const double x = (inner - b) * slope;
    const double psi = sqrt(1.0 - x * x);
    return ratio < PLANT_LAMINAR ? psi : psi * (1.0 - ratio) * (1.0 / (1.0 - PLANT_LAMINAR));
}

/* p_u psi(p_d/p_u) from pressure `from` to pressure `to`, negative if it goes back, [Pa]. */
static inline double plant_flow_between(double from, double to, double b, double slope)
{
    return from >= to ? from * plant_flow_function(to / from, b, slope) : -to * plant_flow_function(from / to, b, slope);
}

#endif
