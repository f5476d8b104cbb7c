// Objects that are called once a sample: a call costs little more than its arithmetic.
#ifndef DEHYST_NATIVE_SAMPLE_CALL_H
#define DEHYST_NATIVE_SAMPLE_CALL_H

#include <limits>
#include <type_traits>

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

// First base of a class with `double step(double)` whose objects are called with a float. Python finds `entry` in the
// object itself (PEP 590); everything but one float, or a second one for the time since then, goes on to the `__call__` that the class is bound with.
template <class T>
class SampleCall {
  protected:
    SampleCall() : entry_(&SampleCall::call) {}

  public:
    static void bind(const nb::class_<T> &bound)
    {
        static_assert(std::is_base_of<SampleCall, T>::value, "the class derives from SampleCall of itself");
        PyTypeObject *type = reinterpret_cast<PyTypeObject *>(bound.ptr());
        const nb::object probe = nb::inst_alloc(bound); // memory without an object: only addresses matter
        T *inside = nb::inst_ptr<T>(probe);
        offset_ = reinterpret_cast<char *>(&static_cast<SampleCall *>(inside)->entry_) -
                  reinterpret_cast<char *>(probe.ptr());
        made_ = type->tp_new;
        type->tp_new = &SampleCall::blank;
        type->tp_vectorcall_offset = offset_;
        type->tp_call = PyVectorcall_Call;
        type->tp_flags |= Py_TPFLAGS_HAVE_VECTORCALL;
        PyType_Modified(type);
    }

  private:
    static vectorcallfunc &entry_of(PyObject *self)
    {
        return *reinterpret_cast<vectorcallfunc *>(reinterpret_cast<char *>(self) + offset_);
    }

    // T.__new__(T) without __init__ leaves memory as it is; a call of that must be an error, not a jump.
    static PyObject *blank(PyTypeObject *type, PyObject *words, PyObject *names)
    {
        PyObject *self = made_(type, words, names);
        if (self != nullptr) entry_of(self) = nullptr;
        return self;
    }

    static PyObject *call(PyObject *self, PyObject *const *words, std::size_t count, PyObject *names)
    {
        const Py_ssize_t given = PyVectorcall_NARGS(count);
        if (names == nullptr && (given == 1 || (given == 2 && PyFloat_Check(words[1]))) && PyFloat_Check(words[0]))
            return PyFloat_FromDouble(static_cast<T *>(owner(self))->step(PyFloat_AS_DOUBLE(words[0])));
        PyObject *method = PyObject_GetAttrString(self, "__call__");
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
    static inline Py_ssize_t offset_ = 0;
    static inline newfunc made_ = nullptr;
};

#endif
