// Parameters of the plant: dicts with the field names of plant.h, read strictly. A wrong key or number is named.
#include <cmath>
#include <set>

#include "plant_joint.h"

namespace {

[[noreturn]] void fail(const std::string &message) { throw std::invalid_argument(message); }

constexpr std::size_t kMostPoints = std::size_t{1} << 23; // of a table of forces

enum class Range { any, positive, not_negative };

// Reads one dict; `finish` complains about keys that nobody asked for.
class Reader {
  public:
    Reader(nb::handle source, std::string where, bool optional = false)
        : where_(std::move(where)), optional_(optional)
    {
        if (!nb::isinstance<nb::dict>(source)) fail(where_ + " must be a dict");
        source_ = nb::borrow<nb::dict>(source);
    }

    bool has(const char *key)
    {
        known_.insert(key);
        return source_.contains(key);
    }

    nb::object get(const char *key)
    {
        if (!has(key)) fail("missing key: " + name(key));
        return source_[key];
    }

    double number(const char *key, Range range = Range::any)
    {
        if (optional_ && !has(key)) return 0;
        return checked(get(key), name(key), range);
    }

    double life(const char *key, Range range) { return has(key) ? number(key, range) : 0; } // rows of life.h: may be missing

    int32_t integer(const char *key, int32_t low, int32_t high)
    {
        const double value = number(key);
        if (value != std::floor(value) || value < low || value > high)
            fail(name(key) + " must be an integer from " + std::to_string(low) + " to " + std::to_string(high) +
                 ", not " + std::to_string(value));
        return static_cast<int32_t>(value);
    }

    // Fills `to` from a sequence of at most `most` numbers and returns how many there were.
    int32_t list(const char *key, double *to, std::size_t most, Range range = Range::any)
    {
        if (optional_ && !has(key)) return 0;
        const nb::object value = get(key);
        if (!PySequence_Check(value.ptr())) fail(name(key) + " must be a sequence of numbers");
        const std::size_t size = nb::len(value);
        if (size > most)
            fail(name(key) + " holds " + std::to_string(size) + " numbers, at most " + std::to_string(most) + " fit");
        for (std::size_t i = 0; i < size; ++i)
            to[i] = checked(value[i], name(key) + "[" + std::to_string(i) + "]", range);
        return static_cast<int32_t>(size);
    }

    // Copies a matrix of finite numbers, two rows and columns or more.
    void points(const char *key, std::vector<double> &to, int32_t &rows, int32_t &columns)
    {
        using Points = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
        Points given;
        if (!nb::try_cast(get(key), given)) fail(name(key) + " must be a matrix of numbers, float64 row by row");
        if (given.shape(0) < 2 || given.shape(1) < 2 || given.size() > kMostPoints)
            fail(name(key) + " must have 2 rows and columns or more, and at most " + std::to_string(kMostPoints) +
                 " numbers");
        to.assign(given.data(), given.data() + given.size());
        for (const double value : to)
            if (!std::isfinite(value)) fail(name(key) + " must be finite");
        rows = static_cast<int32_t>(given.shape(0));
        columns = static_cast<int32_t>(given.shape(1));
    }

    void finish()
    {
        for (auto item : source_) {
            const std::string key = nb::str(item.first).c_str();
            if (known_.count(key) == 0) fail("unknown key: " + name(key.c_str()));
        }
    }

    std::string name(const char *key) const { return where_.empty() ? key : where_ + "." + key; }

  private:
    static double checked(nb::handle value, const std::string &name, Range range)
    {
        const double number = PyFloat_AsDouble(value.ptr());
        if (number == -1.0 && PyErr_Occurred() != nullptr) {
            PyErr_Clear();
            fail(name + " must be a number");
        }
        if (!std::isfinite(number)) fail(name + " must be finite");
        if (range == Range::positive && !(number > 0)) fail(name + " must be positive, not " + std::to_string(number));
        if (range == Range::not_negative && !(number >= 0))
            fail(name + " must not be negative, as " + std::to_string(number) + " is");
        return number;
    }

    nb::dict source_;
    std::string where_;
    bool optional_; // a missing number is 0, a missing list empty
    std::set<std::string> known_;
};

#define LIFE(name, range) life.name = reader.life(#name, Range::range);

void read_kind(Reader &reader, const std::string &name, plant_kind &kind)
{
#define READ(quality) kind.quality = reader.number((name + "_" #quality).c_str(), Range::not_negative);
    PLANT_QUALITIES(READ)
#undef READ
}

constexpr int32_t kCoefficients[] = {6, 6, 8, 2, 6}; // of the maps, in the order of their enum

void same_length(Reader &reader, const char *count, int32_t have, const char *list, int32_t expected)
{
    if (have != expected)
        fail(reader.name(list) + " holds " + std::to_string(have) + " numbers, but " + reader.name(count) + " has " +
             std::to_string(expected));
}

void pair(const char *key, nb::object (&both)[2], Reader &reader)
{
    const nb::object value = reader.get(key);
    if (!PySequence_Check(value.ptr()) || nb::len(value) != 2 || nb::isinstance<nb::dict>(value))
        fail(std::string(key) + " must be a list of two dicts, one for each muscle");
    for (std::size_t m = 0; m < 2; ++m) both[m] = value[m];
}

std::string at(const char *key, int m) { return std::string(key) + "[" + std::to_string(m) + "]"; }

}  // namespace

