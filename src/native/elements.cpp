// Binding of elements in parallel (engine/elements.h): no formula.
#include <nanobind/stl/optional.h>

#include <optional>

#include "arrays.h"
#include "elements.h"
#include "stoppable.h"

namespace {

using Kinds = nb::ndarray<const int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

engine_elements view(const Kinds &kind, const In &weight, const In &radius, const In &extra, double slope, double lag)
{
    const std::size_t n = kind.size();
    require(weight.size() == n && radius.size() == n && extra.size() == n, "one weight, radius and extra for each element");
    require(lag > 0.0, "lag must be positive");
    for (std::size_t i = 0; i < n; ++i) {
        require(kind.data()[i] >= 0 && kind.data()[i] < ENGINE_KINDS, "no such kind of element");
        require(radius.data()[i] >= 0.0, "a radius is negative");
        require(kind.data()[i] != ENGINE_CREEP || extra.data()[i] > 0.0, "a time constant must be positive");
    }
    return {static_cast<int32_t>(n), kind.data(), weight.data(), radius.data(), extra.data(), slope, lag};
}

void check(const engine_elements &p, const In &signal, const std::optional<In> &dt, const In &memory)
{
    require(!dt || dt->size() == signal.size(), "signal and dt differ in length");
    require(memory.size() == static_cast<std::size_t>(p.n) + ENGINE_ELEMENT_MEMORY, "memory belongs to other elements");
}

nb::tuple run(const Kinds &kind, const In &weight, const In &radius, const In &extra, double slope, double lag, const In &x,
              const std::optional<In> &dt, const In &memory)
{
    const engine_elements p = view(kind, weight, radius, extra, slope, lag);
    check(p, x, dt, memory);
    std::vector<double> after = copy(memory);
    Buffer y(x.size());
    {
        const nb::gil_scoped_release released;
        engine_elements_run(&p, static_cast<int64_t>(x.size()), x.data(), dt ? dt->data() : nullptr, after.data(), y.data(),
                            nullptr);
    }
    raise_if_stopped();
    return nb::make_tuple(y.release(), own(std::move(after)));
}

Matrix bank(const Kinds &kind, const In &radius, const In &extra, double lag, const In &x, const std::optional<In> &dt,
            const In &memory)
{
    const engine_elements p = view(kind, radius, radius, extra, 0.0, lag);
    check(p, x, dt, memory);
    std::vector<double> after = copy(memory);
    Buffer rows(x.size() * kind.size()), y(x.size());
    {
        const nb::gil_scoped_release released;
        engine_elements_run(&p, static_cast<int64_t>(x.size()), x.data(), dt ? dt->data() : nullptr, after.data(), y.data(),
                            rows.data());
    }
    raise_if_stopped();
    return rows.release(x.size(), kind.size());
}

nb::tuple invert(const Kinds &kind, const In &weight, const In &radius, const In &extra, double slope, double lag,
                 const In &y, const std::optional<In> &dt, double farthest, const In &memory)
{
    const engine_elements p = view(kind, weight, radius, extra, slope, lag);
    check(p, y, dt, memory);
    std::vector<double> after = copy(memory);
    Buffer x(y.size());
    {
        const nb::gil_scoped_release released;
        engine_elements_invert(&p, static_cast<int64_t>(y.size()), y.data(), dt ? dt->data() : nullptr, farthest,
                               after.data(), x.data());
    }
    raise_if_stopped();
    return nb::make_tuple(x.release(), own(std::move(after)));
}

}  // namespace

void bind_elements(nb::module_ &m)
{
    m.attr("ELEMENT_PLAY") = static_cast<int>(ENGINE_PLAY);
    m.attr("ELEMENT_STOP") = static_cast<int>(ENGINE_STOP);
    m.attr("ELEMENT_PIECE") = static_cast<int>(ENGINE_PIECE);
    m.attr("ELEMENT_DAMPER") = static_cast<int>(ENGINE_DAMPER);
    m.attr("ELEMENT_CREEP") = static_cast<int>(ENGINE_CREEP);
    m.attr("ELEMENT_RATE") = static_cast<int>(ENGINE_RATE);
    m.def("elements_run", &run, "kind"_a, "weight"_a, "radius"_a, "extra"_a, "slope"_a, "lag"_a, "x"_a, "dt"_a.none(),
          "memory"_a, "(outputs (T,), memory after them) of elements in parallel.");
    m.def("elements_bank", &bank, "kind"_a, "radius"_a, "extra"_a, "lag"_a, "x"_a, "dt"_a.none(), "memory"_a,
          "Output of each element, (T, n).");
    m.def("elements_invert", &invert, "kind"_a, "weight"_a, "radius"_a, "extra"_a, "slope"_a, "lag"_a, "y"_a,
          "dt"_a.none(), "farthest"_a, "memory"_a, "(inputs (T,), memory after them) for outputs of elements in parallel.");
}
