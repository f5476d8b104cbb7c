// Objects that are called once a sample: a call costs little more than its arithmetic.
#ifndef DEHYST_NATIVE_SAMPLE_CALL_H
#define DEHYST_NATIVE_SAMPLE_CALL_H

#include <limits>
#include <stdexcept>
#include <type_traits>

#include "arrays.h"

#include <structmember.h>

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

// First base of a class with `double step(double)` whose objects are called with a float, bound with `slots()`. Python
// finds `entry` in the object itself (PEP 590); everything but one float, or a second one for the time since then, goes on
// to `_call`, which nanobind makes. Only a type made by a specification of our own can say so in the limited
// API, hence the base in Python: its flag and offset are inherited, until someone sets `__call__`.
template <class T>
class SampleCall {
  protected:
    SampleCall() : entry_(&SampleCall::call) {}

  public:
    static const PyType_Slot *slots()
    {
        static PyMemberDef members[] = {{"__vectorcalloffset__", T_PYSSIZET, kOffset, READONLY, nullptr}, {}};
        static PyType_Slot own[] = {
            {Py_tp_call, reinterpret_cast<void *>(&PyVectorcall_Call)}, {Py_tp_members, members}, {0, nullptr}};
        static PyType_Spec spec = {"dehyst._native.SampleCall", static_cast<int>(kOffset + sizeof(vectorcallfunc)), 0,
                                   Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE | Py_TPFLAGS_HAVE_VECTORCALL, own};
        static PyType_Slot found[] = {
            {Py_tp_base, PyType_FromSpec(&spec)}, {Py_tp_new, reinterpret_cast<void *>(&SampleCall::blank)}, {0, nullptr}};
        if (found[0].pfunc == nullptr) throw nb::python_error();
        return found;
    }

    static void bind(const nb::class_<T> &bound)
    {
        static_assert(std::is_base_of<SampleCall, T>::value, "the class derives from SampleCall of itself");
        const nb::object probe = nb::inst_alloc(bound); // memory without an object: only addresses matter
        if (&static_cast<SampleCall *>(nb::inst_ptr<T>(probe))->entry_ != &entry_of(probe.ptr()))
            throw std::logic_error("nanobind keeps objects elsewhere than SampleCall says");
        bound.attr("_call") = nb::cpp_function(
            [](T &self, nb::handle x, double) { return self.step(sample_of(x)); }, nb::name("__call__"), nb::is_method(),
            "x"_a.none(), "period"_a = 0.0,
            "Output for the next sample; None is a rejected sample: the last good output is held. The time since the one "
            "before changes nothing.");
#if PY_VERSION_HEX < 0x030C0000 // does not inherit the flag
        reinterpret_cast<PyTypeObject *>(bound.ptr())->tp_flags |= Py_TPFLAGS_HAVE_VECTORCALL;
        PyType_Modified(reinterpret_cast<PyTypeObject *>(bound.ptr()));
#endif
    }

  private:
    static constexpr Py_ssize_t kOffset = sizeof(PyObject) + 8; // nanobind's own 8 bytes come between

    static vectorcallfunc &entry_of(PyObject *self)
    {
        return *reinterpret_cast<vectorcallfunc *>(reinterpret_cast<char *>(self) + kOffset);
    }

    // T.__new__(T) without __init__ leaves memory as it is; a call of that must be an error, not a jump.
    static PyObject *blank(PyTypeObject *type, PyObject *, PyObject *)
    {
        try {
            PyObject *self = nb::inst_alloc(reinterpret_cast<PyObject *>(type)).release().ptr();
            entry_of(self) = nullptr;
            return self;
        } catch (nb::python_error &fault) {
            fault.restore();
            return nullptr;
        }
    }

    static PyObject *call(PyObject *self, PyObject *const *words, std::size_t count, PyObject *names)
    {
        const Py_ssize_t given = PyVectorcall_NARGS(count);
        if (names == nullptr && (given == 1 || (given == 2 && PyFloat_Check(words[1]))) && PyFloat_Check(words[0]))
            return PyFloat_FromDouble(static_cast<T *>(owner(self))->step(PyFloat_AsDouble(words[0])));
        PyObject *method = PyObject_GetAttrString(self, "_call");
        if (method == nullptr) return nullptr;
        PyObject *result = PyObject_Vectorcall(method, words, count & ~PY_VECTORCALL_ARGUMENTS_OFFSET, names);
        Py_DECREF(method);
        return result;
    }

    static SampleCall *owner(PyObject *self)
    {
        return reinterpret_cast<SampleCall *>(&entry_of(self)); // entry_ is the first member
    }

    vectorcallfunc entry_;
};

#endif
