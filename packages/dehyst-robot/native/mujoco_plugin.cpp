// One muscle of the plant as an actuator plugin of MuJoCo: its XML, its state, its step; no formula.
//
// No header of MuJoCo is included and nothing of it is linked, so that one build serves every version. Its functions
// come as addresses; where a version keeps its arrays is measured by Python, which knows their names and addresses
// (dehyst_robot.mujoco_plugin). What is taken from its header is the order of mjpPlugin's members, the same from 3.3.6
// to 4.0.0. The whole muscle lies in MuJoCo's plugin_state, parameters included: copies, saved states and resets are
// then MuJoCo's own, and there is nothing to free.
#include <nanobind/stl/vector.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <locale>
#include <sstream>
#include <type_traits>

#include "robot.h"
#include "plant.h"

namespace {

struct Plugin { // mjpPlugin
    const char *name;
    int nattribute;
    const char *const *attributes;
    int capabilityflags; // 1: actuator
    int needstage;
    int (*nstate)(const void *, int);
    int (*nsensordata)(const void *, int, int);
    int (*init)(const void *, void *, int);
    void (*destroy)(void *, int);
    void (*copy)(void *, const void *, const void *, int);
    void (*reset)(const void *, double *, void *, int);
    void (*compute)(const void *, void *, int, int);
    void (*advance)(const void *, void *, int);
    void *others[64]; // visualize, act_dot, sdf_..., and whatever a later version adds: none
};

struct { // of MuJoCo, see `bind_mujoco_plugin`
    int (*register_plugin)(const void *);
    const char *(*config)(const void *, int, const char *);
    void (*error)(const char *, ...);
} api;

// Offsets in mjData, then in mjModel, [byte]; -1: this version has no such member.
struct {
    int64_t state, ctrl, length, velocity, force, timestep, actuators, plugin, length0, stateadr, ctrladr, outadr;
} place;
bool placed = false;
constexpr std::size_t kPlaces = sizeof place / sizeof(int64_t);

template <class T> T &member(const void *base, int64_t offset)
{
    return *reinterpret_cast<T *>(const_cast<char *>(static_cast<const char *>(base)) + offset);
}

int index(const void *m, int64_t offset, int i) { return offset < 0 ? i : member<int *>(m, offset)[i]; }

struct Muscle { // in plugin_state; what a user may want to read comes first
    double pressure, contraction, force, friction; // gauge [Pa], 1, [N], [N]
    double start, contraction0;                    // gauge pressure at the start, contraction at qpos0
    plant_air air;
    plant_muscle muscle;
    plant_valve valve;
    plant_muscle_state state;
    int32_t substeps, imposed;
    int64_t begun, mark; // begun 0: after a reset, it starts where the first step finds it
};
constexpr int64_t kMark = 0x6d7573636c653139; // in a state that `reset` wrote
static_assert(std::is_trivially_copyable<Muscle>::value && sizeof(Muscle) % sizeof(double) == 0, "kept as doubles");

struct Key {
    const char *name;
    double low, high;
    const char *meaning;
};
constexpr double kLeast_any = -1e12, kLeast_not_negative = 0;
#define LIFE_KEY(name, range) {#name, kLeast_##range, 1e12, "what a real muscle adds, in SI, see packages/dehyst-robot/plant/life.h"},
constexpr Key kKeys[] = {
    {"muscle", 0, 0, "the type, one of dmsp40, dmsp20"},
    {"valve", 0, 0, "the type, one of mpye, mpye_small"},
    {"drive", 0, 0, "what ctrl is, one of valve, pressure"},
    {"mechanism", 0, 0, "of hysteresis, one of maxwell-slip, preisach, dahl, braid, lugre, pinched, ageing, none"},
    {"map", 0, 0, "static force, one of tool, exponential, geometric"},
    {"coefficient", -1e9, 1e9, "coefficients of the map, 6 or, geometric, 8, in SI"},
    {"contraction", -0.3, 0.5, "contraction where the model is in qpos0, share of the length"},
    {"pressure", 0, 2e6, "gauge pressure at the start [Pa]"},
    {"length", 1e-3, 10, "of the muscle without pressure and load [m]"},
    {"volume", -1e3, 1e3, "volume over length by powers of the contraction, 4 numbers [m^2]"},
    {"dead_volume", 0, 1, "of hose and fitting [m^3]"},
    {"viscous_force", 0, 1e6, "[N]"},
    {"viscous_speed", 1e-9, 1e3, "[m/s]"},
    {"creep_time", 1e-6, 1e9, "time constants, at most 8 [s]"},
    {"creep_force", -1e9, 1e9, "as many as creep_time [N]"},
    {"creep_pressure", -1e3, 1e3, "as many as creep_time [N/Pa]"},
    {"size", 0, 1e6, "force of the hysteresis when all slips, at reference_pressure [N]"},
    {"constant_share", 0, 1e3, "of the hysteresis at no pressure"},
    {"pressure_share", 0, 1e3, "of the hysteresis that grows with pressure"},
    {"reference_pressure", 1, 1e8, "[Pa]"},
    {"asymmetry", -0.5, 0.5, "of contraction over elongation"},
    {"conductance", 1e-15, 1, "of the valve, C of ISO 6358 [m^3/(s Pa)]"},
    {"ratio", 0, 0.9, "critical pressure ratio b of ISO 6358"},
    {"dead_band", 0, 0.9, "share of the valve's stroke"},
    {"leak", 0, 1, "share of full opening"},
    {"frequency", 1e-3, 1e6, "of the spool [rad/s]"},
    {"damping", 1e-3, 1e3, "of the spool"},
    {"supply", 1e3, 1e8, "absolute [Pa]"},
    {"ambient", 1e3, 1e8, "absolute, not above supply [Pa]"},
    {"temperature", 1, 2e3, "[K]"},
    {"gas_constant", 1, 1e5, "[J/(kg K)]"},
    {"polytropic", 1, 2, "exponent"},
    {"reference_density", 1e-3, 1e3, "[kg/m^3]"},
    {"substeps", 1, 1000, "of valve and chamber in a timestep"},
    PLANT_HYSTERESIS_LIFE(LIFE_KEY) PLANT_MUSCLE_LIFE(LIFE_KEY) PLANT_VALVE_LIFE(LIFE_KEY)
};
constexpr int kCount = sizeof kKeys / sizeof *kKeys;

constexpr struct {
    const char *type, *key, *value; // type "": every muscle
} kNamed[] = {
#include "named_muscles.inc"
};

// Attributes of one instance. The first fault is kept as text; error() of MuJoCo does not return.
class Config {
  public:
    Config(const void *m, int instance) : m_(m), instance_(instance) { fault[0] = '\0'; }

