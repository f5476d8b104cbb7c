// Signals on the host: turning points, and the samples that decide the states of plays.
#include "arrays.h"

#include <nanobind/stl/optional.h>

#include <memory>
#include <optional>

#include "signal.h"
#include "stoppable.h"

using Indices = nb::ndarray<nb::numpy, int64_t, nb::ndim<1>>;

// Room for as many indices as there are samples: never touched beyond what is found, so it costs nothing.
struct Found {
    explicit Found(std::size_t room) : values(new int64_t[room]) {}
    Indices take(int64_t count) const
    {
        auto *kept = new std::vector<int64_t>(values.get(), values.get() + count);
        nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<int64_t> *>(p); });
        return Indices(kept->data(), {kept->size()}, owner);
    }
    std::unique_ptr<int64_t[]> values;
};

static Indices turning_points(const In &x, double swing)
{
    const Found point(x.size() + 2);
    int64_t count = 0;
    {
        nb::gil_scoped_release released;
        count = engine_turning_points(static_cast<int64_t>(x.size()), x.data(), swing, point.values.get());
    }
    raise_if_stopped();
    return point.take(count);
}

static nb::tuple essential(const In &x, const Rows &rows)
{
    const std::size_t chosen = rows.size();
    for (std::size_t j = 0; j < chosen; ++j)
        require(rows.data()[j] >= (j == 0 ? 0 : rows.data()[j - 1] + 1) &&
                    rows.data()[j] < static_cast<int64_t>(x.size()),
                "rows must increase strictly and lie within the signal");
    const Found kept(chosen == 0 ? 0 : static_cast<std::size_t>(rows.data()[chosen - 1]) + 1), place(chosen);
    int64_t count = 0;
    {
        nb::gil_scoped_release released;
        count = engine_essential(x.data(), static_cast<int64_t>(chosen), rows.data(), kept.values.get(),
                                 place.values.get());
    }
    raise_if_stopped();
    return nb::make_tuple(kept.take(count), place.take(static_cast<int64_t>(chosen)));
}

static Matrix bin_sums(const In &x, const In &y, const std::optional<In> &weight, int32_t bins, double low, double high)
{
    require(x.size() == y.size() && (!weight || weight->size() == x.size()), "x, y and weight differ in length");
    require(bins > 0 && low < high, "bins must be positive and low below high");
    const auto room = static_cast<std::size_t>(bins);
    auto *sums = new std::vector<double>(5 * room, 0.0);
    nb::capsule owner(sums, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    {
        nb::gil_scoped_release released;
        engine_bin_sums(static_cast<int64_t>(x.size()), x.data(), y.data(), weight ? weight->data() : nullptr, bins,
                        low, high, sums->data());
    }
    raise_if_stopped();
    return Matrix(sums->data(), {room, 5}, owner);
}

void bind_signal(nb::module_ &m)
{
    m.def("bin_sums", &bin_sums, "x"_a, "y"_a, "weight"_a.none(), "bins"_a, "low"_a, "high"_a,
          "Sums (bins, 5) of (1, t, t^2, y, t y) over equal bins of x, t the place in the bin.");
    m.def("turning_points", &turning_points, "x"_a, "swing"_a,
          "Indices where a signal turns by more than `swing`, its first and its last sample.");
    m.def("essential", &essential, "x"_a, "rows"_a,
          "(kept, place): samples that give every play the same state at the rows, and where the rows stand among them.");
}
