/* Air in the muscles: dp/dt = n/V (R T mdot - p dV/dt), by Heun's method, the spool exact in between. */
#include "parts.h"

typedef struct chamber {
    double pressure, spool, spool_speed, mass;
    double in, out;        /* openings of both ways */
    double kappa, advance; /* contraction and its change in a substep */
    double volume, slope;
    double full, ratio, ratio_slope; /* C rho_0, b, 1/(1 - b) */
    double supply, drawn;            /* absolute pressure; sum of what came from it, in units of `full` */
    double sent, arriving;           /* sum of what went into the tube; what comes out of it */
    int tube;
} chamber;

/* Mass flow into the muscle: the valve's, or what comes out of the tube while the valve's goes into it. */
static inline double flow(chamber *c, const plant_air *air, double p)
{
    const double in = c->in * plant_flow_between(c->supply, p, c->ratio, c->ratio_slope);
    const double mdot = c->full * (in - c->out * plant_flow_between(p, air->ambient, c->ratio, c->ratio_slope));
    c->drawn += in;
    c->sent += mdot;
    return c->tube ? c->arriving : mdot;
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
    c.supply = state->supply;
    c.drawn = c.sent = 0.0;
    c.arriving = state->arriving;
    c.tube = valve->tube_length > 0.0;
    open_ways(&c, valve);
    return c;
}

/* Share of a flow that friction in the tube lets through: exp(-R_t R T L/(2 p c)), Richer, Hurmuzlu 2000. */
static double let_through(const plant_valve *valve, const plant_air *air, double mdot, double p, double sound)
{
    const double mu = 1.82e-5, d = valve->tube_diameter; /* viscosity of air, [Pa s] */
    const double reynolds = 4.0 * fabs(mdot) / (3.141592653589793 * d * mu), root = sqrt(reynolds);
    const double turbulent = 0.158 * root * sqrt(root); /* Re^(3/4); the larger of both frictions acts */
    const double resistance = mu / (d * d) * (turbulent > 32.0 ? turbulent : 32.0);
    return exp(-resistance * air->gas_constant * air->temperature * valve->tube_length / (2.0 * p * sound));
}

static void leave(const chamber *c, const plant_unit *unit, plant_muscle_state *state, double period)
{
    const plant_valve *valve = unit->valve;
    double through = 1.0;
    if (c->tube) {
        const double sound = sqrt(1.4 * unit->air->gas_constant * unit->air->temperature);
        const double mean = c->sent / (2 * unit->substeps), p = c->pressure > 1e4 ? c->pressure : 1e4;
        through = let_through(valve, unit->air, mean, p, sound);
        state->arriving = plant_delayed(&state->tube, through * mean, valve->tube_length / sound / period - 1.0);
    }
    state->drawn = through * c->full * c->drawn * period / (2 * unit->substeps);
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
    leave(&c, unit, state, period);
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
    leave(&first, &unit[0], &state[0], period);
    leave(&second, &unit[1], &state[1], period);
}

double plant_supply_step(const plant_air *air, double supply, double drawn, double period, int failing)
{
    if (!(air->supply_volume > 0.0)) return supply;
    const double rate = air->polytropic * air->gas_constant * air->temperature / air->supply_volume; /* [Pa/kg] */
    const double full = failing ? 0.0 : air->supply_conductance * air->reference_density;
    const double settled = air->supply - (full > 0.0 ? drawn / period / full : 0.0); /* exact for a constant draw */
    const double next = full > 0.0 ? supply + plant_settled(full * rate * period) * (settled - supply)
                                   : supply - rate * drawn;
    return next > 0.0 ? next : 0.0;
}
