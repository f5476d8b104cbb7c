// Binding of the direct inverse and of learning: no formula but exp(-T/tau), which a machine is given as a number.
#include "direct_parameters.h"
#include "no_pickle.h"

#include <nanobind/stl/optional.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "stoppable.h"

namespace {

using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// One direct inverse with its memory, at a fixed period. It begins at the first sample that it accepts, or where `reset`
// says.
struct DirectStepper {
    Direct direct;
    bool started = false;

    explicit DirectStepper(const nb::tuple &parameters) : direct(parameters), fingerprint_(fingerprint())
    {
        direct.reset(0.0);
    }
    DirectStepper(const DirectStepper &) = delete;
    DirectStepper &operator=(const DirectStepper &) = delete;

    void reset(double y)
    {
        require(dehyst_accept(y), "it can only begin at a finite number");
        direct.reset(y);
        started = true;
    }

    double step(double y, double rate, double first, double second, double third)
    {
        const double given[DEHYST_GIVEN] = {first, second, third};
        if (!started && dehyst_accept(y) && dehyst_accept(rate) && dehyst_accept_given(given)) begin(y);
        dehyst_direct_step(&direct.view, &direct.state, y, rate, given);
        return dehyst_direct_output(&direct.view, &direct.state, nullptr);
    }

    // A step `passed` seconds after the one before, whatever the period of the parameters is.
    double advance(double y, double rate, double passed, const In &time_constant, double first, double second,
                   double third)
    {
        require(time_constant.size() == direct.gain.size(), "a time constant for every creep term");
        const std::vector<double> kept = direct.gain;
        after(passed, time_constant);
        const double u = step(y, rate, first, second, third);
        direct.gain = kept;
        return u;
    }

    // y, rate, time (T,), given (T, 3), restart (T,) -> u and doubt, (T, 2 + groups): each group's part behind them; and
    // how many samples were rejected.
    nb::tuple simulate(const In &y, const In &rate, const In &time, const Table &given, const Rows &restart,
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
        std::size_t rejected = 0;
        Patience patience(100 + 10 * columns + 10 * direct.memory.size());
        for (std::size_t k = 0; k < samples; ++k) {
            if (patience.stops()) {
                direct.gain = kept;
                throw nb::python_error();
            }
            if (restart.data()[k] != 0 || k == 0) started = false;
            const double passed = k > 0 && restart.data()[k] == 0 ? time.data()[k] - time.data()[k - 1] : 0.0;
            after(passed, time_constant);
            double *row = rows->data() + k * columns;
            const double *told = given.data() + DEHYST_GIVEN * k;
            row[0] = step(y.data()[k], rate.data()[k], told[0], told[1], told[2]);
            rejected += direct.state.flags & DEHYST_REJECTED;
            row[1] = dehyst_direct_doubt(&direct.view, &direct.state, nullptr);
            for (std::size_t g = 0; g + 2 < columns; ++g) row[2 + g] = direct.state.part[g];
        }
        direct.gain = kept;
        return nb::make_tuple(Matrix(rows->data(), {samples, columns}, owner), rejected);
    }

    // Fingerprint of the parameters, whether it has started, flags, last y, curve, parts, doubts, memory.
    Out save() const
    {
        const dehyst_direct_state &now = direct.state;
        std::vector<double> image{fingerprint_, started ? 1.0 : 0.0, static_cast<double>(now.flags), now.last, now.curve};
        image.insert(image.end(), now.part, now.part + DEHYST_GROUPS);
        image.insert(image.end(), now.doubt, now.doubt + DEHYST_GROUPS);
        image.insert(image.end(), direct.memory.begin(), direct.memory.end());
        return own(std::move(image));
    }

    void restore(const In &image)
    {
        const double *at = image.data();
        require(image.size() == kHead + direct.memory.size(), "saved state belongs to a model with other terms");
        for (std::size_t i = 0; i < image.size(); ++i) require(dehyst_accept(at[i]), "saved state is not finite");
        require(at[0] == fingerprint_, "saved state belongs to another model, or to another period");
        require(at[1] == 0.0 || at[1] == 1.0, "saved state is damaged");
        require(at[2] >= 0.0 && at[2] <= kFlags && at[2] == std::floor(at[2]), "saved state carries unknown flags");
        const auto flags = static_cast<uint32_t>(at[2]);
        require((flags & ~static_cast<uint32_t>(kFlags)) == 0, "saved state carries unknown flags");
        require(admissible(at[3], at + kHead), "saved state is not admissible: no output leaves it");
        dehyst_direct_state &now = direct.state;
        started = at[1] != 0.0;
        now.flags = flags;
        now.last = at[3];
        now.curve = at[4];
        std::copy(at + 5, at + 5 + DEHYST_GROUPS, now.part);
        std::copy(at + 5 + DEHYST_GROUPS, at + kHead, now.doubt);
        std::copy(at + kHead, at + image.size(), direct.memory.begin());
    }

