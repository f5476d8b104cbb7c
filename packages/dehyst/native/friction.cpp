// Host models of friction along a path: a curve and elements with memory, forwards and backwards.
#include "arrays.h"

#include "duhem.h"
#include "friction.h"
#include "lugre.h"
#include "stoppable.h"

static std::vector<double> limits_of(const In &element)
{
    require(element.size() % ENGINE_FRICTION == 0, "an element has 10 numbers");
    const std::size_t elements = element.size() / ENGINE_FRICTION;
    std::vector<double> limit(ENGINE_PHASES * elements);
    engine_friction_limits(static_cast<int32_t>(elements), element.data(), limit.data());
    return limit;
}

static engine_bank bank_of(const In &curve, const In &element, const In &weight, const In &memory,
                           const std::vector<double> &limit)
{
    require(element.size() == ENGINE_FRICTION * weight.size() && memory.size() == weight.size() + 1 && curve.size() > 0,
            "an element has 10 numbers, the memory one more than there are elements");
    return {static_cast<int32_t>(curve.size()), static_cast<int32_t>(weight.size()), curve.data(), element.data(),
            weight.data(), limit.data()};
}

static nb::tuple bank_run(const In &x, const In &curve, const In &element, const In &weight, const In &memory)
{
    const std::vector<double> limit = limits_of(element);
    const engine_bank bank = bank_of(curve, element, weight, memory, limit);
    std::vector<double> y(x.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_bank_run(&bank, static_cast<int64_t>(x.size()), x.data(), after.data(), y.data(), nullptr);
    }
    raise_if_stopped();
    return nb::make_tuple(own(std::move(y)), own(std::move(after)));
}

static Matrix bank_states(const In &x, const In &element, const In &memory)
{
    const std::vector<double> curve(1, 0.0), weight(memory.size() > 0 ? memory.size() - 1 : 0, 0.0);
    const std::vector<double> limit = limits_of(element);
    require(element.size() == ENGINE_FRICTION * weight.size() && memory.size() > 0, "an element has 10 numbers");
    const engine_bank bank = {1, static_cast<int32_t>(weight.size()), curve.data(), element.data(), weight.data(),
                              limit.data()};
    std::vector<double> y(x.size()), after = copy(memory);
    Buffer z(x.size() * weight.size());
    {
        nb::gil_scoped_release released;
        engine_bank_run(&bank, static_cast<int64_t>(x.size()), x.data(), after.data(), y.data(), z.data());
    }
    raise_if_stopped();
    return z.release(x.size(), weight.size());
}

static nb::tuple bank_invert(const In &y, double farthest, const In &curve, const In &element, const In &weight,
                             const In &memory)
{
    const std::vector<double> limit = limits_of(element);
    const engine_bank bank = bank_of(curve, element, weight, memory, limit);
    std::vector<double> x(y.size()), after = copy(memory), power(weight.size());
    {
        nb::gil_scoped_release released;
        engine_bank_invert(&bank, static_cast<int64_t>(y.size()), y.data(), farthest, after.data(), power.data(),
                           x.data());
    }
    raise_if_stopped();
    return nb::make_tuple(own(std::move(x)), own(std::move(after)));
}

static engine_lugre lugre_of(const In &curve, const In &parameter, const In &samples, const In &dt, const In &memory)
{
    require(parameter.size() == 6 && memory.size() == 2 && curve.size() > 0 && samples.size() == dt.size(),
            "six parameters, a memory of two, one step of time a sample");
    const double *a = parameter.data();
    return {static_cast<int32_t>(curve.size()), curve.data(), {a[0], a[1], a[2]}, a[3], a[4], a[5]};
}

static nb::tuple lugre_run(const In &x, const In &dt, const In &curve, const In &parameter, const In &memory)
{
    const engine_lugre model = lugre_of(curve, parameter, x, dt, memory);
    std::vector<double> y(x.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_lugre_run(&model, static_cast<int64_t>(x.size()), x.data(), dt.data(), after.data(), y.data(), nullptr);
    }
    raise_if_stopped();
    return nb::make_tuple(own(std::move(y)), own(std::move(after)));
}

