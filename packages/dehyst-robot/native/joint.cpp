// Binding of the joint controller of the core: no formula.
#include "robot.h"
#include "joint_controller.h"
#include "no_pickle.h"
#include "stoppable.h"

namespace {

constexpr std::size_t kReference = 7, kOutput = 14;
using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

dehyst_joint_output stepped(JointController &self, double angle, double p_1, double p_2, const double *reference,
                            int64_t switches)
{
    const dehyst_joint_sensors sensors = {angle, {p_1, p_2}};
    const dehyst_joint_reference wanted = {reference[0], reference[1], reference[2], reference[3],
                                           reference[4], reference[5], reference[6]};
    dehyst_joint_output out;
    self.advance(sensors, wanted, static_cast<uint32_t>(switches), out);
    return out;
}

nb::tuple step(JointController &self, double angle, double p_1, double p_2, const nb::tuple &reference, int64_t switches)
{
    require(reference.size() == kReference, "a reference has 7 values");
    double values[kReference];
    for (std::size_t i = 0; i < kReference; ++i) values[i] = nb::cast<double>(reference[i]);
    const dehyst_joint_output o = stepped(self, angle, p_1, p_2, values, switches);
    return nb::make_tuple(o.valve[0], o.valve[1], o.desired[0], o.desired[1], o.pressure_difference, o.torque,
                          o.integrator, o.compensation, o.angle, o.velocity, o.load, o.contact, o.doubt, o.flags);
}

Matrix run(JointController &self, const In &angle, const In &p_1, const In &p_2, const Table &reference,
           const Rows &switches)
{
    const std::size_t samples = angle.size();
    require(p_1.size() == samples && p_2.size() == samples && reference.shape(0) == samples &&
                switches.size() == samples,
            "signals differ in length");
    require(reference.shape(1) == kReference, "a reference has 7 columns");
    auto *rows = new std::vector<double>(samples * kOutput);
    nb::capsule owner(rows, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    Patience patience(1000);
    for (std::size_t k = 0; k < samples; ++k) {
        patience.go_on();
        const dehyst_joint_output o = stepped(self, angle.data()[k], p_1.data()[k], p_2.data()[k],
                                              reference.data() + k * kReference, switches.data()[k]);
        const double row[kOutput] = {o.valve[0],     o.valve[1],     o.desired[0], o.desired[1],
                                     o.pressure_difference, o.torque, o.integrator, o.compensation,
                                     o.angle,        o.velocity,     o.load,       o.contact,
                                     o.doubt,        static_cast<double>(o.flags)};
        std::memcpy(rows->data() + k * kOutput, row, sizeof row);
    }
    return Matrix(rows->data(), {samples, kOutput}, owner);
}

nb::dict flags()
{
    nb::dict names;
    names["angle-fault"] = static_cast<uint32_t>(DEHYST_ANGLE_FAULT);
    names["pressure-fault-1"] = static_cast<uint32_t>(DEHYST_PRESSURE_FAULT_1);
    names["pressure-fault-2"] = static_cast<uint32_t>(DEHYST_PRESSURE_FAULT_2);
    names["failed"] = static_cast<uint32_t>(DEHYST_FAILED);
    names["pressure-limit"] = static_cast<uint32_t>(DEHYST_PRESSURE_LIMIT);
    names["valve-limit"] = static_cast<uint32_t>(DEHYST_VALVE_LIMIT);
    names["reference-fault"] = static_cast<uint32_t>(DEHYST_REFERENCE_FAULT);
    names["fault-ever"] = static_cast<uint32_t>(DEHYST_FAULT_EVER);
    names["learned"] = static_cast<uint32_t>(DEHYST_LEARNED);
    names["stale"] = static_cast<uint32_t>(DEHYST_STALE);
    names["shifted"] = static_cast<uint32_t>(DEHYST_SHIFTED);
    names["touched"] = static_cast<uint32_t>(DEHYST_TOUCHED);
    return names;
}

}  // namespace

void bind_joint(nb::module_ &m)
{
    m.attr("POSITION") = static_cast<uint32_t>(DEHYST_POSITION);
    m.attr("INTEGRATOR") = static_cast<uint32_t>(DEHYST_INTEGRATOR);
    m.attr("COMPENSATOR") = static_cast<uint32_t>(DEHYST_COMPENSATOR);
    m.attr("ADAPT") = static_cast<uint32_t>(DEHYST_ADAPT);
    m.attr("DISTURBANCE") = static_cast<uint32_t>(DEHYST_DISTURBANCE);
    nb::dict laws;
    laws["pid"] = static_cast<int>(REVIEWED_PID);
    laws["vo-minh"] = static_cast<int>(REVIEWED_VO_MINH);
    laws["sliding-mode"] = static_cast<int>(REVIEWED_SLIDING_MODE);
    laws["one-valve"] = static_cast<int>(REVIEWED_ONE_VALVE);
    m.attr("LAWS") = laws;
    m.attr("JOINT_FLAGS") = flags();
    m.def("root", &dehyst_root, "x"_a, "Square root as the core takes it.");
    m.def("flow_function", &dehyst_flow_function, "ratio"_a, "critical"_a, "psi of ISO 6358.");
    m.def(
        "valve_opening",
        [](const nb::dict &air, double flow, double pressure) {
            const dehyst_pneumatics p = pneumatics_of(air);
            return dehyst_valve_opening(&p, flow, pressure);
        },
        "pneumatics"_a, "flow"_a, "pressure"_a, "Opening for a mass flow [kg/s] at an absolute pressure [Pa].");
    m.def(
        "valve_command",
        [](const nb::dict &air, double opening) {
            const dehyst_pneumatics p = pneumatics_of(air);
            return dehyst_valve_command(&p, opening);
        },
        "pneumatics"_a, "opening"_a, "Command across the nominal dead band.");
    m.def(
        "chamber_flow",
        [](const nb::dict &air, double volume, double volume_rate, double pressure, double rate) {
            const dehyst_pneumatics p = pneumatics_of(air);
            return dehyst_chamber_flow(&p, volume, volume_rate, pressure, rate);
        },
        "pneumatics"_a, "volume"_a, "volume_rate"_a, "pressure"_a, "rate"_a, "Mass flow [kg/s] of the pressure law.");
    nb::class_<JointController> bound(m, "JointController", "Controller of one joint with its state.");
    refuse_pickling(bound);
    bound
        .def(nb::init<const nb::dict &, const nb::object &, const nb::object &, const nb::dict &, const nb::object &>(),
             "parameters"_a, "compensator"_a.none(), "direct"_a.none(), "adaptation"_a, "law"_a.none() = nb::none())
        .def("reset", &JointController::reset, "angle"_a, "p_1"_a, "p_2"_a, "Start at these readings.")
        .def("step", &step, "angle"_a, "p_1"_a, "p_2"_a, "reference"_a, "switches"_a,
             "One period: (valve 1, 2, desired 1, 2, dp, torque, integrator, compensation, angle, velocity, load,"
             " contact, doubt, flags).")
        .def("run", &run, "angle"_a, "p_1"_a, "p_2"_a, "reference"_a, "switches"_a,
             "Many periods: reference (T, 7) -> outputs (T, 14) in the order of `step`.")
        .def("restart", &JointController::restart, "angle"_a, "p_1"_a, "p_2"_a, "known"_a,
             "Start at these readings, with the past known or not.")
        .def_prop_ro("scales", [](const JointController &self) {
            const dehyst_learning &l = self.state.learning;
            const int32_t groups = self.joint.direct ? self.joint.direct->groups : 0;
            return own(std::vector<double>(l.scale, l.scale + groups));
        }, nb::rv_policy::move)
        .def_prop_ro("applied", [](const JointController &self) {
            const dehyst_learning &l = self.state.learning;
            const int32_t groups = self.joint.direct ? self.joint.direct->groups : 0;
            return own(std::vector<double>(l.applied, l.applied + groups));
        }, nb::rv_policy::move)
        .def_prop_ro("offsets", [](const JointController &self) {
            return nb::make_tuple(self.state.learning.offset, self.state.learning.applied_offset);
        })
        .def("exchange", &JointController::exchange, "compensator"_a.none(), "unit"_a, "shear"_a,
             "Fade to another compensator.")
        .def("save", &JointController::save, "Image of the state.")
        .def("restore", &JointController::restore, "image"_a,
             "Go on from a saved image; the answer of the core, 0 if it was good.")
        .def_prop_ro("disturbance", [](const JointController &self) {
            return self.reviewed ? self.reviewed->state.disturbance : 0.0;
        })
        .def_prop_ro("compensator_state", [](const JointController &self) {
            return own(self.compensator ? std::vector<double>(self.compensator->z) : std::vector<double>());
        }, nb::rv_policy::move);
}