  private:
    static constexpr std::size_t kHead = 5 + 2 * DEHYST_GROUPS;
    static constexpr double kFlags = DEHYST_REJECTED | DEHYST_REJECTED_EVER | DEHYST_LIMITED | DEHYST_LIMITED_EVER;

    void after(double passed, const In &time_constant)
    {
        for (std::size_t j = 0; j < direct.gain.size(); ++j)
            direct.gain[j] = -std::expm1(-passed / time_constant.data()[j]);
    }

    // At y; what was rejected before stays known.
    void begin(double y)
    {
        const uint32_t ever = direct.state.flags & (DEHYST_REJECTED_EVER | DEHYST_LIMITED_EVER);
        reset(y);
        direct.state.flags |= ever;
    }

    // Whether plays lie within their radii about the last y, and path lags and doubts within their lengths.
    bool admissible(double last, const double *memory) const
    {
        const auto n = direct.radius.size(), k = direct.length.size(), m = direct.gain.size();
        const double *low = memory, *high = low + n, *path = high + n, *doubt = path + k, *creep = doubt + k + m;
        bool good = true;
        for (std::size_t i = 0; i < n; ++i) {
            const double r = direct.radius[i], slack = 1e-9 * (std::fabs(last) + r);
            good = good && low[i] <= high[i] && low[i] >= last - r - slack && high[i] <= last + r + slack;
        }
        for (std::size_t i = 0; i < k; ++i) {
            const double most = (1 + 1e-9) * direct.length[i];
            good = good && std::fabs(path[i]) <= most && doubt[i] >= 0 && doubt[i] <= most;
        }
        for (std::size_t j = 0; j < m; ++j) good = good && creep[j] >= 0;
        return good;
    }

    // FNV-1a over all parameters, 53 bits of it: a whole number that a double holds.
    double fingerprint() const
    {
        uint64_t hash = UINT64_C(0xcbf29ce484222325);
        const auto add = [&hash](double value) {
            unsigned char bytes[sizeof value];
            std::memcpy(bytes, &value, sizeof value);
            for (unsigned char byte : bytes) hash = (hash ^ byte) * UINT64_C(0x100000001b3);
        };
        const auto all = [&add](const std::vector<double> &values) {
            add(static_cast<double>(values.size()));
            for (double value : values) add(value);
        };
        const dehyst_direct &v = direct.view;
        for (const auto *values : {&direct.radius, &direct.length, &direct.gain, &direct.weight}) all(*values);
        for (int32_t g : direct.group) add(g);
        for (int32_t s = 0; s < v.schedules; ++s) {
            add(v.source[s]);
            add(v.low[s]);
            add(v.high[s]);
        }
        for (double value : {v.center, v.input_low, v.input_high, v.output_low, v.output_high}) add(value);
        for (int32_t value : {v.coefficients, v.groups, v.past}) add(value);
        return static_cast<double>(hash >> 11);
    }

