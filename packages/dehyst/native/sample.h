// A sample from whatever Python passes.
#ifndef DEHYST_NATIVE_SAMPLE_H
#define DEHYST_NATIVE_SAMPLE_H

#include <limits>

#include "arrays.h"

// One number from whatever Python passes; a sensor that has nothing to say gives None, which is a rejected sample.
inline double sample_of(nb::handle x)
{
    if (x.is_none()) return std::numeric_limits<double>::quiet_NaN();
    const double value = PyFloat_AsDouble(x.ptr());
    if (value == -1.0 && PyErr_Occurred() != nullptr) {
        PyErr_Clear();
        const std::string kind =
            nb::str(nb::handle(reinterpret_cast<PyObject *>(Py_TYPE(x.ptr()))).attr("__name__")).c_str();
        throw nb::type_error(("a sample must be one number (or None, for a sensor without an answer), not a " + kind +
                              "; whole signals go through simulate()")
                                 .c_str());
    }
    return value;
}

// Adds the call with a sample to the class of a machine with `double step(double)`.
template <class T>
void bind_call(nb::class_<T> &bound)
{
    bound.def(
        "__call__", [](T &self, nb::handle x, double) { return self.step(sample_of(x)); }, "x"_a.none(), "period"_a = 0.0,
        "Output for the next sample; None is a rejected sample: the last good output is held. The time since the one "
        "before changes nothing.");
}

#endif
