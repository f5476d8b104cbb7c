// The closed loop: sensors -> controllers -> pneumatics -> rigid body, one period after the other, without Python.
//
// The rigid body is MuJoCo's, stepped through the address of its own mj_step: nothing of it is linked or included, so
// that one build serves every version of it.
#include <algorithm>
#include <cmath>
#include <memory>

#include "robot.h"
#include "joint_controller.h"
#include "plant_joint.h"
#include "stoppable.h"

namespace {

using Cube = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Switches = nb::ndarray<const uint32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Commands = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Vector = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Log = nb::ndarray<nb::numpy, double, nb::ndim<3>>;

// angle, velocity, acceleration, load, mean pressure, pressure difference, extra, torque hung on the joint
constexpr std::size_t kReference = 8;
constexpr std::size_t kColumns = 17 + DEHYST_GROUPS;

// Servo of an electric module: it knows its own angle and is far stiffer than any muscle.
struct Electric {
    double stiffness = 0, damping = 0, inertia = 0;
};

// What goes wrong while the loop runs: upper bits of a knot's switches, the lower ones are the controller's.
constexpr uint32_t kControllers = 0xffffu;
constexpr uint32_t kAngleLost = 1u << 16, kAngleJump = 1u << 17, kAngleFrozen = 1u << 18, kPressureLost = 1u << 19,
                   kPressureJump = 1u << 20, kPressureFrozen = 1u << 21, kReferenceLost = 1u << 22, kSupplyLost = 1u << 23;
constexpr double kAngleError = 0.2, kPressureError = 1e5; // of a jump [rad], [Pa]

// Where learned values were at any period of any run.
struct Learned {
    double lowest = 1, highest = 1, offset = 0;
    bool finite = true;

    void see(const dehyst_learning &learning)
    {
        for (int32_t g = 0; g < DEHYST_GROUPS; ++g) {
            for (const double scale : {learning.scale[g], learning.applied[g]}) {
                lowest = scale < lowest ? scale : lowest;
                highest = scale > highest ? scale : highest;
                finite = finite && std::isfinite(scale);
            }
        }
        for (const double value : {learning.offset, learning.applied_offset}) {
            offset = std::fabs(value) > offset ? std::fabs(value) : offset;
            finite = finite && std::isfinite(value);
        }
        finite = finite && std::isfinite(learning.error) && std::isfinite(learning.usual);
    }
};

struct Axis {
    PneumaticJoint *plant = nullptr; // null: electric
    JointController *control = nullptr;
    Electric electric;
    Learned learned;
    dehyst_joint_sensors last{};
    nb::object keep_plant, keep_control;
    nb::object own;         // a controller in Python, in the place of `control` while the position is controlled
    bool in_charge = false; // it was, in the period before
};

// Reference between two knots: cubic in the angle, linear in everything else.
void interpolate(const double *a, const double *b, double span, double s, dehyst_joint_reference &r)
{
    const double u = 1 - s;
    const double s2 = s * s;
    r.angle = (1 + 2 * s) * u * u * a[0] + s * u * u * span * a[1] + s2 * (3 - 2 * s) * b[0] - s2 * u * span * b[1];
    r.velocity = 6 * s * u * (b[0] - a[0]) / span + u * (1 - 3 * s) * a[1] + s * (3 * s - 2) * b[1];
    r.acceleration = u * a[2] + s * b[2];
    r.load = u * a[3] + s * b[3];
    r.mean_pressure = u * a[4] + s * b[4];
    r.pressure_difference = u * a[5] + s * b[5];
    r.extra = u * a[6] + s * b[6];
}

class ClosedLoop {
  public:
    ClosedLoop(std::uintptr_t step, std::uintptr_t model, std::uintptr_t data, const Vector &position,
               const Vector &velocity, const Vector &force, double period)
        : step_(reinterpret_cast<Step>(step)), model_(reinterpret_cast<void *>(model)),
          data_(reinterpret_cast<void *>(data)), position_(position), velocity_(velocity), force_(force),
          period_(period)
    {
        require(step != 0 && model != 0 && data != 0, "no rigid body");
        require(position.size() == velocity.size() && position.size() == force.size(), "dof arrays differ in length");
        require(period > 0, "the period must be positive");
    }