    double fingerprint_;
};

// Values of every elementary term along y, (T, stops + paths + creeps): the columns of an identification; and the memory
// after them, from which the next samples go on: last y and time, lowest and highest plays, path lags, lags.
nb::tuple bank(const In &y, const In &time, const In &radius, const In &length, const In &time_constant, bool known,
               const std::optional<In> &memory)
{
    const std::size_t samples = y.size(), stops = radius.size(), paths = length.size(), creeps = time_constant.size();
    const std::size_t columns = stops + paths + creeps;
    require(samples > 0 && time.size() == samples, "signals differ in length, or are empty");
    std::vector<double> after(2 + columns + stops, 0.0);
    require(!memory || memory->size() == after.size(), "memory belongs to other terms");
    double *low = after.data() + 2, *high = low + stops, *path = high + stops, *lag = path + paths;
    if (memory) {
        std::copy(memory->data(), memory->data() + after.size(), after.begin());
    } else {
        after[0] = y.data()[0];
        after[1] = time.data()[0];
        for (std::size_t i = 0; i < stops; ++i) {
            low[i] = after[0] - (known ? 0.0 : radius.data()[i]);
            high[i] = after[0] + (known ? 0.0 : radius.data()[i]);
        }
        std::fill(lag, lag + creeps, after[0]);
    }
    Buffer rows(samples * columns);
    Patience patience(20 * (1 + columns));
    for (std::size_t k = 0; k < samples; ++k) {
        patience.go_on();
        const double x = y.data()[k];
        require(dehyst_accept(x), "a sample is not finite");
        const double way = x - after[0], passed = time.data()[k] - after[1];
        after[0] = x;
        after[1] = time.data()[k];
        double *row = rows.data() + k * columns;
        for (std::size_t i = 0; i < stops; ++i) {
            const double r = radius.data()[i];
            low[i] = dehyst_within(low[i], x - r, x + r);
            high[i] = dehyst_within(high[i], x - r, x + r);
            row[i] = x - (low[i] + 0.5 * (high[i] - low[i]));
        }
        for (std::size_t i = 0; i < paths; ++i) {
            const double end = way < 0 ? -length.data()[i] : length.data()[i];
            path[i] = end + dehyst_decay(std::fabs(way) / length.data()[i]) * (path[i] - end);
            row[stops + i] = path[i];
        }
        for (std::size_t j = 0; j < creeps; ++j) {
            lag[j] -= std::expm1(-passed / time_constant.data()[j]) * (x - lag[j]);
            row[stops + paths + j] = x - lag[j];
        }
    }
    return nb::make_tuple(rows.release(samples, columns), own(std::move(after)));
}

}  // namespace

void bind_direct(nb::module_ &m)
{
    m.attr("DIRECT_GROUPS") = DEHYST_GROUPS;
    m.attr("DIRECT_SCHEDULES") = DEHYST_SCHEDULES;
    m.attr("DIRECT_GIVEN") = DEHYST_GIVEN;
    m.attr("DIRECT_COEFFICIENTS") = DEHYST_DEGREE;
    m.def("decay", &dehyst_decay, "x"_a, "exp(-x) as the core takes it.");
    m.def("direct_bank", &bank, "y"_a, "time"_a, "radius"_a, "length"_a, "time_constant"_a, "known"_a,
          "memory"_a = nb::none(),
          "Values (T, stops + paths + creeps) of every term of a direct inverse along y, and the memory after them.");
    nb::class_<DirectStepper> bound(m, "DirectStepper", "A direct inverse with its memory, a sample at a time.");
    refuse_pickling(bound);
    bound
        .def(nb::init<const nb::tuple &>(), "parameters"_a)
        .def("__call__", &DirectStepper::step, "y"_a, "rate"_a = 0.0, "first"_a = 0.0, "second"_a = 0.0,
             "third"_a = 0.0,
             "u for the next sample of y, its rate and the scheduling variables from outside.")
        .def("advance", &DirectStepper::advance, "y"_a, "rate"_a, "passed"_a, "time_constant"_a, "first"_a = 0.0,
             "second"_a = 0.0, "third"_a = 0.0, "u for the next sample, `passed` seconds after the one before.")
        .def("reset", &DirectStepper::reset, "y"_a = 0.0, "Begin at y. Without it the first accepted sample is where it begins.")
        .def("save", &DirectStepper::save, "Image of the state for `restore`.")
        .def("restore", &DirectStepper::restore, "image"_a, "Continue from a saved image, to the bit.")
        .def("simulate", &DirectStepper::simulate, "y"_a, "rate"_a, "time"_a, "given"_a, "restart"_a,
             "time_constant"_a, "u, doubt and the parts of the groups along a signal, (T, 2 + groups), and the number of rejected samples.")
        .def_prop_ro("doubt", [](const DirectStepper &s) {
            return dehyst_direct_doubt(&s.direct.view, &s.direct.state, nullptr);
        })
        .def_prop_ro("rejected", [](const DirectStepper &s) {
            return (s.direct.state.flags & DEHYST_REJECTED) != 0;
        })
        .def_prop_ro("rejected_ever", [](const DirectStepper &s) {
            return (s.direct.state.flags & DEHYST_REJECTED_EVER) != 0;
        })
        .def_prop_ro("limited", [](const DirectStepper &s) {
            return (s.direct.state.flags & DEHYST_LIMITED) != 0;
        })
        .def_prop_ro("memory", [](const DirectStepper &s) {
            return own(std::vector<double>(s.direct.memory));
        }, nb::rv_policy::move);
}
