// One simulated pneumatic joint with its state and the Python mechanisms attached to it.
#ifndef DEHYST_NATIVE_PLANT_JOINT_H
#define DEHYST_NATIVE_PLANT_JOINT_H

#include <exception>

#include "arrays.h"
#include "plant.h"

// A hysteresis mechanism written in Python. The plant calls it from C, where no exception may pass: the first fault is
// kept, the force is zero from then on, and `PneumaticJoint::raise` hands the fault over.
struct ForeignMechanism {
    nb::object object;
    std::exception_ptr fault;

    static double force(void *context, double contraction, double pressure, double period);
};

// `joint` and `state` are for C++ callers, who may step without the GIL; afterwards they call `raise` with it.
struct PneumaticJoint {
    std::vector<double> tables[2]; // static maps that are given by points; `joint` has their addresses
    plant_joint joint{};
    plant_joint_state state{};
    plant_reading reading{}; // the last one that Python asked for
    ForeignMechanism foreign[2];

    PneumaticJoint(const nb::dict &parameters, uint64_t seed);
    PneumaticJoint(const PneumaticJoint &) = delete; // the plant keeps the addresses of `tables` and `foreign`
    PneumaticJoint &operator=(const PneumaticJoint &) = delete;

    void reset(double q, double p1, double p2, uint64_t seed);
    void attach(int muscle, nb::object mechanism);
    // After a step, where no other joint takes air from the supply.
    void breathe(double period) { supply(plant_supply_step(&joint.air, state.muscle[0].supply, drawn(), period, 0)); }
    double drawn() const { return state.muscle[0].drawn + state.muscle[1].drawn; }
    void supply(double pressure) { state.muscle[0].supply = state.muscle[1].supply = pressure; }
    void raise();          // throws the fault of a foreign mechanism, if there was one, and forgets it
    void complete() const; // throws if a foreign mechanism is asked for and none is attached
};

// The hysteresis of one muscle from its dict; `where` names it in errors.
plant_hysteresis plant_read_hysteresis(const nb::dict &parameters, const std::string &where);
// `table` takes the points of a map that is a table: the result has its address.
plant_joint plant_read_joint(const nb::dict &parameters, std::vector<double> (&tables)[2]);
plant_muscle plant_read_muscle(const nb::dict &parameters, const std::string &where, std::vector<double> &table);
plant_valve plant_read_valve(const nb::dict &parameters, const std::string &where);
plant_air plant_read_air(const nb::dict &parameters, const std::string &where);

#endif
