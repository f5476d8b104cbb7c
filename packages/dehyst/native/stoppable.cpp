// Whether Python wants a long call to stop: asked at most every 40 ms, for a question costs the GIL.
#include "stoppable.h"

#include <chrono>

namespace {

using Clock = std::chrono::steady_clock;

unsigned long main_thread = 0;
Clock::time_point last; // of the main thread alone

// Python handles signals in its main thread only. A handler that raises leaves its error for `raise_if_stopped`.
int stopped()
{
    if (PyThread_get_thread_ident() != main_thread) return 0;
    const Clock::time_point now = Clock::now();
    if (now - last < std::chrono::milliseconds(40)) return 0;
    const nb::gil_scoped_acquire hold;
    const bool stop = PyErr_CheckSignals() != 0;
    last = Clock::now();
    return stop ? 1 : 0;
}

}  // namespace

void bind_stoppable()
{
    main_thread = nb::cast<unsigned long>(nb::module_::import_("threading").attr("main_thread")().attr("ident"));
    engine_ask(&stopped);
}
