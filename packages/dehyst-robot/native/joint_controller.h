// One joint controller of the core with everything that it points to: no formula.
#ifndef DEHYST_NATIVE_JOINT_CONTROLLER_H
#define DEHYST_NATIVE_JOINT_CONTROLLER_H

#include <cstring>
#include <memory>

#include "arrays.h"
#include "dehyst.h"
#include "direct_parameters.h"
#include "model_parameters.h"
#include "reviewed.h"

// Values of a dict of parameters, each taken once; a missing, foreign or non-finite one is refused by name.
class Fields {
  public:
    explicit Fields(const nb::dict &values, const char *what) : values_(values), what_(what) {}

    nb::object object(const char *name)
    {
        if (!values_.contains(name)) throw std::invalid_argument(std::string(what_) + " lacks '" + name + "'");
        ++taken_;
        return nb::borrow<nb::object>(values_[name]);
    }

    double real(const char *name) { return finite(name, object(name)); }

    int32_t count(const char *name)
    {
        const double value = real(name);
        if (value != static_cast<double>(static_cast<int32_t>(value < 0 ? 0 : value > 2147483647.0 ? 2147483647.0 : value)))
            throw std::invalid_argument(std::string("'") + name + "' is not a number of samples");
        return static_cast<int32_t>(value);
    }

    // Coefficients, lowest power first; the others are zero.
    void list(const char *name, double *out, std::size_t most) { fill(name, object(name), out, most); }

    static void fill(const char *name, const nb::object &values, double *out, std::size_t most)
    {
        std::size_t n = 0;
        for (nb::handle value : values) {
            if (n == most) throw std::invalid_argument(std::string("too many coefficients in '") + name + "'");
            out[n++] = finite(name, nb::borrow<nb::object>(value));
        }
        if (n == 0) throw std::invalid_argument(std::string("no coefficients in '") + name + "'");
    }

    void done() const
    {
        if (taken_ != values_.size()) throw std::invalid_argument(std::string(what_) + " has unknown entries");
    }

  private:
    static double finite(const char *name, const nb::object &value)
    {
        const double x = nb::cast<double>(value);
        if (!dehyst_accept(x)) throw std::invalid_argument(std::string("'") + name + "' is not a finite number");
        return x;
    }

    const nb::dict &values_;
    const char *what_;
    std::size_t taken_ = 0;
};

inline dehyst_pneumatics pneumatics_of(const nb::dict &values)
{
    Fields from(values, "pneumatics");
    dehyst_pneumatics air{};
    air.supply = from.real("supply");
    air.ambient = from.real("ambient");
    air.gas_temperature = from.real("gas_temperature");
    air.polytropic = from.real("polytropic");
    air.reference_density = from.real("reference_density");
    air.conductance = from.real("conductance");
    air.ratio = from.real("ratio");
    air.dead_band = from.real("dead_band");
    from.done();
    return air;
}

inline dehyst_joint joint_of(const nb::dict &values)
{
    Fields from(values, "joint");
    dehyst_joint joint{};
    joint.period = from.real("period");
    joint.inertia = from.real("inertia");
    joint.pole = from.real("pole");
    joint.observer_pole = from.real("observer_pole");
    joint.pressure_gain = from.real("pressure_gain");
    joint.windup_gain = from.real("windup_gain");
    from.list("a", joint.a, DEHYST_DEGREE);
    from.list("b", joint.b, DEHYST_DEGREE);
    from.list("c", joint.c, DEHYST_DEGREE);
    std::size_t muscle = 0;
    for (nb::handle volume : from.object("volume")) {
        require(muscle < 2, "'volume' has more than two chambers");
        Fields::fill("volume", nb::borrow<nb::object>(volume), joint.volume[muscle++], 4);
    }
    require(muscle == 2, "'volume' needs two chambers");
    joint.angle_low = from.real("angle_low");
    joint.angle_high = from.real("angle_high");
    joint.pressure_low = from.real("pressure_low");
    joint.pressure_high = from.real("pressure_high");
    joint.ramp = from.real("ramp");
    joint.shear = from.real("shear");
    joint.compensator_unit = from.real("compensator_unit");
    joint.pneumatics = pneumatics_of(nb::cast<nb::dict>(from.object("pneumatics")));
    joint.angle_jump = from.real("angle_jump");
    joint.pressure_jump = from.real("pressure_jump");
    joint.angle_step = from.real("angle_step");
    joint.frozen_samples = from.count("frozen_samples");
    joint.hold_samples = from.count("hold_samples");
    from.done();
    return joint;
}

// A compensator: parameters, start states and the states in use.
struct Compensator {
    ModelParameters model;
    std::vector<double> start, z;

    explicit Compensator(const nb::tuple &t)
        : model(array(t, 0), array(t, 1), number(t, 2), number(t, 3), array(t, 4), array(t, 5), array(t, 6),
                array(t, 7)),
          start(copy(array(t, 8))), z(start)
    {
        require(start.size() == model.threshold.size(), "state and thresholds differ in length");
    }

