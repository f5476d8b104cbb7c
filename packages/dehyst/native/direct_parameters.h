// Parameters and memory of a direct inverse as the binding owns them.
#ifndef DEHYST_NATIVE_DIRECT_PARAMETERS_H
#define DEHYST_NATIVE_DIRECT_PARAMETERS_H

#include "arrays.h"
#include "dehyst.h"

// From the tuple (radius, length, gain, weight, group, source, low, high, limits, coefficients, groups, past); limits are
// center, input low, high, output low, high. `view` is what the core reads, `state` and `memory` what it moves.
struct Direct {
    std::vector<double> radius, length, gain, weight, memory;
    std::vector<int32_t> group;
    dehyst_direct view{};
    dehyst_direct_state state{};

    explicit Direct(const nb::tuple &t)
        : radius(copy(array(t, 0))), length(copy(array(t, 1))), gain(copy(array(t, 2))), weight(copy(array(t, 3))),
          group(counts(t, 4))
    {
        view.coefficients = nb::cast<int32_t>(t[9]);
        view.groups = nb::cast<int32_t>(t[10]);
        view.past = nb::cast<int32_t>(t[11]);
        view.stops = static_cast<int32_t>(radius.size());
        view.paths = static_cast<int32_t>(length.size());
        view.creeps = static_cast<int32_t>(gain.size());
        schedule(counts(t, 5), copy(array(t, 6)), copy(array(t, 7)));
        limit(copy(array(t, 8)));
        require(view.coefficients >= 1 && view.coefficients <= DEHYST_DEGREE, "1 to 8 coefficients");
        require(view.past >= DEHYST_PAST_UNKNOWN && view.past <= DEHYST_PAST_FALLING, "no such past");
        require(view.groups >= 1 && view.groups <= DEHYST_GROUPS, "1 to 8 groups");
        const std::size_t terms = static_cast<std::size_t>(
            DEHYST_DIRECT_TERMS(view.coefficients, view.stops, view.paths, view.creeps));
        const std::size_t sets = view.schedules > 0 ? 2 * static_cast<std::size_t>(view.schedules) : 1;
        require(weight.size() == sets * terms, "weights and terms differ in length");
        require(group.size() == terms - static_cast<std::size_t>(view.coefficients), "every term needs a group");
        for (int32_t g : group) require(g >= 0 && g < view.groups, "no such group");
        memory.resize(static_cast<std::size_t>(DEHYST_DIRECT_REALS(view.stops, view.paths, view.creeps)));
        view.radius = radius.data();
        view.length = length.data();
        view.gain = gain.data();
        view.weight = weight.data();
        view.group = group.data();
        state.memory = memory.data();
    }
    Direct(const Direct &) = delete;
    Direct &operator=(const Direct &) = delete;

    void reset(double y) { dehyst_direct_reset(&view, &state, y); }

  private:
    static In array(const nb::tuple &t, std::size_t i)
    {
        require(t.size() == 12, "a direct inverse is a tuple of 12 parameters");
        return nb::cast<In>(t[i]);
    }
    static std::vector<int32_t> counts(const nb::tuple &t, std::size_t i)
    {
        const Rows values = nb::cast<Rows>(t[i]);
        std::vector<int32_t> out;
        for (std::size_t k = 0; k < values.size(); ++k) out.push_back(static_cast<int32_t>(values.data()[k]));
        return out;
    }
    void schedule(const std::vector<int32_t> &source, const std::vector<double> &low, const std::vector<double> &high)
    {
        require(source.size() <= DEHYST_SCHEDULES && low.size() == source.size() && high.size() == source.size(),
                "at most 3 schedules, each with a source and a range");
        view.schedules = static_cast<int32_t>(source.size());
        for (std::size_t v = 0; v < source.size(); ++v) {
            require(source[v] >= DEHYST_BY_OUTPUT && source[v] < DEHYST_GIVEN && high[v] > low[v], "no such schedule");
            view.source[v] = source[v];
            view.low[v] = low[v];
            view.high[v] = high[v];
        }
    }
    void limit(const std::vector<double> &limits)
    {
        require(limits.size() == 5 && limits[2] > limits[1] && limits[4] > limits[3], "limits that are none");
        view.center = limits[0];
        view.input_low = limits[1];
        view.input_high = limits[2];
        view.output_low = limits[3];
        view.output_high = limits[4];
    }
};

#endif