    void add_pneumatic(nb::object plant, nb::object control, nb::object own)
    {
        Axis axis;
        axis.plant = nb::cast<PneumaticJoint *>(plant);
        axis.control = control.is_none() ? nullptr : nb::cast<JointController *>(control);
        axis.keep_plant = std::move(plant);
        axis.keep_control = std::move(control);
        if (!own.is_none()) axis.own = std::move(own);
        axes_.push_back(std::move(axis));
    }

    void add_electric(double stiffness, double damping, double inertia)
    {
        Axis axis;
        axis.electric = {stiffness, damping, inertia};
        axes_.push_back(std::move(axis));
    }

    // Controllers start from what the sensors see now, which is returned, (n, 3); `blind`: without any knowledge of the
    // past.
    Matrix reset_controllers(bool blind)
    {
        std::vector<double> seen(3 * axes_.size());
        look(seen.data());
        for (std::size_t j = 0; j < axes_.size(); ++j) {
            Axis &axis = axes_[j];
            axis.in_charge = false;
            if (axis.control == nullptr) continue;
            const double *at = seen.data() + 3 * j;
            if (blind) {
                axis.control->restart(at[0], at[1], at[2], false);
            } else {
                axis.control->reset(at[0], at[1], at[2]);
            }
        }
        return given(std::move(seen));
    }

    // knots (K, n, 8), switches (K, n): valid from their knot on. Runs (K - 1) intervals of `ticks` periods.
    Log run(const Cube &knots, const Switches &switches, std::size_t ticks, std::size_t every)
    {
        const std::size_t n = axes_.size();
        require(n == position_.size(), "every joint needs a drive");
        require(knots.shape(0) >= 2 && knots.shape(1) == n && knots.shape(2) == kReference, "knots must be (K, n, 8)");
        require(switches.shape(0) == knots.shape(0) && switches.shape(1) == n, "switches must be (K, n)");
        require(ticks > 0 && every > 0, "ticks and every must be positive");
        for (const Axis &axis : axes_)
            require(axis.plant == nullptr || axis.control != nullptr || axis.own.is_valid(), "a joint has no controller");
        const std::size_t total = (knots.shape(0) - 1) * ticks;
        const std::size_t rows = (total + every - 1) / every;
        auto log = std::make_unique<std::vector<double>>(rows * n * kColumns);
        {
            nb::gil_scoped_release release;
            loop(knots.data(), switches.data(), n, total, ticks, every, log->data());
        }
        raise_if_stopped();
        if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
        for (Axis &axis : axes_)
            if (axis.plant != nullptr) axis.plant->raise();
        auto *kept = log.release();
        nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
        return Log(kept->data(), {rows, n, kColumns}, owner);
    }

    // What the sensors show, (n, 3): angle and both pressures of a joint with muscles, the angle alone of another one.
    Matrix sense()
    {
        std::vector<double> seen(3 * axes_.size());
        look(seen.data());
        return given(std::move(seen));
    }