plant_hysteresis plant_read_hysteresis(const nb::dict &parameters, const std::string &where)
{
    plant_hysteresis h{};
    h.kind = Reader(parameters, where).integer("kind", PLANT_NONE, PLANT_FOREIGN);
    const bool simple = h.kind == PLANT_NONE || h.kind == PLANT_FOREIGN;
    Reader reader(parameters, where, simple);
    (void)reader.integer("kind", PLANT_NONE, PLANT_FOREIGN);
    h.size = reader.number("size", Range::not_negative);
    h.constant_share = reader.number("constant_share", Range::not_negative);
    h.pressure_share = reader.number("pressure_share", Range::not_negative);
    h.reference_pressure = simple ? 1 : reader.number("reference_pressure", Range::positive);
    if (simple) (void)reader.number("reference_pressure");
    h.asymmetry = reader.number("asymmetry");
    if (!(std::fabs(h.asymmetry) <= 0.5)) // beyond it, y + a y^2 is not monotone any more
        fail(reader.name("asymmetry") + " must lie in -0.5 .. 0.5, not " + std::to_string(h.asymmetry));
    if (reader.has("center") || h.kind == PLANT_PREISACH || h.kind == PLANT_BRAID) h.center = reader.number("center");
    h.n = reader.list("strain", h.strain, PLANT_ELEMENTS, simple ? Range::any : Range::positive);
    same_length(reader, "strain", reader.list("share", h.share, PLANT_ELEMENTS, simple ? Range::any : Range::positive),
                "share", h.n);
    if (reader.has("n")) same_length(reader, "n", h.n, "strain", reader.integer("n", 0, PLANT_ELEMENTS));
    plant_hysteresis &life = h;
    PLANT_HYSTERESIS_LIFE(LIFE)
    reader.finish();
    if (simple) return h;
    if (h.n == 0) fail(reader.name("strain") + " is empty");
    double sum = 0;
    for (int32_t i = 0; i < h.n; ++i) {
        sum += h.share[i];
        if (i > 0 && h.strain[i] <= h.strain[i - 1]) fail(reader.name("strain") + " must increase");
    }
    if (std::fabs(sum - 1) > 1e-9) fail(reader.name("share") + " must sum to 1, not to " + std::to_string(sum));
    return h;
}

plant_muscle plant_read_muscle(const nb::dict &parameters, const std::string &where, std::vector<double> &table)
{
    Reader reader(parameters, where);
    plant_muscle m{};
    m.map = reader.integer("map", PLANT_MAP_TOOL, PLANT_MAP_TABLE);
    const int32_t given = reader.list("coefficient", m.coefficient, 8);
    if (given != kCoefficients[m.map])
        fail(reader.name("coefficient") + " holds " + std::to_string(given) + " numbers, map " +
             std::to_string(m.map) + " takes " + std::to_string(kCoefficients[m.map]));
    if (m.map == PLANT_MAP_TOOL && !(m.coefficient[4] > 0 && m.coefficient[5] > 0))
        fail(reader.name("coefficient") + ": km and p_ref (the last two) must be positive");
    if (m.map == PLANT_MAP_TABLE) {
        if (!(m.coefficient[3] > 0 && m.coefficient[5] > 0))
            fail(reader.name("coefficient") + ": the steps of pressure and contraction must be positive");
        reader.points("table", table, m.rows, m.columns);
        m.table = table.data();
    }
    m.length = reader.number("length", Range::positive);
    if (reader.list("volume", m.volume, 4) != 4) fail(reader.name("volume") + " must hold 4 numbers");
    m.dead_volume = reader.number("dead_volume", Range::not_negative);
    m.viscous_force = reader.number("viscous_force", Range::not_negative);
    m.viscous_speed = reader.number("viscous_speed", Range::positive);
    m.creep_branches = reader.list("creep_time", m.creep_time, PLANT_CREEP, Range::positive);
    same_length(reader, "creep_time", reader.list("creep_force", m.creep_force, PLANT_CREEP), "creep_force",
                m.creep_branches);
    same_length(reader, "creep_time", reader.list("creep_pressure", m.creep_pressure, PLANT_CREEP), "creep_pressure",
                m.creep_branches);
    if (reader.has("creep_branches"))
        same_length(reader, "creep_branches", m.creep_branches, "creep_time",
                    reader.integer("creep_branches", 0, PLANT_CREEP));
    const nb::object hysteresis = reader.get("hysteresis");
    if (!nb::isinstance<nb::dict>(hysteresis)) fail(reader.name("hysteresis") + " must be a dict");
    m.hysteresis = plant_read_hysteresis(nb::cast<nb::dict>(hysteresis), reader.name("hysteresis"));
    plant_muscle &life = m;
    PLANT_MUSCLE_LIFE(LIFE)
    reader.finish();
    return m;
}

