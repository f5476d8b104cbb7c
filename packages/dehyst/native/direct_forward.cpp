// The output that follows an input, from a direct inverse.
#include "arrays.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "follow.h"
#include "stoppable.h"

using Grid = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

static nb::tuple direct_forward(const In &u, const std::optional<In> &time, const std::optional<Grid> &given,
                                double first, const In &lowest, const In &highest, const In &path,
                                const In &radii, const In &lengths,
                                const In &time_constants, const Grid &stop_weights, const Grid &path_weights,
                                const Grid &creep_weights, const Grid &polynomial, const In &viscous,
                                const std::vector<int32_t> &factor, const In &low, const In &high, double center,
                                double held_low, double held_high, double y_low, double y_high)
{
    const std::size_t sets = viscous.size(), samples = u.size();
    require(sets > 0 && sets <= ENGINE_SETS && factor.size() == sets && low.size() == sets && high.size() == sets,
            "one factor and its range for each of 1 to 6 sets");
    require(stop_weights.shape(0) == sets && path_weights.shape(0) == sets && creep_weights.shape(0) == sets &&
                polynomial.shape(0) == sets,
            "one row of weights for each set");
    require(stop_weights.shape(1) == radii.size() && path_weights.shape(1) == lengths.size() &&
                creep_weights.shape(1) == time_constants.size(),
            "one weight for each term");
    require(lowest.size() == radii.size() && highest.size() == radii.size() && path.size() == lengths.size(),
            "one state for each stop and path");
    require(!time || time->size() == samples, "u and time differ in length");
    require(!given || (given->shape(0) == samples && given->shape(1) == sets), "one factor for each sample and set");
    require(y_low < y_high, "y_low must be below y_high");
    const engine_direct d = {static_cast<int32_t>(sets),
                             static_cast<int32_t>(radii.size()),
                             static_cast<int32_t>(lengths.size()),
                             static_cast<int32_t>(time_constants.size()),
                             static_cast<int32_t>(polynomial.shape(1)),
                             radii.data(),
                             lengths.data(),
                             time_constants.data(),
                             stop_weights.data(),
                             path_weights.data(),
                             creep_weights.data(),
                             polynomial.data(),
                             viscous.data(),
                             factor.data(),
                             low.data(),
                             high.data(),
                             center,
                             held_low,
                             held_high,
                             y_low,
                             y_high};
    std::vector<double> least = copy(lowest), most = copy(highest), walked = copy(path), y(samples, first);
    int64_t lost = 0;
    {
        const nb::gil_scoped_release released;
        lost = engine_follow(&d, static_cast<int64_t>(samples), u.data(), time ? time->data() : nullptr,
                             given ? given->data() : nullptr, least.data(), most.data(), walked.data(), y.data());
    }
    raise_if_stopped();
    if (lost < 0) throw std::bad_alloc();
    return nb::make_tuple(own(std::move(y)), lost);
}

void bind_direct_forward(nb::module_ &m)
{
    m.def("direct_forward", &direct_forward, "u"_a, "time"_a.none(), "given"_a.none(), "first"_a, "lowest"_a,
          "highest"_a, "path"_a, "radii"_a, "lengths"_a, "time_constants"_a, "stop_weights"_a, "path_weights"_a,
          "creep_weights"_a, "polynomial"_a, "viscous"_a, "factor"_a, "low"_a, "high"_a, "center"_a,
          "held_low"_a, "held_high"_a, "y_low"_a, "y_high"_a, "(outputs y (T,) with D[y] = u, number of samples at which no y within the bounds gives u).");
}
