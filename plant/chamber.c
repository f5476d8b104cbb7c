/* Air in the muscles: dp/dt = n/V (R T mdot - p dV/dt), by Heun's method, the spool exact in between. */
#include "parts.h"

typedef struct chamber {
    double pressure, spool, spool_speed, mass;
    double in, out;        /* openings of both ways */
    double kappa, advance; /* contraction and its change in a substep */
    double volume, slope;
    double full, ratio, ratio_slope; /* C rho_0, b, 1/(1 - b) */
} chamber;

static inline double flow(const chamber *c, const plant_air *air, double p)
{
    return c->full * (c->in * plant_flow_between(air->supply, p, c->ratio, c->ratio_slope) -
                      c->out * plant_flow_between(p, air->ambient, c->ratio, c->ratio_slope));
}

static inline void open_ways(chamber *c, const plant_valve *valve)
{
    c->in = plant_opening(valve, c->spool);
    c->out = plant_opening(valve, -c->spool);
}

static inline void move_spool(chamber *c, const double *m, double u)
{
    const double gap = c->spool - u, speed = c->spool_speed;
    c->spool = u + m[0] * gap + m[1] * speed;
    c->spool_speed = m[2] * gap + m[3] * speed;
    if (c->spool > 1.0 || c->spool < -1.0) { /* end stops */
        c->spool = c->spool > 1.0 ? 1.0 : -1.0;
        c->spool_speed = 0.0;
    }
}

/* n h/V (R T mdot - p dV/dt): change of pressure in a substep at the present rate. */
static inline double rise(const chamber *c, const plant_air *air, double mdot, double p, double h)
{
    return air->polytropic / c->volume * (air->gas_constant * air->temperature * mdot * h - p * c->slope * c->advance);
}

static inline void substep(chamber *c, const plant_unit *unit, const double *spool, double u, double h)
{
    const plant_air *air = unit->air;
    const double p = c->pressure;
    const double mdot = flow(c, air, p);
    const double first = rise(c, air, mdot, p, h);
    move_spool(c, spool, u);
    open_ways(c, unit->valve);
    c->kappa += c->advance;
    c->volume = plant_muscle_volume(unit->muscle, c->kappa, &c->slope);
    const double ahead = p + first > 0.0 ? p + first : 0.0;
    const double mdot_ahead = flow(c, air, ahead);
    const double next = p + 0.5 * (first + rise(c, air, mdot_ahead, ahead, h));
    c->pressure = next > 0.0 ? next : 0.0;
    c->mass += 0.5 * h * (mdot + mdot_ahead);
}

static chamber enter(const plant_unit *unit, const plant_muscle_state *state, double kappa)
{
    const plant_valve *valve = unit->valve;
    chamber c;
    c.pressure = state->pressure;
    c.spool = state->spool;
    c.spool_speed = state->spool_speed;
    c.mass = state->mass;
    c.kappa = state->contraction;
    c.advance = (kappa - state->contraction) / unit->substeps;
    c.volume = plant_muscle_volume(unit->muscle, c.kappa, &c.slope);
    c.full = valve->conductance * unit->air->reference_density;
    c.ratio = valve->ratio;
    c.ratio_slope = 1.0 / (1.0 - valve->ratio);
    open_ways(&c, valve);
    return c;
}

static void leave(const chamber *c, plant_muscle_state *state)
{
    state->pressure = c->pressure;
    state->spool = c->spool;
    state->spool_speed = c->spool_speed;
    state->mass = c->mass;
}

void plant_chamber_step(const plant_unit *unit, plant_muscle_state *state, double kappa, double command, double period)
{
    chamber c = enter(unit, state, kappa);
    for (int32_t k = 0; k < unit->substeps; ++k)
        substep(&c, unit, state->cache.spool, command, period / unit->substeps);
    leave(&c, state);
}

void plant_chambers_step(const plant_unit unit[2], plant_muscle_state state[2], const double kappa[2],
                         const double command[2], double period)
{
    const double h = period / unit->substeps;
    chamber first = enter(&unit[0], &state[0], kappa[0]);
    chamber second = enter(&unit[1], &state[1], kappa[1]);
    for (int32_t k = 0; k < unit->substeps; ++k) { /* side by side: neither waits for the other's roots */
        substep(&first, &unit[0], state[0].cache.spool, command[0], h);
        substep(&second, &unit[1], state[1].cache.spool, command[1], h);
    }
    leave(&first, &state[0]);
    leave(&second, &state[1]);
}
