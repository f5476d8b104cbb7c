// Host models of friction along a path: a curve and elements with memory, forwards and backwards.
#include "arrays.h"

#include "friction.h"

static engine_bank bank_of(const In &curve, const In &element, const In &weight, const In &memory)
{
    require(element.size() == ENGINE_FRICTION * weight.size() && memory.size() == weight.size() + 1 && curve.size() > 0,
            "an element has 10 numbers, the memory one more than there are elements");
    return {static_cast<int32_t>(curve.size()), static_cast<int32_t>(weight.size()), curve.data(), element.data(),
            weight.data()};
}

static nb::tuple bank_run(const In &x, const In &curve, const In &element, const In &weight, const In &memory)
{
    const engine_bank bank = bank_of(curve, element, weight, memory);
    std::vector<double> y(x.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_bank_run(&bank, static_cast<int64_t>(x.size()), x.data(), after.data(), y.data(), nullptr);
    }
    return nb::make_tuple(own(std::move(y)), own(std::move(after)));
}

static Matrix bank_states(const In &x, const In &element, const In &memory)
{
    const std::vector<double> curve(1, 0.0), weight(memory.size() > 0 ? memory.size() - 1 : 0, 0.0);
    require(element.size() == ENGINE_FRICTION * weight.size() && memory.size() > 0, "an element has 10 numbers");
    const engine_bank bank = {1, static_cast<int32_t>(weight.size()), curve.data(), element.data(), weight.data()};
    std::vector<double> y(x.size()), after = copy(memory);
    Buffer z(x.size() * weight.size());
    {
        nb::gil_scoped_release released;
        engine_bank_run(&bank, static_cast<int64_t>(x.size()), x.data(), after.data(), y.data(), z.data());
    }
    return z.release(x.size(), weight.size());
}

static nb::tuple bank_invert(const In &y, double farthest, const In &curve, const In &element, const In &weight,
                             const In &memory)
{
    const engine_bank bank = bank_of(curve, element, weight, memory);
    std::vector<double> x(y.size()), after = copy(memory);
    {
        nb::gil_scoped_release released;
        engine_bank_invert(&bank, static_cast<int64_t>(y.size()), y.data(), farthest, after.data(), x.data());
    }
    return nb::make_tuple(own(std::move(x)), own(std::move(after)));
}

void bind_friction(nb::module_ &m)
{
    m.def("bank_run", &bank_run, "x"_a, "curve"_a, "element"_a, "weight"_a, "memory"_a,
          "(y, memory): a curve and weighted elements along x.");
    m.def("bank_states", &bank_states, "x"_a, "element"_a, "memory"_a, "States (T, m) of the elements along x.");
    m.def("bank_invert", &bank_invert, "y"_a, "farthest"_a, "curve"_a, "element"_a, "weight"_a, "memory"_a,
          "(x, memory): the inputs for outputs y that rise with the input.");
}