    // Commands (n, 2), held for `ticks` periods: of valves, -1..1, or with `pressures` pressures [Pa] in their place; of an
    // electric joint its angle; `hung`: torques (n,) on the joints besides. Every period ends with a look at the sensors;
    // the last one is returned.
    Matrix act(const Commands &commands, bool pressures, std::size_t ticks, const In &hung)
    {
        const std::size_t n = axes_.size();
        require(n == position_.size(), "every joint needs a drive");
        require(commands.shape(0) == n && commands.shape(1) == 2 && ticks > 0, "commands must be (n, 2), ticks positive");
        require(hung.size() == n, "torques must be (n,)");
        std::vector<double> seen(3 * n);
        {
            nb::gil_scoped_release release;
            Patience patience(20000);
            for (std::size_t k = 0; k < ticks && !patience.stops(); ++k) {
                for (std::size_t j = 0; j < n; ++j)
                    force_.data()[j] = hung.data()[j] + obey(axes_[j], j, commands.data() + 2 * j, pressures);
                breathe(nullptr);
                step_(model_, data_);
                look(seen.data());
            }
        }
        raise_if_stopped();
        for (Axis &axis : axes_)
            if (axis.plant != nullptr) axis.plant->raise();
        return given(std::move(seen));
    }

    nb::tuple learned(std::size_t j) const
    {
        const Learned &l = axes_.at(j).learned;
        return nb::make_tuple(l.lowest, l.highest, l.offset, l.finite);
    }

    // For Python's garbage collector: a foreign mechanism may lead back to the arm that this loop belongs to.
    int visit(visitproc visit, void *arg)
    {
        for (Axis &axis : axes_) {
            Py_VISIT(axis.keep_plant.ptr());
            Py_VISIT(axis.keep_control.ptr());
            Py_VISIT(axis.own.ptr());
        }
        return 0;
    }

    void forget() { axes_.clear(); }

  private:
    using Step = void (*)(const void *, void *);

    static Matrix given(std::vector<double> &&values)
    {
        auto *kept = new std::vector<double>(std::move(values));
        nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
        return Matrix(kept->data(), {kept->size() / 3, 3}, owner);
    }

    void look(double *seen)
    {
        for (std::size_t j = 0; j < axes_.size(); ++j, seen += 3) {
            Axis &axis = axes_[j];
            const double q = position_.data()[j];
            seen[0] = q, seen[1] = seen[2] = 0;
            if (axis.plant == nullptr) continue;
            plant_reading &reading = axis.plant->reading;
            plant_joint_sense(&axis.plant->joint, &axis.plant->state, q, period_, &reading);
            seen[0] = reading.angle, seen[1] = reading.pressure_1, seen[2] = reading.pressure_2;
        }
    }

    double obey(Axis &axis, std::size_t j, const double *command, bool pressures)
    {
        const double q = position_.data()[j], v = velocity_.data()[j];
        if (axis.plant == nullptr) return axis.electric.stiffness * (command[0] - q) - axis.electric.damping * v;
        const auto advance = pressures ? &plant_joint_impose : &plant_joint_step;
        return advance(&axis.plant->joint, &axis.plant->state, q, v, command, period_);
    }

    void loop(const double *knots, const uint32_t *switches, std::size_t n, std::size_t total, std::size_t ticks,
              std::size_t every, double *log)
    {
        const double span = period_ * static_cast<double>(ticks);
        Patience patience(20000);
        for (std::size_t k = 0; k < total && !fault_ && !patience.stops(); ++k) {
            const std::size_t knot = k / ticks;
            const double s = static_cast<double>(k % ticks) / static_cast<double>(ticks);
            const std::size_t first = k / every * every;
            const double share = 1.0 / static_cast<double>((first + every < total ? first + every : total) - first);
            for (std::size_t j = 0; j < n; ++j) {
                const double *a = knots + (knot * n + j) * kReference;
                const double *b = a + n * kReference;
                dehyst_joint_reference reference{};
                interpolate(a, b, span, s, reference);
                double *row = log + (first / every * n + j) * kColumns;
                const double hung = (1 - s) * a[7] + s * b[7];
                force_.data()[j] = hung + drive(axes_[j], j, reference, switches[knot * n + j], k == first, share, row);
            }
            breathe(switches + knot * n);
            step_(model_, data_);
        }
    }