  private:
    static In array(const nb::tuple &t, std::size_t i)
    {
        require(t.size() == 9, "a compensator is a tuple of 9 parameters");
        return nb::cast<In>(t[i]);
    }
    static double number(const nb::tuple &t, std::size_t i) { return nb::cast<double>(t[i]); }
};

// A direct inverse in a joint: two memories, one along the desired and one along the measured angle.
struct TwoMemories {
    Direct direct;
    std::vector<double> seen;

    explicit TwoMemories(const nb::tuple &parameters) : direct(parameters), seen(direct.memory) {}
};

inline void learn_by(const nb::dict &values, dehyst_joint &joint)
{
    Fields from(values, "adaptation");
    dehyst_adaptation &a = joint.adaptation;
    a.rate = from.real("rate");
    a.memory = from.real("memory");
    a.noise = from.real("noise");
    a.dead_zone = from.real("dead_zone");
    a.most_error = from.real("most_error");
    a.contact_ratio = from.real("contact_ratio");
    a.first_error = from.real("first_error");
    a.patience = from.real("patience");
    a.rest = from.real("rest");
    a.settling = from.real("settling");
    a.lowest = from.real("lowest");
    a.highest = from.real("highest");
    a.offset_limit = from.real("offset_limit");
    a.unit = from.real("unit");
    joint.most_acceleration = from.real("most_acceleration");
    joint.least_speed = from.real("least_speed");
    joint.disturbance_pole = from.real("disturbance_pole");
    from.done();
    require(a.noise >= 1e-6 && a.lowest >= 0 && a.lowest <= 1 && a.highest >= 1 && a.offset_limit >= 0 && a.rate >= 0,
            "an adaptation that could diverge");
}

// A reviewed controller in the place of the core's.
struct Reviewed {
    reviewed_law law{};
    reviewed_state state{};

    explicit Reviewed(const nb::dict &values)
    {
        Fields from(values, "law");
        law.kind = from.count("kind");
        switch (law.kind) {
        case REVIEWED_PID:
            law.pid.proportional = from.real("proportional");
            law.pid.integral = from.real("integral");
            law.pid.derivative = from.real("derivative");
            law.pid.slope = from.real("slope");
            law.pid.filter = from.real("filter");
            break;
        case REVIEWED_VO_MINH:
            law.vo_minh.proportional = from.real("proportional");
            law.vo_minh.integral = from.real("integral");
            break;
        case REVIEWED_SLIDING_MODE:
            law.sliding_mode.surface = from.real("surface");
            law.sliding_mode.gain = from.real("gain");
            law.sliding_mode.boundary = from.real("boundary");
            law.sliding_mode.observer_pole = from.real("observer_pole");
            require(law.sliding_mode.boundary > 0, "a sliding mode without a boundary layer");
            break;
        case REVIEWED_ONE_VALVE:
            law.one_valve.pole = from.real("pole");
            law.one_valve.pressure_gain = from.real("pressure_gain");
            law.one_valve.mean_time = from.real("mean_time");
            break;
        default:
            throw std::invalid_argument("no such law");
        }
        from.done();
    }
};

struct JointController {
    dehyst_joint joint;
    dehyst_joint_state state{};
    std::unique_ptr<Compensator> compensator;
    std::unique_ptr<TwoMemories> direct;
    std::unique_ptr<Reviewed> reviewed; // null: the core's controller

    JointController(const nb::dict &parameters, const nb::object &compensator_tuple, const nb::object &direct_tuple,
                    const nb::dict &adaptation, const nb::object &law)
        : joint(joint_of(parameters)), compensator(made(compensator_tuple)),
          direct(direct_tuple.is_none() ? nullptr : std::make_unique<TwoMemories>(nb::cast<nb::tuple>(direct_tuple))),
          reviewed(law.is_none() ? nullptr : std::make_unique<Reviewed>(nb::cast<nb::dict>(law)))
    {
        learn_by(adaptation, joint);
        joint.direct = direct ? &direct->direct.view : nullptr;
        state.wanted.memory = direct ? direct->direct.memory.data() : nullptr;
        state.seen.memory = direct ? direct->seen.data() : nullptr;
        joint.compensator = compensator ? &compensator->model.view : nullptr;
        state.compensator.z = compensator ? compensator->z.data() : nullptr;
        reset(0.0, joint.pressure_low, joint.pressure_low);
    }
    JointController(const JointController &) = delete;
    JointController &operator=(const JointController &) = delete;

    void reset(double angle, double p_1, double p_2)
    {
        const dehyst_joint_sensors sensors = {angle, {p_1, p_2}};
        dehyst_joint_reset(&joint, &state, &sensors, compensator ? compensator->start.data() : nullptr);
        if (reviewed) reviewed_reset(&state, &reviewed->state);
    }

