// Binding of one simulated pneumatic joint: no formula.
#include <cmath>
#include <cstring>

#include "robot.h"
#include "no_pickle.h"
#include "plant_joint.h"
#include "stoppable.h"

using Pairs = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

double ForeignMechanism::force(void *context, double contraction, double pressure, double period)
{
    auto *self = static_cast<ForeignMechanism *>(context);
    if (self->fault) return 0;
    nb::gil_scoped_acquire gil;
    try {
        const double f = nb::cast<double>(self->object.attr("force")(contraction, pressure, period));
        if (!(std::fabs(f) <= 1e9))
            throw std::invalid_argument(
                "the attached mechanism returned a force of " + std::to_string(f) + " N at contraction " +
                std::to_string(contraction) + " and " + std::to_string(pressure) +
                " Pa; the plant would carry it on for ever. Let force() return a finite number below 1e9 N");
        return f;
    } catch (const nb::cast_error &) {
        self->fault = std::make_exception_ptr(
            nb::type_error("force() of the attached mechanism must return one number, the force in newton"));
    } catch (...) {
        self->fault = std::current_exception();
    }
    return 0;
}

PneumaticJoint::PneumaticJoint(const nb::dict &parameters, uint64_t seed) 
    : joint(plant_read_joint(parameters, tables))
{
    const double p[2] = {0, 0};
    plant_joint_reset(&joint, &state, 0, p, seed);
}

void PneumaticJoint::complete() const
{
    for (int m = 0; m < 2; ++m)
        require(joint.muscle[m].hysteresis.kind != PLANT_FOREIGN || joint.muscle[m].hysteresis.foreign != nullptr,
                "a muscle's hysteresis has kind 4 (foreign), but no mechanism is attached: call attach(muscle, "
                "mechanism) first");
}

void PneumaticJoint::reset(double q, double p1, double p2, uint64_t seed)
{
    complete();
    require(std::isfinite(q) && std::isfinite(p1) && std::isfinite(p2), "angle and pressures must be finite");
    require(p1 + joint.air.ambient >= 0 && p2 + joint.air.ambient >= 0, "an absolute pressure cannot be negative");
    const double p[2] = {p1, p2};
    plant_joint_reset(&joint, &state, q, p, seed);
    for (int m = 0; m < 2; ++m) {
        foreign[m].fault = nullptr;
        if (foreign[m].object.is_valid()) foreign[m].object.attr("reset")(state.muscle[m].contraction);
    }
}

void PneumaticJoint::attach(int muscle, nb::object mechanism)
{
    require(muscle == 0 || muscle == 1, "muscle must be 0 or 1");
    for (const char *method : {"reset", "force"})
        if (!nb::hasattr(mechanism, method))
            throw nb::type_error((std::string("a mechanism needs a method ") + method +
                                  "(...); see dehyst_robot.arm._mechanisms.Mechanism")
                                     .c_str());
    mechanism.attr("reset")(state.muscle[muscle].contraction);
    foreign[muscle].object = std::move(mechanism);
    foreign[muscle].fault = nullptr;
    plant_hysteresis &h = joint.muscle[muscle].hysteresis;
    h.kind = PLANT_FOREIGN;
    h.foreign = &ForeignMechanism::force;
    h.context = &foreign[muscle];
}

void PneumaticJoint::raise()
{
    complete();
    for (ForeignMechanism &f : foreign)
        if (f.fault) std::rethrow_exception(std::exchange(f.fault, nullptr));
}