    // All joints take their air from one supply.
    void breathe(const uint32_t *switches)
    {
        const PneumaticJoint *first = nullptr;
        double drawn = 0;
        int failing = 0;
        for (std::size_t j = 0; j < axes_.size(); ++j) {
            if (axes_[j].plant == nullptr) continue;
            if (first == nullptr) first = axes_[j].plant;
            drawn += axes_[j].plant->drawn();
            failing |= switches != nullptr && (switches[j] & kSupplyLost) != 0;
        }
        if (first == nullptr || !(first->joint.air.supply_volume > 0)) return;
        const double next = plant_supply_step(&first->joint.air, first->state.muscle[0].supply, drawn, period_, failing);
        for (Axis &axis : axes_)
            if (axis.plant != nullptr) axis.plant->supply(next);
    }

    // A row of the log holds what was at its first period, but sensors as their mean and flags as their union over all
    // its periods: a logger that neither aliases noise nor misses an event.
    double drive(Axis &axis, std::size_t j, const dehyst_joint_reference &reference, uint32_t switches, bool first,
                 double share, double *row)
    {
        const double q = position_.data()[j], v = velocity_.data()[j];
        if (axis.plant == nullptr) {
            const double torque = reference.load + axis.electric.inertia * reference.acceleration +
                                  axis.electric.damping * (reference.velocity - v) +
                                  axis.electric.stiffness * (reference.angle - q);
            if (first) row[0] = reference.angle, row[1] = q, row[3] = torque;
            row[2] += share * q;
            return torque;
        }
        plant_joint_state &state = axis.plant->state;
        plant_reading reading{};
        plant_joint_sense(&axis.plant->joint, &state, q, period_, &reading);
        const dehyst_joint_sensors sensors = faulty(axis, reading, switches);
        dehyst_joint_reference told = reference;
        if (switches & kReferenceLost) told.angle = std::nan("");
        dehyst_joint_output out{};
        const bool own = axis.own.is_valid() && (axis.control == nullptr || (switches & DEHYST_POSITION) != 0);
        if (axis.control != nullptr) { // beside one's own it goes on as an observer, and its compensator
            const uint32_t on = own ? switches & ~(DEHYST_INTEGRATOR | DEHYST_ADAPT) : switches;
            axis.control->advance(sensors, told, on & kControllers, out);
            if (axis.control->direct) axis.learned.see(axis.control->state.learning);
            told.extra = out.compensation;
        }
        if (own) command(axis, sensors, told, out);
        axis.in_charge = own;
        const double torque = plant_joint_step(&axis.plant->joint, &state, q, v, out.valve, period_);
        if (first) {
            row[0] = reference.angle, row[1] = q, row[3] = torque;
            row[6] = out.pressure_difference, row[7] = out.compensation, row[8] = out.integrator;
            row[9] = out.torque, row[10] = out.load, row[11] = out.contact, row[12] = out.doubt;
            row[14] = row[16] = 1;
            if (axis.control != nullptr) {
                const dehyst_joint_state &c = axis.control->state;
                row[14] = c.fit.found, row[15] = c.fit.offset, row[16] = c.fit.scale;
                for (int32_t g = 0; g < DEHYST_GROUPS; ++g) row[17 + g] = c.learning.applied[g];
            }
        }
        row[2] += share * reading.angle;
        row[4] += share * reading.pressure_1;
        row[5] += share * reading.pressure_2;
        row[13] = static_cast<double>(static_cast<uint32_t>(row[13]) | out.flags);
        return torque;
    }

