// Binding of the direct inverse and of learning: no formula but exp(-T/tau), which a machine is given as a number.
#include "direct_parameters.h"

#include <cmath>

#include "joint_controller.h"

namespace {

using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// One direct inverse with its memory, at a fixed period.
struct DirectStepper {
    Direct direct;

    explicit DirectStepper(const nb::tuple &parameters) : direct(parameters) { direct.reset(0.0); }
    DirectStepper(const DirectStepper &) = delete;
    DirectStepper &operator=(const DirectStepper &) = delete;

    void reset(double y)
    {
        require(dehyst_accept(y), "it can only begin at a finite number");
        direct.reset(y);
    }

    double step(double y, double rate, double first, double second)
    {
        const double given[DEHYST_GIVEN] = {first, second};
        dehyst_direct_step(&direct.view, &direct.state, y, rate, given);
        return dehyst_direct_output(&direct.view, &direct.state, nullptr);
    }

    // y, rate, time (T,), given (T, 2), restart (T,) -> u and doubt, (T, 2 + groups): each group's part behind them.
    Matrix simulate(const In &y, const In &rate, const In &time, const Table &given, const Rows &restart,
                    const In &time_constant)
    {
        const std::size_t samples = y.size(), columns = 2 + static_cast<std::size_t>(direct.view.groups);
        require(rate.size() == samples && time.size() == samples && given.shape(0) == samples &&
                    given.shape(1) == DEHYST_GIVEN && restart.size() == samples,
                "signals differ in length");
        require(time_constant.size() == direct.gain.size(), "a time constant for every creep term");
        auto *rows = new std::vector<double>(samples * columns);
        nb::capsule owner(rows, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
        const std::vector<double> kept = direct.gain;
        for (std::size_t k = 0; k < samples; ++k) {
            if (restart.data()[k] != 0 || k == 0) reset(y.data()[k]);
            const double passed = k > 0 && restart.data()[k] == 0 ? time.data()[k] - time.data()[k - 1] : 0.0;
            for (std::size_t j = 0; j < direct.gain.size(); ++j)
                direct.gain[j] = -std::expm1(-passed / time_constant.data()[j]);
            double *row = rows->data() + k * columns;
            row[0] = step(y.data()[k], rate.data()[k], given.data()[2 * k], given.data()[2 * k + 1]);
            row[1] = dehyst_direct_doubt(&direct.view, &direct.state, nullptr);
            for (std::size_t g = 0; g + 2 < columns; ++g) row[2 + g] = direct.state.part[g];
        }
        direct.gain = kept;
        return Matrix(rows->data(), {samples, columns}, owner);
    }
};

// Values of every elementary term along y, (T, stops + paths + creeps): the columns of an identification.
Matrix bank(const In &y, const In &time, const Rows &restart, const In &radius, const In &length,
            const In &time_constant, bool known)
{
    const std::size_t samples = y.size(), stops = radius.size(), paths = length.size(), creeps = time_constant.size();
    require(time.size() == samples && restart.size() == samples, "signals differ in length");
    const std::size_t columns = stops + paths + creeps;
    auto *rows = new std::vector<double>(samples * columns);
    nb::capsule owner(rows, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    std::vector<double> low(stops), high(stops), path(paths), lag(creeps);
    for (std::size_t k = 0; k < samples; ++k) {
        const double x = y.data()[k];
        require(dehyst_accept(x), "a sample is not finite");
        const bool begins = k == 0 || restart.data()[k] != 0;
        const double way = begins ? 0.0 : x - y.data()[k - 1];
        const double passed = begins ? 0.0 : time.data()[k] - time.data()[k - 1];
        double *row = rows->data() + k * columns;
        for (std::size_t i = 0; i < stops; ++i) {
            const double r = radius.data()[i];
            if (begins) low[i] = x - (known ? 0.0 : r), high[i] = x + (known ? 0.0 : r);
            low[i] = dehyst_within(low[i], x - r, x + r);
            high[i] = dehyst_within(high[i], x - r, x + r);
            row[i] = x - (low[i] + 0.5 * (high[i] - low[i]));
        }
        for (std::size_t i = 0; i < paths; ++i) {
            const double end = way < 0 ? -length.data()[i] : length.data()[i];
            path[i] = begins ? 0.0 : end + dehyst_decay(std::fabs(way) / length.data()[i]) * (path[i] - end);
            row[stops + i] = path[i];
        }
        for (std::size_t j = 0; j < creeps; ++j) {
            lag[j] = begins ? x : lag[j] - std::expm1(-passed / time_constant.data()[j]) * (x - lag[j]);
            row[stops + paths + j] = x - lag[j];
        }
    }
    return Matrix(rows->data(), {samples, columns}, owner);
}

}  // namespace

void bind_direct(nb::module_ &m)
{
    m.attr("DIRECT_GROUPS") = DEHYST_GROUPS;
    m.attr("DIRECT_SCHEDULES") = DEHYST_SCHEDULES;
    m.attr("DIRECT_COEFFICIENTS") = DEHYST_DEGREE;
    m.def("decay", &dehyst_decay, "x"_a, "exp(-x) as the core takes it.");
    m.def("direct_bank", &bank, "y"_a, "time"_a, "restart"_a, "radius"_a, "length"_a, "time_constant"_a, "known"_a,
          "Values (T, stops + paths + creeps) of every term of a direct inverse along y.");
    nb::class_<DirectStepper>(m, "DirectStepper", "A direct inverse with its memory, a sample at a time.")
        .def(nb::init<const nb::tuple &>(), "parameters"_a)
        .def("__call__", &DirectStepper::step, "y"_a, "rate"_a = 0.0, "first"_a = 0.0, "second"_a = 0.0,
             "u for the next sample of y, its rate and the scheduling variables from outside.")
        .def("reset", &DirectStepper::reset, "y"_a = 0.0, "Begin at rest at y.")
        .def("simulate", &DirectStepper::simulate, "y"_a, "rate"_a, "time"_a, "given"_a, "restart"_a,
             "time_constant"_a, "u, doubt and the parts of the groups along a signal, (T, 2 + groups).")
        .def_prop_ro("doubt", [](const DirectStepper &s) {
            return dehyst_direct_doubt(&s.direct.view, &s.direct.state, nullptr);
        })
        .def_prop_ro("rejected", [](const DirectStepper &s) {
            return (s.direct.state.flags & DEHYST_REJECTED) != 0;
        })
        .def_prop_ro("limited", [](const DirectStepper &s) {
            return (s.direct.state.flags & DEHYST_LIMITED) != 0;
        })
        .def_prop_ro("memory", [](const DirectStepper &s) {
            return own(std::vector<double>(s.direct.memory));
        }, nb::rv_policy::move);
}