plant_valve plant_read_valve(const nb::dict &parameters, const std::string &where)
{
    Reader reader(parameters, where);
    plant_valve v{};
    v.conductance = reader.number("conductance", Range::positive);
    v.ratio = reader.number("ratio", Range::not_negative);
    v.dead_band = reader.number("dead_band", Range::not_negative);
    v.leak = reader.number("leak", Range::not_negative);
    v.frequency = reader.number("frequency", Range::positive);
    v.damping = reader.number("damping", Range::positive);
    plant_valve &life = v;
    PLANT_VALVE_LIFE(LIFE)
    reader.finish();
    if (v.tube_length > 0 && v.tube_diameter == 0)
        fail(reader.name("tube_diameter") + " must be positive: the tube is " + std::to_string(v.tube_length) + " m long");
    if (v.ratio > 0.9) fail(reader.name("ratio") + " must lie in 0 .. 0.9: a critical pressure ratio is 0.2 to 0.53");
    if (v.dead_band > 0.9) fail(reader.name("dead_band") + " must lie in 0 .. 0.9 of the stroke");
    if (v.leak > 1) fail(reader.name("leak") + " must lie in 0 .. 1 of full opening");
    return v;
}

plant_air plant_read_air(const nb::dict &parameters, const std::string &where)
{
    Reader reader(parameters, where);
    plant_air a{};
    a.supply = reader.number("supply", Range::positive);
    a.ambient = reader.number("ambient", Range::positive);
    a.temperature = reader.number("temperature", Range::positive);
    a.gas_constant = reader.number("gas_constant", Range::positive);
    a.polytropic = reader.number("polytropic", Range::positive);
    a.reference_density = reader.number("reference_density", Range::positive);
    plant_air &life = a;
    PLANT_AIR_LIFE(LIFE)
    reader.finish();
    if (a.supply < a.ambient) fail(reader.name("supply") + " is absolute and must not be below the ambient pressure");
    return a;
}

plant_joint plant_read_joint(const nb::dict &parameters, std::vector<double> (&tables)[2])
{
    Reader reader(parameters, "");
    plant_joint joint{};
    const auto sub = [](nb::handle value, const std::string &where) {
        if (!nb::isinstance<nb::dict>(value)) fail(where + " must be a dict");
        return nb::borrow<nb::dict>(value);
    };
    joint.air = plant_read_air(sub(reader.get("air"), "air"), "air");
    nb::object muscle[2], valve[2];
    pair("muscle", muscle, reader);
    pair("valve", valve, reader);
    for (int m = 0; m < 2; ++m) {
        joint.muscle[m] = plant_read_muscle(sub(muscle[m], at("muscle", m)), at("muscle", m), tables[m]);
        joint.valve[m] = plant_read_valve(sub(valve[m], at("valve", m)), at("valve", m));
    }
    Reader sensors(sub(reader.get("sensors"), "sensors"), "sensors", true);
#define READ(kind) read_kind(sensors, #kind, joint.sensors.kind);
    PLANT_KINDS(READ)
#undef READ
    sensors.finish();
    const nb::object arms = reader.get("arm");
    if (!PySequence_Check(arms.ptr()) || nb::len(arms) != 2) fail("arm must hold two lists, one for each muscle");
    for (int m = 0; m < 2; ++m) {
        nb::dict one;
        one[at("arm", m).c_str()] = arms[m];
        if (Reader(one, "").list(at("arm", m).c_str(), joint.arm[m], PLANT_ARM) == 0) fail(at("arm", m) + " is empty");
    }
    if (!(joint.arm[0][0] > 0 && joint.arm[1][0] < 0))
        fail("arm[0] must begin with a positive number and arm[1] with a negative one: q > 0 shortens muscle 1");
    joint.contraction = reader.number("contraction");
    joint.substeps = reader.integer("substeps", 1, 1000);
    plant_joint &life = joint;
    PLANT_JOINT_LIFE(LIFE)
    reader.finish();
    if (joint.backlash > 0 && joint.backlash_damping == 0) fail("backlash_damping must be positive: the joint has play");
    return joint;
}