    int choice(const char *name, std::initializer_list<const char *> words)
    {
        int i = 0;
        for (const char *word : words) {
            if (std::strcmp(word, text(name)) == 0) return i;
            ++i;
        }
        refuse(name);
        return 0;
    }

    double number(const char *name)
    {
        double x = 0;
        if (list(name, &x, 1) != 1) refuse(name);
        return x;
    }

    double life(const char *name) // 0 if nothing is said
    {
        double x = 0;
        return list(name, &x, 1) == 1 ? x : 0;
    }

    int list(const char *name, double *to, int most)
    {
        const Key &key = *find(name);
        std::istringstream text_of(text(name));
        text_of.imbue(std::locale::classic()); // a window's toolkit may have set another one
        int n = 0;
        bool good = true;
        for (double x; good && text_of >> x; ++n) {
            good = n < most && x >= key.low && x <= key.high;
            if (good) to[n] = x;
        }
        if (!good || !text_of.eof()) refuse(name);
        return n;
    }

    void refuse(const char *name)
    {
        if (fault[0] != '\0') return;
        const Key &key = *find(name);
        char range[80] = "";
        if (key.high > key.low) std::snprintf(range, sizeof range, ", from %g to %g", key.low, key.high);
        std::snprintf(fault, sizeof fault,
                      "dehyst.muscle: %s=\"%.60s\" is not usable: it is %s%s. Correct it, or leave the line out for %.200s", name, text(name), key.meaning, range, standard(name));
    }