namespace {

void usable_period(double period) { require(period > 0 && period < 10, "the period must be positive and below 10 s"); }

nb::tuple sense(PneumaticJoint &self, double q, double period)
{
    usable_period(period);
    plant_joint_sense(&self.joint, &self.state, q, period, &self.reading);
    return nb::make_tuple(self.reading.angle, self.reading.pressure_1, self.reading.pressure_2);
}

nb::dict sensed(const PneumaticJoint &self)
{
    nb::dict out;
#define TELL(name, kind, value) out[#name] = self.reading.name;
    PLANT_SENSORS(TELL)
#undef TELL
    return out;
}

double step(PneumaticJoint &self, double q, double qd, double u1, double u2, double period)
{
    usable_period(period);
    const double u[2] = {u1, u2};
    const double torque = plant_joint_step(&self.joint, &self.state, q, qd, u, period);
    self.breathe(period);
    self.raise();
    return torque;
}

double impose(PneumaticJoint &self, double q, double qd, double p1, double p2, double period)
{
    usable_period(period);
    const double p[2] = {p1, p2};
    const double torque = plant_joint_impose(&self.joint, &self.state, q, qd, p, period);
    self.raise();
    return torque;
}

using Step = double (*)(const plant_joint *, plant_joint_state *, double, double, const double *, double);

Matrix matrix(std::vector<double> &&values)
{
    const std::size_t rows = values.size() / 2;
    auto *kept = new std::vector<double>(std::move(values));
    nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    return Matrix(kept->data(), {rows, 2}, owner);
}

constexpr const char *kSignals[] = {"contraction", "pressure", "force", "friction", "spool", "mass"};
constexpr std::size_t kCount = sizeof kSignals / sizeof *kSignals;

void look(const plant_muscle_state &muscle, double (&values)[kCount])
{
    const double now[kCount] = {muscle.contraction, muscle.pressure, muscle.force,
                                muscle.friction,    muscle.spool,    muscle.mass};
    std::memcpy(values, now, sizeof now);
}

nb::dict run_with(PneumaticJoint &self, Step advance, const In &q, const In &qd, const Pairs &input, double period)
{
    usable_period(period);
    self.complete();
    const std::size_t samples = q.size();
    require(qd.size() == samples && input.shape(0) == samples && input.shape(1) == 2,
            "angle (T,), speed (T,) and input (T, 2) differ in length");
    std::vector<double> torque(samples), signal[kCount];
    for (auto &s : signal) s.resize(2 * samples);
    {
        nb::gil_scoped_release release;
        Patience patience(2000);
        for (std::size_t k = 0; k < samples && !patience.stops(); ++k) {
            torque[k] = advance(&self.joint, &self.state, q.data()[k], qd.data()[k], input.data() + 2 * k, period);
            self.breathe(period);
            for (std::size_t m = 0; m < 2; ++m) {
                double now[kCount];
                look(self.state.muscle[m], now);
                for (std::size_t i = 0; i < kCount; ++i) signal[i][2 * k + m] = now[i];
            }
            if (self.foreign[0].fault || self.foreign[1].fault) break;
        }
    }
    raise_if_stopped();
    self.raise();
    nb::dict out;
    out["torque"] = own(std::move(torque));
    for (std::size_t i = 0; i < kCount; ++i) out[kSignals[i]] = matrix(std::move(signal[i]));
    return out;
}

nb::dict run(PneumaticJoint &self, const In &q, const In &qd, const Pairs &u, double period)
{
    return run_with(self, &plant_joint_step, q, qd, u, period);
}

nb::dict run_imposed(PneumaticJoint &self, const In &q, const In &qd, const Pairs &p, double period)
{
    return run_with(self, &plant_joint_impose, q, qd, p, period);
}

nb::dict state(const PneumaticJoint &self)
{
    nb::dict out;
    double first[kCount], second[kCount];
    look(self.state.muscle[0], first);
    look(self.state.muscle[1], second);
    for (std::size_t i = 0; i < kCount; ++i) out[kSignals[i]] = nb::make_tuple(first[i], second[i]);
    const plant_muscle_state *m = self.state.muscle;
    out["stretch"] = nb::make_tuple(m[0].stretch, m[1].stretch);
    out["warmth"] = nb::make_tuple(m[0].warmth, m[1].warmth);
    out["loop"] = nb::make_tuple(m[0].loop, m[1].loop);
    return out;
}

// Tells joints apart by the bytes of their parameters, addresses left out (FNV-1a).
uint64_t fingerprint(const PneumaticJoint &self)
{
    plant_joint joint;
    std::memcpy(&joint, &self.joint, sizeof joint);
    for (plant_muscle &muscle : joint.muscle) {
        muscle.hysteresis.foreign = nullptr;
        muscle.hysteresis.context = nullptr;
    }
    const auto *bytes = reinterpret_cast<const unsigned char *>(&joint);
    uint64_t hash = 0xcbf29ce484222325u;
    for (std::size_t i = 0; i < sizeof joint; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

nb::bytes save(const PneumaticJoint &self)
{
    const uint64_t mark = fingerprint(self);
    std::string image(reinterpret_cast<const char *>(&mark), sizeof mark);
    image.append(reinterpret_cast<const char *>(&self.state), sizeof self.state);
    return nb::bytes(image.data(), image.size());
}

void restore(PneumaticJoint &self, const nb::bytes &image)
{
    const uint64_t mark = fingerprint(self);
    require(image.size() == sizeof mark + sizeof self.state && std::memcmp(image.c_str(), &mark, sizeof mark) == 0,
            "the saved state belongs to a joint with other parameters, or to another build");
    plant_joint_state state;
    std::memcpy(&state, image.c_str() + sizeof mark, sizeof state);
    for (const plant_muscle_state &muscle : state.muscle)
        require(muscle.turns >= 0 && muscle.turns <= PLANT_TURNS && muscle.turns != 1, "the saved state is damaged");
    self.state = state;
}

Out everett(const In &from, const In &to)
{
    require(from.size() == to.size(), "arrays differ in length");
    std::vector<double> e(from.size());
    Patience patience(50);
    for (std::size_t k = 0; k < e.size(); ++k) {
        patience.go_on();
        e[k] = plant_everett(from.data()[k], to.data()[k]);
    }
    return own(std::move(e));
}

Out muscle_force(const nb::dict &parameters, const In &p, const In &kappa)
{
    std::vector<double> table;
    const plant_muscle muscle = plant_read_muscle(parameters, "muscle", table);
    require(p.size() == kappa.size(), "arrays differ in length");
    std::vector<double> f(p.size());
    Patience patience(50);
    for (std::size_t k = 0; k < f.size(); ++k) {
        patience.go_on();
        f[k] = plant_muscle_force(&muscle, p.data()[k], kappa.data()[k]);
    }
    return own(std::move(f));
}

nb::tuple muscle_volume(const nb::dict &parameters, const In &kappa)
{
    std::vector<double> table;
    const plant_muscle muscle = plant_read_muscle(parameters, "muscle", table);
    std::vector<double> volume(kappa.size()), slope(kappa.size());
    Patience patience(50);
    for (std::size_t k = 0; k < volume.size(); ++k) {
        patience.go_on();
        volume[k] = plant_muscle_volume(&muscle, kappa.data()[k], &slope[k]);
    }
    return nb::make_tuple(own(std::move(volume)), own(std::move(slope)));
}

Out valve_flow(const nb::dict &valve, const nb::dict &air, const In &s, const In &p)
{
    const plant_valve v = plant_read_valve(valve, "valve");
    const plant_air a = plant_read_air(air, "air");
    require(s.size() == p.size(), "arrays differ in length");
    std::vector<double> mdot(s.size());
    Patience patience(50);
    for (std::size_t k = 0; k < mdot.size(); ++k) {
        patience.go_on();
        mdot[k] = plant_valve_flow(&v, &a, s.data()[k], p.data()[k]);
    }
    return own(std::move(mdot));
}

Out hysteresis_force(const nb::dict &parameters, double start, const In &kappa, const In &p)
{
    const plant_hysteresis h = plant_read_hysteresis(parameters, "hysteresis");
    require(h.kind != PLANT_FOREIGN, "a foreign mechanism runs in a PneumaticJoint only");
    require(kappa.size() == p.size(), "arrays differ in length");
    std::vector<double> f(kappa.size());
    plant_muscle_state state{};
    plant_hysteresis_reset(&h, &state, start, p.size() > 0 ? p.data()[0] : 0);
    Patience patience(500);
    for (std::size_t k = 0; k < f.size(); ++k) {
        patience.go_on();
        f[k] = plant_hysteresis_step(&h, &state, kappa.data()[k], p.data()[k], 1e-3);
    }
    return own(std::move(f));
}

// A mechanism may hold the joint that it is attached to: the garbage collector has to see the cycle.
int traverse(PyObject *self, visitproc visit, void *arg)
{
    Py_VISIT(Py_TYPE(self));
    if (!nb::inst_ready(self)) return 0;
    for (ForeignMechanism &f : nb::inst_ptr<PneumaticJoint>(self)->foreign) Py_VISIT(f.object.ptr());
    return 0;
}

int clear(PyObject *self)
{
    auto *joint = nb::inst_ptr<PneumaticJoint>(self);
    for (int m = 0; m < 2; ++m) {
        joint->joint.muscle[m].hysteresis.foreign = nullptr;
        joint->foreign[m].object.reset();
    }
    return 0;
}

PyType_Slot kSlots[] = {{Py_tp_traverse, reinterpret_cast<void *>(&traverse)},
                        {Py_tp_clear, reinterpret_cast<void *>(&clear)},
                        {0, nullptr}};

}  // namespace

void bind_plant(nb::module_ &m)
{
    m.attr("PLANT_ELEMENTS") = PLANT_ELEMENTS;
    m.attr("PLANT_TURNS") = PLANT_TURNS;
    m.def("muscle_force", &muscle_force, "muscle"_a, "pressure"_a, "contraction"_a,
          "Static force (T,) of a muscle's map at gauge pressures (T,), [N]; negative where it would push.");
    m.def("muscle_volume", &muscle_volume, "muscle"_a, "contraction"_a,
          "Volume (T,) of a muscle with its dead volume and its derivative (T,) by the contraction, [m^3].");
    m.def("valve_flow", &valve_flow, "valve"_a, "air"_a, "spool"_a, "pressure"_a,
          "Mass flow (T,) into a muscle at absolute pressures (T,), [kg/s].");
    m.def("everett", &everett, "start"_a, "end"_a, "Everett function (T,) of the Preisach mechanism, 0..2.");
    m.def("hysteresis_force", &hysteresis_force, "hysteresis"_a, "start"_a, "contraction"_a, "pressure"_a,
          "Force (T,) of a built-in mechanism that opposes contraction, from nothing remembered at `start`, [N].");
    nb::class_<PneumaticJoint> bound(m, "PneumaticJoint", nb::type_slots(kSlots),
                               "Two pneumatic muscles that pull on a joint, with valves and sensors.");
    refuse_pickling(bound);
    bound
        .def(nb::init<const nb::dict &, uint64_t>(), "parameters"_a, "seed"_a)
        .def("reset", &PneumaticJoint::reset, "angle"_a, "pressure_1"_a, "pressure_2"_a, "seed"_a,
             "At rest at an angle [rad] and two gauge pressures [Pa], nothing remembered.")
        .def("attach", &PneumaticJoint::attach, "muscle"_a, "mechanism"_a,
             "Replace the hysteresis of muscle 0 or 1 by a Python object with reset(contraction) and "
             "force(contraction, pressure, period).")
        .def("sense", &sense, "angle"_a, "period"_a, "(encoder [rad], gauge pressures 1 and 2 [Pa]).")
        .def_prop_ro("sensed", &sensed, "What every sensor showed at the last `sense`, by its name in packages/dehyst-robot/plant/sensors.h.")
        .def("step", &step, "angle"_a, "speed"_a, "valve_1"_a, "valve_2"_a, "period"_a,
             "Torque [Nm] after one period with the angle moving at constant speed.")
        .def("impose", &impose, "angle"_a, "speed"_a, "pressure_1"_a, "pressure_2"_a, "period"_a,
             "The same with ideal gauge pressures [Pa] in place of valves and chambers.")
        .def("run", &run, "angle"_a, "speed"_a, "valve"_a, "period"_a,
             "Steps along angles (T,), speeds (T,) and valve commands (T, 2): signals at the end of every step.")
        .def("run_imposed", &run_imposed, "angle"_a, "speed"_a, "pressure"_a, "period"_a,
             "The same with ideal gauge pressures (T, 2), [Pa].")
        .def("save", &save, "State as bytes for `restore`; the memory of attached mechanisms is not in it.")
        .def("restore", &restore, "image"_a, "Continue from a saved state.")
        .def_prop_ro("state", &state, "Contraction, absolute pressure, force, friction, spool, mass, stretch of the tendon, warmth and factor of "
                     "the loop's size of both muscles.")
        .def_prop_ro("torque", [](const PneumaticJoint &self) { return self.state.torque; },
                     "On the joint after the last step, [Nm].")
        .def_prop_ro("gap", [](const PneumaticJoint &self) { return self.state.gap; },
                     "How far the pulley is before the link, [rad].")
        .def_prop_ro("supply", [](const PneumaticJoint &self) { return self.state.muscle[0].supply; },
                     "Absolute pressure of the supply, [Pa].");
}