    // Asks the controller in Python for both valves; its first fault ends the run. Of the controller that it stands in for
    // only the compensator and what was found out about it is left; dp is the measured one.
    void command(Axis &axis, const dehyst_joint_sensors &sensors, const dehyst_joint_reference &r, dehyst_joint_output &out)
    {
        out.pressure_difference = sensors.pressure[0] - sensors.pressure[1];
        out.integrator = out.torque = out.valve[0] = out.valve[1] = 0;
        out.flags &= DEHYST_STALE | DEHYST_SHIFTED | DEHYST_TOUCHED;
        if (fault_) return;
        nb::gil_scoped_acquire gil;
        try {
            const nb::tuple seen = nb::make_tuple(sensors.angle, sensors.pressure[0], sensors.pressure[1]);
            if (!axis.in_charge) axis.own(seen, nb::none());
            const nb::object asked = axis.own(seen, nb::make_tuple(r.angle, r.velocity, r.acceleration, r.load,
                                                                   r.mean_pressure, r.pressure_difference, r.extra));
            for (int m = 0; m < 2; ++m) {
                const double valve = nb::cast<double>(asked[m]);
                out.valve[m] = std::clamp(valve, -1.0, 1.0);
                if (valve != out.valve[m]) out.flags |= DEHYST_VALVE_LIMIT;
            }
        } catch (...) {
            fault_ = std::current_exception();
        }
    }

    static dehyst_joint_sensors faulty(Axis &axis, const plant_reading &reading, uint32_t switches)
    {
        dehyst_joint_sensors seen = {reading.angle, {reading.pressure_1, reading.pressure_2}};
        if (switches & kAngleFrozen) seen.angle = axis.last.angle;
        if (switches & kPressureFrozen) seen.pressure[1] = axis.last.pressure[1];
        axis.last = seen;
        if (switches & kAngleJump) seen.angle += kAngleError;
        if (switches & kPressureJump) seen.pressure[0] += kPressureError;
        if (switches & kAngleLost) seen.angle = std::nan("");
        if (switches & kPressureLost) seen.pressure[0] = std::nan("");
        return seen;
    }

    Step step_;
    void *model_, *data_;
    Vector position_, velocity_, force_;
    double period_;
    std::vector<Axis> axes_;
    std::exception_ptr fault_; // of a controller in Python
};

int traverse(PyObject *self, visitproc visit, void *arg)
{
    Py_VISIT(Py_TYPE(self));
    return nb::inst_ready(self) ? nb::inst_ptr<ClosedLoop>(self)->visit(visit, arg) : 0;
}

int clear(PyObject *self)
{
    nb::inst_ptr<ClosedLoop>(self)->forget();
    return 0;
}

PyType_Slot kSlots[] = {{Py_tp_traverse, reinterpret_cast<void *>(&traverse)},
                        {Py_tp_clear, reinterpret_cast<void *>(&clear)},
                        {0, nullptr}};

}  // namespace

void bind_robot(nb::module_ &m)
{
    nb::class_<ClosedLoop>(m, "ClosedLoop", nb::type_slots(kSlots),
                           "Sensors, controllers, pneumatics and rigid body, period after period.")
        .def(nb::init<std::uintptr_t, std::uintptr_t, std::uintptr_t, const Vector &, const Vector &, const Vector &,
                      double>(),
             "step"_a, "model"_a, "data"_a, "position"_a, "velocity"_a, "force"_a, "period"_a)
        .def("add_pneumatic", &ClosedLoop::add_pneumatic, "plant"_a, "control"_a.none(), "own"_a.none())
        .def("sense", &ClosedLoop::sense, "What the sensors show, (n, 3).")
        .def("act", &ClosedLoop::act, "commands"_a, "pressures"_a, "ticks"_a, "hung"_a,
             "Commands (n, 2) for `ticks` periods without controllers; what the sensors show then, (n, 3).")
        .def("add_electric", &ClosedLoop::add_electric, "stiffness"_a, "damping"_a, "inertia"_a)
        .def("reset_controllers", &ClosedLoop::reset_controllers, "blind"_a, "What the sensors show, (n, 3).")
        .def("learned", &ClosedLoop::learned, "axis"_a,
             "Lowest and highest scale, largest offset of any period so far, and whether all were finite.")
        .def("run", &ClosedLoop::run, "knots"_a, "switches"_a, "ticks"_a, "every"_a,
             "Log (rows, n, 25) of a run along reference knots (K, n, 8) that lie `ticks` periods apart.");
}