    void advance(const dehyst_joint_sensors &sensors, const dehyst_joint_reference &reference, uint32_t switches,
                 dehyst_joint_output &out)
    {
        if (reviewed) {
            reviewed_step(&joint, &reviewed->law, &state, &reviewed->state, &sensors, &reference, switches, &out);
        } else {
            dehyst_joint_step(&joint, &state, &sensors, &reference, switches, &out);
        }
    }

    void exchange(const nb::object &compensator_tuple, double unit, double shear)
    {
        require(dehyst_accept(unit) && dehyst_accept(shear), "unit and shear must be finite numbers");
        std::unique_ptr<Compensator> next = made(compensator_tuple);
        dehyst_joint_exchange(&joint, &state, next ? &next->model.view : nullptr, unit, shear,
                              next ? next->z.data() : nullptr, next ? next->start.data() : nullptr);
        compensator = std::move(next);
    }

    // Start again with or without knowledge of the past, whatever the parameters say.
    void restart(double angle, double p_1, double p_2, bool known)
    {
        if (!direct) return reset(angle, p_1, p_2);
        const int32_t said = direct->direct.view.past;
        direct->direct.view.past = known ? DEHYST_PAST_REST : DEHYST_PAST_UNKNOWN;
        reset(angle, p_1, p_2);
        direct->direct.view.past = said;
    }

    // Image of the state, the core's words low byte first, with a fingerprint of all parameters.
    nb::bytes save() const
    {
        require(!reviewed, "images hold the state of the paper's controller only; a reviewed one is started anew");
        std::vector<uint32_t> image(words());
        (void)dehyst_joint_save(&joint, &state, fingerprint(), image.data(), static_cast<int32_t>(image.size()));
        std::string bytes;
        for (uint32_t word : image)
            for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(word >> 8 * i & 0xff));
        return nb::bytes(bytes.data(), bytes.size());
    }

    // The answer of the core: DEHYST_IMAGE_GOOD, or nothing has changed.
    int32_t restore(const nb::bytes &saved)
    {
        if (reviewed) return DEHYST_IMAGE_FOREIGN;
        if (saved.size() != 4 * words()) return DEHYST_IMAGE_SIZE;
        std::vector<uint32_t> image(words());
        for (std::size_t i = 0; i < saved.size(); ++i)
            image[i / 4] |= static_cast<uint32_t>(static_cast<unsigned char>(saved.c_str()[i])) << 8 * (i % 4);
        return dehyst_joint_restore(&joint, &state, fingerprint(), image.data(), static_cast<int32_t>(image.size()));
    }

  private:
    static constexpr uint64_t kSeed = UINT64_C(0xcbf29ce484222325);

    static std::unique_ptr<Compensator> made(const nb::object &t)
    {
        return t.is_none() ? nullptr : std::make_unique<Compensator>(nb::cast<nb::tuple>(t));
    }

    static uint64_t sum(uint64_t hash, const void *data, std::size_t size)  // FNV-1a
    {
        const unsigned char *bytes = static_cast<const unsigned char *>(data);
        for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
        return hash;
    }
    static uint64_t sum(uint64_t hash, const std::vector<double> &values)
    {
        const uint64_t size = values.size();
        return sum(sum(hash, &size, sizeof size), values.data(), values.size() * sizeof(double));
    }

    std::size_t words() const
    {
        const int32_t operators = compensator ? compensator->model.view.hysteresis.n : 0;
        const int32_t memory = direct ? static_cast<int32_t>(direct->seen.size()) : -1;
        return static_cast<std::size_t>(DEHYST_JOINT_WORDS(operators, memory));
    }

    uint32_t fingerprint() const
    {
        dehyst_joint plain;
        std::memcpy(&plain, &joint, sizeof plain);
        plain.compensator = nullptr;
        plain.direct = nullptr;
        uint64_t hash = sum(kSeed, &plain, sizeof plain);
        if (compensator) {
            const ModelParameters &model = compensator->model;
            for (const auto *values : {&model.threshold, &model.weight, &model.before_u, &model.before_v,
                                       &model.after_u, &model.after_v})
                hash = sum(hash, *values);
            const double rest[2] = {model.view.hysteresis.center, model.view.hysteresis.offset};
            hash = sum(hash, rest, sizeof rest);
        }
        if (direct) {
            const Direct &from = direct->direct;
            for (const auto *values : {&from.radius, &from.length, &from.gain, &from.weight}) hash = sum(hash, *values);
            hash = sum(hash, from.group.data(), from.group.size() * sizeof(int32_t));
            dehyst_direct view;
            std::memcpy(&view, &from.view, sizeof view);
            view.radius = view.length = view.gain = view.weight = nullptr;
            view.group = nullptr;
            hash = sum(hash, &view, sizeof view);
        }
        return static_cast<uint32_t>(hash ^ (hash >> 32));
    }
};

#endif
