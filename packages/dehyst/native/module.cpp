// nanobind binding of the core and its engine: arrays in, arrays out, no formula.
#include "arrays.h"

NB_MODULE(_native, m)
{
    nb::set_leak_warnings(false); // what a model keeps until the interpreter's end is no leak
    m.doc() = "dehyst's C core (hysteresis models as they run on a machine) and its engine for long signals.";
    bind_stoppable();
    bind_models(m);
    bind_stack(m);
    bind_block(m);
    bind_direct(m);
    bind_direct_block(m);
    bind_gram(m);
    bind_solver(m);
    bind_ramps(m);
    bind_engine(m);
    bind_element_sum(m);
    bind_signal(m);
    bind_direct_forward(m);
    bind_triangle(m);
    bind_oscillator(m);
    bind_offset(m);
    bind_text(m);
    bind_friction(m);
}
