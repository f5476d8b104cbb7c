// Long calls answer Ctrl-C: they ask between parts of their work, with or without the GIL.
#ifndef DEHYST_NATIVE_STOPPABLE_H
#define DEHYST_NATIVE_STOPPABLE_H

#include <mutex>

#include "arrays.h"
#include "patience.h"

// After a call that may have been stopped; with the GIL.
inline void raise_if_stopped()
{
    if (PyErr_Occurred() != nullptr) throw nb::python_error();
}

// One of several threads at a time, without the GIL: who waits for its turn with it stops the one who needs it to be asked.
class Turn {
  public:
    explicit Turn(std::mutex &mutex) : alone_(mutex) {}

  private:
    nb::gil_scoped_release others_run_;
    std::lock_guard<std::mutex> alone_;
};

// For loops of the binding: `work` is that of a sample, in about nanoseconds.
class Patience {
  public:
    explicit Patience(std::size_t work) : work_(static_cast<int64_t>(work)) {}
    bool stops() { return engine_stops(&left_, work_) != 0; }
    void go_on() // or not; with the GIL
    {
        if (stops()) throw nb::python_error();
    }

  private:
    int64_t left_ = ENGINE_BETWEEN, work_;
};

#endif