    char fault[600];

  private:
    static const Key *find(const char *name)
    {
        for (const Key &key : kKeys)
            if (std::strcmp(key.name, name) == 0) return &key;
        return kKeys;
    }

    const char *standard(const char *name) const
    {
        const bool type = std::strcmp(name, "muscle") == 0 || std::strcmp(name, "valve") == 0;
        for (const auto &row : kNamed) {
            if (std::strcmp(row.key, name) != 0) continue;
            if (*row.type == '\0') return row.value;
            if (!type && (std::strcmp(row.type, text("muscle")) == 0 || std::strcmp(row.type, text("valve")) == 0))
                return row.value;
        }
        return "";
    }

    const char *text(const char *name) const
    {
        const char *given = api.config(m_, instance_, name);
        return given != nullptr && *given != '\0' ? given : standard(name);
    }

    const void *m_;
    int instance_;
};

// Slip strains and shares of the mechanisms of dehyst_robot.arm._mechanisms, with their standard arguments.
void spread(plant_hysteresis &h)
{
    const double scale = 0.0125;
    double sum = 0, ahead = 0;
    if (h.kind == PLANT_MAXWELL_SLIP || h.kind == PLANT_BRAID || h.kind == PLANT_AGEING) {
        h.n = 40;
        for (int i = 0; i < h.n; ++i) h.strain[i] = 2e-4 * std::pow(4e-2 / 2e-4, i / (h.n - 1.0));
        for (int i = h.n - 1; i >= 0; --i) {
            const double x = h.strain[i], before = i > 0 ? h.strain[i - 1] : 0;
            const double slope = (std::expm1(-before / scale) - std::expm1(-x / scale)) / (x - before);
            h.share[i] = x * (slope - ahead);
            ahead = slope;
            sum += h.share[i];
        }
        for (int i = 0; i < h.n; ++i) h.share[i] /= sum;
    } else if (h.kind == PLANT_DAHL) {
        h.n = 3;
        for (int i = 0; i < h.n; ++i) {
            h.strain[i] = scale * std::pow(2.5, i - 1);
            h.share[i] = i == 1 ? 0.5 : 0.25;
        }
    } else if (h.kind == PLANT_PREISACH) {
        h.n = 1;
        h.strain[0] = 12.8 * scale;
        h.share[0] = 1;
    } else if (h.kind == PLANT_LUGRE || h.kind == PLANT_PINCHED) {
        h.n = 1;
        h.strain[0] = scale;
        h.share[0] = 1;
    }
    if (h.kind == PLANT_PREISACH || h.kind == PLANT_BRAID) h.center = 0.11;
}

void read(Config &c, Muscle &u)
{
    std::memset(&u, 0, sizeof u);
    plant_muscle &p = u.muscle;
    (void)c.choice("muscle", {"dmsp40", "dmsp20"});
    (void)c.choice("valve", {"mpye", "mpye_small"});
    u.imposed = c.choice("drive", {"valve", "pressure"});
    u.start = c.number("pressure");
    u.contraction0 = c.number("contraction");
    u.substeps = static_cast<int32_t>(c.number("substeps"));
    u.air = {c.number("supply"),     c.number("ambient"),           c.number("temperature"), c.number("gas_constant"),
             c.number("polytropic"), c.number("reference_density"), 0,                       0};
    if (u.air.ambient > u.air.supply) c.refuse("ambient");
    plant_valve &v = u.valve;
    v.conductance = c.number("conductance");
    v.ratio = c.number("ratio");
    v.dead_band = c.number("dead_band");
    v.leak = c.number("leak");
    v.frequency = c.number("frequency");
    v.damping = c.number("damping");
    p.map = c.choice("map", {"tool", "exponential", "geometric"});
    if (c.list("coefficient", p.coefficient, 8) != (p.map == PLANT_MAP_GEOMETRIC ? 8 : 6)) c.refuse("coefficient");
    p.length = c.number("length");
    if (c.list("volume", p.volume, 4) != 4) c.refuse("volume");
    p.dead_volume = c.number("dead_volume");
    p.viscous_force = c.number("viscous_force");
    p.viscous_speed = c.number("viscous_speed");
    p.creep_branches = c.list("creep_time", p.creep_time, PLANT_CREEP);
    if (c.list("creep_force", p.creep_force, PLANT_CREEP) != p.creep_branches) c.refuse("creep_force");
    if (c.list("creep_pressure", p.creep_pressure, PLANT_CREEP) != p.creep_branches) c.refuse("creep_pressure");
    plant_hysteresis &h = p.hysteresis;
    h.kind = c.choice("mechanism", {"none", "maxwell-slip", "preisach", "dahl", "braid", "lugre", "pinched", "ageing"});
    h.size = c.number("size");
    h.constant_share = c.number("constant_share");
    h.pressure_share = c.number("pressure_share");
    h.reference_pressure = c.number("reference_pressure");
    h.asymmetry = c.number("asymmetry");
    spread(h);
#define READ_HYSTERESIS(name, range) h.name = c.life(#name);
#define READ_MUSCLE(name, range) p.name = c.life(#name);
#define READ_VALVE(name, range) v.name = c.life(#name);
    PLANT_HYSTERESIS_LIFE(READ_HYSTERESIS)
    PLANT_MUSCLE_LIFE(READ_MUSCLE)
    PLANT_VALVE_LIFE(READ_VALVE)
    if (v.tube_length > 0 && !(v.tube_diameter > 0)) c.refuse("tube_diameter");
    u.mark = kMark;
}

// A state may come from anywhere, mj_setState takes every number: no index and no count in it may lead astray.
bool intact(const Muscle &u)
{
    const plant_hysteresis &h = u.muscle.hysteresis;
    return u.mark == kMark && u.muscle.map <= PLANT_MAP_GEOMETRIC && u.substeps >= 1 && u.substeps <= 1000 && h.kind >= PLANT_NONE && h.kind < PLANT_FOREIGN &&
           h.n >= 0 && h.n <= PLANT_ELEMENTS && u.muscle.creep_branches >= 0 && u.muscle.creep_branches <= PLANT_CREEP &&
           u.state.turns >= 0 && u.state.turns <= PLANT_TURNS && u.state.turns != 1;
}

int actuator_of(const void *m, int instance)
{
    for (int i = 0; placed && i < member<int32_t>(m, place.actuators); ++i)
        if (member<int *>(m, place.plugin)[i] == instance) return i;
    return -1;
}

int nstate(const void *m, int instance)
{
    static thread_local char fault[600]; // error() may jump over destructors
    {
        Config config(m, instance);
        Muscle unused;
        read(config, unused);
        int users = 0;
        for (int i = 0; placed && i < member<int32_t>(m, place.actuators); ++i)
            users += member<int *>(m, place.plugin)[i] == instance;
        if (users > 1)
            std::snprintf(config.fault, sizeof config.fault,
                          "dehyst.muscle: %d actuators share one instance, but a muscle remembers its own way. Write the "
                          "config into each actuator, without instance=", users);
        std::memcpy(fault, config.fault, sizeof fault);
    }
    if (fault[0] != '\0') api.error("%s", fault);
    return sizeof(Muscle) / sizeof(double);
}

int init(const void *, void *, int) { return 0; }

void reset(const void *m, double *state, void *, int instance)
{
    Muscle &u = *reinterpret_cast<Muscle *>(state);
    Config config(m, instance);
    read(config, u);
    u.pressure = u.start;
    u.contraction = u.contraction0;
}

Muscle *muscle(const void *m, const void *d, int instance)
{
    auto *u = reinterpret_cast<Muscle *>(member<double *>(d, place.state) + member<int *>(m, place.stateadr)[instance]);
    if (!intact(*u))
        api.error("dehyst.muscle: the state of plugin instance %d is none of a muscle; it was overwritten, or saved with "
                  "another model or another dehyst. Call mj_resetData, and set the state of this model", instance);
    return u;
}

void step(const void *m, const void *d, Muscle &u, int actuator)
{
    const int in = index(m, place.ctrladr, actuator), out = index(m, place.outadr, actuator);
    const plant_unit unit = {&u.air, &u.muscle, &u.valve, u.substeps};
    const double period = member<double>(m, place.timestep), ctrl = member<double *>(d, place.ctrl)[in];
    const double speed = -member<double *>(d, place.velocity)[out];
    const double shorter = member<double *>(m, place.length0)[out] - member<double *>(d, place.length)[out];
    const double now = u.contraction0 + shorter / u.muscle.length, kappa = now + speed * period / u.muscle.length;
    if (!u.begun) plant_muscle_reset(&unit, &u.state, now, u.start);
    u.begun = 1;
    const bool good = std::fabs(kappa) < 1e6 && std::fabs(speed) < 1e6; // else it stays where it is
    const double to = good ? kappa : u.state.contraction, v = good ? speed : 0.0;
    if (u.imposed) {
        const double most = u.air.supply - u.air.ambient, p = ctrl > most ? most : ctrl < 0.0 ? 0.0 : ctrl;
        u.force = plant_muscle_impose(&unit, &u.state, to, v, p, period);
    } else
        u.force = plant_muscle_step(&unit, &u.state, to, v, ctrl, period);
    u.pressure = u.state.pressure - u.air.ambient;
    u.contraction = u.state.contraction;
    u.friction = u.state.friction;
}

// The force of a step is the one at its end, as on the plant; the state itself moves in `advance` only, so that
// mj_forward may be called as often as one likes.
void compute(const void *m, void *d, int instance, int)
{
    const int actuator = actuator_of(m, instance);
    if (actuator < 0) return;
    Muscle u = *muscle(m, d, instance);
    step(m, d, u, actuator);
    member<double *>(d, place.force)[index(m, place.outadr, actuator)] = -u.force;
}

void advance(const void *m, void *d, int instance)
{
    const int actuator = actuator_of(m, instance);
    if (actuator >= 0) step(m, d, *muscle(m, d, instance), actuator);
}

void register_plugin(std::uintptr_t registering, std::uintptr_t config, std::uintptr_t error)
{
    static const char *names[kCount];
    for (int i = 0; i < kCount; ++i) names[i] = kKeys[i].name;
    api.register_plugin = reinterpret_cast<int (*)(const void *)>(registering);
    api.config = reinterpret_cast<const char *(*)(const void *, int, const char *)>(config);
    api.error = reinterpret_cast<void (*)(const char *, ...)>(error);
    static const Plugin plugin = {"dehyst.muscle", kCount, names, 1, 0, nstate, nullptr, init, nullptr, nullptr,
                                  reset, compute, advance, {}};
    (void)api.register_plugin(&plugin);
}

void places(const std::vector<int64_t> &offsets)
{
    require(offsets.size() == kPlaces, "one offset a member is needed");
    std::memcpy(&place, offsets.data(), sizeof place);
    placed = true;
}

}  // namespace

void bind_mujoco_plugin(nb::module_ &m)
{
    m.def("mujoco_register", &register_plugin, "register"_a, "config"_a, "error"_a,
          "Register the actuator plugin dehyst.muscle through the addresses of MuJoCo's mjp_registerPlugin, "
          "mj_getPluginConfig and mju_error. It does nothing until `mujoco_places`.");
    m.def("mujoco_places", &places, "offsets"_a, "Tell the plugin where MuJoCo keeps what it reads and writes.");
}