static Matrix lugre_columns(const In &x, const In &dt, const In &curve, const In &parameter, const In &memory)
{
    const engine_lugre model = lugre_of(curve, parameter, x, dt, memory);
    std::vector<double> y(x.size()), after = copy(memory);
    Buffer columns(3 * x.size());
    {
        nb::gil_scoped_release released;
        engine_lugre_run(&model, static_cast<int64_t>(x.size()), x.data(), dt.data(), after.data(), y.data(),
                         columns.data());
    }
    raise_if_stopped();
    return columns.release(x.size(), 3);
}

static nb::tuple lugre_invert(const In &y, const In &dt, double farthest, const In &curve, const In &parameter,
                              const In &memory)
{
    const engine_lugre model = lugre_of(curve, parameter, y, dt, memory);
    std::vector<double> x(y.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_lugre_invert(&model, static_cast<int64_t>(y.size()), y.data(), dt.data(), farthest, after.data(),
                            x.data());
    }
    raise_if_stopped();
    return nb::make_tuple(own(std::move(x)), own(std::move(after)));
}

static engine_duhem duhem_of(const In &curve, double alpha, const In &loss, const In &memory)
{
    require(loss.size() > 0 && loss.size() <= ENGINE_LOSSES && memory.size() == 2 && curve.size() > 0 && alpha > 0.0,
            "1 to 16 coefficients of the loss, a memory of two, alpha positive");
    engine_duhem model;
    engine_duhem_make(&model, static_cast<int32_t>(curve.size()), curve.data(), alpha, static_cast<int32_t>(loss.size()),
                      loss.data());
    return model;
}

static nb::tuple duhem_run(const In &x, const In &curve, double alpha, const In &loss, const In &memory)
{
    const engine_duhem model = duhem_of(curve, alpha, loss, memory);
    std::vector<double> y(x.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_duhem_run(&model, static_cast<int64_t>(x.size()), x.data(), after.data(), y.data());
    }
    raise_if_stopped();
    return nb::make_tuple(own(std::move(y)), own(std::move(after)));
}

static nb::tuple duhem_invert(const In &y, double farthest, const In &curve, double alpha, const In &loss,
                              const In &memory)
{
    const engine_duhem model = duhem_of(curve, alpha, loss, memory);
    std::vector<double> x(y.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_duhem_invert(&model, static_cast<int64_t>(y.size()), y.data(), farthest, after.data(), x.data());
    }
    raise_if_stopped();
    return nb::make_tuple(own(std::move(x)), own(std::move(after)));
}

void bind_friction(nb::module_ &m)
{
    m.def("bank_run", &bank_run, "x"_a, "curve"_a, "element"_a, "weight"_a, "memory"_a,
          "(y, memory): a curve and weighted elements along x.");
    m.def("bank_states", &bank_states, "x"_a, "element"_a, "memory"_a, "States (T, m) of the elements along x.");
    m.def("bank_invert", &bank_invert, "y"_a, "farthest"_a, "curve"_a, "element"_a, "weight"_a, "memory"_a,
          "(x, memory): the inputs for outputs y that rise with the input.");
    m.def("lugre_run", &lugre_run, "x"_a, "dt"_a, "curve"_a, "parameter"_a, "memory"_a,
          "(y, memory): a curve and LuGre friction along x in time.");
    m.def("lugre_columns", &lugre_columns, "x"_a, "dt"_a, "curve"_a, "parameter"_a, "memory"_a,
          "z, its rate and the speed (T, 3) along x in time.");
    m.def("lugre_invert", &lugre_invert, "y"_a, "dt"_a, "farthest"_a, "curve"_a, "parameter"_a, "memory"_a,
          "(x, memory): the inputs for outputs y that rise with the input.");
    m.def("duhem_run", &duhem_run, "x"_a, "curve"_a, "alpha"_a, "loss"_a, "memory"_a,
          "(y, memory): Coleman and Hodgdon's model along x.");
    m.def("duhem_invert", &duhem_invert, "y"_a, "farthest"_a, "curve"_a, "alpha"_a, "loss"_a, "memory"_a,
          "(x, memory): the inputs for outputs y that rise with the input.");
}
